//! Which master drives the robot: the one place where the protocols part.

use hinf_control::Controller;
use uarm_io::drive::network::{Learned, StopReport};
use uarm_io::drive::odrive::Identified;
use uarm_io::drive::{DriveNetwork, OdriveNetwork};
use uarm_io::embedded_can::StandardId;
use uarm_io::link::Link;
use uarm_io::time::Clock;
use uarm_loop::control_loop::{LoopEnd, LoopFault};
use uarm_loop::fault_code::{Coded, FaultCode};
use uarm_loop::guard::{LimitViolation, Quantity};
use uarm_loop::record::Recorder;
use uarm_loop::robot::Protocol;
use uarm_loop::run::{Finished, Observer, RunError, run};
use uarm_loop::schedule::{Allowed, Overrun};
use uarm_loop::settings::Settings;

use crate::dimensions::{LoopRobot, Outcome};
use crate::error_text::with_causes;

/// How a run ended, and what came of it until then, whatever drives it had.
#[derive(Debug)]
pub struct Ended<R, const J: usize = 3, const N: usize = 2> {
    /// The end, or the first cause of an early one.
    pub end: Result<LoopEnd, Failure>,
    /// Faults after the first cause.
    pub later_faults: u64,
    /// What came of the run.
    pub outcome: Outcome<N>,
    /// What the drives said when they were stopped.
    pub stop: StopReport<J>,
    /// The recorder that the run was given.
    pub recorder: R,
}

/// Why a run did not end as planned.
#[derive(Debug)]
pub struct Failure {
    /// The first cause.
    pub cause: anyhow::Error,
    /// Its name.
    pub code: FaultCode,
    /// Which option of the command line would have helped.
    pub hint: Option<&'static str>,
}

impl Failure {
    /// The cause and the hint in words.
    pub fn text(&self) -> String {
        let cause = with_causes(&self.cause);
        self.hint.map_or_else(|| cause.clone(), |hint| format!("{cause} ({hint})"))
    }
}

/// The way to a robot's drives.
#[derive(Debug)]
pub struct ToDrives<L> {
    /// The link to their bus.
    pub link: L,
    /// Is told what was learned of each CANopen drive, before any has power.
    pub learned: Learned,
    /// Is told what each ODrive axis says that it is.
    pub identified: Identified,
}

impl<L> ToDrives<L> {
    /// Over `link`, and nobody is told.
    pub const fn over(link: L) -> Self {
        Self { link, learned: |_, _, _| {}, identified: |_, _| {} }
    }
}

/// Makes a run on the drives of `robot`, whatever protocol they speak.
///
/// # Errors
/// If the run cannot be prepared; nothing was sent then.
pub fn run_on<L: Link, C: Clock, R: Recorder<J, N>, const J: usize, const N: usize>(
    robot: &LoopRobot<J, N>,
    settings: &Settings,
    controller: &mut dyn Controller<f64, N>,
    way: ToDrives<L>,
    clock: &mut C,
    recorder: R,
    observer: Observer<'_, N>,
) -> anyhow::Result<Ended<R, J, N>>
where
    L::Error: Send + Sync + 'static,
{
    match robot.bus.protocol {
        Protocol::Canopen => {
            let mut drives = DriveNetwork::new(way.link, robot.network_configuration()?);
            drives.on_learned(way.learned);
            Ok(ended(run(robot, settings, controller, drives, clock, recorder, observer)?))
        }
        Protocol::Odrive(positions) => {
            let mut drives = OdriveNetwork::new(way.link, robot.odrive_configuration(positions)?);
            drives.on_identified(way.identified);
            Ok(ended(run(robot, settings, controller, drives, clock, recorder, observer)?))
        }
    }
}

/// The identifiers that the drives of `robot` send.
///
/// # Errors
/// If the drives cannot be described to their master.
pub fn receive_identifiers<const J: usize, const N: usize>(robot: &LoopRobot<J, N>) -> anyhow::Result<Vec<StandardId>> {
    Ok(match robot.bus.protocol {
        Protocol::Canopen => robot.network_configuration()?.receive_identifiers().collect(),
        Protocol::Odrive(positions) => robot.odrive_configuration(positions)?.receive_identifiers().collect(),
    })
}

fn ended<S, C, R, const J: usize, const N: usize>(finished: Finished<S, C, R, J, N>) -> Ended<R, J, N>
where
    S: std::error::Error + Coded + Send + Sync + 'static,
    C: std::error::Error + Coded + Send + Sync + 'static,
{
    let Finished { end, later_faults, outcome, stop, recorder } = finished;
    let end = end.map_err(|error| Failure { code: error.code(), hint: hint(&error), cause: anyhow::Error::new(error) });
    Ended { end, later_faults, outcome, stop, recorder }
}

fn hint<S, C>(error: &RunError<S, C>) -> Option<&'static str> {
    match error {
        RunError::Forbidden(LimitViolation { quantity: Quantity::StartError, .. }) => {
            Some("--approach 5s would go there first")
        }
        RunError::Forbidden(LimitViolation { quantity: Quantity::ApproachVelocity, .. }) => {
            Some("--approach says how long it may take")
        }
        RunError::Loop(LoopFault::Overrun(Overrun { allowed: Allowed::None, .. })) => {
            Some("--overrun skip would go on")
        }
        RunError::Approach(_) => Some("--approach says how long it may take"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use uarm_io::drive::odrive::Positions;
    use uarm_io::time::Duration;

    use super::*;
    use crate::robot::Robot;
    use crate::robot::overrides::Overrides;

    fn odrive(changes: &[(&str, &str)]) -> LoopRobot {
        let mut text = include_str!("../robots/uarm-odrive.toml").to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap().description
    }

    #[test]
    fn the_master_is_told_what_the_robot_file_says_of_the_axes() {
        let robot = odrive(&[
            ("node = 2", "node = 12"),
            ("controller_heartbeat_ms = 10", "controller_heartbeat_ms = 11"),
            ("controller_timeout_ms = 50", "controller_timeout_ms = 60"),
            ("drive_heartbeat_ms = 50", "drive_heartbeat_ms = 70"),
            ("drive_timeout_ms = 200", "drive_timeout_ms = 180\nboot_timeout_ms = 4000\npower_timeout_ms = 1500"),
        ]);
        let configuration = robot.odrive_configuration(Positions::OnRequest).unwrap();
        assert_eq!(configuration.axes.map(|axis| axis.node.raw()), [1, 12, 3]);
        assert_eq!(configuration.axes.map(|axis| axis.counts_per_turn.per_revolution()), [33_739.0; 3]);
        assert_eq!(configuration.axes.map(|axis| axis.rated_torque.newton_metres()), [0.2; 3]);
        let times = configuration.times;
        let told = [times.feed, times.watchdog, times.heartbeat, times.heartbeat_timeout, times.presence, times.state];
        assert_eq!(told, [11, 60, 70, 180, 4_000, 1_500].map(Duration::from_millis));
        assert_eq!(configuration.positions, Positions::OnRequest);
    }

    /// Node times 32 plus what an axis sends (00h, 01h, 09h, 15h, 17h) and what only its master does; for CANopen 80h, 180h, 580h and 700h plus the node.
    #[test]
    fn the_kernel_lets_through_what_the_drives_of_the_protocol_send() {
        let of = |robot: &LoopRobot| {
            let mut raw: Vec<_> = receive_identifiers(robot).unwrap().iter().map(|id| id.as_raw()).collect();
            raw.sort_unstable();
            raw
        };
        let axis = [0x00, 0x01, 0x02, 0x07, 0x09, 0x0B, 0x0E, 0x15, 0x17, 0x18];
        let expected: Vec<u16> =
            [0x20, 0x40, 0x60].iter().flat_map(|node| axis.map(|message| node + message)).collect();
        assert_eq!(of(&odrive(&[])), expected);
        let canopen = of(&Robot::load(None).unwrap().description);
        assert!([0x081, 0x182, 0x583, 0x701].iter().all(|id| canopen.contains(id)), "{canopen:03X?}");
    }

    #[test]
    fn a_node_that_no_axis_can_have_is_an_error_of_the_joint() {
        let mut robot = odrive(&[]);
        robot.joints[1].node = uarm_io::drive::NodeId::new(63).unwrap();
        let error = robot.odrive_configuration(Positions::OnRequest).unwrap_err();
        assert_eq!(error.to_string(), "joint 2: node 63, expected 1 to 62 for an ODrive axis");
    }
}
