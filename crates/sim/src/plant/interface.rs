//! What every plant does: time, motion, brakes.

use core::time::Duration;
use nalgebra::Vector3;

/// A three-joint robot: joint 1 is the free base, joints 2 and 3 are driven.
///
/// Deterministic: the same calls give the same bits. Plant time is counted in whole nanoseconds from zero.
pub trait Plant {
    /// Plant time.
    fn time(&self) -> Duration;

    /// True joint angles, rad.
    fn position(&self) -> Vector3<f64>;

    /// True joint velocities, rad/s.
    fn velocity(&self) -> Vector3<f64>;

    /// Moves on to `until` with `torque` (N·m at the motors) held and the joints in `brakes` held still.
    /// Steps exactly onto `until` and onto every instant at which a disturbance starts.
    fn advance(&mut self, until: Duration, torque: &Vector3<f64>, brakes: [Brake; 3]);
}

/// A joint's holding brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brake {
    /// The joint is held.
    Engaged,
    /// The joint is free.
    Released,
}
