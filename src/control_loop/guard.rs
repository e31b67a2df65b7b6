//! The limits of the robot, beyond which a run ends: torque zero, quick stop, brakes.

use std::fmt;

use hinf_control::Reference;
use nalgebra::Vector2;

use super::estimation::Estimate;

/// What one joint may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Smallest and largest angle, rad.
    pub position: [f64; 2],
    /// Largest rate either way, rad/s.
    pub rate: f64,
}

/// Watches the limits of a run.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    /// What each joint may do.
    pub joints: [JointLimits; 3],
    /// How far a driven joint may be from its reference, rad.
    pub tracking_error: f64,
    /// How far a driven joint may be from its reference in the first cycle, rad.
    pub start_tolerance: f64,
}

/// What went beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The joint's angle.
    Position,
    /// The joint's rate.
    Rate,
    /// The distance from the reference.
    TrackingError,
    /// The distance from the reference in the first cycle.
    StartError,
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Position => "angle",
            Self::Rate => "rate",
            Self::TrackingError => "tracking error",
            Self::StartError => "distance from the start of the motion (--approach 5s would go there first)",
        })
    }
}

/// A limit was passed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "joint {joint} at {time:.3} s: {quantity} is {:.2} deg{unit}, expected {:.2} to {:.2} deg{unit}",
    .found.to_degrees(), .allowed[0].to_degrees(), .allowed[1].to_degrees(),
    unit = if *.quantity == Quantity::Rate { "/s" } else { "" }
)]
pub struct LimitViolation {
    /// The joint, 1 to 3.
    pub joint: usize,
    /// Task time, s.
    pub time: f64,
    /// What was passed.
    pub quantity: Quantity,
    /// Its value, rad or rad/s.
    pub found: f64,
    /// Its range.
    pub allowed: [f64; 2],
}

impl Guard {
    /// Checks the cycle at task time `time` that comes `elapsed` ticks after its predecessor, 0 if it is the first.
    ///
    /// # Errors
    /// [`LimitViolation`] for the first limit that is passed.
    pub fn check(
        &self,
        time: f64,
        elapsed: u64,
        estimate: &Estimate,
        reference: &Reference<f64>,
    ) -> Result<(), LimitViolation> {
        let within = |joint, quantity, found: f64, allowed: [f64; 2]| {
            let [least, most] = allowed;
            // Written so that NaN is outside.
            if found >= least && found <= most {
                Ok(())
            } else {
                Err(LimitViolation { joint, time, quantity, found, allowed })
            }
        };
        for (index, (joint, limits)) in estimate.joints.iter().zip(&self.joints).enumerate() {
            within(index + 1, Quantity::Position, joint.position, limits.position)?;
            within(index + 1, Quantity::Rate, joint.velocity, [-limits.rate, limits.rate])?;
        }
        let (quantity, allowed) = match elapsed {
            0 => (Quantity::StartError, self.start_tolerance),
            _ => (Quantity::TrackingError, self.tracking_error),
        };
        let error: Vector2<f64> = estimate.measurement().position - reference.position;
        within(2, quantity, error.x, [-allowed, allowed])?;
        within(3, quantity, error.y, [-allowed, allowed])
    }
}
