//! The loop by which a drive turns its motor at a speed: proportional and integral, once per SYNC.

use super::encoder::whole;
use super::parameters::DriveParameters;
use core::time::Duration;
use uarm_io::time::Instant;

/// Per mille of the rated torque for an error of one revolution of the joint per second: the rated torque at 1 rad/s.
const GAIN: f64 = 1000.0 * core::f64::consts::TAU;
/// Time constant of the integral part, s.
const INTEGRAL_TIME: f64 = 0.3;
/// A joint slower than this stands, revolutions per second.
const STANDS: f64 = 0.0005;
/// How fast the measured speed follows, s.
const SMOOTHING: f64 = 0.02;
/// After a longer time without a SYNC the loop begins anew.
const LONGEST_STEP: Duration = Duration::from_millis(100);

/// The loop's state.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedLoop {
    last: Option<(Instant, i32)>,
    /// The speed that is wanted now, counts/s: it follows the one that was asked for along the ramp.
    wanted: f64,
    /// The speed measured, revolutions of the joint per second.
    speed: f64,
    /// The integral part, per mille.
    integral: f64,
    torque: i16,
}

impl SpeedLoop {
    /// Per mille of the rated torque.
    pub const fn torque(&self) -> i16 {
        self.torque
    }

    /// True if the motor stands.
    pub const fn stands(&self) -> bool {
        self.speed.abs() < STANDS
    }

    /// One step to `target` counts/s, with at most `ramp` counts/s², at a counter of `counts`; torque within `limit` per mille.
    pub fn step(
        &mut self,
        target: f64,
        ramp: Option<f64>,
        counts: i32,
        limit: i16,
        drive: &DriveParameters,
        now: Instant,
    ) {
        let Some((at, before)) = self.last.replace((now, counts)) else { return };
        let passed = now.since(at);
        if passed.is_zero() || passed > LONGEST_STEP {
            return;
        }
        let seconds = passed.as_secs_f64();
        let change = ramp.map_or(f64::INFINITY, |ramp| ramp * seconds);
        self.wanted += (target - self.wanted).clamp(-change, change);
        let per_revolution =
            f64::from(drive.encoder().description().counts_per_revolution) * drive.transmission().ratio().factor();
        let measured = f64::from(drive.encoder().wrapped(counts.wrapping_sub(before))) / seconds / per_revolution;
        self.speed += (measured - self.speed) * (seconds / (SMOOTHING + seconds));
        let error = self.wanted / per_revolution - measured;
        let most = f64::from(limit);
        self.integral = (self.integral + GAIN / INTEGRAL_TIME * error * seconds).clamp(-most, most);
        let torque = (GAIN * error + self.integral).clamp(-most, most);
        self.torque = i16::try_from(whole(torque)).unwrap_or_default();
    }
}
