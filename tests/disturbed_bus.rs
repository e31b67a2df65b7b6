//! What happens on the bus, to a drive or to the interface ends a run: on the real loop in virtual time, by which code, and how soon all
//! brakes are closed.

use hinf_control::Law;
use uarm::campaign::fault::{Fault, ForeignFault};
use uarm::campaign::observation::{End, Observation};
use uarm::campaign::scenario::Scenario;
use uarm::campaign::trial::observe;
use uarm::robot::Robot;
use uarm_io::time::Duration;
use uarm_loop::fault_code::FaultCode;
use uarm_sim::{Brake, DriveFault, Joint};

/// Phases of the task: at rest, in acceleration, at full velocity, in the hold. Cycles of 3 ms.
const PHASES: [u64; 4] = [3, 200, 500, 1_100];
/// `control.period_us` in robots/uarm.toml.
const PERIOD: Duration = Duration::from_millis(3);
/// `controller_timeout_ms` and `controller_heartbeat_ms` there, and two periods.
const BY_WATCHDOG: Duration = Duration::from_millis(50 + 10 + 6);

/// A run of controller 1 in which `fault` happens to the drive of joint 2 with SYNC number `cycle`, counted from 0.
fn observed(fault: Fault, cycle: u64) -> Observation {
    let robot = Robot::load(None).unwrap();
    let drawn = Scenario::draw(&robot, 1).unwrap();
    let scenario = Scenario {
        law: Law::Nonlinear,
        plant: robot.plant.uarm,
        start_offset: Default::default(),
        fault,
        joint: Joint::TWO,
        cycle,
        ..drawn
    };
    observe(&robot, &scenario).unwrap()
}

/// In every phase the run ends with `code`, and all brakes are closed `within` that time.
#[track_caller]
fn ends(fault: Fault, code: FaultCode, within: Duration) {
    for cycle in PHASES {
        let found = observed(fault, cycle);
        assert_eq!(found.end, End::Fault(code), "{fault:?} at {cycle}");
        assert_eq!(found.brakes, [Brake::Engaged; 3], "{fault:?} at {cycle}");
        let took = found.reaction().unwrap();
        assert!(took <= within, "{fault:?} at {cycle}: {took:?}");
        // The cycle of the fault leaves no record, or is the last that does.
        assert!(found.recorded <= cycle + 1, "{fault:?} at {cycle}: {} cycles", found.recorded);
    }
}

#[test]
fn a_bus_without_a_fault_ends_nothing() {
    assert_eq!(observed(Fault::Nothing, 500).end, End::Completed);
}

#[test]
fn a_second_answer_to_one_sync() {
    ends(Fault::FeedbackTwice, FaultCode::TwoDrivesOneNode, PERIOD);
}

#[test]
fn what_only_this_controller_may_send() {
    for foreign in [ForeignFault::Sync, ForeignFault::Heartbeat, ForeignFault::Torque] {
        ends(Fault::Foreign(foreign), FaultCode::OtherMaster, PERIOD);
    }
    // The drives hear these, and then no command of this controller: their watchdogs brake.
    for foreign in [ForeignFault::NmtStop, ForeignFault::NmtReset] {
        ends(Fault::Foreign(foreign), FaultCode::OtherMaster, BY_WATCHDOG);
    }
}

#[test]
fn a_boot_up_message() {
    ends(Fault::BootUp, FaultCode::DriveRebooted, PERIOD);
}

#[test]
fn an_emergency_with_all_bytes_or_none() {
    for bytes in [0, 3, 8] {
        ends(Fault::Emergency { bytes }, FaultCode::DriveEmergency, PERIOD);
    }
}

/// Its drive is switched off, and says so in the statusword and by an emergency.
#[test]
fn a_drive_that_faults() {
    ends(Fault::Drive(DriveFault::OverTemperature), FaultCode::DriveEmergency, PERIOD);
}

#[test]
fn an_interface_that_refuses_one_frame() {
    ends(Fault::LinkRefusesOnce, FaultCode::LinkFailed, PERIOD);
}

/// Nothing of the stop arrives: the drives brake by the watchdogs that the start has armed.
#[test]
fn an_interface_that_refuses_every_frame() {
    ends(Fault::LinkDown, FaultCode::LinkFailed, BY_WATCHDOG);
}
