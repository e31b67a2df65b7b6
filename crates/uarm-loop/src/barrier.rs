//! The braking barrier: a run ends while each joint can still be stopped within its limits.
//!
//! In each cycle it is asked where a joint would be, and how fast, if the stop were sent one cycle later: until then the torques may
//! accelerate it with all they have, after that it coasts until its brake holds. If that is beyond a limit, this cycle is the last.
//! What is believed of the joint is bounded from the safe side: its velocity is the difference of two counts, each of which may be a
//! count off, and it may have accelerated in between.

use uarm_io::time::Duration;

use crate::plausibility::AccelerationBound;

/// How many periods after the SYNC of a cycle the stop of the next cycle has surely reached the drives: one until its SYNC, and one
/// more, within which its counts have to come.
const PERIODS_UNTIL_STOP: f64 = 2.0;

/// How a joint comes to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopping {
    /// The most that it accelerates, by the nominal model.
    pub acceleration: AccelerationBound,
    /// From the command to stop until the brake holds.
    pub brake: Duration,
    /// From a command until the motor has its torque.
    pub torque_delay: Duration,
    /// What one count is, rad.
    pub resolution: f64,
}

/// The time that the barrier works with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Task time, s.
    pub time: f64,
    /// Since the cycle before, s; zero in the first cycle, before which the joints stood.
    pub elapsed: f64,
    /// The period of the loop, s.
    pub period: f64,
}

/// How far a joint goes until its brake holds, and how fast it becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// From where the counts say that it is, rad.
    pub distance: f64,
    /// rad/s.
    pub velocity: f64,
}

impl Default for Stopping {
    /// A joint without torque whose brake holds at once.
    fn default() -> Self {
        let acceleration = AccelerationBound { by_torque: 0.0, by_velocity: 0.0 };
        Self { acceleration, brake: Duration::ZERO, torque_delay: Duration::ZERO, resolution: 0.0 }
    }
}

impl Stopping {
    /// How far a joint goes, and how fast it becomes, that turned by `turned`, rad, in the direction that is looked at since the cycle before,
    /// beside a fastest joint of `fastest`, rad/s.
    pub fn reach(&self, turned: f64, fastest: f64, times: &Times) -> Reach {
        let AccelerationBound { by_torque, by_velocity } = self.acceleration;
        let coasting = by_velocity * fastest * fastest;
        let driven = by_torque + coasting;
        // Either count may be half a count off; and the velocity is that of the middle between them.
        let turned = if times.elapsed > 0.0 { (turned + self.resolution) / times.elapsed } else { 0.0 };
        let now = turned + driven * times.elapsed / 2.0;
        let powered = PERIODS_UNTIL_STOP * times.period + self.torque_delay.as_secs_f64();
        let brake = self.brake.as_secs_f64();
        let at_stop = now + driven * powered;
        Reach {
            distance: self.resolution / 2.0
                + (now + driven * powered / 2.0) * powered
                + (at_stop + coasting * brake / 2.0) * brake,
            velocity: at_stop + coasting * brake,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: Times = Times { time: 1.0, elapsed: 0.01, period: 0.01 };

    fn stopping(by_torque: f64, by_velocity: f64, brake: u64) -> Stopping {
        Stopping {
            acceleration: AccelerationBound { by_torque, by_velocity },
            brake: Duration::from_millis(brake),
            ..Stopping::default()
        }
    }

    fn assert_reach(found: Reach, distance: f64, velocity: f64) {
        assert!((found.distance - distance).abs() < 1e-12, "{found:?}");
        assert!((found.velocity - velocity).abs() < 1e-12, "{found:?}");
    }

    /// At 2 rad/s, without acceleration: two periods of 10 ms and a brake of 30 ms are 0.1 rad.
    #[test]
    fn a_joint_goes_on_for_two_periods_and_the_brake() {
        assert_reach(stopping(0.0, 0.0, 30).reach(0.02, 2.0, &TIMES), 0.1, 2.0);
        assert_reach(stopping(0.0, 0.0, 30).reach(-0.02, 2.0, &TIMES), -0.1, -2.0);
        let late = Stopping { torque_delay: Duration::from_millis(5), ..stopping(0.0, 0.0, 30) };
        assert_reach(late.reach(0.02, 2.0, &TIMES), 0.11, 2.0);
        let first = Times { elapsed: 0.0, ..TIMES };
        assert_reach(stopping(0.0, 0.0, 30).reach(0.0, 0.0, &first), 0.0, 0.0);
    }

    /// 40 rad/s² for half of the last period and two more: from 1 rad/s to 1.2 now and 2.0 then, over 0.032 rad; then 100 ms.
    #[test]
    fn torque_that_is_left_counts_until_the_stop_acts() {
        assert_reach(stopping(40.0, 0.0, 100).reach(0.01, 1.0, &TIMES), 0.032 + 0.2, 2.0);
    }

    /// 0.5 per rad at 4 rad/s are 8 rad/s²: 0.04 rad/s now, 0.2 after 20 ms and 0.0024 rad, 1.0 after 100 ms more and 0.06 rad.
    #[test]
    fn a_fast_joint_accelerates_the_others() {
        assert_reach(stopping(0.0, 0.5, 100).reach(0.0, 4.0, &TIMES), 0.0024 + 0.06, 1.0);
    }

    /// Counts of 0.001 rad: half of one in the angle, one in a turn of 10 ms.
    #[test]
    fn counts_are_believed_to_within_half_of_one() {
        let coarse = Stopping { resolution: 0.001, ..stopping(0.0, 0.0, 30) };
        assert_reach(coarse.reach(0.02, 2.0, &TIMES), 0.0005 + 2.1 * 0.05, 2.1);
    }
}
