//! Both torques in one figure.

use uarm_plot::sheet::{Axis, Panel, Sheet, Symbol};

use crate::dimensions::ACTIVE;
use crate::figures::style::{RECORDED, REPLAYED};
use uarm_log::replay::what_if::Pair;

/// Width and height, points.
const SIZE: [u32; 2] = [1000, 640];
/// About so many ticks on an axis.
const TICKS: usize = 6;

/// The recorded torques and the other's, joint by joint.
pub fn chart(pairs: &[Pair<ACTIVE>], recorded: &str, other: &str, note: &str) -> Sheet {
    Sheet {
        name: "replay".into(),
        title: format!("What {other} would have asked for where {recorded} was in control"),
        note: note.to_owned(),
        size: SIZE,
        columns: 1,
        legend: vec![
            (format!("{recorded}, recorded"), Symbol::Line(RECORDED)),
            (format!("{other}, replayed"), Symbol::Line(REPLAYED)),
        ],
        panels: [0, 1].map(|joint| panel(pairs, joint)).to_vec(),
    }
}

fn panel(pairs: &[Pair<ACTIVE>], joint: usize) -> Panel {
    let pairs = || pairs.iter();
    let times = pairs().map(|pair| pair.time);
    let torques = pairs().flat_map(|pair| [pair.recorded[joint], pair.other[joint]]);
    let title = format!("Joint {}: torque", joint + 2);
    Panel::new(&title, Axis::covering("Time (s)", times, TICKS), Axis::covering("Torque (N\u{b7}m)", torques, TICKS))
        .with(RECORDED, pairs().map(|pair| [pair.time, pair.recorded[joint]]))
        .with(REPLAYED, pairs().map(|pair| [pair.time, pair.other[joint]]))
}
