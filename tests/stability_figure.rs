//! The figure of docs/theory.md, section 13: it is what its command draws, and its curves pass where the tables there say.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use roxmltree::{Document, Node};
use support::text;
use uarm_plot::style::{BLUE, Colour, VERMILION};

const FIGURE: &str = "docs/figures/stability.svg";
/// Half a unit of the drawing is 0.00004 on the vertical axis; the tables have three decimals.
const TOLERANCE: f64 = 6e-4;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The command of the document, with another file for the figure.
fn draw(figure: &Path, further: &[&str]) -> Output {
    let theory = std::fs::read_to_string(root().join("docs/theory.md")).unwrap();
    let line = theory.lines().find(|line| line.starts_with("uarm stability") && line.contains(FIGURE)).unwrap();
    let arguments = line.split_whitespace().skip(1).filter(|word| *word != "--force");
    let arguments = arguments.map(|word| if word == FIGURE { figure.to_str().unwrap() } else { word });
    let mut uarm = Command::new(env!("CARGO_BIN_EXE_uarm"));
    uarm.args(arguments).args(further).current_dir(root()).output().unwrap()
}

#[test]
fn the_figure_of_the_theory_is_what_its_command_draws() {
    let file = support::scratch("stability-figure.svg");
    let _ = std::fs::remove_file(&file);
    let drawn = draw(&file, &[]);
    assert_eq!(drawn.status.code(), Some(0), "{}", text(&drawn));
    let same = std::fs::read(&file).unwrap() == std::fs::read(root().join(FIGURE)).unwrap();
    assert!(same, "{FIGURE} is not what its command draws; compare {}", file.display());
}

#[test]
fn a_figure_that_is_there_is_replaced_only_with_force_and_a_robot_file_never() {
    let file = support::scratch("stability-kept.svg");
    std::fs::write(&file, "mine").unwrap();
    let refused = draw(&file, &[]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused).contains("--figure") && text(&refused).contains("the file exists"), "{}", text(&refused));
    let robot = support::scratch("stability-robot.svg");
    std::fs::write(&robot, uarm::robot::BUILT_IN).unwrap();
    let refused = draw(&robot, &["--force", "--beside", robot.to_str().unwrap()]);
    assert!(text(&refused).contains("it is the input "), "{}", text(&refused));
    assert_eq!(std::fs::read_to_string(robot).unwrap(), uarm::robot::BUILT_IN);
}

/// The values of the tables in docs/theory.md, section 13.
#[test]
fn the_curves_pass_where_the_tables_say() {
    let svg = std::fs::read_to_string(root().join(FIGURE)).unwrap();
    let document = Document::parse(&svg).unwrap();
    for (colour, [task, workspace]) in [
        (BLUE, [&[(1.0, 1.009), (0.70, 1.000)][..], &[(0.0, 0.991), (1.0, 1.012), (2.0, 1.037), (0.60, 1.000)]]),
        (VERMILION, [&[], &[(1.0, 0.994), (1.25, 0.994)]]),
    ] {
        let curves = curves(&document, colour);
        assert_eq!(curves.len(), 2, "one in each panel");
        for (panel, (curve, expected)) in curves.iter().zip([task, workspace]).enumerate() {
            let axes = Axes::of(&document, panel);
            for (delay, radius) in expected {
                let found = axes.radius(curve, *delay);
                assert!(
                    (found - radius).abs() < TOLERANCE,
                    "panel {panel}, {delay} cycles: {found}, expected {radius}"
                );
            }
        }
    }
}

/// The curves in a colour, from left to right, as points.
fn curves(document: &Document, colour: Colour) -> Vec<Vec<[f64; 2]>> {
    let colour = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
    let lines = document.descendants().filter(|node| node.has_tag_name("polyline"));
    let points = |node: Node| -> Vec<[f64; 2]> {
        let pairs = node.attribute("points").unwrap().split_whitespace();
        pairs.map(|pair| pair.split_once(',').unwrap()).map(|(x, y)| [x.parse().unwrap(), y.parse().unwrap()]).collect()
    };
    let lines = lines.filter(|node| node.attribute("stroke") == Some(&colour)).map(points);
    // A line of two points is that of the legend.
    let mut curves: Vec<_> = lines.filter(|line| line.len() > 2).collect();
    curves.sort_by(|one, other| one[0][0].total_cmp(&other[0][0]));
    curves
}

/// Where a panel's ticks are.
struct Axes {
    delay_0_and_2: [f64; 2],
    radius_1_00_and_1_01: [f64; 2],
}

impl Axes {
    fn of(document: &Document, panel: usize) -> Self {
        let at = |label: &str, axis: &str| {
            let labels = document.descendants().filter(|node| node.text().is_some_and(|text| text.trim() == label));
            let labels = labels.filter(|node| node.has_tag_name("text"));
            let place = |node: &Node, axis: &str| node.attribute(axis).unwrap().parse::<f64>().unwrap();
            let mut labels: Vec<_> = labels.map(|node| (place(&node, "x"), place(&node, axis))).collect();
            labels.sort_by(|(one, _), (other, _)| one.total_cmp(other));
            labels.get(panel).unwrap_or_else(|| panic!("{label}: {labels:?}")).1
        };
        Self {
            delay_0_and_2: ["0.0", "2.0"].map(|label| at(label, "x")),
            radius_1_00_and_1_01: ["1.00", "1.01"].map(|label| at(label, "y")),
        }
    }

    /// The radius of a curve with a delay in cycles.
    fn radius(&self, curve: &[[f64; 2]], delay: f64) -> f64 {
        let [none, two] = self.delay_0_and_2;
        let x = (none + delay / 2.0 * (two - none)).clamp(curve[0][0], curve[curve.len() - 1][0]);
        let pair = curve.windows(2).find(|pair| pair[0][0] <= x && x <= pair[1][0]).unwrap();
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        let y = y0 + (x - x0) / (x1 - x0) * (y1 - y0);
        let [one, above] = self.radius_1_00_and_1_01;
        1.0 + 0.01 * (y - one) / (above - one)
    }
}
