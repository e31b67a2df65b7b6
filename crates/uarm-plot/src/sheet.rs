//! What a figure shows, before it is drawn.

use std::ops::Range;

use crate::style::{Colour, Stroke};

/// How far beyond an end of the vertical axis a curve is still drawn, as a share of the axis: a line along the end may
/// overshoot it by less than its own width.
const OVERSHOOT: f64 = 0.01;
/// An axis with more ticks is a mistake of its maker, and would not end for a spacing of almost nothing.
const MOST_TICKS: i64 = 1000;

/// A figure: panels below a title, a note and a legend.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The file's name without its extension.
    pub name: String,
    /// The title above everything.
    pub title: String,
    /// A line below the title, in grey.
    pub note: String,
    /// Width and height, points.
    pub size: [u32; 2],
    /// How many panels are in a row; 0 counts as 1.
    pub columns: usize,
    /// The legend, above all panels, where it can hide no curve: each entry's text and symbol.
    pub legend: Vec<(String, Symbol)>,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// What is before the text of an entry in a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Symbol {
    /// A short line, drawn as the curves that it names.
    Line(Stroke),
    /// A point, drawn as the marks that it names.
    Point(Colour, Shape),
}

/// A coordinate system with curves.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The title above it; may be empty.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// A part of the horizontal axis whose background is shaded, and the text there.
    pub shade: Option<(Range<f64>, String)>,
    /// The curves; a later one is drawn above an earlier one.
    pub curves: Vec<Curve>,
    /// Single points, above all curves.
    pub marks: Vec<Mark>,
}

/// A linear axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// The values at its ends, in the unit of the label; finite, the start below the end.
    pub range: Range<f64>,
    /// The ticks: the value of each, and the text there.
    pub ticks: Vec<(f64, String)>,
}

/// A curve. What lies outside the axes is not drawn.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Colour, width and dashes of its line.
    pub stroke: Stroke,
    /// Its points `[x, y]`, in the units of the axes.
    pub points: Vec<[f64; 2]>,
}

/// A single point.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    /// Its place `[x, y]`, in the units of the axes.
    pub at: [f64; 2],
    /// The colour of the point.
    pub colour: Colour,
    /// The shape of the point.
    pub shape: Shape,
}

/// The shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A filled circle.
    Disc,
    /// An open circle.
    Ring,
}

impl Axis {
    /// An axis over `range` with ticks at the multiples of `spacing` in it, written with `decimals`. Without ticks if
    /// `spacing` is not above 0, the range is empty, or there were more than 1000 of them.
    pub fn new(label: impl Into<String>, range: Range<f64>, spacing: f64, decimals: usize) -> Self {
        // A tick on an end of the axis may miss it by rounding.
        let slack = 1e-9 * (range.end - range.start);
        let (first, last) =
            (((range.start - slack) / spacing).ceil() as i64, ((range.end + slack) / spacing).floor() as i64);
        let tick = |multiple| {
            let value = multiple as f64 * spacing;
            (value.clamp(range.start, range.end), number(value, decimals))
        };
        let countable = spacing > 0.0 && range.start < range.end && last.saturating_sub(first) < MOST_TICKS;
        let ticks = if countable { (first..=last).map(tick).collect() } else { Vec::new() };
        Self { label: label.into(), ticks, range }
    }

    /// An axis that begins and ends on a tick and holds all finite `values`, with about `count` ticks at round numbers;
    /// from -1 to 1 if there are no two different values.
    pub fn covering(label: impl Into<String>, values: impl IntoIterator<Item = f64>, count: usize) -> Self {
        let (least, most) = values
            .into_iter()
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
        let (least, most) = if least < most { (least, most) } else { (-1.0, 1.0) };
        let wanted = (most - least) / count.max(1) as f64;
        let power = 10.0_f64.powi(wanted.log10().floor() as i32);
        let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| factor * power >= wanted).unwrap_or(10.0);
        let spacing = factor * power;
        let decimals = (-spacing.log10() - 1e-9).ceil().max(0.0) as usize;
        Self::new(label, (least / spacing).floor() * spacing..(most / spacing).ceil() * spacing, spacing, decimals)
    }

    /// Between which values of a vertical axis curves are drawn: those of its ends, and 1 % of the axis beyond.
    pub(crate) fn drawn(&self) -> [f64; 2] {
        let slack = OVERSHOOT * (self.range.end - self.range.start);
        [self.range.start - slack, self.range.end + slack]
    }

    /// The same axis with a tick at its lower end, for an end that is no multiple of the spacing.
    #[must_use]
    pub fn with_tick_at_start(mut self) -> Self {
        let start = self.range.start;
        // The next tick would be written over it.
        self.ticks.retain(|(at, _)| at - start > 0.04 * (self.range.end - start));
        self.ticks.insert(0, (start, number(start, 0)));
        self
    }
}

/// A number as axes show it, with the minus sign U+2212.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().any(|digit| (b'1'..=b'9').contains(&digit)) => format!("\u{2212}{rest}"),
        Some(rest) => rest.to_owned(),
        None => text,
    }
}

impl Panel {
    /// A panel without curves.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { title: title.into(), x, y, shade: None, curves: Vec::new(), marks: Vec::new() }
    }

    /// Does a curve leave the vertical axis where it is within the horizontal one?
    pub fn cuts_a_curve(&self) -> bool {
        let shown = |[x, _]: &&[f64; 2]| self.x.range.start <= *x && *x <= self.x.range.end;
        let [low, high] = self.y.drawn();
        let outside = |[_, y]: &[f64; 2]| *y < low || *y > high;
        self.curves.iter().any(|curve| curve.points.iter().filter(shown).any(outside))
    }

    /// The same panel with a curve above the others.
    #[must_use]
    pub fn with(mut self, stroke: Stroke, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        self.curves.push(Curve { stroke, points: points.into_iter().collect() });
        self
    }
}

/// Entries of a legend with lines: the text and the line of each.
pub fn legend(entries: &[(&str, Stroke)]) -> Vec<(String, Symbol)> {
    entries.iter().map(|(text, stroke)| ((*text).to_owned(), Symbol::Line(*stroke))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_the_multiples_within_the_range() {
        let axis = Axis::new("q", -65.0..80.0, 20.0, 0);
        let texts: Vec<_> = axis.ticks.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(texts, ["\u{2212}60", "\u{2212}40", "\u{2212}20", "0", "20", "40", "60", "80"]);
        let texts: Vec<_> = axis.with_tick_at_start().ticks.into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts[..2], ["\u{2212}65", "\u{2212}40"]);
        let torque = Axis::new("torque", -0.1..0.15, 0.05, 2);
        assert_eq!(torque.ticks.len(), 6);
        assert_eq!(torque.ticks[2].1, "0.00");
    }
}
