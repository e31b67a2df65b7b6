//! What a figure shows, before it is drawn.

use std::ops::Range;

use plotters::style::RGBColor;

use super::style::Stroke;

/// How far beyond an end of the vertical axis a curve is still drawn, as a share of the axis: a line along the end may
/// overshoot it by less than its own width.
const OVERSHOOT: f64 = 0.01;

/// A figure.
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
    /// Panels stand in rows of this many.
    pub columns: usize,
    /// The legend, above all panels, where it can hide no curve.
    pub legend: Vec<(String, Symbol)>,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// What stands before an entry of a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Symbol {
    /// A piece of line.
    Line(Stroke),
    /// A point.
    Point(RGBColor, Shape),
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
    /// Abscissae behind which the ground is shaded, and what stands there.
    pub shade: Option<(Range<f64>, String)>,
    /// The curves, those above last.
    pub curves: Vec<Curve>,
    /// Single points, above all curves.
    pub marks: Vec<Mark>,
}

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// From end to end.
    pub range: Range<f64>,
    /// Where ticks stand, and what is written there.
    pub ticks: Vec<(f64, String)>,
}

/// A curve. What lies outside the axes is not drawn.
#[derive(Clone, Debug)]
pub struct Curve {
    /// How it is drawn.
    pub stroke: Stroke,
    /// Its points.
    pub points: Vec<[f64; 2]>,
}

/// A single point.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    /// Where.
    pub at: [f64; 2],
    /// In which colour.
    pub colour: RGBColor,
    /// In which shape.
    pub shape: Shape,
}

/// The shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Filled.
    Disc,
    /// Open.
    Ring,
}

impl Axis {
    /// An axis over `range` with ticks at the multiples of `spacing` in it, written with `decimals`.
    pub fn new(label: impl Into<String>, range: Range<f64>, spacing: f64, decimals: usize) -> Self {
        // A tick on an end of the axis may miss it by rounding.
        let slack = 1e-9 * (range.end - range.start);
        let (first, last) =
            (((range.start - slack) / spacing).ceil() as i64, ((range.end + slack) / spacing).floor() as i64);
        let ticks = (first..=last).map(|multiple| {
            let value = multiple as f64 * spacing;
            (value.clamp(range.start, range.end), number(value, decimals))
        });
        Self { label: label.into(), ticks: ticks.collect(), range }
    }

    /// An axis that begins and ends on a tick and holds all `values`, with about `count` ticks at round numbers.
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

    /// Between which values of a vertical axis curves are drawn.
    pub fn drawn(&self) -> [f64; 2] {
        let slack = OVERSHOOT * (self.range.end - self.range.start);
        [self.range.start - slack, self.range.end + slack]
    }

    /// The same axis with a tick at its lower end, as the paper has where that end is no multiple.
    #[must_use]
    pub fn with_tick_at_start(mut self) -> Self {
        let start = self.range.start;
        // The next tick would be written over it.
        self.ticks.retain(|(at, _)| at - start > 0.04 * (self.range.end - start));
        self.ticks.insert(0, (start, number(start, 0)));
        self
    }
}

/// A number as axes show it, with a true minus sign.
pub fn number(value: f64, decimals: usize) -> String {
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
