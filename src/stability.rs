//! Is the loop stable that a robot file makes with a law? The frozen sampled loop of [`uarm_loop::stability`], with the
//! period, the estimators and the drives of the file.

use hinf_control::{AdaptationGuard, BuildError, Controller, Law};
use nalgebra::SVector;
use uarm_loop::dimensions;
use uarm_loop::robot::Joint;
use uarm_loop::stability::survey::{Worst, task, workspace, worst};
use uarm_loop::stability::{DelayError, NotLinear, SampledLoop, TransportDelay};

use crate::dimensions::LoopRobot;
use crate::robot::Robot;

/// Why a loop cannot be judged.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StabilityError {
    /// An estimator is not linear.
    #[error(transparent)]
    NotLinear(#[from] NotLinear),
    /// The delay is longer than the analysis reaches.
    #[error("from the counts to the torque: {0}")]
    Delay(#[from] DelayError),
    /// The law cannot be built.
    #[error(transparent)]
    Law(#[from] BuildError),
}

/// A robot's loop with one law, to be looked at in its configurations.
pub struct Analysis<'a, const J: usize = 3, const N: usize = 2> {
    robot: &'a LoopRobot<J, N>,
    sampled: SampledLoop<J, N>,
    controller: Box<dyn Controller<f64, N>>,
    delays: [TransportDelay; N],
}

impl<'a, const J: usize, const N: usize> Analysis<'a, J, N> {
    /// The loop of `robot` with `law`, whose torques act `delay` after the counts were latched; without it, when the robot
    /// file's drives apply them.
    ///
    /// # Errors
    /// [`StabilityError`] if it cannot be judged.
    pub fn new(robot: &'a Robot<J, N>, law: Law, delay: Option<TransportDelay>) -> Result<Self, StabilityError> {
        let description = &robot.description;
        let mut delays = [delay.unwrap_or_default(); N];
        if delay.is_none() {
            let active = description.joints.iter().skip(dimensions::passive::<J, N>());
            for (delay, joint) in delays.iter_mut().zip(active) {
                *delay = drive_delay(description, joint)?;
            }
        }
        let estimators = description.joints.each_ref().map(|joint| &joint.estimator);
        Ok(Self {
            robot: description,
            sampled: SampledLoop::new(robot.arm.rest_model(), estimators, description.period, delays)?,
            controller: robot.controller(law, AdaptationGuard::None)?,
            delays,
        })
    }

    /// From the latch of the counts to the torque, joint by joint.
    pub const fn delays(&self) -> [TransportDelay; N] {
        self.delays
    }

    /// What `look` finds in the same loop with another delay.
    pub fn with_delay<T>(&mut self, delay: TransportDelay, look: impl FnOnce(&mut Self) -> T) -> T {
        let own = self.delays;
        self.set_delays([delay; N]);
        let found = look(self);
        self.set_delays(own);
        found
    }

    fn set_delays(&mut self, delays: [TransportDelay; N]) {
        self.delays = delays;
        self.sampled = self.sampled.with_delays(delays);
    }

    /// The worst configuration that the task visits, its start tolerance included.
    pub fn along_the_task(&mut self) -> Worst<N> {
        let configurations = task(self.robot.task.reference.clone(), self.robot.task.start_tolerance);
        worst(&self.sampled, self.controller.as_mut(), configurations).unwrap_or(nowhere())
    }

    /// The worst configuration within the joints' limits.
    pub fn in_the_workspace(&mut self) -> Worst<N> {
        let mut limits = [[0.0; 2]; N];
        let active = self.robot.joints.iter().skip(dimensions::passive::<J, N>());
        for (limits, joint) in limits.iter_mut().zip(active) {
            *limits = joint.limits.position;
        }
        worst(&self.sampled, self.controller.as_mut(), workspace(limits)).unwrap_or(nowhere())
    }

    /// The shortest delay, in hundredths of a cycle, with which the loop is unstable along the task; `None` if there is none
    /// up to [`TransportDelay::LONGEST`].
    pub fn delay_limit(&mut self) -> Option<f64> {
        let mut unstable = |hundredths: u32| {
            let delay = TransportDelay::cycles(f64::from(hundredths) / 100.0).ok()?;
            Some(self.with_delay(delay, |other| other.along_the_task().is_unstable()))
        };
        let tenth = (0..).step_by(10).map_while(|at| Some((at, unstable(at)?))).find(|(_, unstable)| *unstable)?.0;
        let first = (tenth.saturating_sub(9)..tenth).find(|at| unstable(*at) == Some(true));
        Some(f64::from(first.unwrap_or(tenth)) / 100.0)
    }
}

/// No configuration was looked at. There always is one; if not, nothing is known to be stable.
fn nowhere<const N: usize>() -> Worst<N> {
    Worst { radius: f64::NAN, configuration: SVector::repeat(f64::NAN) }
}

/// From the SYNC that latches the counts to the torque of a joint's motor.
fn drive_delay<const J: usize, const N: usize>(
    robot: &LoopRobot<J, N>,
    joint: &Joint,
) -> Result<TransportDelay, DelayError> {
    TransportDelay::of(robot.command_delay(joint) + joint.torque_delay, robot.period)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hinf_control::BaseAcceleration;
    use uarm_io::time::Duration;
    use uarm_loop::stability::LinearEstimator;

    use super::*;
    use crate::robot::BUILT_IN;
    use crate::robot::overrides::Overrides;

    fn reduced(changes: &[(&str, &str)]) -> Robot {
        let text = changes.iter().fold(BUILT_IN.to_owned(), |text, (from, to)| text.replace(from, to));
        let mode = Some((Law::Nonlinear, BaseAcceleration::Reduced));
        let overrides = Overrides { base_acceleration: mode, ..Overrides::default() };
        Robot::parse(Path::new("test.toml"), &text, &overrides).unwrap()
    }

    fn radii(robot: &Robot, cycles: f64) -> [f64; 2] {
        let delay = TransportDelay::cycles(cycles).unwrap();
        let mut analysis = Analysis::new(robot, Law::Nonlinear, Some(delay)).unwrap();
        [analysis.along_the_task(), analysis.in_the_workspace()].map(|worst| worst.radius)
    }

    /// 0.991 without delay, 1.012 with one cycle; the task is best there without its tolerance, 1.008.
    #[test]
    fn the_robot_file_is_what_is_judged() {
        let robot = reduced(&[("start_tolerance_deg = 2.0", "start_tolerance_deg = 0.0")]);
        for (cycles, expected) in [(0.0, [0.991, 0.991]), (1.0, [1.008, 1.012])] {
            let found = radii(&robot, cycles);
            assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 5e-4), "{found:?}");
        }
        let slow = reduced(&[("period_us = 3000", "period_us = 10000")]);
        assert!((radii(&slow, 0.0)[1] - 1.057).abs() < 5e-4);
        let levant = reduced(&[(
            "kind = \"low-pass\"\ncutoff_rad_per_s = 27.81882",
            "kind = \"levant\"\njerk_bound_rad_per_s3 = 20.0",
        )]);
        assert!(matches!(Analysis::new(&levant, Law::Nonlinear, None), Err(StabilityError::NotLinear(NotLinear))));
    }

    /// A cycle's frames take 695 us of 3 ms; 1500 us are half a period.
    #[test]
    fn the_delay_is_the_bus_and_the_drive() {
        let delays =
            |robot: &Robot| Analysis::new(robot, Law::Nonlinear, None).unwrap().delays().map(TransportDelay::get);
        assert!(delays(&reduced(&[])).iter().all(|delay| (delay - 0.695 / 3.0).abs() < 1e-3));
        let changed = [("rated_torque_nm = 0.2,", "rated_torque_nm = 0.2, torque_delay_us = 1500,")];
        assert!(delays(&reduced(&changed)).iter().all(|delay| (delay - 0.695 / 3.0 - 0.5).abs() < 1e-3));
        let at_sync = "rated_torque_nm = 0.2, torque_applies = \"at-sync\", torque_delay_us = 600,";
        let robot = reduced(&[("rated_torque_nm = 0.2,", at_sync)]);
        assert!(delays(&robot).iter().all(|delay| (delay - 1.2).abs() < 1e-9));
    }

    #[test]
    fn the_delay_limit_is_where_the_task_becomes_unstable() {
        let robot = reduced(&[]);
        let limit = Analysis::new(&robot, Law::Nonlinear, None).unwrap().delay_limit().unwrap();
        assert!(radii(&robot, limit)[0] >= 1.0 && radii(&robot, limit - 0.01)[0] < 1.0, "{limit}");
        // With the base acceleration eliminated the disturbance weighs more and the feedback less.
        let mut overrides = Overrides { period: Some(Duration::from_millis(1)), ..Overrides::default() };
        overrides.base_acceleration = Some((Law::Nonlinear, BaseAcceleration::Eliminated));
        let stable = Robot::parse(Path::new("test.toml"), BUILT_IN, &overrides).unwrap();
        assert_eq!(Analysis::new(&stable, Law::Nonlinear, None).unwrap().delay_limit(), None);
    }

    /// The table of docs/theory.md, section 13: the velocity's standard deviation for white rounding errors of an encoder,
    /// one count wide, is that of a count by the root of the sum of the squares of the impulse response.
    #[test]
    fn the_noise_of_the_estimators_for_hardware() {
        let hardware = include_str!("../robots/uarm-hardware.toml");
        let one_count_deg: f64 = 360.0 / 33_739.0 / 12.0_f64.sqrt();
        for (period, kind, setting, noise_deg_per_s) in [
            (3000, "low-pass", "cutoff_rad_per_s = 27.81882", 0.08),
            (3000, "low-pass", "cutoff_rad_per_s = 800.0", 1.26),
            (3000, "kalman", "jerk_density_rad2_per_s5 = 1e6", 2.53),
            (3000, "tracking-loop", "bandwidth_rad_per_s = 600.0", 1.79),
            (2000, "low-pass", "cutoff_rad_per_s = 27.81882", 0.08),
            (2000, "low-pass", "cutoff_rad_per_s = 150.0", 0.43),
            (2000, "tracking-loop", "bandwidth_rad_per_s = 400.0", 1.19),
            (2000, "kalman", "jerk_density_rad2_per_s5 = 1e5", 1.56),
        ] {
            let text = hardware
                .replace("period_us = 2000", &format!("period_us = {period}"))
                .replace("kind = \"low-pass\"", &format!("kind = \"{kind}\""))
                .replace("cutoff_rad_per_s = 150.0", setting);
            let robot = Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap();
            let description = &robot.description;
            let linear = LinearEstimator::of(&description.joints[1].estimator, description.period).unwrap();
            let response = std::iter::successors(Some(linear.input), |last| Some(linear.transition * last));
            let gain = response.take(20_000).map(|estimate| estimate.y * estimate.y).sum::<f64>().sqrt();
            let found = one_count_deg * gain;
            assert!((found - noise_deg_per_s).abs() < 6e-3, "{kind}, {setting}: {found}");
        }
    }

    /// The file for hardware, with all that it says of its drives: a cycle and a quarter.
    #[test]
    fn the_robot_file_for_hardware_is_stable_with_every_law() {
        let robot = Robot::load(Some(Path::new("robots/uarm-hardware.toml"))).unwrap();
        for law in Law::ALL {
            let mut analysis = Analysis::new(&robot, law, None).unwrap();
            assert!(analysis.delays().iter().all(|delay| (delay.get() - 1.25).abs() < 0.01));
            for worst in [analysis.along_the_task(), analysis.in_the_workspace()] {
                assert!(worst.radius < 0.998, "{}: {worst:?}", law.name());
            }
        }
    }
}
