//! Postures on the way.

use nalgebra::SVector;
use serde::{Deserialize, Serialize};

/// How a posture on the way is passed. Serialised, it is the text `"through"` or `"stop"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Passing {
    /// In motion, with the least jerk.
    #[default]
    Through,
    /// At rest.
    Stop,
}

/// A posture on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViaPoint<const N: usize> {
    /// When, s from the start.
    pub time: f64,
    /// Angles of the active joints, rad.
    pub position: SVector<f64, N>,
    /// How.
    pub passing: Passing,
}
