//! The figure of `uarm stability`: the worst spectral radius against the delay, robot by robot.

use uarm_loop::stability::{DelayError, TransportDelay};
use uarm_plot::sheet::{Axis, Mark, Panel, Shape, Sheet, Symbol, legend};
use uarm_plot::style::{BLACK, BLUE, Dash, GREEN, GREY, PURPLE, Stroke, VERMILION};

use crate::robot::Robot;
use crate::stability::Analysis;

/// Width and height, points.
const SIZE: [u32; 2] = [1000, 430];
/// The delays: so many steps of equal length from none to the last, cycles.
const STEPS: u32 = 20;
const LAST_DELAY: f64 = 2.0;
/// Points of a robot: those of the curves, and its own.
pub const POINTS: u64 = STEPS as u64 + 2;
/// About so many ticks on the vertical axes.
const TICKS: usize = 6;
/// The robots in the order of the command line; from the fifth on they repeat.
const ROBOTS: [Stroke; 4] =
    [Stroke::solid(BLUE), Stroke::solid(VERMILION), Stroke::solid(GREEN), Stroke::solid(PURPLE)];
/// From here up the loop is unstable.
const LIMIT: Stroke = Stroke::solid(BLACK).dashed(Dash::Dotted).wide(1.2);

/// The worst spectral radii of a loop with one delay.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Radii {
    /// From the latch of the counts to the torque, cycles.
    delay: f64,
    task: f64,
    workspace: f64,
}

impl Radii {
    fn of<const J: usize, const N: usize>(analysis: &mut Analysis<'_, J, N>) -> Self {
        let delay = analysis.delays().map(TransportDelay::get).into_iter().fold(0.0, f64::max);
        Self { delay, task: analysis.along_the_task().radius, workspace: analysis.in_the_workspace().radius }
    }
}

/// The curves of a robot.
#[derive(Clone, Debug)]
pub struct RobotCurves {
    label: String,
    by_delay: Vec<Radii>,
    /// With the delay that the robot has; of the joints' delays the longest stands for all.
    own: Radii,
}

impl RobotCurves {
    /// The curves of `robot` in the loop of `analysis`. `done` is called after each of the [`POINTS`].
    ///
    /// # Errors
    /// None for the delays of the figure.
    pub fn of<const J: usize, const N: usize>(
        robot: &Robot<J, N>,
        mut analysis: Analysis<'_, J, N>,
        done: impl Fn(),
    ) -> Result<Self, DelayError> {
        let at = |step: u32| {
            let delay = TransportDelay::cycles(LAST_DELAY * f64::from(step) / f64::from(STEPS))?;
            let radii = analysis.with_delay(delay, Radii::of);
            done();
            Ok(radii)
        };
        let by_delay = (0..=STEPS).map(at).collect::<Result<_, DelayError>>()?;
        let period = robot.description.period.duration();
        let label = format!("{}: {period:?}, {}", robot.description.name, robot.file.estimator);
        let own = Radii::of(&mut analysis);
        done();
        Ok(Self { label, by_delay, own })
    }
}

/// Along the task and in the workspace, side by side.
pub fn sheet(robots: &[RobotCurves], note: String) -> Sheet {
    let strokes = || ROBOTS.into_iter().cycle();
    let labels: Vec<_> = robots.iter().map(|robot| robot.label.as_str()).zip(strokes()).collect();
    let mut legend = legend(&labels);
    legend.push(("with the robot's own delay".into(), Symbol::Point(GREY, Shape::Disc)));
    legend.push(("unstable above".into(), Symbol::Line(LIMIT)));
    let panel = |title: &str, radius: fn(&Radii) -> f64| {
        let radii = robots.iter().flat_map(|robot| robot.by_delay.iter().map(radius));
        let y = Axis::covering("Spectral radius", radii.chain([1.0]), TICKS);
        let x = Axis::new("Delay (cycles)", 0.0..LAST_DELAY, 0.5, 1);
        let limit = Panel::new(title, x, y).with(LIMIT, [[0.0, 1.0], [LAST_DELAY, 1.0]]);
        robots.iter().zip(strokes()).fold(limit, |mut panel, (RobotCurves { by_delay, own, .. }, stroke)| {
            if own.delay <= LAST_DELAY {
                panel.marks.push(Mark { at: [own.delay, radius(own)], colour: stroke.colour, shape: Shape::Disc });
            }
            panel.with(stroke, by_delay.iter().map(|radii| [radii.delay, radius(radii)]))
        })
    };
    Sheet {
        name: "stability".into(),
        title: "How much delay the sampled loop bears".into(),
        note,
        size: SIZE,
        columns: 2,
        legend,
        panels: vec![
            panel("Worst along the task", |radii| radii.task),
            panel("Worst in the workspace", |radii| radii.workspace),
        ],
    }
}
