//! Studies: many experiments in virtual time, on all cores.
//!
//! Each experiment is the one that `uarm run --virtual-time` runs: the same loop, the same emulated drives. What differs
//! from experiment to experiment is drawn from a random stream that belongs to a seed and an index, so that a study gives
//! the same bytes on any number of threads.
//!
//! | module | subject |
//! |---|---|
//! | [`contestant`] | who is compared: the paper's six, other readings of it, our extensions, the baseline |
//! | [`random`] | random streams from (seed, subject, index) |
//! | [`start`] | what differs between the repetitions of an experiment: encoder phase, start angles |
//! | [`trial`] | one experiment in virtual time |
//! | [`parallel`] | trials on all cores, in order |
//! | [`statistics`] | mean and spread, quantiles |
//! | [`comparison`] | repetitions on one plant, beside the paper's Table 4 |
//! | [`spread`] | plants around a plant |
//! | [`monte_carlo`] | each controller on many of them |
//! | [`table`], [`csv`] | studies for people, and for other programs |

pub mod comparison;
pub mod contestant;
pub mod csv;
pub mod monte_carlo;
pub mod parallel;
pub mod random;
pub mod spread;
pub mod start;
pub mod statistics;
pub mod table;
pub mod trial;

/// What must be said wherever numbers of the fitted plant stand beside the paper's.
pub const FITTED_PLANT_CAVEAT: &str = "\
The imperfect plant is one fit of 13 parameters to the 12 numbers of Table 4, chosen after 26 fits. It shows what an
imperfect robot does to the controllers, not what the paper's robot was: that L2 and E come near Table 4 is its making.
On the plants near it, too (--monte-carlo), `nonlinear` is worst in L2, but only as the fit has it, with the base
acceleration eliminated: see `nonlinear-omitted`. The order in E, and among the adaptive laws in L2, shows nothing.";
