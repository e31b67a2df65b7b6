//! Names of what ends a run, the same in reports, logs and documents.

use serde::Serialize;
use uarm_io::drive::network::{CycleError, Disturbance, StartError};
use uarm_io::drive::odrive::{OdriveCycleError, OdriveStartError};
use uarm_io::drive::readings::Quantity as Reading;

use crate::control_loop::LoopFault;
use crate::estimation::{AngleError, EstimationError};
use crate::guard::{LimitViolation, Quantity};
use crate::run::RunError;
use crate::signal_path::SignalFault;
use crate::supervision::SupervisionFault;
use crate::supervision::decision::Contradiction;

/// Why a run ended otherwise than asked for, in one of few names. What was found and expected is in the error itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultCode {
    /// The CAN interface or its driver failed.
    LinkFailed,
    /// A drive did not boot, or was not heard.
    DriveNotFound,
    /// A drive is another than the robot file says, or lacks what a run needs.
    DriveRefused,
    /// A drive did not come to a state while it was started.
    DriveNotReady,
    /// A drive's watchdog was tried and did not act.
    WatchdogSilent,
    /// The joints are not where the motion begins.
    StartPosition,
    /// A joint turns before the brakes opened.
    JointTurning,
    /// The approach would be faster than a joint may be, or cannot be planned.
    ApproachImpossible,
    /// Frames were heard that only this controller may send.
    OtherMaster,
    /// A drive booted anew.
    DriveRebooted,
    /// Two drives have one node id.
    TwoDrivesOneNode,
    /// Counts of a joint did not come in time.
    FeedbackMissing,
    /// A drive left the state in which it follows torques.
    DriveNotEnabled,
    /// A drive ignores its target torque.
    TargetIgnored,
    /// A drive sent an emergency message.
    DriveEmergency,
    /// A drive's heartbeat stopped.
    DriveSilent,
    /// A drive left NMT Operational.
    DriveNotOperational,
    /// The supply voltage of a drive is beyond its limits.
    SupplyVoltage,
    /// A drive or motor is too hot, or too cold.
    Temperature,
    /// A drive does not tell its supply voltage or temperature any more.
    ReadingMissing,
    /// An encoder's counts cannot be where the joint went.
    EncoderImplausible,
    /// A joint is outside its angles.
    JointAngle,
    /// A joint is faster than it may be.
    JointVelocity,
    /// A joint is too far from its reference.
    TrackingError,
    /// A torque is no number, or none that can be sent.
    TorqueInvalid,
    /// An estimate, a result of the law or an adapted parameter is NaN or infinite.
    NotFinite,
    /// The torque of a joint was cut by its limits for too long.
    TorqueSaturated,
    /// A counter stands still under a torque that must move its joint.
    EncoderStuck,
    /// A joint accelerates against its torque.
    TorqueReversed,
    /// Counts and torques contradict the model.
    ModelContradicted,
    /// A cycle came too late.
    Overrun,
    /// A drive did not confirm at the end that its power is off.
    StopUnconfirmed,
}

crate::choice! {
    FaultCode:
    LinkFailed = "link-failed", "The CAN interface or its driver failed";
    DriveNotFound = "drive-not-found", "A drive did not boot, or was not heard";
    DriveRefused = "drive-refused", "A drive is another than the robot file says, or lacks what a run needs";
    DriveNotReady = "drive-not-ready", "A drive did not come to a state while it was started";
    WatchdogSilent = "watchdog-silent", "A drive's watchdog was tried at start and did not act";
    StartPosition = "start-position", "The joints are not where the motion begins";
    JointTurning = "joint-turning", "A joint turns before the brakes opened";
    ApproachImpossible = "approach-impossible", "The approach would be too fast for a joint, or cannot be planned";
    OtherMaster = "other-master", "Frames were heard that only this controller may send";
    DriveRebooted = "drive-rebooted", "A drive booted anew after it was set up";
    TwoDrivesOneNode = "two-drives-one-node", "Two drives answer with one node id";
    FeedbackMissing = "feedback-missing", "Counts of a joint did not come in time";
    DriveNotEnabled = "drive-not-enabled", "A drive left the state in which it follows torques";
    TargetIgnored = "target-ignored", "A drive ignores its target torque";
    DriveEmergency = "drive-emergency", "A drive sent an emergency message";
    DriveSilent = "drive-silent", "A drive's heartbeat stopped";
    DriveNotOperational = "drive-not-operational", "A drive left NMT Operational";
    SupplyVoltage = "supply-voltage", "The supply voltage of a drive is beyond its limits";
    Temperature = "temperature", "A drive or motor is too hot, or too cold";
    ReadingMissing = "reading-missing", "A drive does not tell its supply voltage or temperature any more";
    EncoderImplausible = "encoder-implausible", "An encoder's counts cannot be where the joint went";
    JointAngle = "joint-angle", "A joint is outside its angles";
    JointVelocity = "joint-velocity", "A joint is faster than it may be";
    TrackingError = "tracking-error", "A joint is too far from its reference";
    TorqueInvalid = "torque-invalid", "A torque is no number, or none that can be sent";
    NotFinite = "not-finite", "An estimate, a result of the law or an adapted parameter is NaN or infinite";
    TorqueSaturated = "torque-saturated", "The torque of a joint was cut by its limits for too long";
    EncoderStuck = "encoder-stuck", "A counter stands still under a torque that must move its joint";
    TorqueReversed = "torque-reversed", "A joint accelerates against its torque";
    ModelContradicted = "model-contradicted", "Counts and torques of a joint contradict the model";
    Overrun = "overrun", "A cycle came too late";
    StopUnconfirmed = "stop-unconfirmed", "A drive did not confirm at the end that its power is off";
}

impl FaultCode {
    /// Whether it comes from the signals of a cycle, and so again in a replay; what drives and bus do does not.
    pub const fn is_of_signals(self) -> bool {
        matches!(
            self,
            Self::StartPosition
                | Self::FeedbackMissing
                | Self::EncoderImplausible
                | Self::JointAngle
                | Self::JointVelocity
                | Self::TrackingError
                | Self::TorqueInvalid
                | Self::NotFinite
                | Self::TorqueSaturated
                | Self::EncoderStuck
                | Self::TorqueReversed
                | Self::ModelContradicted
        )
    }
}

/// An error that has a [`FaultCode`].
pub trait Coded {
    /// Its code.
    fn code(&self) -> FaultCode;
}

impl Coded for Disturbance {
    fn code(&self) -> FaultCode {
        match self {
            Self::Rebooted { .. } => FaultCode::DriveRebooted,
            Self::AnotherMaster(_) => FaultCode::OtherMaster,
            Self::Twins { .. } | Self::SdoTwins { .. } => FaultCode::TwoDrivesOneNode,
        }
    }
}

/// The code of a quantity beyond its limits.
const fn of_reading(quantity: Reading) -> FaultCode {
    match quantity {
        Reading::SupplyVoltage => FaultCode::SupplyVoltage,
        Reading::Temperature => FaultCode::Temperature,
    }
}

impl<E> Coded for StartError<E> {
    fn code(&self) -> FaultCode {
        match self {
            Self::Link(_) => FaultCode::LinkFailed,
            Self::Disturbed(disturbance) => disturbance.code(),
            Self::Emergency { .. } => FaultCode::DriveEmergency,
            Self::NoBootUp { .. } => FaultCode::DriveNotFound,
            Self::Reading { found, .. } => of_reading(found.quantity),
            Self::WatchdogSilent { .. } => FaultCode::WatchdogSilent,
            Self::NotOperational { .. } | Self::NotReached { .. } => FaultCode::DriveNotReady,
            Self::Sdo(_)
            | Self::NotADrive { .. }
            | Self::ReadBack { .. }
            | Self::Undone { .. }
            | Self::Mismatch { .. }
            | Self::Refused { .. } => FaultCode::DriveRefused,
        }
    }
}

impl<E> Coded for CycleError<E> {
    fn code(&self) -> FaultCode {
        match self {
            Self::Link(_) => FaultCode::LinkFailed,
            Self::Disturbed(disturbance) => disturbance.code(),
            Self::NotEnabled { .. } => FaultCode::DriveNotEnabled,
            Self::TargetIgnored { .. } => FaultCode::TargetIgnored,
            Self::Emergency { .. } => FaultCode::DriveEmergency,
            Self::Lost { .. } => FaultCode::DriveSilent,
            Self::Reading { found, .. } => of_reading(found.quantity),
            Self::NoReading { .. } => FaultCode::ReadingMissing,
            Self::NotOperational { .. } => FaultCode::DriveNotOperational,
        }
    }
}

impl Coded for EstimationError {
    fn code(&self) -> FaultCode {
        match self.source {
            AngleError::Encoder(_) | AngleError::Implausible { .. } => FaultCode::EncoderImplausible,
            AngleError::NoneYet | AngleError::Missing { .. } => FaultCode::FeedbackMissing,
        }
    }
}

impl<E> Coded for OdriveStartError<E> {
    fn code(&self) -> FaultCode {
        match self {
            Self::Link(_) => FaultCode::LinkFailed,
            Self::AnotherMaster(_) => FaultCode::OtherMaster,
            Self::TwoAxes { .. } => FaultCode::TwoDrivesOneNode,
            Self::NotHeard { .. } => FaultCode::DriveNotFound,
            Self::Reading { found, .. } => of_reading(found.quantity),
            Self::NoReading { .. } => FaultCode::ReadingMissing,
            Self::NotReached { .. } | Self::NoPosition { .. } => FaultCode::DriveNotReady,
            Self::Position { .. } => FaultCode::EncoderImplausible,
            Self::Unrequested { .. } | Self::AnotherProduct { .. } => FaultCode::DriveRefused,
            Self::NoWatchdog { .. } => FaultCode::WatchdogSilent,
        }
    }
}

impl<E> Coded for OdriveCycleError<E> {
    fn code(&self) -> FaultCode {
        match self {
            Self::Link(_) => FaultCode::LinkFailed,
            Self::AnotherMaster(_) => FaultCode::OtherMaster,
            Self::TwoAxes { .. } => FaultCode::TwoDrivesOneNode,
            Self::Position { .. } => FaultCode::EncoderImplausible,
            Self::NotArmed { .. } => FaultCode::DriveNotEnabled,
            Self::Reading { found, .. } => of_reading(found.quantity),
            Self::NoReading { .. } => FaultCode::ReadingMissing,
            Self::Lost { .. } => FaultCode::DriveSilent,
        }
    }
}

impl Coded for LimitViolation {
    fn code(&self) -> FaultCode {
        match self.quantity {
            Quantity::Position | Quantity::StoppingAngle => FaultCode::JointAngle,
            Quantity::Velocity | Quantity::StoppingVelocity => FaultCode::JointVelocity,
            Quantity::TrackingError => FaultCode::TrackingError,
            Quantity::StartError => FaultCode::StartPosition,
            Quantity::ApproachVelocity => FaultCode::ApproachImpossible,
        }
    }
}

impl Coded for SupervisionFault {
    fn code(&self) -> FaultCode {
        match self.source {
            Contradiction::Stuck { .. } | Contradiction::Stopped(_) => FaultCode::EncoderStuck,
            Contradiction::Reversed { .. } => FaultCode::TorqueReversed,
            Contradiction::Residual { .. } => FaultCode::ModelContradicted,
        }
    }
}

impl Coded for SignalFault {
    fn code(&self) -> FaultCode {
        match self {
            Self::Estimation(error) => error.code(),
            Self::Limit(violation) => violation.code(),
            Self::NotFinite(_) => FaultCode::NotFinite,
            Self::Saturation(_) => FaultCode::TorqueSaturated,
            Self::Supervision(fault) => fault.code(),
            Self::Torque(_) => FaultCode::TorqueInvalid,
        }
    }
}

impl<E: Coded> Coded for LoopFault<E> {
    fn code(&self) -> FaultCode {
        match self {
            Self::Drives(error) => error.code(),
            Self::Signals(fault) => fault.code(),
            Self::Overrun(_) => FaultCode::Overrun,
        }
    }
}

impl<S: Coded, C: Coded> Coded for RunError<S, C> {
    fn code(&self) -> FaultCode {
        match self {
            Self::Start(error) => error.code(),
            Self::Encoder(error) => error.code(),
            Self::Approach(_) => FaultCode::ApproachImpossible,
            Self::Forbidden(violation) => match violation.quantity {
                // Before brakes open: the joint stands there.
                Quantity::Position => FaultCode::StartPosition,
                _ => violation.code(),
            },
            Self::Turning(_) => FaultCode::JointTurning,
            Self::Loop(fault) => fault.code(),
            Self::NotOff(_) => FaultCode::StopUnconfirmed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::Choice;

    type Error = RunError<StartError<()>, CycleError<()>>;

    fn name(error: Error) -> &'static str {
        error.code().name()
    }

    fn violation(quantity: Quantity) -> LimitViolation {
        LimitViolation { joint: 2, time: 0.0, quantity, found: 2.0, allowed: [0.0, 1.0], braking: None }
    }

    #[test]
    fn a_joint_outside_its_angles_is_told_apart_before_and_after_the_brakes_opened() {
        assert_eq!(name(RunError::Forbidden(violation(Quantity::Position))), "start-position");
        let moving = LoopFault::Signals(SignalFault::Limit(violation(Quantity::Position)));
        assert_eq!(name(RunError::Loop(moving)), "joint-angle");
    }

    #[test]
    fn the_drives_say_who_is_to_blame() {
        let drives = |error| name(RunError::Loop(LoopFault::Drives(error)));
        assert_eq!(drives(CycleError::Disturbed(Disturbance::Rebooted { node: 2 })), "drive-rebooted");
        assert_eq!(drives(CycleError::Disturbed(Disturbance::Twins { node: 2 })), "two-drives-one-node");
        assert_eq!(drives(CycleError::Link(())), "link-failed");
        assert_eq!(name(RunError::Start(StartError::Link(()))), "link-failed");
    }
}
