//! What is plotted of a run: the same panels in figures and in terminals.

use std::ops::Range;

use uarm_log::description::ClockKind;
use uarm_loop::dimensions;
use uarm_loop::uarm_io::time::Instant;

use uarm_plot::envelope::Envelope;
use uarm_plot::sheet::{Axis, Panel, Sheet, legend};
use uarm_plot::style::{BLACK, Dash, PURPLE, SKY_BLUE, Stroke};

use crate::dimensions::{CycleRecord, RunLog};
use crate::figures::style::{BASE, of_joint, reported_by_joint};

/// Width and height of a figure's row of two panels, points.
const SIZE: [u32; 2] = [1280, 400];
/// Panels in a row.
const COLUMNS: usize = 2;
/// About so many ticks on an axis.
const TICKS: usize = 6;

const WAKE_UP: Stroke = Stroke::solid(SKY_BLUE);
const FEEDBACK: Stroke = Stroke::solid(PURPLE).dashed(Dash::Dashed);
const TOTAL: Stroke = Stroke::solid(BLACK).wide(0.8);

/// What is plotted of a cycle, of the joint of an index or of the loop.
type Signal<const J: usize, const N: usize> = fn(&CycleRecord<J, N>, usize) -> f64;

/// The highest number of a joint: eight active ones behind a base.
const LAST_JOINT: usize = 9;

/// What the curves of the panels are.
pub fn curve_names() -> impl Iterator<Item = (String, Stroke)> {
    let joints = (1..=LAST_JOINT).map(|joint| (format!("joint {joint}"), of_joint(joint)));
    let reported = (1..=LAST_JOINT).map(|joint| (format!("joint {joint}, reported"), reported_by_joint(joint)));
    let others = [("base", BASE), ("wake-up", WAKE_UP), ("SYNC to counts", FEEDBACK), ("total", TOTAL)];
    joints.chain(reported).chain(others.map(|(name, stroke)| (name.to_owned(), stroke)))
}

/// All panels of a run, gathered cycle by cycle in memory that does not grow with the run.
#[derive(Debug)]
pub struct RunPlots<const J: usize, const N: usize> {
    plots: Vec<Plot<J, N>>,
    /// When the flight recorder's window begins, of a run that failed.
    window_start: Option<Instant>,
    /// Task time of the first cycle of that window and of the last cycle, s.
    window: Option<Range<f64>>,
}

impl<const J: usize, const N: usize> RunPlots<J, N> {
    /// No cycle yet, of the run that `log` tells of; its own cycles are not looked at.
    pub fn new(log: &RunLog<J, N>) -> Self {
        let mut plots = vec![Plot::tracking_error(), Plot::torque()];
        if dimensions::passive::<J, N>() > 0 {
            plots.push(Plot::base());
        }
        // Virtual time passes only while the loop sleeps: it has no latencies.
        if log.run.clock() == ClockKind::Monotonic {
            plots.push(Plot::latencies());
        }
        let window_start = log.fault.as_ref().map(|fault| log.run.axis.instant(fault.window_start_ns));
        Self { plots, window_start, window: None }
    }

    /// Takes the next cycle.
    pub fn take(&mut self, record: &CycleRecord<J, N>) {
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
    pub fn sheet(self, log: &RunLog<J, N>) -> Sheet {
        let mut panels: Vec<Panel> = self.plots.iter().map(Plot::panel).collect();
        for panel in &mut panels {
            panel.shade = self.window.clone().map(|window| (window, "flight recorder".to_owned()));
        }
        let [width, row] = SIZE;
        let rows = u32::try_from(panels.len().div_ceil(COLUMNS)).unwrap_or(1);
        let drawn = |(_, stroke): &(String, Stroke)| {
            panels.iter().any(|panel| panel.curves.iter().any(|curve| curve.stroke == *stroke))
        };
        let entries: Vec<_> = curve_names().filter(drawn).collect();
        let entries: Vec<_> = entries.iter().map(|(name, stroke)| (name.as_str(), *stroke)).collect();
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
fn note<const J: usize, const N: usize>(log: &RunLog<J, N>) -> String {
    let file = log.path.file_name().unwrap_or_default().to_string_lossy();
    log.fault.as_ref().map_or_else(|| file.to_string(), |fault| format!("{file}; {}", fault.cause))
}

/// A panel that is gathered cycle by cycle.
#[derive(Debug)]
pub struct Plot<const J: usize, const N: usize> {
    title: &'static str,
    label: &'static str,
    /// Task time of the earliest and the latest cycle, s.
    times: Option<[f64; 2]>,
    curves: Vec<Curve<J, N>>,
}

/// A curve that is gathered cycle by cycle.
#[derive(Debug)]
struct Curve<const J: usize, const N: usize> {
    stroke: Stroke,
    signal: Signal<J, N>,
    /// The index that the signal is asked with.
    joint: usize,
    envelope: Envelope,
}

impl<const J: usize, const N: usize> Curve<J, N> {
    fn of_joint(stroke: Stroke, joint: usize, signal: Signal<J, N>) -> Self {
        Self { stroke, signal, joint, envelope: Envelope::default() }
    }

    fn of_loop(stroke: Stroke, signal: Signal<J, N>) -> Self {
        Self::of_joint(stroke, 0, signal)
    }
}

impl<const J: usize, const N: usize> Plot<J, N> {
    const fn new(title: &'static str, label: &'static str, curves: Vec<Curve<J, N>>) -> Self {
        Self { title, label, times: None, curves }
    }

    /// Errors of the active joints.
    pub fn tracking_error() -> Self {
        let error: Signal<J, N> = |record, joint| record.tracking_error().position[joint].to_degrees();
        let curve = |joint| Curve::of_joint(of_joint(dimensions::number_of_active::<J, N>(joint)), joint, error);
        Self::new("Tracking error", "Error (\u{b0})", (0..N).map(curve).collect())
    }

    /// Torques of the active joints behind the limiter, and those that their drives reported, if any did.
    pub fn torque() -> Self {
        let number = dimensions::number_of_active::<J, N>;
        let applied =
            |joint| Curve::of_joint(of_joint(number(joint)), joint, |record, joint| record.torque_applied[joint]);
        let reported = |joint| Curve::of_joint(reported_by_joint(number(joint)), joint, reported_torque);
        let curves = (0..N).map(applied).chain((0..N).map(reported)).collect();
        Self::new("Torque applied", "Torque (N\u{b7}m)", curves)
    }

    /// The base's angle.
    pub fn base() -> Self {
        let angle = Curve::of_loop(BASE, |record, _| record.position[0].to_degrees());
        Self::new("Base attitude", "Attitude (\u{b0})", vec![angle])
    }

    /// Latencies of each cycle.
    pub fn latencies() -> Self {
        let curves = vec![
            Curve::of_loop(TOTAL, |record, _| record.instants.total().as_secs_f64() * 1e6),
            Curve::of_loop(WAKE_UP, |record, _| record.instants.wake_up().as_secs_f64() * 1e6),
            Curve::of_loop(FEEDBACK, |record, _| record.instants.feedback_latency().as_secs_f64() * 1e6),
        ];
        Self::new("Loop latencies", "Latency (\u{b5}s)", curves)
    }

    /// Takes the next cycle.
    fn take(&mut self, record: &CycleRecord<J, N>) {
        let [earliest, latest] = self.times.unwrap_or([record.time; 2]);
        self.times = Some([earliest.min(record.time), latest.max(record.time)]);
        for Curve { signal, joint, envelope, .. } in &mut self.curves {
            envelope.take([record.time, signal(record, *joint)]);
        }
    }

    /// The panel of these cycles.
    pub fn of(mut self, cycles: &[CycleRecord<J, N>]) -> Panel {
        cycles.iter().for_each(|record| self.take(record));
        self.panel()
    }

    /// The panel of the cycles so far; a curve without a point is left out.
    fn panel(&self) -> Panel {
        let curves: Vec<(Stroke, Vec<_>)> =
            self.curves.iter().map(|curve| (curve.stroke, curve.envelope.points().collect())).collect();
        let values = curves.iter().flat_map(|(_, points)| points.iter().map(|[_, value]| *value));
        let x = Axis::covering("Time (s)", self.times.into_iter().flatten(), TICKS);
        let y = Axis::covering(self.label, values, TICKS);
        let drawn = curves.into_iter().filter(|(_, points)| !points.is_empty());
        drawn.fold(Panel::new(self.title, x, y), |panel, (stroke, points)| panel.with(stroke, points))
    }
}

/// The torque that the drive of the active joint of this index reported, N m; not a number, and so not drawn, without a report.
fn reported_torque<const J: usize, const N: usize>(record: &CycleRecord<J, N>, joint: usize) -> f64 {
    record.torque_actual[joint + dimensions::passive::<J, N>()].map_or(f64::NAN, |actual| actual.newton_metres)
}

#[cfg(test)]
mod tests {
    use uarm_loop::torque::ActualTorque;

    use super::*;

    #[test]
    fn torques_that_no_drive_reported_have_no_curve() {
        let silent = CycleRecord::<3, 2>::default();
        let mut reported = silent;
        reported.torque_actual[2] = Some(ActualTorque { per_mille: 10, newton_metres: 0.5 });
        assert_eq!(Plot::torque().of(&[silent]).curves.len(), 2);
        let panel = Plot::torque().of(&[silent, reported]);
        assert_eq!(
            panel.curves.last().map(|curve| (curve.stroke, curve.points.len())),
            Some((reported_by_joint(3), 1))
        );
        assert_eq!(panel.curves.len(), 3);
    }

    #[test]
    fn a_run_without_cycles_has_panels_without_curves() {
        assert!(Plot::<3, 2>::tracking_error().of(&[]).curves.is_empty());
    }
}
