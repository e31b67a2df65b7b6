//! From what the drives command to what their motors do: the same, some time later.

use core::time::Duration;
use nalgebra::SVector;
use uarm_io::time::Instant;

/// What a drive wants of its motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Commanded {
    /// N·m at the joint.
    pub(crate) torque: f64,
    /// The power stage is on.
    pub(crate) power: bool,
}

/// A motor that follows its drive's commands after a delay. Power that goes takes the torque with it at once.
#[derive(Clone, Copy, Debug, Default)]
struct Motor {
    delay: Duration,
    /// The torque that acts, N·m; without a delay it is not used.
    acting: f64,
    /// The torque on its way, and when it acts.
    coming: Option<(Instant, f64)>,
}

impl Motor {
    fn torque(&self, commanded: &Commanded) -> f64 {
        if self.delay.is_zero() || !commanded.power { commanded.torque } else { self.acting }
    }

    /// Takes a command that comes at `now`. A torque still on its way acts at once, so that none is passed over.
    fn command(&mut self, commanded: &Commanded, now: Instant) {
        if self.delay.is_zero() {
            return;
        }
        if !commanded.power {
            self.follow(0.0);
            return;
        }
        let last = self.coming.map_or(self.acting, |(_, torque)| torque);
        if commanded.torque != last {
            self.acting = last;
            self.coming = Some((now + self.delay, commanded.torque));
        }
    }

    fn elapse(&mut self, now: Instant) {
        if let Some((_, torque)) = self.coming.filter(|(due, _)| *due <= now) {
            self.follow(torque);
        }
    }

    fn follow(&mut self, torque: f64) {
        self.acting = torque;
        self.coming = None;
    }
}

/// The motors of the joints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motors<const J: usize>([Motor; J]);

impl<const J: usize> Motors<J> {
    /// Motors at rest that follow after `delays`.
    pub(crate) fn new(delays: [Duration; J]) -> Self {
        Self(delays.map(|delay| Motor { delay, ..Motor::default() }))
    }

    /// The same motors, at rest.
    pub(crate) fn at_rest(&self) -> Self {
        Self::new(self.0.map(|motor| motor.delay))
    }

    /// The torques that act, N·m.
    pub(crate) fn torque(&self, commanded: &[Commanded; J]) -> SVector<f64, J> {
        SVector::from_iterator(self.0.iter().zip(commanded).map(|(motor, commanded)| motor.torque(commanded)))
    }

    /// On a clock: lets what is due by `now` act, and takes the commands of that instant.
    pub(crate) fn command(&mut self, commanded: &[Commanded; J], now: Instant) {
        for (motor, commanded) in self.0.iter_mut().zip(commanded) {
            motor.elapse(now);
            motor.command(commanded, now);
        }
    }

    /// On a clock: when the next torque begins to act.
    pub(crate) fn next_change(&self) -> Option<Instant> {
        self.0.iter().filter_map(|motor| motor.coming.map(|(due, _)| due)).min()
    }

    /// In lockstep: the motors' delay that follows on `last`, as time after the SYNC; nothing if there is none longer.
    pub(crate) fn next_delay(&self, last: Duration) -> Option<Duration> {
        self.0.iter().map(|motor| motor.delay).filter(|delay| *delay > last).min()
    }

    /// In lockstep: lets the motors with this delay follow the commands.
    pub(crate) fn follow(&mut self, delay: Duration, commanded: &[Commanded; J]) {
        for (motor, commanded) in self.0.iter_mut().zip(commanded).filter(|(motor, _)| motor.delay == delay) {
            motor.follow(commanded.torque);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DELAY: Duration = Duration::from_micros(700);

    fn at(microseconds: u64) -> Instant {
        Instant::from_nanoseconds(microseconds * 1_000)
    }

    fn wanted(torque: f64) -> [Commanded; 3] {
        [Commanded { torque, power: true }; 3]
    }

    #[test]
    fn no_command_is_passed_over_however_fast_they_come() {
        let mut motors = Motors::new([DELAY; 3]);
        motors.command(&wanted(1.0), at(0));
        assert_eq!((motors.torque(&wanted(1.0)).x, motors.next_change()), (0.0, Some(at(700))));
        motors.command(&wanted(2.0), at(100));
        assert_eq!((motors.torque(&wanted(2.0)).x, motors.next_change()), (1.0, Some(at(800))));
        motors.command(&wanted(2.0), at(200));
        assert_eq!(motors.next_change(), Some(at(800)), "the same command again is none");
        motors.command(&wanted(2.0), at(800));
        assert_eq!((motors.torque(&wanted(2.0)).x, motors.next_change()), (2.0, None));
        let off = [Commanded { torque: 0.0, power: false }; 3];
        motors.command(&wanted(3.0), at(900));
        motors.command(&off, at(1_000));
        assert_eq!((motors.torque(&off).x, motors.next_change()), (0.0, None));
        motors.command(&wanted(0.0), at(2_000));
        assert_eq!(motors.torque(&wanted(0.0)).x, 0.0, "nothing is left of what was before");
    }
}
