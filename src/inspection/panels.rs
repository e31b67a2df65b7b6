//! What is plotted of a run: the same panels in figures and in terminals.

use std::ops::Range;

use uarm_log::description::ClockKind;

use uarm_plot::sheet::{Axis, Panel, Sheet, legend};
use uarm_plot::style::{BLACK, Dash, PURPLE, SKY_BLUE, Stroke};

use crate::dimensions::{CycleRecord, RunLog};
use crate::figures::style::{BASE, JOINT_2, JOINT_3};

/// Width and height of a figure's row of two panels, points.
const SIZE: [u32; 2] = [1280, 400];
/// Panels in a row.
const COLUMNS: usize = 2;
/// About so many ticks on an axis.
const TICKS: usize = 6;
/// A curve of more points is drawn by the least and the most of neighbours: there are fewer columns than this to draw in.
const MOST_POINTS: usize = 4000;

const WAKE_UP: Stroke = Stroke::solid(SKY_BLUE);
const FEEDBACK: Stroke = Stroke::solid(PURPLE).dashed(Dash::Dashed);
const TOTAL: Stroke = Stroke::solid(BLACK).wide(0.8);

const REPORTED_2: Stroke = Stroke::solid(SKY_BLUE).dashed(Dash::Dotted);
const REPORTED_3: Stroke = Stroke::solid(PURPLE).dashed(Dash::Dotted);

/// What is plotted of a cycle.
type Signal = fn(&CycleRecord) -> f64;

/// What the curves of the panels are.
pub const LEGEND: [(&str, Stroke); 8] = [
    ("joint 2", JOINT_2),
    ("joint 3", JOINT_3),
    ("joint 2, reported", REPORTED_2),
    ("joint 3, reported", REPORTED_3),
    ("base", BASE),
    ("wake-up", WAKE_UP),
    ("SYNC to counts", FEEDBACK),
    ("total", TOTAL),
];

/// All panels of a run as one figure.
pub fn sheet(log: &RunLog) -> Sheet {
    let mut panels = vec![tracking_error(&log.cycles), torque(&log.cycles), base(&log.cycles)];
    // Virtual time passes only while the loop sleeps: it has no latencies.
    if log.run.clock() == ClockKind::Monotonic {
        panels.push(latencies(&log.cycles));
    }
    let window = flight_recorder(log);
    for panel in &mut panels {
        panel.shade = window.clone().map(|window| (window, "flight recorder".to_owned()));
    }
    let [width, row] = SIZE;
    let rows = u32::try_from(panels.len().div_ceil(COLUMNS)).unwrap_or(1);
    let drawn = |(_, stroke): &(&str, Stroke)| {
        panels.iter().any(|panel| panel.curves.iter().any(|curve| curve.stroke == *stroke))
    };
    let entries: Vec<_> = LEGEND.into_iter().filter(drawn).collect();
    Sheet {
        name: "run".into(),
        title: format!("{} on {}, controller {}", log.run.robot.name, log.run.place, log.run.controller),
        note: note(log),
        size: [width, row * rows],
        columns: COLUMNS,
        legend: legend(&entries),
        panels,
    }
}

/// The part before a fault that is marked, in task time.
fn flight_recorder(log: &RunLog) -> Option<Range<f64>> {
    let start = log.run.axis.instant(log.fault.as_ref()?.window_start_ns);
    let first = log.cycles.iter().find(|record| record.instants.done >= start)?;
    Some(first.time..log.cycles.last()?.time)
}

/// What stands below a figure's title: the file, and the first cause of a fault.
fn note(log: &RunLog) -> String {
    let file = log.path.file_name().unwrap_or_default().to_string_lossy();
    log.fault.as_ref().map_or_else(|| file.to_string(), |fault| format!("{file}; {}", fault.cause))
}

/// Errors of joints 2 and 3.
pub fn tracking_error(cycles: &[CycleRecord]) -> Panel {
    panel(
        cycles,
        "Tracking error",
        "Error (\u{b0})",
        &[
            (JOINT_2, |record| record.tracking_error().position.x.to_degrees()),
            (JOINT_3, |record| record.tracking_error().position.y.to_degrees()),
        ],
    )
}

/// Torques of joints 2 and 3 behind the limiter, and those that their drives reported, if any did.
pub fn torque(cycles: &[CycleRecord]) -> Panel {
    let mut signals: Vec<(Stroke, Signal)> =
        vec![(JOINT_2, |record| record.torque_applied[0]), (JOINT_3, |record| record.torque_applied[1])];
    if cycles.iter().any(|record| record.torque_actual.iter().any(Option::is_some)) {
        signals.push((REPORTED_2, |record| reported_torque(record, 1)));
        signals.push((REPORTED_3, |record| reported_torque(record, 2)));
    }
    panel(cycles, "Torque applied", "Torque (N\u{b7}m)", &signals)
}

/// The torque that the drive of the joint of this index reported, N m; not a number, and so not drawn, without a report.
fn reported_torque(record: &CycleRecord, joint: usize) -> f64 {
    record.torque_actual[joint].map_or(f64::NAN, |actual| actual.newton_metres)
}

/// The base's angle.
pub fn base(cycles: &[CycleRecord]) -> Panel {
    panel(cycles, "Base attitude", "Attitude (\u{b0})", &[(BASE, |record| record.position[0].to_degrees())])
}

/// Latencies of each cycle.
pub fn latencies(cycles: &[CycleRecord]) -> Panel {
    panel(
        cycles,
        "Loop latencies",
        "Latency (\u{b5}s)",
        &[
            (TOTAL, |record| record.instants.total().as_secs_f64() * 1e6),
            (WAKE_UP, |record| record.instants.wake_up().as_secs_f64() * 1e6),
            (FEEDBACK, |record| record.instants.feedback_latency().as_secs_f64() * 1e6),
        ],
    )
}

fn panel(cycles: &[CycleRecord], title: &str, label: &str, signals: &[(Stroke, Signal)]) -> Panel {
    let curves: Vec<_> = signals.iter().map(|(stroke, signal)| (*stroke, curve(cycles, *signal))).collect();
    let times = cycles.iter().map(|record| record.time);
    let values = curves.iter().flat_map(|(_, points)| points.iter().map(|[_, value]| *value));
    let (x, y) = (Axis::covering("Time (s)", times, TICKS), Axis::covering(label, values, TICKS));
    curves.into_iter().fold(Panel::new(title, x, y), |panel, (stroke, points)| panel.with(stroke, points))
}

fn curve(cycles: &[CycleRecord], signal: Signal) -> Vec<[f64; 2]> {
    let points = cycles.iter().map(|record| [record.time, signal(record)]);
    let points: Vec<_> = points.filter(|point| point.iter().all(|value| value.is_finite())).collect();
    if points.len() <= MOST_POINTS { points } else { envelope(&points, MOST_POINTS) }
}

/// The least and the most of neighbours, in their order; about `most` points.
fn envelope(points: &[[f64; 2]], most: usize) -> Vec<[f64; 2]> {
    let neighbours = points.len().div_ceil(most / 2);
    let by_value = |one: &(usize, &[f64; 2]), other: &(usize, &[f64; 2])| one.1[1].total_cmp(&other.1[1]);
    let ends = |chunk: &[[f64; 2]]| {
        let least = chunk.iter().enumerate().min_by(by_value).map(|(index, _)| index).unwrap_or_default();
        let most = chunk.iter().enumerate().max_by(by_value).map(|(index, _)| index).unwrap_or_default();
        [chunk[least.min(most)], chunk[least.max(most)]]
    };
    points.chunks(neighbours).flat_map(ends).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_keeps_every_extreme() {
        let points: Vec<[f64; 2]> =
            (0..10_000).map(|k| [f64::from(k), if k == 4321 { 9.0 } else { f64::from(k % 3) }]).collect();
        let drawn = envelope(&points, MOST_POINTS);
        assert!(drawn.len() <= MOST_POINTS, "{}", drawn.len());
        assert!(drawn.contains(&[4321.0, 9.0]));
        assert!(drawn.is_sorted_by(|one, other| one[0] <= other[0]));
    }

    #[test]
    fn a_run_without_cycles_has_panels() {
        assert_eq!(tracking_error(&[]).curves.len(), 2);
        assert!(latencies(&[]).curves.iter().all(|curve| curve.points.is_empty()));
    }
}
