//! Figs. 4 to 11 and 13 to 16 of the paper: two of each controller, in its layout and with its axes.

use std::ops::Range;

use hinf_control::Law;
use uarm_plot::sheet::{Axis, Panel, Sheet, legend};

use super::experiments::Experiment;
use crate::figures::style::{BASE, JOINT_2, JOINT_3, REFERENCE};

/// Width and height of a figure with two panels, of one with one, points.
const TWO_PANELS: [u32; 2] = [1000, 430];
const ONE_PANEL: [u32; 2] = [620, 430];

/// Axes that the paper's figures have in common, in the units shown.
const POSITION_RANGE: Range<f64> = -65.0..80.0;
const VELOCITY_RANGE: Range<f64> = -35.0..40.0;
const TORQUE_RANGE: Range<f64> = -0.1..0.15;

/// What the paper shows of one controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperFigures {
    /// The number of the figure with positions and velocities.
    pub motion: u8,
    /// The number of the figure with torques.
    pub torque: u8,
    /// Where the time axes of the two end, s.
    pub time_end: [f64; 2],
    /// Are the lower ends of the motion's axes, -65 and -35, among its ticks?
    pub tick_at_start: bool,
    /// The controller's name in the captions.
    pub controller: &'static str,
}

/// The figures of a law; `None` for one that is not in the paper.
pub const fn figures_of(law: Law) -> Option<PaperFigures> {
    Some(match law {
        Law::Nonlinear => PaperFigures {
            motion: 4,
            torque: 5,
            time_end: [3.5, 3.0],
            tick_at_start: false,
            controller: "nonlinear H\u{221e} control",
        },
        Law::Adaptive => PaperFigures {
            motion: 6,
            torque: 7,
            time_end: [3.0, 3.0],
            tick_at_start: false,
            controller: "adaptive nonlinear H\u{221e} control",
        },
        Law::Neural => PaperFigures {
            motion: 8,
            torque: 9,
            time_end: [3.0, 3.0],
            tick_at_start: false,
            controller: "adaptive neural network nonlinear H\u{221e} control (1)",
        },
        Law::NeuralModel => PaperFigures {
            motion: 10,
            torque: 11,
            time_end: [3.0, 3.0],
            tick_at_start: true,
            controller: "adaptive neural network nonlinear H\u{221e} control (2)",
        },
        Law::Fuzzy => PaperFigures {
            motion: 13,
            torque: 14,
            time_end: [3.5, 3.5],
            tick_at_start: true,
            controller: "adaptive fuzzy nonlinear H\u{221e} control (1)",
        },
        Law::FuzzyModel => PaperFigures {
            motion: 15,
            torque: 16,
            time_end: [3.5, 3.5],
            tick_at_start: true,
            controller: "adaptive fuzzy nonlinear H\u{221e} control (2)",
        },
        _ => return None,
    })
}

/// Positions and velocities, side by side.
pub fn motion(experiment: &Experiment, figures: &PaperFigures, note: &str) -> Sheet {
    let [time_end, _] = figures.time_end;
    let [position, velocity] =
        [("Joint position (\u{b0})", POSITION_RANGE, 20.0), ("Joint velocity (\u{b0}/s)", VELOCITY_RANGE, 10.0)].map(
            |(label, range, spacing)| {
                let axis = Axis::new(label, range, spacing, 0);
                if figures.tick_at_start { axis.with_tick_at_start() } else { axis }
            },
        );
    let positions = Panel::new("", time_axis(time_end), position)
        .with(BASE, experiment.curve(|record| record.position[0].to_degrees()))
        .with(JOINT_2, experiment.curve(|record| record.position[1].to_degrees()))
        .with(JOINT_3, experiment.curve(|record| record.position[2].to_degrees()))
        .with(REFERENCE, experiment.curve(|record| record.reference_position[0].to_degrees()))
        .with(REFERENCE, experiment.curve(|record| record.reference_position[1].to_degrees()));
    let velocities = Panel::new("", time_axis(time_end), velocity)
        .with(BASE, experiment.curve(|record| record.velocity[0].to_degrees()))
        .with(JOINT_2, experiment.curve(|record| record.velocity[1].to_degrees()))
        .with(JOINT_3, experiment.curve(|record| record.velocity[2].to_degrees()))
        .with(REFERENCE, experiment.curve(|record| record.reference_velocity[0].to_degrees()))
        .with(REFERENCE, experiment.curve(|record| record.reference_velocity[1].to_degrees()));
    Sheet {
        name: format!("fig{:02}-{}-motion", figures.motion, experiment.law.name()),
        title: format!(
            "Fig. {}. Joints and base positions and velocities \u{2014} {}",
            figures.motion, figures.controller
        ),
        note: note.to_owned(),
        size: TWO_PANELS,
        columns: 2,
        legend: legend(&[("Base", BASE), ("Joint 2", JOINT_2), ("Joint 3", JOINT_3), ("Reference", REFERENCE)]),
        panels: vec![positions, velocities],
    }
}

/// The torques of joints 2 and 3 after the limiter.
pub fn torque(experiment: &Experiment, figures: &PaperFigures, note: &str) -> Sheet {
    let [_, time_end] = figures.time_end;
    let panel = Panel::new("", time_axis(time_end), Axis::new("Torque (N\u{b7}m)", TORQUE_RANGE, 0.05, 2))
        .with(JOINT_2, experiment.curve(|record| record.torque_applied[0]))
        .with(JOINT_3, experiment.curve(|record| record.torque_applied[1]));
    Sheet {
        name: format!("fig{:02}-{}-torque", figures.torque, experiment.law.name()),
        title: format!("Fig. {}. Torques \u{2014} {}", figures.torque, figures.controller),
        note: note.to_owned(),
        size: ONE_PANEL,
        columns: 1,
        legend: legend(&[("Joint 2", JOINT_2), ("Joint 3", JOINT_3)]),
        panels: vec![panel],
    }
}

/// An axis of time from 0 to `end` seconds, with a tick every half second.
pub fn time_axis(end: f64) -> Axis {
    Axis::new("Time (s)", 0.0..end, 0.5, 1)
}
