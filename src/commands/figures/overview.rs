//! The six controllers in one figure.

use hinf_control::{Disturbance, Law};
use nalgebra::SVector;
use uarm_loop::dimensions;
use uarm_loop::outcome::Indices;
use uarm_loop::robot::Task;
use uarm_plot::sheet::{Axis, Mark, Panel, Shape, Sheet, Symbol, legend};
use uarm_plot::style::GREY;

use super::experiments::Experiment;
use super::paper::time_axis;
use crate::dimensions::CycleRecord;
use crate::figures::style::of_law;

/// Of so many panels, three stand side by side, of more four.
const FEW_PANELS: usize = 6;
/// Width of three panels, and height of two, points.
const THREE_WIDE: u32 = 1280;
const TWO_HIGH: u32 = 780;
/// While the disturbance is above one hundredth of its amplitude, s: e^{-5s} falls to that within 0.92 s of its start.
const DISTURBED: std::ops::Range<f64> = 1.0..1.92;
/// About so many ticks on an axis.
const TICKS: usize = 6;
/// Up to this time, s, half seconds are marked.
const SHORT: f64 = 5.0;

/// Whether the paper's Table 4 stands beside the simulated indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Published {
    /// It does.
    Shown,
    /// The robot is not the paper's.
    Hidden,
}

/// What the experiments have in common.
#[derive(Clone, Debug)]
pub struct Shared<const N: usize = 2> {
    /// What was to be done.
    pub task: Task<N>,
    /// What disturbed it.
    pub disturbance: Disturbance,
    /// Whether there are numbers of the paper for it.
    pub published: Published,
    /// What else is to be said of them.
    pub note: String,
}

/// Errors, base where an encoder is on it, torques and L2 of all experiments.
pub fn overview<const J: usize, const N: usize>(experiments: &[Experiment<J, N>], shared: &Shared<N>) -> Sheet {
    let Shared { task, disturbance, published, note } = shared;
    let passive = dimensions::passive::<J, N>();
    let number = dimensions::number_of_active::<J, N>;
    let overlay = |title: String, label: &str, signal: &dyn Fn(&CycleRecord<J, N>) -> f64| {
        let values = experiments.iter().flat_map(|experiment| experiment.curve(signal)).map(|[_, value]| value);
        let mut panel = Panel::new(&title, axis_of_time(task.motion().end()), Axis::covering(label, values, TICKS));
        panel.shade = (*disturbance != Disturbance::None).then(|| (DISTURBED, "disturbance".into()));
        experiments.iter().fold(panel, |panel, experiment| panel.with(of_law(experiment.law), experiment.curve(signal)))
    };
    let errors = (0..N).map(|index| {
        let error = |record: &CycleRecord<J, N>| record.tracking_error().position[index].to_degrees();
        overlay(format!("Joint {}: position error", number(index)), "Error (\u{b0})", &error)
    });
    let base = (0..passive).map(|base| {
        overlay("Base: attitude".into(), "Attitude (\u{b0})", &move |record| record.position[base].to_degrees())
    });
    let torques = (0..N).map(|index| {
        overlay(format!("Joint {}: torque", number(index)), "Torque (N\u{b7}m)", &|record| record.torque_applied[index])
    });
    let panels: Vec<_> = errors.chain(base).chain(torques).chain([table_4(experiments, *published)]).collect();
    let strokes: Vec<_> =
        experiments.iter().map(|experiment| (experiment.law.name(), of_law(experiment.law))).collect();
    let mut legend = legend(&strokes);
    legend.push(("simulated".into(), Symbol::Point(GREY, Shape::Disc)));
    if *published == Published::Shown {
        legend.push(("the paper's Table 4".into(), Symbol::Point(GREY, Shape::Ring)));
    }
    let columns = if panels.len() <= FEW_PANELS { 3 } else { 4 };
    let [columns_wide, rows] = [columns, panels.len().div_ceil(columns)].map(|number| number as u32);
    Sheet {
        name: "overview".into(),
        title: title(task, *disturbance),
        note: note.clone(),
        size: [columns_wide * THREE_WIDE / 3, rows * TWO_HIGH / 2],
        columns,
        legend,
        panels,
    }
}

/// What the controllers had to do.
fn title<const N: usize>(task: &Task<N>, disturbance: Disturbance) -> String {
    let reference = &task.reference;
    let angles = |position: &SVector<f64, N>| {
        let degrees: Vec<_> = position.iter().map(|angle| format!("{}\u{b0}", rounded(angle.to_degrees()))).collect();
        format!("({})", degrees.join(", "))
    };
    let disturbed = match disturbance {
        Disturbance::None => String::new(),
        Disturbance::Paper => format!(", disturbed at {} s", DISTURBED.start),
    };
    format!(
        "Six controllers, one task: from {} to {} in {} s{disturbed}",
        angles(reference.start()),
        angles(reference.end()),
        reference.duration()
    )
}

/// To a hundredth of a degree, which a sheet has room for.
fn rounded(degrees: f64) -> f64 {
    (degrees * 100.0).round() / 100.0 + 0.0
}

fn axis_of_time(end: f64) -> Axis {
    if end <= SHORT { time_axis(end) } else { Axis::covering("Time (s)", [0.0, end], TICKS) }
}

/// L2 of each law beside the paper's.
fn table_4<const J: usize, const N: usize>(experiments: &[Experiment<J, N>], published: Published) -> Panel {
    let published = |law: Law| match published {
        Published::Shown => Indices::published(law).map(|indices| indices.l2),
        Published::Hidden => None,
    };
    let values = experiments.iter().flat_map(|experiment| [Some(experiment.indices.l2), published(experiment.law)]);
    let mut x = Axis::new("", 0.0..experiments.len() as f64, 1.0, 0);
    x.ticks =
        experiments.iter().zip(0..).map(|(experiment, k)| (f64::from(k) + 0.5, short_name(experiment.law))).collect();
    let y = Axis::covering("L2 (rad, rad/s)", values.flatten().chain([0.0]), TICKS);
    let mut panel = Panel::new("L2 of the tracking error", x, y);
    for (experiment, k) in experiments.iter().zip(0..) {
        let at = |y| [f64::from(k) + 0.5, y];
        let colour = of_law(experiment.law).colour;
        panel.marks.extend(published(experiment.law).map(|l2| Mark { at: at(l2), colour, shape: Shape::Ring }));
        panel.marks.push(Mark { at: at(experiment.indices.l2), colour, shape: Shape::Disc });
    }
    panel
}

/// A law's name where there is little room.
fn short_name(law: Law) -> String {
    law.name().replace("neural-model", "neural+m").replace("fuzzy-model", "fuzzy+m")
}
