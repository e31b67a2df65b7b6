//! What can be wrong with sets, data and options.

use thiserror::Error;

use crate::limits::{MAXIMUM_MAGNITUDE, MAXIMUM_RULES, MAXIMUM_STEEPNESS, MINIMUM_HALF_WIDTH, MINIMUM_STEEPNESS};

/// An error of this crate. Each message says what was found and what was expected.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum AnfisError {
    /// A bell's half width is not a positive finite number in range.
    #[error("half width {0} of a bell: expected a number in [{MINIMUM_HALF_WIDTH:e}, {MAXIMUM_MAGNITUDE:e}]")]
    HalfWidth(f64),
    /// A bell's steepness is not a positive finite number in range.
    #[error("steepness {0} of a bell: expected a number in [{MINIMUM_STEEPNESS}, {MAXIMUM_STEEPNESS}]")]
    Steepness(f64),
    /// A bell's centre is not finite, or too large.
    #[error("centre {0} of a bell: expected a number of magnitude at most {MAXIMUM_MAGNITUDE:e}")]
    Centre(f64),
    /// A universe of discourse is empty, not finite, or too narrow for its magnitude.
    #[error("universe [{lower}, {upper}]: expected two finite ends, the upper above the lower")]
    Universe {
        /// The lower end found.
        lower: f64,
        /// The upper end found.
        upper: f64,
    },
    /// An input has too few sets, or a system no input.
    #[error("{found} {what}: expected at least {expected}")]
    TooFew {
        /// What was counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// The centres of an input's sets do not increase.
    #[error("the centres of input `{input}` do not ascend: {previous} stands before {next}")]
    CentreOrder {
        /// The input's name.
        input: String,
        /// The earlier centre.
        previous: f64,
        /// The later and smaller centre.
        next: f64,
    },
    /// A grid with more rules than this crate takes.
    #[error("the grid has more than {MAXIMUM_RULES} rules; take fewer inputs or fewer sets per input")]
    TooManyRules,
    /// Two lengths that must agree do not.
    #[error("{found} {what}: expected {expected}")]
    Length {
        /// What was counted.
        what: &'static str,
        /// The length found.
        found: usize,
        /// The length expected.
        expected: usize,
    },
    /// A sample's value is not finite, or too large.
    #[error("value {value} in sample {sample}: expected a number of magnitude at most {MAXIMUM_MAGNITUDE:e}")]
    Sample {
        /// Index of the sample, from 0.
        sample: usize,
        /// The value found.
        value: f64,
    },
    /// A consequent coefficient is not finite.
    #[error("consequent {0}: expected a finite number")]
    Consequent(f64),
    /// An option of the training is out of its range.
    #[error("{option} is {found}: expected {expected}")]
    Training {
        /// The option.
        option: &'static str,
        /// Its value.
        found: f64,
        /// Its range, in words.
        expected: &'static str,
    },
    /// The model of the lowest checking error was asked for, or early stopping, without a checking set.
    #[error("no checking set: expected one, since the options judge the model by its checking error")]
    NoCheckingSet,
}
