//! What is simulated, and which numbers of it are sought.

use crate::sample::Sample;
use nalgebra::SVector;

/// A number that is sought.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// What it is called, as in a robot file.
    pub name: String,
    /// Its unit; empty for a factor.
    pub unit: &'static str,
    /// The least that it can be.
    pub least: f64,
    /// How large such a number usually is; > 0.
    pub scale: f64,
    /// Where the search begins.
    pub start: f64,
}

/// A robot of `J` joints with unknown numbers.
pub trait Model<const J: usize> {
    /// The numbers that are sought.
    fn parameters(&self) -> Vec<Parameter>;

    /// The angles, rad, at the instants of `window` of a robot with these `values`, whose joints are at `position`, rad, and move with
    /// `velocity`, rad/s, at its first one. `None` if there is no such robot.
    fn angles(
        &self,
        values: &[f64],
        position: &SVector<f64, J>,
        velocity: &SVector<f64, J>,
        window: &[Sample<J>],
    ) -> Option<Vec<SVector<f64, J>>>;
}
