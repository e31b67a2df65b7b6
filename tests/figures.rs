//! The figures: what is on them, and that they are always the same.

use std::path::PathBuf;
use std::process::Command;

use hinf_control::{Disturbance, Law};
use roxmltree::{Document, Node};
use uarm::commands::figures::experiments::{Experiment, simulate_paper as simulate};
use uarm::commands::figures::{overview, paper};
use uarm::figures::style;
use uarm::robot::Robot;
use uarm::simulated_plant::PlantChoice;
use uarm_plot::output::{png, svg};
use uarm_plot::style::Colour;

fn experiment(law: Law) -> Experiment {
    simulate(&Robot::load(None).unwrap(), PlantChoice::Uarm, law).unwrap()
}

fn number(node: &Node, attribute: &str) -> f64 {
    node.attribute(attribute).unwrap().parse().unwrap()
}

fn texts<'a>(document: &'a Document) -> Vec<(&'a str, Node<'a, 'a>)> {
    let nodes = document.descendants().filter(|node| node.has_tag_name("text"));
    nodes.map(|node| (node.text().unwrap_or_default().trim(), node)).collect()
}

/// All pieces of line in a colour, as points.
fn lines(document: &Document, colour: Colour) -> Vec<Vec<[f64; 2]>> {
    let colour = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
    let lines = document.descendants().filter(|node| node.attribute("stroke") == Some(&colour));
    let points = |node: Node| {
        let pairs = node.attribute("points").unwrap().split_whitespace();
        pairs.map(|pair| pair.split_once(',').unwrap()).map(|(x, y)| [x.parse().unwrap(), y.parse().unwrap()]).collect()
    };
    lines.filter(|node| node.has_tag_name("polyline")).map(points).collect()
}

#[test]
fn curves_stand_where_the_axes_say() {
    let experiment = experiment(Law::Nonlinear);
    let figures = paper::figures_of(Law::Nonlinear).unwrap();
    let file = svg(&paper::motion(&experiment, &figures, "")).unwrap();
    let document = Document::parse(&file).unwrap();
    assert_eq!(number(&document.root_element(), "width"), 1000.0);
    let texts = texts(&document);
    for expected in ["\u{2212}60", "80", "\u{2212}30", "40", "3.5", "Time (s)", "Joint position (\u{b0})", "Base"] {
        assert!(texts.iter().any(|(text, _)| *text == expected), "{expected} is missing");
    }
    // The labels of the left panel tell where 20, 80 degrees, 0 and 3.5 s are.
    let place = |label: &str, axis: &str| number(&texts.iter().find(|(text, _)| *text == label).unwrap().1, axis);
    let joint_2 = &lines(&document, style::JOINT_2.colour);
    // One of the legend, one in each panel.
    assert_eq!(joint_2.len(), 3);
    let curve = joint_2.iter().find(|line| line.len() > 10).unwrap();
    let (first, last) = (curve.first().unwrap(), curve.last().unwrap());
    let degree = (place("20", "y") - place("80", "y")) / 60.0;
    let second = (place("3.5", "x") - place("0.0", "x")) / 3.5;
    let [_, q_end, _] = experiment.records.last().unwrap().position;
    let t_end = experiment.records.last().unwrap().time;
    // A label is placed to the unit, and so is a point: two of each.
    let tolerance = 4.0;
    assert!((first[1] - place("20", "y")).abs() < tolerance, "{first:?}");
    assert!((first[0] - place("0.0", "x")).abs() < tolerance, "{first:?}");
    assert!((last[1] - (place("80", "y") - (q_end.to_degrees() - 80.0) * degree)).abs() < tolerance, "{last:?}");
    assert!((last[0] - (place("0.0", "x") + t_end * second)).abs() < tolerance, "{last:?}");
}

#[test]
fn figures_are_the_same_bytes_each_time() {
    let draw = || {
        let experiments = [Law::Nonlinear, Law::Fuzzy].map(experiment);
        let shared = overview::Shared {
            task: Robot::load(None).unwrap().description.task,
            disturbance: Disturbance::Paper,
            published: overview::Published::Shown,
            note: "note".to_owned(),
        };
        let overview = overview::overview(&experiments, &shared);
        let torque = paper::torque(&experiments[1], &paper::figures_of(Law::Fuzzy).unwrap(), "note");
        (svg(&overview).unwrap(), png(&torque).unwrap())
    };
    let (first, second) = (draw(), draw());
    assert_eq!(first, second);
    Document::parse(&first.0).unwrap();
    let decoder = png::Decoder::new(std::io::Cursor::new(first.1));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (1240, 860));
    // Both joints' colours are there, by far not everywhere.
    for colour in [style::JOINT_2.colour, style::JOINT_3.colour] {
        let count = pixels.chunks_exact(3).filter(|pixel| *pixel == [colour.0, colour.1, colour.2]).count();
        assert!((500..50_000).contains(&count), "{count} pixels");
    }
}

#[test]
fn every_paper_figure_of_a_controller_is_there_once() {
    let mut numbers: Vec<u8> = Law::PAPER
        .into_iter()
        .filter_map(paper::figures_of)
        .flat_map(|figures| [figures.motion, figures.torque])
        .collect();
    numbers.sort_unstable();
    assert_eq!(numbers, [4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16]);
}

#[test]
fn a_directory_that_cannot_be_is_named() {
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("no-directory");
    std::fs::write(&file, "").unwrap();
    let arguments = ["figures", "--out", file.to_str().unwrap()];
    let output = Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("--out") && message.contains("no-directory"), "{message}");
}
