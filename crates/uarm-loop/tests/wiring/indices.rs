//! Over which cycles L2 and E are taken, and what else a report tells.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use uarm_loop::hinf_control::QuinticReference;
use uarm_loop::motion::Motion;
use uarm_loop::nalgebra::Vector2;
use uarm_loop::outcome::{Indices, Outcome};
use uarm_loop::period::Period;
use uarm_loop::record::{CycleFlags, CycleRecord};
use uarm_loop::supervisor::Authority;
use uarm_loop::timing::CycleInstants;
use uarm_loop::uarm_io::time::{Duration, Instant};

use crate::fake_path::{FakeLaw, path, rest, tick};

/// 2⁻⁸ s, so that times are exact.
const PERIOD: f64 = 0.003_906_25;

fn period() -> Period {
    Period::new(Duration::from_nanos(3_906_250)).unwrap()
}

/// Two cycles of approach from (1, 1) rad, four of the task at (0, 0), two that hold it.
fn motion() -> Motion<2> {
    let approach = QuinticReference::new(Vector2::new(1.0, 1.0), Vector2::zeros(), 2.0 * PERIOD).unwrap();
    rest([0.0; 2], 4.0 * PERIOD, 2.0 * PERIOD).after(approach)
}

/// Joints at 300 and 400 counts of TAU/36000 are 500 such counts from zero. E is made of 0.1 N·m that are left of 0.5, and of
/// 0.04 N·m, over four cycles.
#[test]
fn indices_are_taken_over_the_task_alone() {
    let mut law = FakeLaw::constant(0.5, -0.04);
    let mut path = path(&mut law, motion());
    for index in 0..8 {
        let elapsed = u64::from(index > 0);
        let signals = path
            .step(
                &tick(index, elapsed),
                Instant::default(),
                &[Some(0), Some(300), Some(400)],
                period(),
                Authority::Full,
            )
            .unwrap();
        let cycles = i32::try_from(index).unwrap() - 2;
        assert_eq!(signals.time, f64::from(cycles) * PERIOD);
    }
    assert_relative_eq!(path.indices.elapsed(), 4.0 * PERIOD);
    assert_relative_eq!(path.indices.tracking(), 500.0 * TAU / 36_000.0, max_relative = 1e-14);
    assert_relative_eq!(path.indices.torque(), 4.0 * PERIOD * 0.14, max_relative = 1e-14);
}

/// A cycle with tracking errors of 3e and 4e rad/s and rad, and torques of t and −2t.
fn record(time: f64, error: f64, torque: f64) -> CycleRecord<3, 2> {
    CycleRecord {
        tick: 7,
        elapsed_ticks: 1,
        time,
        position: [time, 0.5, 0.5 + 4.0 * error],
        velocity: [9.0, 0.25 + 3.0 * error, 0.0],
        reference_position: [0.5, 0.5],
        reference_velocity: [0.25, 0.0],
        torque_requested: [100.0; 2],
        torque_applied: [torque, -2.0 * torque],
        ..CycleRecord::default()
    }
}

#[test]
fn the_outcome_of_cycles_is_that_of_the_run() {
    let (end, hold) = (4.0 * PERIOD, 5.0 * PERIOD);
    let mut cycles = vec![
        record(-2.0 * PERIOD, 100.0, 0.7),
        record(-PERIOD, 100.0, 0.1),
        record(0.0, 1.0, 0.125),
        record(PERIOD, 1.0, 0.125),
        record(2.0 * PERIOD, 1.0, -0.125),
        record(3.0 * PERIOD, 1.0, 0.125),
        record(end, 100.0, 0.1),
        record(hold, 0.25, 0.1),
    ];
    cycles[0].elapsed_ticks = 0;
    cycles[3].flags = CycleFlags { limited: [false, true], ..CycleFlags::default() };
    cycles[5].flags = CycleFlags { limited: [true, true], ..CycleFlags::default() };
    cycles[6].flags = CycleFlags { at_bound: true, frozen: true, ..CycleFlags::default() };
    let at = Instant::from_nanoseconds;
    cycles[4].instants = CycleInstants { torque_out: at(3_906_251), done: at(9_000_000), ..CycleInstants::default() };
    cycles[5].elapsed_ticks = 3;

    let outcome = Outcome::of_cycles(&motion(), period(), &cycles);
    // Errors of 3 and 4 make 5. Three eighths of a N·m, four times.
    assert_eq!(outcome.indices, Indices { l2: 5.0, e: 4.0 * PERIOD * 0.375 });
    assert_eq!(outcome.last_time, cycles.last().map(|record| record.time));
    assert_eq!(outcome.final_error, [0.0, 1.0]);
    assert_eq!(outcome.peak_torque, [0.7, 1.4], "peaks count from the first cycle to the last");
    assert_eq!(outcome.base_drift, 7.0 * PERIOD);
    assert_eq!(outcome.limited_cycles, 2);
    let timing = outcome.timing;
    assert_eq!((timing.cycles, timing.missed_deadlines, timing.skipped_ticks), (8, 1, 2));
    assert_eq!((timing.period_ns, timing.total.maximum_ns), (3_906_250, 3_906_251));
}

#[test]
fn peaks_are_magnitudes_and_drift_has_a_sign() {
    let cycles = [record(0.5, 0.0, -0.25), record(0.125, 0.0, 0.125)];
    let outcome = Outcome::of_cycles(&motion(), period(), &cycles);
    assert_eq!((outcome.peak_torque, outcome.base_drift), ([0.25, 0.5], -0.375));
    let nothing = Outcome::of_cycles::<3>(&motion(), period(), &[]);
    assert_eq!((nothing.base_drift, nothing.last_time), (0.0, None));
}
