//! Adaptive-network-based fuzzy inference (Jang 1993): premise sets learned from data, off line.
//!
//! J.-S. R. Jang, *ANFIS: adaptive-network-based fuzzy inference system*, IEEE Transactions on Systems, Man, and
//! Cybernetics 23 (1993) 665–685. The fuzzy controllers of Pazelli et al. (2011), section 4.3, take their sets from it.
//!
//! # Example
//!
//! Learns the torque that errors of velocity and position call for; [`PremiseSets`] is what a controller takes.
//!
//! ```
//! use std::ops::ControlFlow;
//!
//! use anfis::{DataSet, Firing, InputSets, PremiseSets, StepMetric, Training};
//!
//! // (velocity error in rad/s, position error in rad) → torque in N·m.
//! let run = (0..200).map(|k| 0.003 * f64::from(k)).map(|t| {
//!     let (velocity, position) = (0.3 * (9.0 * t).cos(), 0.03 * (9.0 * t).sin());
//!     ([velocity, position], 0.2 * velocity + 2.0 * position * position.abs())
//! });
//! let (training_set, checking_set) = DataSet::new(run)?.split(4)?;
//!
//! let start = PremiseSets::new(
//!     Firing::Minimum,
//!     vec![
//!         InputSets::grid("velocity error", "rad/s", training_set.universe(0)?, 3)?,
//!         InputSets::grid("position error", "rad", training_set.universe(1)?, 3)?,
//!     ],
//! )?;
//! let training = Training { premise_updates: 20, metric: StepMetric::Universe, ..Training::default() };
//! let trained = training.run(&start, &training_set, Some(&checking_set), |epoch| {
//!     // Here a progress bar advances.
//!     assert!(epoch.rmse.is_finite());
//!     ControlFlow::Continue(())
//! })?;
//!
//! assert!(trained.kept_epoch().rmse <= trained.history[0].rmse);
//! let sets = trained.anfis.premises().inputs()[0].sets();
//! assert!(sets.is_sorted_by(|one, next| one.centre() <= next.centre()));
//! # Ok::<(), anfis::AnfisError>(())
//! ```
//!
//! # The system
//! First-order Takagi–Sugeno: rule r says IF x_1 is A_r1 AND … AND x_n is A_rn THEN f_r = f_r0 + f_r1 x_1 + … + f_rn x_n.
//! It fires with w_r, the product or the minimum of its memberships, and y = Σ w_r f_r / Σ w_r. The sets are bells,
//! μ(x) = 1/(1 + |(x − c)/a|^2b), and the rules all combinations of one set per input.
//!
//! # Conventions
//! - Rules count with the first input slowest; a rule's consequents are its constant, then one coefficient per input.
//! - An epoch: least squares for the consequents → errors recorded → gradient of E = Σ(y − target)² → the premises move by
//!   −k·∇E/‖∇E‖ over all a, b, c together → the rule for k. Record n of a history is the state after n moves, with the step k
//!   that follows.
//! - k: ×1.1 after four decreases of the error in a row; ×0.9 after up, down, up, down; either restarts the count.
//! - Train with the firing that runs. Sets are kept in the order of their centres, half widths and steepnesses positive.
//! - Where no rule fires, far outside the universe, strengths are compared in logarithms: nothing divides 0 by 0.
//! - Least squares is exact and of minimum norm; a dropped rank is reported in [`Trained::rank_drops`]. Jang's recursion is
//!   an option ([`ConsequentEstimator::Recursive`]), and it is what his printed errors come from.
//! - Same data, same options: the same bits, on any machine. Transcendentals come from `libm`; nothing is parallel.
//!
//! # Map
//! | module | holds |
//! |---|---|
//! | `bell`, `input`, `premises` | [`Bell`], [`InputSets`], [`PremiseSets`]: validated, sampled for plots, serialisable with the feature `serde` |
//! | `data` | [`DataSet`]: training and checking pairs |
//! | `training`, `step_size` | [`Training`], its options, [`Trained`] with the error history |
//! | `pass`, `least_squares`, `gradient`, `network` | one epoch, [`Pass`], and its parts |
//! | `inference` | [`Anfis`]: a trained system and its output |
//! | [`mackey_glass`], [`limits`] | Jang's benchmark; the ranges admitted |
//!
//! Not here: other shapes of sets, subtractive clustering, several outputs (train one system per output), learning on line
//! (that is the controllers' part).
#![forbid(unsafe_code)]

mod bell;
mod data;
mod error;
mod gradient;
mod inference;
mod input;
mod least_squares;
pub mod limits;
pub mod mackey_glass;
mod network;
mod pass;
mod premises;
mod step_size;
mod training;

pub use bell::{Bell, BellParameters, LogDerivatives};
pub use data::DataSet;
pub use error::AnfisError;
pub use gradient::BellGradient;
pub use inference::Anfis;
pub use input::{InputSets, MembershipCurves, Universe};
pub use pass::{ConsequentEstimator, InitialCovariance, Pass};
pub use premises::{Firing, PremiseSets};
pub use step_size::StepSizeRule;
pub use training::{Epoch, Keep, SteepnessRange, StepMetric, StopReason, Trained, Training};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
