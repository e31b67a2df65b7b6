//! The six controllers in one figure.

use hinf_control::Law;
use uarm_plot::sheet::{Axis, Mark, Panel, Shape, Sheet, Symbol, legend};
use uarm_plot::style::GREY;

use super::experiments::Experiment;
use super::paper::time_axis;
use crate::dimensions::CycleRecord;
use crate::figures::style::of_law;
use uarm_loop::outcome::Indices;

/// Width and height, points.
const SIZE: [u32; 2] = [1280, 780];
/// Where the time axes end, s: the motion and the hold.
const TIME_END: f64 = 3.5;
/// While the disturbance is above one hundredth of its amplitude, s: e^{-5s} falls to that within 0.92 s of its start.
const DISTURBED: std::ops::Range<f64> = 1.0..1.92;
/// About so many ticks on an axis.
const TICKS: usize = 6;

/// Whether the paper's Table 4 stands beside the simulated indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Published {
    /// It does.
    Shown,
    /// The robot is not the paper's.
    Hidden,
}

/// Errors, base, torques and L2 of all experiments.
pub fn overview(experiments: &[Experiment], published: Published, note: &str) -> Sheet {
    let error = |joint: usize| {
        move |record: &CycleRecord| (record.position[joint] - record.reference_position[joint - 1]).to_degrees()
    };
    let panels = vec![
        overlay(experiments, "Joint 2: position error", "Error (\u{b0})", error(1)),
        overlay(experiments, "Joint 3: position error", "Error (\u{b0})", error(2)),
        overlay(experiments, "Base: attitude", "Attitude (\u{b0})", |record| record.position[0].to_degrees()),
        overlay(experiments, "Joint 2: torque", "Torque (N\u{b7}m)", |record| record.torque_applied[0]),
        overlay(experiments, "Joint 3: torque", "Torque (N\u{b7}m)", |record| record.torque_applied[1]),
        table_4(experiments, published),
    ];
    let strokes: Vec<_> =
        experiments.iter().map(|experiment| (experiment.law.name(), of_law(experiment.law))).collect();
    let mut legend = legend(&strokes);
    legend.push(("simulated".into(), Symbol::Point(GREY, Shape::Disc)));
    if published == Published::Shown {
        legend.push(("the paper's Table 4".into(), Symbol::Point(GREY, Shape::Ring)));
    }
    Sheet {
        name: "overview".into(),
        title: "Six controllers, one task: from (20\u{b0}, 20\u{b0}) to (80\u{b0}, 60\u{b0}) in 3 s, disturbed at 1 s"
            .into(),
        note: note.to_owned(),
        size: SIZE,
        columns: 3,
        legend,
        panels,
    }
}

/// One signal of all experiments.
fn overlay(experiments: &[Experiment], title: &str, label: &str, signal: impl Fn(&CycleRecord) -> f64 + Copy) -> Panel {
    let values = experiments.iter().flat_map(|experiment| experiment.curve(signal)).map(|[_, value]| value);
    let mut panel = Panel::new(title, time_axis(TIME_END), Axis::covering(label, values, TICKS));
    panel.shade = Some((DISTURBED, "disturbance".into()));
    experiments.iter().fold(panel, |panel, experiment| panel.with(of_law(experiment.law), experiment.curve(signal)))
}

/// L2 of each law beside the paper's.
fn table_4(experiments: &[Experiment], published: Published) -> Panel {
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
