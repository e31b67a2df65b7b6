//! The live view as a widget.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph, Row, Table, Widget};

use super::snapshot::{JointRow, Snapshot};
use super::state::{Life, State};
use crate::inspection::chart::PanelChart;
use crate::inspection::panels::Plot;
use crate::inspection::{health, plain_text};
use crate::report::latency_table;
use uarm_log::decoder::LoggedNote;
use uarm_log::description::ClockKind;
use uarm_log::time_axis::seconds_between;
use uarm_loop::recording::Severity;
use uarm_plot::sheet::Panel;

/// Lines of a view as plain text, beside those of the joints: room for all other parts.
const PLAIN_LINES: u16 = 49;
/// Lines of a part's frame.
const FRAME: u16 = 2;
/// The fewest lines of a plot in which a curve can be told from its axes.
const PLOT_LINES: u16 = 9;
/// Notes that are shown.
const NOTES: u16 = 4;
/// Columns of the latency table, which has numbers only, with its frame.
const TIMING_COLUMNS: u16 = 70;
/// What the last line says.
const FOOTER: &str = " q, Esc or Ctrl-C: quit     the view lags behind by up to a quarter of a second";

/// The live view: what its parts show, whatever the joints of the robot are.
#[derive(Debug)]
pub struct View<'a> {
    snapshot: Snapshot<'a>,
    life: Life,
    /// How many there are.
    joints: u16,
    timing: Vec<String>,
    bus: Vec<String>,
    notes: &'a [LoggedNote],
    begin: Option<u64>,
    tracking_error: Panel,
    torque: Panel,
    latencies: Panel,
}

/// The view as plain text.
pub fn plain<const J: usize, const N: usize>(state: &State<J, N>) -> String {
    let view = View::of(state);
    let mut buffer = Buffer::empty(Rect::new(0, 0, plain_text::columns(), PLAIN_LINES + view.joints));
    view.render(buffer.area, &mut buffer);
    plain_text::of(&buffer)
}

/// The parts in the order in which they stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Head,
    Joints,
    Plots,
    Timing,
    Bus,
    Notes,
    Footer,
}

/// What a small terminal is filled with first.
const BY_IMPORTANCE: [Part; 7] =
    [Part::Head, Part::Joints, Part::Timing, Part::Footer, Part::Bus, Part::Plots, Part::Notes];
const FROM_ABOVE: [Part; 7] =
    [Part::Head, Part::Joints, Part::Plots, Part::Timing, Part::Bus, Part::Notes, Part::Footer];

impl Widget for &View<'_> {
    fn render(self, area: Rect, buffer: &mut Buffer) {
        let shown = self.fitting(area.height);
        let heights = shown.iter().map(|part| match part {
            Part::Plots => Constraint::Min(PLOT_LINES),
            part => Constraint::Length(self.height(*part)),
        });
        let areas = Layout::vertical(heights).split(area);
        for (part, area) in shown.iter().zip(areas.iter()) {
            self.draw(*part, *area, buffer);
        }
    }
}

impl<'a> View<'a> {
    /// The view of a state.
    pub fn of<const J: usize, const N: usize>(state: &'a State<J, N>) -> Self {
        let snapshot = Snapshot::of(state);
        let recent = state.recent();
        Self {
            life: state.life(),
            joints: u16::try_from(J).unwrap_or(u16::MAX),
            timing: timing_lines(&snapshot),
            bus: snapshot.health.map(health::lines).unwrap_or_default(),
            notes: &state.notes,
            begin: state.begin,
            tracking_error: Plot::tracking_error().of(recent),
            torque: Plot::torque().of(recent),
            latencies: Plot::latencies().of(recent),
            snapshot,
        }
    }

    fn height(&self, part: Part) -> u16 {
        let lines = |lines: &[String]| u16::try_from(lines.len()).unwrap_or(u16::MAX);
        match part {
            Part::Head => FRAME + 2,
            Part::Joints => FRAME + 1 + self.joints,
            Part::Plots => PLOT_LINES,
            Part::Timing => FRAME + lines(&self.timing),
            Part::Bus => FRAME + lines(&self.bus).max(1),
            Part::Notes => FRAME + NOTES,
            Part::Footer => 1,
        }
    }

    /// As many parts as there is room for, the important ones first.
    fn fitting(&self, height: u16) -> Vec<Part> {
        let mut room = height;
        let mut chosen = Vec::new();
        for part in BY_IMPORTANCE {
            if let Some(left) = room.checked_sub(self.height(part)) {
                room = left;
                chosen.push(part);
            }
        }
        FROM_ABOVE.into_iter().filter(|part| chosen.contains(part)).collect()
    }

    fn draw(&self, part: Part, area: Rect, buffer: &mut Buffer) {
        match part {
            Part::Head => self.head(area, buffer),
            Part::Joints => self.joints(area, buffer),
            Part::Plots => {
                let [left, right] = Layout::horizontal([Constraint::Fill(1); 2]).areas(area);
                PanelChart(&self.tracking_error).render(left, buffer);
                PanelChart(&self.torque).render(right, buffer);
            }
            Part::Timing => self.timing(area, buffer),
            Part::Bus => paragraph(" Bus and drives ", &self.bus).render(area, buffer),
            Part::Notes => self.notes(area, buffer),
            Part::Footer => Line::from(FOOTER).dim().render(area, buffer),
        }
    }

    fn head(&self, area: Rect, buffer: &mut Buffer) {
        let snapshot = &self.snapshot;
        let style = match self.life {
            Life::Beginning | Life::Ended(_) => Style::new().bold(),
            Life::Running => Style::new().fg(Color::Green).bold(),
            Life::Silent(_) | Life::Unreadable => Style::new().fg(Color::Yellow).bold(),
            Life::Failed(_) => Style::new().fg(Color::White).bg(Color::Red).bold(),
        };
        let title = snapshot.run.map_or_else(
            || " uarm monitor ".to_owned(),
            |run| format!(" {} on {}, controller {} ", run.robot, run.place, run.controller),
        );
        let (tick, time) = snapshot.cycle.as_ref().map_or((0, 0.0), |cycle| (cycle.tick, cycle.time_s));
        let mut where_it_is = format!(
            "tick {tick}   task time {time:.3} s   torque limited in {} cycles   {}",
            snapshot.limited_cycles, snapshot.file
        );
        if let Some(damage) = snapshot.damage.last() {
            where_it_is.push_str(&format!("   DAMAGED: {damage}"));
        }
        let lines = vec![Line::styled(snapshot.told.clone(), style), Line::from(where_it_is)];
        Paragraph::new(lines).block(Block::bordered().title(title.bold())).render(area, buffer);
    }

    fn joints(&self, area: Rect, buffer: &mut Buffer) {
        let columns = [
            ("joint", Constraint::Length(10)),
            ("angle (\u{b0})", Constraint::Length(9)),
            ("vel. (\u{b0}/s)", Constraint::Length(10)),
            ("  desired", Constraint::Length(9)),
            ("   error", Constraint::Length(8)),
            ("asked N\u{b7}m", Constraint::Length(9)),
            ("  applied", Constraint::Length(11)),
            ("sent \u{2030}", Constraint::Length(6)),
            ("drive", Constraint::Fill(1)),
        ];
        let header = Row::new(columns.map(|(name, _)| name));
        let rows = self.snapshot.cycle.iter().flat_map(|cycle| &cycle.joints).map(joint_row);
        let table = Table::new(rows, columns.map(|(_, width)| width))
            .header(header.bold())
            .block(Block::bordered().title(" Joints "));
        Widget::render(table, area, buffer);
    }

    fn timing(&self, area: Rect, buffer: &mut Buffer) {
        let [left, right] = Layout::horizontal([Constraint::Length(TIMING_COLUMNS), Constraint::Fill(1)]).areas(area);
        paragraph(" Timing ", &self.timing).render(left, buffer);
        if self.snapshot.run.is_some_and(|run| run.clock == ClockKind::Monotonic) {
            PanelChart(&self.latencies).render(right, buffer);
        }
    }

    fn notes(&self, area: Rect, buffer: &mut Buffer) {
        let lines = self.notes.iter().rev().take(usize::from(NOTES)).map(|note| {
            let at = self.begin.map_or(0.0, |begin| seconds_between(begin, note.at));
            let style = match note.severity {
                Severity::Info => Style::new(),
                Severity::Warning => Style::new().fg(Color::Yellow),
                Severity::Fatal => Style::new().fg(Color::Red),
            };
            Line::styled(format!("{at:>9.3} s  {}", note.text), style)
        });
        let newest_last: Vec<_> = lines.collect::<Vec<_>>().into_iter().rev().collect();
        Paragraph::new(newest_last).block(Block::bordered().title(" Notes ")).render(area, buffer);
    }
}

fn paragraph<'a>(title: &'a str, lines: &'a [String]) -> Paragraph<'a> {
    let lines: Vec<_> = lines.iter().map(|line| Line::from(line.as_str())).collect();
    Paragraph::new(lines).block(Block::bordered().title(title))
}

fn joint_row(row: &JointRow<'_>) -> Row<'static> {
    let [mut desired, mut error, mut asked, mut applied] = [const { String::new() }; 4];
    let mut limited = false;
    if let Some(active) = &row.active {
        desired = format!("{:>9.3}", active.reference_deg);
        error = format!("{:>+8.3}", active.error_deg);
        asked = format!("{:>+9.5}", active.torque_requested_nm);
        applied = format!("{:>+9.5}{}", active.torque_applied_nm, if active.limited { " !" } else { "" });
        limited = active.limited;
    }
    let cells = [
        row.name.to_owned(),
        format!("{:>8.3}", row.angle_deg),
        format!("{:>+8.3}", row.velocity_deg_per_s),
        desired,
        error,
        asked,
        applied,
        format!("{:>+6}", row.torque_sent_per_mille),
        row.drive.clone(),
    ];
    Row::new(cells).style(if limited { Style::new().fg(Color::Yellow) } else { Style::new() })
}

fn timing_lines(snapshot: &Snapshot<'_>) -> Vec<String> {
    let Some(timing) = &snapshot.timing else { return vec!["no cycle yet".to_owned()] };
    let mut lines = vec![format!(
        "{} cycles of {} ms, {} deadlines missed, {} ticks skipped",
        timing.cycles,
        timing.period_ns as f64 / 1e6,
        timing.missed_deadlines,
        timing.skipped_ticks
    )];
    if snapshot.run.is_some_and(|run| run.clock == ClockKind::Virtual) {
        lines.push("virtual time passes only while the loop sleeps: it has no latencies".to_owned());
        return lines;
    }
    lines.extend(latency_table(timing));
    if let Some(cycle) = &snapshot.cycle {
        let last = cycle.latencies;
        lines.push(format!(
            "last cycle: wake-up {:.1}, SYNC to counts {:.1}, total {:.1}",
            last.wake_up_us, last.feedback_latency_us, last.total_us
        ));
    }
    lines
}
