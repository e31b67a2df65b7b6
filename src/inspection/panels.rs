//! What is plotted of a run: the same panels in figures and in terminals.

use std::ops::Range;

use uarm_log::description::ClockKind;
use uarm_loop::uarm_io::time::Instant;

use uarm_plot::envelope::Envelope;
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

/// All panels of a run, gathered cycle by cycle in memory that does not grow with the run.
#[derive(Debug)]
pub struct RunPlots {
    plots: Vec<Plot>,
    /// When the flight recorder's window begins, of a run that failed.
    window_start: Option<Instant>,
    /// Task time of the first cycle of that window and of the last cycle, s.
    window: Option<Range<f64>>,
}

impl RunPlots {
    /// No cycle yet, of the run that `log` tells of; its own cycles are not looked at.
    pub fn new(log: &RunLog) -> Self {
        let mut plots = vec![Plot::tracking_error(), Plot::torque(), Plot::base()];
        // Virtual time passes only while the loop sleeps: it has no latencies.
        if log.run.clock() == ClockKind::Monotonic {
            plots.push(Plot::latencies());
        }
        let window_start = log.fault.as_ref().map(|fault| log.run.axis.instant(fault.window_start_ns));
        Self { plots, window_start, window: None }
    }

    /// Takes the next cycle.
    pub fn take(&mut self, record: &CycleRecord) {
        self.plots.iter_mut().for_each(|plot| plot.take(record));
        match &mut self.window {
            Some(window) => window.end = record.time,
            None if self.window_start.is_some_and(|start| record.instants.done >= start) => {
                self.window = Some(record.time..record.time);
            }
            None => {}
        }
    }

    /// The panels as one figure of the run that `log` tells of.
    pub fn sheet(self, log: &RunLog) -> Sheet {
        let mut panels: Vec<Panel> = self.plots.iter().map(Plot::panel).collect();
        for panel in &mut panels {
            panel.shade = self.window.clone().map(|window| (window, "flight recorder".to_owned()));
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
}

/// What stands below a figure's title: the file, and the first cause of a fault.
fn note(log: &RunLog) -> String {
    let file = log.path.file_name().unwrap_or_default().to_string_lossy();
    log.fault.as_ref().map_or_else(|| file.to_string(), |fault| format!("{file}; {}", fault.cause))
}

/// A panel that is gathered cycle by cycle.
#[derive(Debug)]
pub struct Plot {
    title: &'static str,
    label: &'static str,
    /// Task time of the earliest and the latest cycle, s.
    times: Option<[f64; 2]>,
    curves: Vec<(Stroke, Signal, Envelope)>,
}

impl Plot {
    fn new(title: &'static str, label: &'static str, signals: &[(Stroke, Signal)]) -> Self {
        let curves = signals.iter().map(|(stroke, signal)| (*stroke, *signal, Envelope::default())).collect();
        Self { title, label, times: None, curves }
    }

    /// Errors of joints 2 and 3.
    pub fn tracking_error() -> Self {
        let signals: [(Stroke, Signal); 2] = [
            (JOINT_2, |record| record.tracking_error().position.x.to_degrees()),
            (JOINT_3, |record| record.tracking_error().position.y.to_degrees()),
        ];
        Self::new("Tracking error", "Error (\u{b0})", &signals)
    }

    /// Torques of joints 2 and 3 behind the limiter, and those that their drives reported, if any did.
    pub fn torque() -> Self {
        let signals: [(Stroke, Signal); 4] = [
            (JOINT_2, |record| record.torque_applied[0]),
            (JOINT_3, |record| record.torque_applied[1]),
            (REPORTED_2, |record| reported_torque(record, 1)),
            (REPORTED_3, |record| reported_torque(record, 2)),
        ];
        Self::new("Torque applied", "Torque (N\u{b7}m)", &signals)
    }

    /// The base's angle.
    pub fn base() -> Self {
        let angle: Signal = |record| record.position[0].to_degrees();
        Self::new("Base attitude", "Attitude (\u{b0})", &[(BASE, angle)])
    }

    /// Latencies of each cycle.
    pub fn latencies() -> Self {
        let signals: [(Stroke, Signal); 3] = [
            (TOTAL, |record| record.instants.total().as_secs_f64() * 1e6),
            (WAKE_UP, |record| record.instants.wake_up().as_secs_f64() * 1e6),
            (FEEDBACK, |record| record.instants.feedback_latency().as_secs_f64() * 1e6),
        ];
        Self::new("Loop latencies", "Latency (\u{b5}s)", &signals)
    }

    /// Takes the next cycle.
    fn take(&mut self, record: &CycleRecord) {
        let [earliest, latest] = self.times.unwrap_or([record.time; 2]);
        self.times = Some([earliest.min(record.time), latest.max(record.time)]);
        for (_, signal, envelope) in &mut self.curves {
            envelope.take([record.time, signal(record)]);
        }
    }

    /// The panel of these cycles.
    pub fn of(mut self, cycles: &[CycleRecord]) -> Panel {
        cycles.iter().for_each(|record| self.take(record));
        self.panel()
    }

    /// The panel of the cycles so far; a curve without a point is left out.
    fn panel(&self) -> Panel {
        let curves: Vec<(Stroke, Vec<_>)> =
            self.curves.iter().map(|(stroke, _, envelope)| (*stroke, envelope.points().collect())).collect();
        let values = curves.iter().flat_map(|(_, points)| points.iter().map(|[_, value]| *value));
        let x = Axis::covering("Time (s)", self.times.into_iter().flatten(), TICKS);
        let y = Axis::covering(self.label, values, TICKS);
        let drawn = curves.into_iter().filter(|(_, points)| !points.is_empty());
        drawn.fold(Panel::new(self.title, x, y), |panel, (stroke, points)| panel.with(stroke, points))
    }
}

/// The torque that the drive of the joint of this index reported, N m; not a number, and so not drawn, without a report.
fn reported_torque(record: &CycleRecord, joint: usize) -> f64 {
    record.torque_actual[joint].map_or(f64::NAN, |actual| actual.newton_metres)
}

#[cfg(test)]
mod tests {
    use uarm_loop::torque::ActualTorque;

    use super::*;

    #[test]
    fn torques_that_no_drive_reported_have_no_curve() {
        let silent = CycleRecord::default();
        let mut reported = silent;
        reported.torque_actual[2] = Some(ActualTorque { per_mille: 10, newton_metres: 0.5 });
        assert_eq!(Plot::torque().of(&[silent]).curves.len(), 2);
        let panel = Plot::torque().of(&[silent, reported]);
        assert_eq!(panel.curves.last().map(|curve| (curve.stroke, curve.points.len())), Some((REPORTED_3, 1)));
        assert_eq!(panel.curves.len(), 3);
    }

    #[test]
    fn a_run_without_cycles_has_panels_without_curves() {
        assert!(Plot::tracking_error().of(&[]).curves.is_empty());
    }
}
