//! Supply voltage and temperature in a run: drives that leave their limits, or do not tell any more, on the real loop in virtual time.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm::campaign::fault::Fault;
use uarm::campaign::injection::{Bench, Injection, Seen};
use uarm::dimensions::{CycleRecord, Progress};
use uarm::robot::overrides::Overrides;
use uarm::robot::{BUILT_IN, Robot};
use uarm::simulated_plant::{PlantChoice, SimulatedPlant};
use uarm::simulated_robot::emulate;
use uarm_io::drive::DriveNetwork;
use uarm_io::time::Duration;
use uarm_loop::fault_code::{Coded, FaultCode};
use uarm_loop::run::{Observer, run};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{DriveFault, InProcessLink, Joint, Pacing, VirtualClock};

/// What the standard and the emulated drive have.
const WATCHED: &str = "supply_voltage_v = { stop_below = 20.0, warn_below = 22.0, warn_above = 26.0, stop_above = 28.0 }, \
     temperature_c = { object = { index = 0x2010, subindex = 0, type = \"i16\", unit = 0.1 }, warn_above = 70.0, stop_above = 80.0 }";
/// For how long brakes are watched after the run.
const AFTER_THE_RUN: Duration = Duration::from_millis(100);

/// What came of a run.
#[derive(Debug)]
struct Ending {
    /// Why it ended; nothing if the motion came to its end.
    code: Option<FaultCode>,
    message: String,
    /// From the fault to closed brakes.
    took: Option<Duration>,
    warnings: u64,
    /// Cycles of the loop.
    cycles: usize,
}

/// The paper's robot with all drives watched, on which `fault` happens to the drive of joint 2 with SYNC number `cycle`.
fn ending(fault: Fault, cycle: u64) -> Ending {
    let text =
        BUILT_IN.replace("drive = { rated_torque_nm = 0.2,", &format!("drive = {{ {WATCHED}, rated_torque_nm = 0.2,"));
    let robot = Robot::parse(Path::new("watched.toml"), &text, &Overrides::default()).unwrap();
    let mut clock = VirtualClock::default();
    let plant = SimulatedPlant::new(&robot, PlantChoice::Uarm, Disturbance::None).unwrap();
    let mut link = InProcessLink::new(emulate(&robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    if let (Fault::Drive(fault), 0) = (fault, cycle) {
        link.inject(Joint::TWO, fault);
    }
    let bench = Rc::new(RefCell::new(Bench { link, seen: Seen::default() }));
    let stop = StopRequest::default();
    let nodes = robot.description.joints.each_ref().map(|joint| joint.node);
    let happens = (fault, Joint::TWO, if cycle == 0 { u64::MAX } else { cycle });
    let injection = Injection::new(Rc::clone(&bench), clock.clone(), happens, nodes, &stop);
    let settings = Settings { guard: AdaptationGuard::Bounded, ..Settings::paper(Law::Nonlinear) };
    let mut controller = robot.controller(settings.law, settings.guard).unwrap();
    let drives = DriveNetwork::new(injection, robot.description.network_configuration().unwrap());
    let observer = Observer { progress: &Progress::default(), stop: &stop };
    let records: Vec<CycleRecord> = Vec::new();
    let finished =
        run(&robot.description, &settings, controller.as_mut(), drives, &mut clock, records, observer).unwrap();
    let bench = &mut *bench.borrow_mut();
    bench.settle(&clock, AFTER_THE_RUN);
    let seen = bench.seen;
    Ending {
        code: finished.end.as_ref().err().map(Coded::code),
        message: finished.end.as_ref().err().map(|error| error.to_string()).unwrap_or_default(),
        took: seen.braked_at.zip(seen.fault_at).map(|(braked, fault)| braked.since(fault)),
        warnings: finished.outcome.reading_warnings,
        cycles: finished.recorder.len(),
    }
}

const SECOND: Duration = Duration::from_secs(1);
/// At rest, in acceleration, at full velocity.
const PHASES: [u64; 3] = [1, 200, 500];

#[test]
fn drives_within_their_limits_are_read_without_a_word() {
    let found = ending(Fault::Nothing, 1);
    assert_eq!((found.code, found.warnings), (None, 0), "{found:?}");
}

#[test]
fn voltage_and_temperature_beyond_their_limits_end_a_run() {
    for (fault, code, words) in [
        (
            DriveFault::SupplyVoltage { millivolts: 19_900 },
            FaultCode::SupplyVoltage,
            "node 2: supply voltage 19.9 V, expected 20 to 28 V",
        ),
        (DriveFault::SupplyVoltage { millivolts: 28_100 }, FaultCode::SupplyVoltage, "node 2: supply voltage 28.1 V"),
        (
            DriveFault::Temperature { tenths: 801 },
            FaultCode::Temperature,
            "node 2: temperature 80.1 deg C, expected at most 80 deg C",
        ),
        (DriveFault::SdoSilent, FaultCode::ReadingMissing, "node 2 does not tell its supply voltage or temperature"),
    ] {
        for cycle in PHASES {
            let found = ending(Fault::Drive(fault), cycle);
            assert_eq!(found.code, Some(code), "{fault:?}: {found:?}");
            assert!(found.message.contains(words), "{}", found.message);
            assert!(found.took.is_some_and(|took| took < SECOND), "{fault:?} at {cycle}: {found:?}");
            println!("{fault:?} at cycle {cycle}: {:?}", found.took);
        }
    }
}

#[test]
fn what_is_worth_a_warning_is_told_and_the_run_goes_on() {
    for fault in [DriveFault::SupplyVoltage { millivolts: 21_000 }, DriveFault::Temperature { tenths: 750 }] {
        let found = ending(Fault::Drive(fault), 200);
        assert_eq!(found.code, None, "{found:?}");
        // Read every 0.3 s for the 2.9 s that are left.
        assert!((8..=11).contains(&found.warnings), "{found:?}");
    }
}

#[test]
fn no_brake_opens_on_a_drive_beyond_its_limits() {
    let found = ending(Fault::Drive(DriveFault::SupplyVoltage { millivolts: 10_000 }), 0);
    assert_eq!((found.code, found.cycles), (Some(FaultCode::SupplyVoltage), 0), "{found:?}");
}
