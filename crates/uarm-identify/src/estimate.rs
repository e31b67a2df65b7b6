//! What was found.

use crate::uarm::UarmParameter;
use std::fmt;

/// What a recording says of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// It is known to within its standard error.
    Well,
    /// The recording does not tell it: the motion excites it too little, or another number has the same effect.
    NotTold,
    /// It is at the least that it can be.
    AtLeast,
}

impl Told {
    /// Above this share of a number's size, or of its usual size, a standard error leaves the number open.
    pub const LARGEST_ERROR: f64 = 0.25;
}

/// A number with its standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// What it is called in a robot file.
    pub name: String,
    /// Its unit; empty for a factor.
    pub unit: &'static str,
    /// The number.
    pub value: f64,
    /// Its standard error, in the same unit; infinite where the recording says nothing.
    pub standard_error: f64,
    /// Whether the recording tells it.
    pub told: Told,
}

impl fmt::Display for Estimate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, unit, value, standard_error, .. } = self;
        write!(formatter, "{name} = {value:.5} +- {standard_error:.5} {unit}")
    }
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchEnd {
    /// No step is worth taking any more.
    Converged,
    /// It had taken as many as it may: where it stands says nothing.
    StepLimit,
}

/// The numbers of a robot, and how well they explain its recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// The numbers, in the order of the model's.
    pub estimates: Vec<Estimate>,
    /// Root mean square of simulated less measured angles, in units of an encoder's rounding error (a step over √12): 1 if the model
    /// explains all but that.
    pub residual: f64,
    /// Correlation of a residual with the next one of its joint.
    pub correlation: f64,
    /// Pairs of numbers, by their places in `estimates`, that the recording hardly tells apart, with their correlation.
    pub confounded: Vec<(usize, usize, f64)>,
    /// Samples that were compared.
    pub samples: usize,
    /// Windows that they were cut into.
    pub windows: usize,
    /// Steps of the search.
    pub steps: usize,
    /// Why it took no more.
    pub end: SearchEnd,
}

impl Identified {
    /// From this correlation on, two numbers are called confounded.
    pub const CONFOUNDED: f64 = 0.95;
    /// Up to this residual the model is said to explain the recording.
    pub const LARGEST_RESIDUAL: f64 = 2.0;

    /// The numbers themselves.
    pub fn values(&self) -> Vec<f64> {
        self.estimates.iter().map(|estimate| estimate.value).collect()
    }

    /// The number that `parameter` is, if it was sought.
    pub fn estimate(&self, parameter: UarmParameter) -> Option<&Estimate> {
        let name = parameter.name();
        self.estimates.iter().find(|estimate| estimate.name == name)
    }

    /// Has the search found its end, and does the model leave no more than encoders do there?
    pub fn explains(&self) -> bool {
        self.end == SearchEnd::Converged && self.residual <= Self::LARGEST_RESIDUAL
    }
}
