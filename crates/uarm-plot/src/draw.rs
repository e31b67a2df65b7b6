//! A sheet on any `plotters` backend.

use std::fmt::Display;

use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, RGBColor, ShapeStyle, TextStyle, WHITE};
use plotters_backend::DrawingBackend;

use crate::error::FigureError;
use crate::polyline::{clip, dash, thin};
use crate::sheet::{Axis, Curve, Mark, Panel, Shape, Sheet, Symbol};
use crate::style::{BLACK, Colour, GREY, Stroke};
use crate::text::{FAMILY, Faces, SIZE_PER_EM};

/// Backends count in units of which this many are a point, since they know whole units only.
pub const UNITS_PER_POINT: u32 = 4;

/// Lines between ticks, lighter than any curve.
const GRID: Colour = Colour(0xE4, 0xE4, 0xE4);
/// The shaded ground of a panel.
const SHADE: Colour = Colour(0xF1, 0xF1, 0xEC);
/// Height of the title, of the note and of the legend, points.
const BANDS: [f64; 3] = [27.0, 19.0, 24.0];
/// Text sizes (em), points.
const TITLE_EM: f64 = 15.0;
const NOTE_EM: f64 = 11.0;
const TEXT_EM: f64 = 12.0;
const TICK_EM: f64 = 11.0;
/// From the left edge to title, note and legend, points.
const LEFT: f64 = 16.0;
/// The piece of line in a legend, and the gaps behind it and behind its text, points.
const SAMPLE: f64 = 30.0;
const SAMPLE_GAP: f64 = 7.0;
const ENTRY_GAP: f64 = 24.0;
/// Radius of a point, points.
const MARK_RADIUS: f64 = 5.0;
/// A curve is thinned as far as nobody sees it, units.
const THINNING: f64 = 0.6;

const fn rgb(Colour(red, green, blue): Colour) -> RGBColor {
    RGBColor(red, green, blue)
}

fn units(points: f64) -> i32 {
    (points * f64::from(UNITS_PER_POINT)).round() as i32
}

fn failed(error: impl Display) -> FigureError {
    FigureError::Drawing(error.to_string())
}

fn font(em: f64, style: FontStyle, colour: Colour) -> TextStyle<'static> {
    let size = em * SIZE_PER_EM * f64::from(UNITS_PER_POINT);
    let mut text = TextStyle::from((FAMILY, size).into_font().style(style));
    text.color = rgb(colour).to_backend_color();
    text
}

fn line(stroke: &Stroke) -> ShapeStyle {
    rgb(stroke.colour).stroke_width(units(stroke.width).unsigned_abs().max(1))
}

/// Draws a sheet on a backend of `sheet.size` points.
///
/// # Errors
/// If the backend fails.
pub fn draw<B: DrawingBackend>(sheet: &Sheet, faces: &Faces, backend: B) -> Result<(), FigureError> {
    let root = backend.into_drawing_area();
    root.fill(&WHITE).map_err(failed)?;
    let below = draw_head(sheet, faces, &root)?;
    let panels = root.margin(units(below), units(8.0), units(8.0), units(14.0));
    let columns = sheet.columns.max(1);
    let rows = sheet.panels.len().div_ceil(columns);
    for (panel, area) in sheet.panels.iter().zip(panels.split_evenly((rows, columns))) {
        draw_panel(panel, &root, &area)?;
    }
    root.present().map_err(failed)
}

/// Title, note and legend; returns where they end, points from above.
fn draw_head<B: DrawingBackend>(
    sheet: &Sheet,
    faces: &Faces,
    root: &DrawingArea<B, Shift>,
) -> Result<f64, FigureError> {
    let [title, note, legend] = BANDS;
    let mut top = 10.0;
    for (text, band, style) in [
        (&sheet.title, title, font(TITLE_EM, FontStyle::Bold, BLACK)),
        (&sheet.note, note, font(NOTE_EM, FontStyle::Normal, GREY)),
    ] {
        if !text.is_empty() {
            root.draw(&Text::new(text.as_str(), (units(LEFT), units(top)), style)).map_err(failed)?;
            top += band;
        }
    }
    if !sheet.legend.is_empty() {
        draw_legend(sheet, faces, root, top + 0.5 * legend)?;
        top += legend;
    }
    Ok(top)
}

fn draw_legend<B: DrawingBackend>(
    sheet: &Sheet,
    faces: &Faces,
    root: &DrawingArea<B, Shift>,
    middle: f64,
) -> Result<(), FigureError> {
    let scale = f64::from(UNITS_PER_POINT);
    let style = font(TEXT_EM, FontStyle::Normal, BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let mut x = LEFT;
    for (text, symbol) in &sheet.legend {
        let width = match symbol {
            Symbol::Line(stroke) => {
                let ends = [[x * scale, middle * scale], [(x + SAMPLE) * scale, middle * scale]];
                draw_chain(root, &ends, stroke)?;
                SAMPLE
            }
            Symbol::Point(colour, shape) => {
                draw_point(root, [(x + MARK_RADIUS) * scale, middle * scale], *colour, *shape)?;
                2.0 * MARK_RADIUS
            }
        };
        x += width + SAMPLE_GAP;
        root.draw(&Text::new(text.as_str(), (units(x), units(middle)), style.clone())).map_err(failed)?;
        x += TEXT_EM * f64::from(faces.length(text, false)) + ENTRY_GAP;
    }
    Ok(())
}

fn draw_panel<B: DrawingBackend>(
    panel: &Panel,
    root: &DrawingArea<B, Shift>,
    area: &DrawingArea<B, Shift>,
) -> Result<(), FigureError> {
    let mut builder = ChartBuilder::on(area);
    builder.set_label_area_size(LabelAreaPosition::Left, units(58.0));
    builder.set_label_area_size(LabelAreaPosition::Bottom, units(42.0));
    builder.margin_top(units(8.0)).margin_right(units(14.0));
    if !panel.title.is_empty() {
        builder.caption(&panel.title, font(TEXT_EM, FontStyle::Bold, BLACK));
    }
    let mut chart = builder.build_cartesian_2d(Ticked(panel.x.clone()), Ticked(panel.y.clone())).map_err(failed)?;
    let (columns, rows) = chart.plotting_area().get_pixel_range();
    let frame = Frame { columns: [columns.start, columns.end], rows: [rows.start, rows.end] };
    if let Some((abscissae, _)) = &panel.shade {
        let corners = [[abscissae.start, panel.y.range.end], [abscissae.end, panel.y.range.start]];
        let corners = corners.map(|corner| rounded(frame.place(panel, corner)));
        root.draw(&Rectangle::new(corners, rgb(SHADE).filled())).map_err(failed)?;
    }
    chart
        .configure_mesh()
        .x_desc(&panel.x.label)
        .y_desc(&panel.y.label)
        .axis_desc_style(font(TEXT_EM, FontStyle::Normal, BLACK))
        .label_style(font(TICK_EM, FontStyle::Normal, BLACK))
        .axis_style(rgb(BLACK).stroke_width(UNITS_PER_POINT))
        .bold_line_style(rgb(GRID).stroke_width(UNITS_PER_POINT))
        .x_label_formatter(&|at| label(&panel.x.ticks, *at))
        .y_label_formatter(&|at| label(&panel.y.ticks, *at))
        .set_all_tick_mark_size(units(4.0))
        .draw()
        .map_err(failed)?;
    draw_contents(panel, root, &frame)
}

/// An axis as `plotters` knows it: linear, with ticks where they are given.
struct Ticked(Axis);

impl Ranged for Ticked {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (low, high): (i32, i32)) -> i32 {
        let Self(Axis { range, .. }) = self;
        let share = (value - range.start) / (range.end - range.start);
        (f64::from(low) + share * f64::from(high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // Light lines between those of the ticks are not wanted.
        if hint.weight().allow_light_points() { Vec::new() } else { self.0.ticks.iter().map(|(at, _)| *at).collect() }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.0.range.clone()
    }
}

/// Where a panel's coordinate system lies, units.
struct Frame {
    columns: [i32; 2],
    rows: [i32; 2],
}

impl Frame {
    fn place(&self, panel: &Panel, [x, y]: [f64; 2]) -> [f64; 2] {
        let share = |value: f64, range: &std::ops::Range<f64>| (value - range.start) / (range.end - range.start);
        let [left, right] = self.columns.map(f64::from);
        let [top, bottom] = self.rows.map(f64::from);
        [left + share(x, &panel.x.range) * (right - left), bottom - share(y, &panel.y.range) * (bottom - top)]
    }
}

fn draw_contents<B: DrawingBackend>(
    panel: &Panel,
    root: &DrawingArea<B, Shift>,
    frame: &Frame,
) -> Result<(), FigureError> {
    if let Some((abscissae, text)) = &panel.shade {
        let [x, y] = frame.place(panel, [abscissae.start, panel.y.range.end]);
        let at = (x.round() as i32 + units(4.0), y.round() as i32 + units(4.0));
        root.draw(&Text::new(text.as_str(), at, font(TICK_EM - 1.0, FontStyle::Normal, GREY))).map_err(failed)?;
    }
    for Curve { stroke, points } in &panel.curves {
        let abscissae = [panel.x.range.start, panel.x.range.end];
        for part in clip(points, abscissae, panel.y.drawn()) {
            let placed: Vec<_> = part.into_iter().map(|point| frame.place(panel, point)).collect();
            draw_chain(root, &thin(&placed, THINNING), stroke)?;
        }
    }
    for Mark { at, colour, shape } in &panel.marks {
        draw_point(root, frame.place(panel, *at), *colour, *shape)?;
    }
    Ok(())
}

/// Draws a chain of points given in units.
fn draw_chain<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    points: &[[f64; 2]],
    stroke: &Stroke,
) -> Result<(), FigureError> {
    let pattern: Vec<f64> = stroke.dash.pattern().iter().map(|length| length * f64::from(UNITS_PER_POINT)).collect();
    for piece in dash(points, &pattern) {
        let mut path: Vec<(i32, i32)> = piece.into_iter().map(rounded).collect();
        path.dedup();
        // A dot shorter than a unit is still a dot.
        if let [(x, y)] = path[..] {
            path.push((x + 1, y));
        }
        root.draw(&PathElement::new(path, line(stroke))).map_err(failed)?;
    }
    Ok(())
}

fn draw_point<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    at: [f64; 2],
    colour: Colour,
    shape: Shape,
) -> Result<(), FigureError> {
    root.draw(&Circle::new(rounded(at), units(MARK_RADIUS), rgb(colour).filled())).map_err(failed)?;
    match shape {
        Shape::Disc => Ok(()),
        Shape::Ring => root.draw(&Circle::new(rounded(at), units(MARK_RADIUS - 2.0), WHITE.filled())).map_err(failed),
    }
}

fn rounded([x, y]: [f64; 2]) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

fn label(ticks: &[(f64, String)], at: f64) -> String {
    ticks.iter().find(|(tick, _)| *tick == at).map(|(_, text)| text.clone()).unwrap_or_default()
}
