//! A panel of a figure in a terminal.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Margin, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{self, Block, Chart, Dataset, GraphType, Widget};
use uarm_plot::sheet::{Axis, Panel, Sheet};
use uarm_plot::style::{BLACK, Stroke};

use super::panels::curve_names;
use super::plain_text;

/// The dots of the first curve, the characters of the others: they differ without colours too.
const MARKERS: [Mark; 3] = [
    Mark { marker: Marker::Braille, symbol: '\u{2812}' },
    Mark { marker: Marker::Dot, symbol: '\u{2022}' },
    Mark { marker: Marker::Custom('+'), symbol: '+' },
];

/// What a curve is drawn with, and what stands for it in the title.
#[derive(Clone, Copy, Debug)]
struct Mark {
    marker: Marker,
    symbol: char,
}

/// The marks of so many curves of these names: of more than there are characters that tell them apart, each is drawn with the number of
/// its joint, or with a letter of its own.
fn marks(names: &[String]) -> Vec<Mark> {
    if names.len() <= MARKERS.len() {
        return MARKERS.into_iter().take(names.len()).collect();
    }
    let mut letters = 'a'..='z';
    let of = |name: &String| {
        let number = name.strip_prefix("joint ").and_then(|number| number.parse().ok());
        number.or_else(|| letters.next()).unwrap_or('*')
    };
    names.iter().map(of).map(|symbol| Mark { marker: Marker::Custom(symbol), symbol }).collect()
}
/// Lines that a panel takes as plain text.
const PANEL_LINES: u16 = 16;
/// Lines and columns of a panel that are not its coordinate system's: the frame, and the horizontal axis with its labels.
const FRAME_LINES: u16 = 4;
/// Columns of the vertical axis itself.
const AXIS_COLUMNS: u16 = 1;
/// A vertical axis has a label for at most each so many lines; a horizontal one below so many columns has none.
const LINES_PER_LABEL: u16 = 2;
const COLUMNS_PER_LABEL: u16 = 10;

/// A panel as a widget.
#[derive(Clone, Copy, Debug)]
pub struct PanelChart<'a>(pub &'a Panel);

/// The panels of a figure, one below the other, as plain text of so many columns.
pub fn plain(sheet: &Sheet, columns: u16) -> String {
    let height = PANEL_LINES.saturating_mul(u16::try_from(sheet.panels.len()).unwrap_or(u16::MAX));
    let mut buffer = Buffer::empty(Rect::new(0, 0, columns, height));
    let areas = Layout::vertical(sheet.panels.iter().map(|_| Constraint::Length(PANEL_LINES))).split(buffer.area);
    for (panel, area) in sheet.panels.iter().zip(areas.iter()) {
        PanelChart(panel).render(*area, &mut buffer);
    }
    plain_text::of(&buffer)
}

impl Widget for PanelChart<'_> {
    fn render(self, area: Rect, buffer: &mut Buffer) {
        let Self(panel) = self;
        let curves: Vec<(Stroke, Vec<(f64, f64)>)> = panel
            .curves
            .iter()
            .map(|curve| (curve.stroke, curve.points.iter().map(|[x, y]| (*x, *y)).collect()))
            .collect();
        let names = names(panel);
        let marks = marks(&names);
        let datasets = curves.iter().zip(&marks).map(|((stroke, points), mark)| {
            Dataset::default().data(points).marker(mark.marker).graph_type(GraphType::Line).style(style(stroke))
        });
        let labels = vertical_labels(&panel.y, area.height.saturating_sub(FRAME_LINES) / LINES_PER_LABEL);
        let label_columns = labels.iter().map(|label| label.chars().count()).max().unwrap_or_default();
        // The first curve is drawn last: its fine dots would disappear below the others' characters.
        let datasets: Vec<_> = datasets.collect::<Vec<_>>().into_iter().rev().collect();
        Chart::new(datasets)
            .block(Block::bordered().title(title(panel, &names, &marks)))
            // Empty labels keep their line free: those of the library do not stand where their ticks are.
            .x_axis(axis(&panel.x).labels(["", ""]))
            .y_axis(axis(&panel.y).labels(labels))
            .render(area, buffer);
        horizontal_labels(&panel.x, area, u16::try_from(label_columns).unwrap_or(u16::MAX), buffer);
    }
}

/// The vertical axis' label and the curves' names.
fn title(panel: &Panel, names: &[String], marks: &[Mark]) -> Line<'static> {
    let mut spans = vec![Span::from(format!(" {} over {}", panel.y.label, panel.x.label)).bold()];
    for ((curve, name), Mark { symbol, .. }) in panel.curves.iter().zip(names).zip(marks) {
        // A line has no room for the names of many: a joint's number says it.
        let text = if symbol.is_ascii_digit() { format!(" {symbol}") } else { format!("   {symbol} {name}") };
        spans.push(Span::styled(text, style(&curve.stroke)));
    }
    spans.push(Span::from(" "));
    Line::from(spans)
}

/// The names of the curves.
fn names(panel: &Panel) -> Vec<String> {
    let name =
        |stroke: &Stroke| curve_names().find(|(_, other)| other == stroke).map_or(String::new(), |(name, _)| name);
    panel.curves.iter().map(|curve| name(&curve.stroke)).collect()
}

fn axis(axis: &Axis) -> widgets::Axis<'static> {
    widgets::Axis::default().bounds([axis.range.start, axis.range.end])
}

/// All of them, or those of the ends if there is too little room.
fn vertical_labels(axis: &Axis, most: u16) -> Vec<String> {
    let texts = axis.ticks.iter().map(|(_, text)| text.clone());
    if axis.ticks.len() <= usize::from(most) {
        return texts.collect();
    }
    let ends = [axis.ticks.first(), axis.ticks.last()];
    ends.into_iter().flatten().map(|(_, text)| text.clone()).collect()
}

/// Writes the labels of the horizontal axis below their ticks, right of a vertical axis with labels of so many columns.
fn horizontal_labels(axis: &Axis, area: Rect, label_columns: u16, buffer: &mut Buffer) {
    let inner = area.inner(Margin::new(1, 1));
    let left = label_columns.saturating_add(AXIS_COLUMNS);
    if inner.height < FRAME_LINES || inner.width <= left.saturating_add(COLUMNS_PER_LABEL) {
        return;
    }
    let width = inner.width - left - 1;
    let mut free_from = inner.x;
    for (value, text) in &axis.ticks {
        let share = (value - axis.range.start) / (axis.range.end - axis.range.start);
        let length = u16::try_from(text.chars().count()).unwrap_or(u16::MAX);
        let middle = inner.x + left + (share * f64::from(width)).round() as u16;
        let column = middle.saturating_sub(length / 2).min(inner.right().saturating_sub(length));
        if column >= free_from {
            buffer.set_string(column, inner.bottom() - 1, text, Style::new());
            free_from = column.saturating_add(length).saturating_add(1);
        }
    }
}

/// Black is for paper: a terminal's own colour stands in.
fn style(stroke: &Stroke) -> Style {
    let colour = stroke.colour;
    if colour == BLACK { Style::new() } else { Style::new().fg(Color::Rgb(colour.0, colour.1, colour.2)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Panel {
        let axis = |label| Axis::new(label, 0.0..4.0, 1.0, 0);
        Panel::new("", axis("Time (s)"), axis("Angle (\u{b0})"))
            .with(crate::figures::style::JOINT_2, [[0.0, 0.0], [4.0, 4.0]])
    }

    #[test]
    fn labels_stand_at_their_ticks_and_curves_end_where_their_axes_do() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 64, 14));
        PanelChart(&ramp()).render(buffer.area, &mut buffer);
        let text = plain_text::of(&buffer);
        let lines: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
        let title: String = lines[0].iter().collect();
        assert!(title.contains("Angle (\u{b0}) over Time (s)   \u{2812} joint 2"), "{text}");
        let places: Vec<usize> = (0..64).filter(|column| lines[12][*column].is_ascii_digit()).collect();
        assert_eq!(places, [3, 18, 33, 47, 62], "{text}");
        assert_eq!((lines[1][1], lines[10][1]), ('4', '0'), "{text}");
        assert!(('\u{2801}'..='\u{28ff}').contains(&lines[1][62]), "{text}");
    }

    /// Seven joints, and what the drives of two of them reported.
    #[test]
    fn many_curves_are_drawn_with_their_numbers() {
        let axis = |label| Axis::new(label, 0.0..4.0, 1.0, 0);
        let line = |height: f64| [[0.0, height], [4.0, height]];
        let panel = Panel::new("", axis("Time (s)"), axis("Torque (N m)"));
        let panel = (1..=7)
            .fold(panel, |panel, joint| panel.with(crate::figures::style::of_joint(joint), line(0.5 * joint as f64)));
        let panel = [2, 3]
            .into_iter()
            .fold(panel, |panel, joint| panel.with(crate::figures::style::reported_by_joint(joint), line(0.1)));
        let mut buffer = Buffer::empty(Rect::new(0, 0, 100, 20));
        PanelChart(&panel).render(buffer.area, &mut buffer);
        let text = plain_text::of(&buffer);
        assert!(
            text.contains("Torque (N m) over Time (s) 1 2 3 4 5 6 7   a joint 2, reported   b joint 3, reported "),
            "{text}"
        );
        for number in '1'..='7' {
            assert!(text.lines().skip(1).any(|line| line.matches(number).count() > 40), "{number}: {text}");
        }
    }

    #[test]
    fn no_area_is_too_small() {
        for (width, height) in (0..20).flat_map(|width| (0..10).map(move |height| (width, height))) {
            let mut buffer = Buffer::empty(Rect::new(0, 0, width, height));
            PanelChart(&ramp()).render(buffer.area, &mut buffer);
        }
    }
}
