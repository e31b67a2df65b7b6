//! Another law on the same measurements.

use approx::assert_abs_diff_eq;
use uarm_log::replay::bus_cycles::Continuity;
use uarm_log::replay::what_if::WhatIf;
use uarm_log::uarm_loop::guard::JointLimits;
use uarm_log::uarm_loop::hinf_control::QuinticReference;
use uarm_log::uarm_loop::nalgebra::Vector2;
use uarm_log::uarm_loop::uarm_io::time::Duration;

use crate::support::{RampLaw, Run, run};

fn what_if(run: &Run, other: &Run) -> WhatIf<2> {
    WhatIf::run(&run.source(), &other.source(), &mut RampLaw::default()).unwrap()
}

#[test]
fn no_limit_of_the_other_robot_ends_it() {
    let (run, mut other) = (run(5), run(0));
    for joint in &mut other.robot.joints {
        joint.limits = JointLimits { position: [0.5, 0.6], velocity: 1e-9 };
    }
    // Nor is the other robot's task where the joints are.
    let elsewhere = Vector2::new(0.5, -0.5);
    other.robot.task.reference = QuinticReference::new(elsewhere, elsewhere, 3.0).unwrap().into();
    other.robot.task.start_tolerance = 1e-9;
    other.robot.tracking_error_limit = 1e-9;
    let outcome = what_if(&run, &other);
    assert_eq!((outcome.pairs.len(), outcome.lost_cycles), (5, 0));
}

/// The other law asks for 0.05, 0.051 and 0.052 N·m at joint 2, and −0.04 N·m at joint 3.
#[test]
fn torques_are_compared_joint_by_joint() {
    let mut run = run(3);
    for (record, torque) in run.records.iter_mut().zip([[0.06, 0.0], [0.051, -0.04], [0.042, 0.04]]) {
        record.torque_applied = torque;
    }
    let summary = what_if(&run, &run).summary;
    // Differences of −0.01, 0 and 0.01, and of −0.04, 0 and −0.08.
    let rms = |squares: f64| (squares / 3.0).sqrt();
    assert_abs_diff_eq!(summary.rms_difference[0], rms(0.0002), epsilon = 1e-15);
    assert_abs_diff_eq!(summary.rms_difference[1], rms(0.008), epsilon = 1e-15);
    assert_abs_diff_eq!(summary.largest_difference[0], 0.01, epsilon = 1e-15);
    assert_abs_diff_eq!(summary.largest_difference[1], 0.08, epsilon = 1e-15);
    assert_abs_diff_eq!(summary.rms_recorded[0], rms(0.0036 + 0.002_601 + 0.001_764), epsilon = 1e-15);
    assert_abs_diff_eq!(summary.rms_other[1], 0.04, epsilon = 1e-15);
}

#[test]
fn a_late_sync_belongs_to_the_tick_that_was_due() {
    let mut run = run(4).bus_only();
    let start = run.bus[0].sync_at;
    // 2.9 ms, 5.8 ms and 0.1 ms after one another: one, two and, as the least, one tick.
    for (cycle, microseconds) in run.bus.iter_mut().zip([0, 2_900, 8_700, 8_800]) {
        cycle.sync_at = start + Duration::from_micros(microseconds);
    }
    let outcome = what_if(&run, &run);
    let pairs: Vec<_> = outcome.pairs.iter().map(|pair| (pair.tick, pair.time)).collect();
    assert_eq!(pairs, [(0, 0.0), (1, 0.003), (3, 0.009), (4, 0.012)]);
    // 1.6 ms late and in step again: one tick each. 4 ms late: the tick that was due 1 ms ago, and the next one.
    for (microseconds, ticks) in [([0, 3_000, 7_600, 9_000], [0, 1, 2, 3]), ([0, 3_000, 10_000, 12_000], [0, 1, 3, 4])]
    {
        for (cycle, microseconds) in run.bus.iter_mut().zip(microseconds) {
            cycle.sync_at = start + Duration::from_micros(microseconds);
        }
        let found: Vec<_> = what_if(&run, &run).pairs.iter().map(|pair| pair.tick).collect();
        assert_eq!(found, ticks);
    }
    // What the drives were told is what was recorded: 250 and −200 per mille of 0.2 N·m.
    assert_abs_diff_eq!(outcome.pairs[0].recorded[0], 0.05, epsilon = 1e-15);
    assert_abs_diff_eq!(outcome.pairs[0].recorded[1], -0.04, epsilon = 1e-15);
}

#[test]
fn cycles_without_counts_or_with_gaps_are_lost() {
    let mut run = run(6);
    run.bus[1].counts[2] = None;
    run.bus[3].continuity = Continuity::Broken;
    let outcome = what_if(&run, &run);
    let ticks: Vec<u64> = outcome.pairs.iter().map(|pair| pair.tick).collect();
    assert_eq!((ticks, outcome.lost_cycles), (vec![0, 2, 4, 5], 2));
}
