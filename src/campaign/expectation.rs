//! How a run with a fault may end, and how soon its brakes must be closed.

use std::time::Duration;

use uarm_loop::estimation::MOST_PREDICTED;
use uarm_loop::fault_code::FaultCode;
use uarm_sim::DriveFault;

use super::fault::{Fault, ForeignFault};
use crate::robot::Robot;

/// What must become of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expectation {
    /// May the motion come to its end as if nothing had happened?
    pub may_complete: bool,
    /// The faults by one of which it may end.
    pub faults: &'static [FaultCode],
    /// How long after the fault all brakes must be closed, if it ends by it; nothing where it shows only later.
    pub within: Option<Duration>,
    /// For how long the joint may have all of its torque after the fault: from then on it shows.
    pub full_torque_for: Option<Duration>,
    /// May the joint's brake stay open, and the joint go on?
    pub brake_may_fail: bool,
}

/// Cycles from what shows in one to brakes that are closed: the cycle itself, and the stop's first frames.
const CYCLES_TO_STOP: u32 = 2;
/// For how long a joint may have all of its torque whose encoder or motor does not do what the torque asks of it.
const FULL_TORQUE: Duration = Duration::from_millis(250);
/// What a stop that was asked for may take.
const REQUESTED_STOP: Duration = Duration::from_millis(110);

impl Expectation {
    /// What must become of a run of `robot` with `fault`.
    pub fn of(fault: Fault, robot: &Robot) -> Self {
        let period = robot.description.period.duration();
        let at_once = Some(period * CYCLES_TO_STOP);
        // The angle of a joint is predicted for some cycles.
        let after_prediction = Some(period * (MOST_PREDICTED + CYCLES_TO_STOP));
        // The drive brakes by itself when it misses the controller's heartbeat, of which one may just have come.
        let bus = &robot.description.bus;
        let by_watchdog = Some(bus.controller_timeout + bus.controller_heartbeat + period * CYCLES_TO_STOP);
        let ends =
            |faults, within| Self { may_complete: false, faults, within, full_torque_for: None, brake_may_fail: false };
        let may_end = |faults, within| Self { may_complete: true, ..ends(faults, within) };
        // At rest, or under a torque that friction may hold, nothing tells of it.
        let shows_at_full_torque = Self { full_torque_for: Some(FULL_TORQUE), ..may_end(ENCODER, None) };
        match fault {
            Fault::Nothing => may_end(&[], None),
            Fault::StopRequest => ends(&[], Some(REQUESTED_STOP)),
            Fault::Drive(fault) => match fault {
                DriveFault::PowerLost => ends(&[FaultCode::FeedbackMissing], after_prediction),
                DriveFault::BusDisconnected => ends(&[FaultCode::FeedbackMissing], by_watchdog),
                DriveFault::EncoderJump { .. } => may_end(ENCODER, None),
                DriveFault::EncoderStuck
                | DriveFault::EncoderReversed
                | DriveFault::TorqueReversed
                | DriveFault::BrakeStuckEngaged => shows_at_full_torque,
                DriveFault::EncoderDrift { .. } => ends(ENCODER, at_once),
                DriveFault::OverTemperature => ends(&[FaultCode::DriveEmergency, FaultCode::DriveNotEnabled], at_once),
                DriveFault::BrakeStuckReleased => Self { brake_may_fail: true, ..may_end(&[], None) },
                _ => may_end(ENCODER, None),
            },
            Fault::FeedbackLost { cycles } if cycles > u64::from(MOST_PREDICTED) => {
                ends(&[FaultCode::FeedbackMissing], after_prediction)
            }
            Fault::FeedbackLost { .. } | Fault::FeedbackShort => may_end(&[], None),
            Fault::FeedbackTwice => ends(&[FaultCode::TwoDrivesOneNode], at_once),
            // The drives answer it, too.
            Fault::Foreign(ForeignFault::Sync) => ends(&[FaultCode::OtherMaster, FaultCode::TwoDrivesOneNode], at_once),
            Fault::Foreign(ForeignFault::Heartbeat | ForeignFault::Torque) => ends(&[FaultCode::OtherMaster], at_once),
            Fault::Foreign(ForeignFault::NmtStop | ForeignFault::NmtReset) => {
                ends(&[FaultCode::OtherMaster, FaultCode::DriveRebooted], by_watchdog)
            }
            Fault::BootUp => ends(&[FaultCode::DriveRebooted], at_once),
            Fault::Emergency { .. } => ends(&[FaultCode::DriveEmergency], at_once),
            Fault::LinkRefusesOnce => ends(&[FaultCode::LinkFailed], at_once),
            Fault::LinkDown => ends(&[FaultCode::LinkFailed], by_watchdog),
            // What the drives' watchdogs bear, the loop has to.
            Fault::Suspended { duration } if duration + bus.controller_heartbeat + period < bus.controller_timeout => {
                may_end(&[], None)
            }
            Fault::Suspended { .. } => may_end(&[FaultCode::DriveEmergency, FaultCode::DriveNotEnabled], None),
        }
    }
}

/// By what a run may end whose encoder, brake or motor does not do what the torque asks of it.
const ENCODER: &[FaultCode] = &[
    FaultCode::EncoderImplausible,
    FaultCode::TrackingError,
    FaultCode::JointVelocity,
    FaultCode::JointAngle,
    FaultCode::TorqueSaturated,
    FaultCode::EncoderStuck,
    FaultCode::TorqueReversed,
    FaultCode::ModelContradicted,
];
