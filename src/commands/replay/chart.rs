//! Both torques in one figure.

use uarm_plot::envelope::Envelope;
use uarm_plot::sheet::{Axis, Panel, Sheet, Symbol};

use crate::figures::style::{RECORDED, REPLAYED};
use uarm_log::replay::what_if::Pair;

/// Width, points.
const WIDTH: u32 = 1000;
/// Height for each joint, points.
const HEIGHT_OF_PANEL: u32 = 320;
/// About so many ticks on an axis.
const TICKS: usize = 6;

/// Both torques of each joint, gathered cycle by cycle in memory that does not grow with the run.
#[derive(Debug)]
pub struct Torques<const N: usize> {
    joints: [[Envelope; 2]; N],
    /// The number of the first joint.
    first: usize,
    /// Task time of the first and the last cycle, s.
    times: Option<[f64; 2]>,
}

impl<const N: usize> Torques<N> {
    /// No cycle yet; `first` is the number of the first active joint.
    pub fn new(first: usize) -> Self {
        Self { joints: std::array::from_fn(|_| Default::default()), first, times: None }
    }

    /// Takes the next cycle.
    pub fn take(&mut self, pair: &Pair<N>) {
        self.times = Some([self.times.map_or(pair.time, |[first, _]| first), pair.time]);
        for (joint, [recorded, other]) in self.joints.iter_mut().enumerate() {
            recorded.take([pair.time, pair.recorded[joint]]);
            other.take([pair.time, pair.other[joint]]);
        }
    }

    /// The recorded torques and the other's, joint by joint.
    pub fn chart(&self, recorded: &str, other: &str, note: &str) -> Sheet {
        Sheet {
            name: "replay".into(),
            title: format!("What {other} would have asked for where {recorded} was in control"),
            note: note.to_owned(),
            size: [WIDTH, HEIGHT_OF_PANEL * u32::try_from(N).unwrap_or(1)],
            columns: 1,
            legend: vec![
                (format!("{recorded}, recorded"), Symbol::Line(RECORDED)),
                (format!("{other}, replayed"), Symbol::Line(REPLAYED)),
            ],
            panels: (0..N).map(|joint| self.panel(joint)).collect(),
        }
    }

    fn panel(&self, joint: usize) -> Panel {
        let [recorded, other] = &self.joints[joint];
        let torques = recorded.points().chain(other.points()).map(|[_, torque]| torque);
        let x = Axis::covering("Time (s)", self.times.into_iter().flatten(), TICKS);
        let y = Axis::covering("Torque (N\u{b7}m)", torques, TICKS);
        Panel::new(format!("Joint {}: torque", joint + self.first), x, y)
            .with(RECORDED, recorded.points())
            .with(REPLAYED, other.points())
    }
}
