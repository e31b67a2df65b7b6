//! What is in the documents, measured from outside.

use std::path::PathBuf;

use uarm_plot::error::FigureError;
use uarm_plot::output::{FigureFile, FileFormat, png, svg, write};
use uarm_plot::sheet::{Axis, Mark, Panel, Shape, Sheet, legend};
use uarm_plot::style::{BLUE, Colour, Dash, Stroke, VERMILION};

/// A line from corner to corner, and one that is cut at the middle of the axis.
fn sheet() -> Sheet {
    let axis = |label: &str| Axis::new(label, 0.0..10.0, 5.0, 0);
    let mut panel = Panel::new("panel", axis("x"), axis("y"))
        .with(Stroke::solid(BLUE), [[0.0, 0.0], [10.0, 10.0]])
        .with(Stroke::solid(VERMILION), [[0.0, 5.0], [20.0, 5.0]]);
    panel.marks.push(Mark { at: [5.0, 5.0], colour: Colour(1, 2, 3), shape: Shape::Disc });
    Sheet {
        name: "lines".into(),
        title: "title & <note>".into(),
        note: "note".into(),
        size: [300, 200],
        columns: 1,
        legend: Vec::new(),
        panels: vec![panel],
    }
}

/// The points of the pieces of line in a colour.
fn lines(document: &str, Colour(red, green, blue): Colour) -> Vec<Vec<[f64; 2]>> {
    let stroke = format!("stroke=\"#{red:02X}{green:02X}{blue:02X}\"");
    let pieces = document.lines().filter(|line| line.starts_with("<polyline") && line.contains(&stroke));
    let points = |line: &str| {
        let points = line.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
        let point = |pair: &str| {
            let (x, y) = pair.split_once(',').unwrap();
            [x.parse().unwrap(), y.parse().unwrap()]
        };
        points.split_whitespace().map(point).collect()
    };
    pieces.map(points).collect()
}

#[test]
fn curves_are_linear_in_the_axes_and_end_with_them() {
    let document = svg(&sheet()).unwrap();
    let (diagonal, level) = (lines(&document, BLUE), lines(&document, VERMILION));
    let ([diagonal], [level]) = (&diagonal[..], &level[..]) else { panic!("{document}") };
    let ([left, bottom], [right, top]) = (diagonal[0], diagonal[1]);
    assert!(left < right && top < bottom, "{diagonal:?}");
    assert_eq!([level[0][0], level[1][0]], [left, right], "cut at the end of the axis");
    assert!((level[0][1] - 0.5 * (top + bottom)).abs() <= 1.0, "{level:?}");
}

#[test]
fn an_svg_has_the_size_in_points_and_escaped_text() {
    let document = svg(&sheet()).unwrap();
    assert!(document.starts_with("<svg width=\"300\" height=\"200\""), "{}", &document[..80]);
    assert!(document.contains("title &amp; &lt;note&gt;"), "{document}");
    for text in ["panel", "note", "x", "y", "10", "DejaVu Sans"] {
        assert!(document.contains(text), "{text}");
    }
}

#[test]
fn a_dashed_line_is_many_pieces() {
    let mut sheet = sheet();
    sheet.panels[0].curves[0].stroke = Stroke::solid(BLUE).dashed(Dash::Dashed);
    let pieces = lines(&svg(&sheet).unwrap(), BLUE);
    assert!(pieces.len() > 10, "{}", pieces.len());
}

#[test]
fn a_png_has_two_pixels_a_point_and_the_colours() {
    let file = png(&sheet()).unwrap();
    assert_eq!(file, png(&sheet()).unwrap(), "the same bytes each time");
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (600, 400));
    let count = |Colour(red, green, blue)| pixels.chunks_exact(3).filter(|pixel| *pixel == [red, green, blue]).count();
    // A disc of 10 pixels radius, less its border.
    assert!((230..=314).contains(&count(Colour(1, 2, 3))), "{}", count(Colour(1, 2, 3)));
    assert!(count(VERMILION) > 600, "{}", count(VERMILION));
}

#[test]
fn sheets_with_nothing_in_them_are_drawn() {
    let empty = Sheet { panels: Vec::new(), columns: 0, legend: legend(&[]), ..sheet() };
    assert!(svg(&empty).unwrap().contains("title"));
    let axis = Axis::covering("", [f64::NAN], 5);
    assert_eq!(axis.range, -1.0..1.0);
    let sheet = Sheet { panels: vec![Panel::new("", axis.clone(), axis)], columns: 0, ..sheet() };
    assert!(png(&sheet).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn an_axis_with_no_sensible_ticks_has_none() {
    for spacing in [0.0, -1.0, f64::NAN, 1e-300] {
        assert!(Axis::new("", 0.0..1.0, spacing, 0).ticks.is_empty(), "{spacing}");
    }
    assert!(Axis::new("", f64::NAN..1.0, 1.0, 0).ticks.is_empty());
}

#[test]
fn an_axis_covers_its_values_in_round_steps() {
    let axis = Axis::covering("", [0.13, 1.71, f64::INFINITY], 4);
    assert_eq!(axis.range, 0.0..2.0);
    let texts: Vec<_> = axis.ticks.iter().map(|(_, text)| text.as_str()).collect();
    assert_eq!(texts, ["0.0", "0.5", "1.0", "1.5", "2.0"]);
}

#[test]
fn a_curve_beyond_the_vertical_axis_is_found() {
    let panel = |y| Panel { curves: Vec::new(), ..sheet().panels.remove(0) }.with(Stroke::solid(BLUE), [[5.0, y]]);
    assert!(panel(10.2).cuts_a_curve());
    assert!(!panel(10.05).cuts_a_curve());
    let beside = panel(5.0).with(Stroke::solid(BLUE), [[11.0, 99.0]]);
    assert!(!beside.cuts_a_curve());
}

#[test]
fn files_are_named_by_the_sheet_and_say_their_format() {
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let written = write(&sheet(), &directory, &FileFormat::ALL).unwrap();
    assert_eq!(written, [directory.join("lines.svg"), directory.join("lines.png")]);
    assert_eq!(std::fs::read_to_string(&written[0]).unwrap(), svg(&sheet()).unwrap());
    assert_eq!(std::fs::read(&written[1]).unwrap(), png(&sheet()).unwrap());
    assert!(matches!("figure.pdf".parse::<FigureFile>(), Err(FigureError::Extension { .. })));
    let nowhere = FigureFile::new(directory.join("absent").join("figure.svg")).unwrap();
    assert!(matches!(nowhere.write(&sheet()), Err(FigureError::Write { .. })));
}
