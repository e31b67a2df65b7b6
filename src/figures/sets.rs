//! The paper's Fig. 12: the fuzzy sets over their universes.

use anfis::{Epoch, Trained};
use hinf_control::{FuzzySets, GeneralisedBell};
use uarm_plot::sheet::{Axis, Mark, Panel, Shape, Sheet, Symbol, legend};
use uarm_plot::style::{BLUE, Dash, GREEN, GREY, Stroke, VERMILION};

/// Width and height, points.
const SIZE: [u32; 2] = [1000, 430];
/// Curves have so many points.
const POINTS: u32 = 400;
/// Before training.
const BEFORE: Stroke = Stroke::solid(GREY).dashed(Dash::Dashed).wide(1.3);
/// After training: first, second and third set.
const AFTER: [Stroke; 3] =
    [Stroke::solid(BLUE).wide(2.0), Stroke::solid(GREEN).wide(2.0), Stroke::solid(VERMILION).wide(2.0)];

/// The sets after training over those before, in the paper's ranges.
pub fn fuzzy_sets(name: &str, before: &FuzzySets<f64>, after: &FuzzySets<f64>, note: &str) -> Sheet {
    let velocity = Axis::new("Velocity error (\u{b0}/s)", -20.0..20.0, 10.0, 0);
    let position = Axis::new("Position error (\u{b0})", -2.0..0.5, 0.5, 1);
    let panels = [(velocity, before.velocity, after.velocity), (position, before.position, after.position)];
    let entries =
        [("before training", BEFORE), ("after: low", AFTER[0]), ("after: middle", AFTER[1]), ("after: high", AFTER[2])];
    Sheet {
        name: name.to_owned(),
        title: "Fig. 12. Fuzzy sets of velocity and position error".into(),
        note: note.to_owned(),
        size: SIZE,
        columns: 2,
        legend: legend(&entries),
        panels: panels.map(|(axis, before, after)| panel(axis, &before, &after)).into(),
    }
}

fn panel(x: Axis, before: &[GeneralisedBell<f64>; 3], after: &[GeneralisedBell<f64>; 3]) -> Panel {
    let range = x.range.clone();
    let curve = move |bell: GeneralisedBell<f64>| {
        let range = range.clone();
        (0..=POINTS).map(move |k| {
            let x = range.start + (range.end - range.start) * f64::from(k) / f64::from(POINTS);
            [x, bell.membership(x.to_radians())]
        })
    };
    let panel = Panel::new("", x, Axis::new("\u{3bc}", 0.0..1.0, 0.2, 1));
    let panel = before.iter().fold(panel, |panel, bell| panel.with(BEFORE, curve(*bell)));
    let after = after.iter().zip(AFTER);
    after.fold(panel, |panel, (bell, stroke)| panel.with(stroke, curve(*bell)))
}

/// The errors of a training by epoch.
pub fn learning_curve(name: &str, trained: &Trained) -> Sheet {
    const MILLI: f64 = 1e3;
    let points = |error: fn(&Epoch) -> Option<f64>| {
        let at = move |epoch: &Epoch| Some([epoch.premise_updates as f64, MILLI * error(epoch)?]);
        trained.history.iter().filter_map(at).collect::<Vec<_>>()
    };
    let (training, checking) = (points(|epoch| Some(epoch.rmse)), points(|epoch| epoch.checking_rmse));
    let kept = trained.kept_epoch();
    let errors = training.iter().chain(&checking).map(|[_, error]| *error);
    let y = Axis::covering("RMSE (mN\u{b7}m)", errors, 6);
    let x = Axis::covering("Epoch", training.iter().map(|[epoch, _]| *epoch).chain([0.0, 1.0]), 8);
    let (trained_stroke, checked) = (Stroke::solid(BLUE), Stroke::solid(VERMILION).dashed(Dash::Dashed));
    let mut panel = Panel::new("", x, y).with(trained_stroke, training).with(checked, checking);
    if let Some(error) = kept.checking_rmse {
        let at = [kept.premise_updates as f64, MILLI * error];
        panel.marks.push(Mark { at, colour: VERMILION, shape: Shape::Ring });
    }
    let mut legend = legend(&[("training set", trained_stroke), ("checking set", checked)]);
    legend.push(("kept".into(), Symbol::Point(VERMILION, Shape::Ring)));
    Sheet {
        name: name.to_owned(),
        title: "ANFIS: error by epoch".into(),
        note: String::new(),
        size: [620, 400],
        columns: 1,
        legend,
        panels: vec![panel],
    }
}
