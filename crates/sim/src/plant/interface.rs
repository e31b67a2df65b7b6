//! What every plant does: time, motion, brakes.

use core::time::Duration;
use nalgebra::SVector;

/// A robot with drives on `JOINTS` joints, by default the paper's three: joint 1 is the free base, joints 2 and 3 are driven.
///
/// Deterministic: the same calls give the same bits. Plant time is counted in whole nanoseconds from zero.
pub trait Plant<const JOINTS: usize = 3> {
    /// Plant time.
    fn time(&self) -> Duration;

    /// True joint angles, rad; m where a joint slides.
    fn position(&self) -> SVector<f64, JOINTS>;

    /// True joint velocities, rad/s or m/s.
    fn velocity(&self) -> SVector<f64, JOINTS>;

    /// Moves on to `until` with `torque` (N·m at the motors) held and the joints in `brakes` held still.
    /// Steps exactly onto `until` and onto every instant at which a disturbance starts.
    fn advance(&mut self, until: Duration, torque: &SVector<f64, JOINTS>, brakes: [Brake; JOINTS]);
}

/// A joint's holding brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brake {
    /// The joint is held.
    Engaged,
    /// The joint is free.
    Released,
}
