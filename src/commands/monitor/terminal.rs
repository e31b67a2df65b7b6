//! The screen and the keys.

use std::io;
use std::time::Duration;

use anyhow::Context;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::source::Source;
use super::view::View;
use crate::robot::shape::Shape;
use uarm_loop::stop_request::StopRequest;

/// How long the view waits for a key before it looks at the log again: the log grows four times a second.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);

/// Gives the terminal back as it was, whatever ends the view; a panic does so before it is printed.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// Shows a log until somebody quits, or it turns out to be one of a robot of another shape, which is returned then.
///
/// # Errors
/// If the terminal or the log fails.
pub fn show<const J: usize, const N: usize>(
    source: &mut Source<J, N>,
    stop: &StopRequest,
) -> anyhow::Result<Option<Shape>> {
    let mut terminal = ratatui::try_init().context("the terminal")?;
    let _restore = Restore;
    while !stop.is_made() {
        source.catch_up()?;
        if let Some(found) = source.other_shape() {
            return Ok(Some(found));
        }
        let view = View::of(&source.state);
        terminal.draw(|frame| frame.render_widget(&view, frame.area())).context("the terminal")?;
        if is_quit_asked_for().context("the keys")? {
            break;
        }
    }
    Ok(None)
}

/// Whether a key was pressed that quits; waits for one a little.
fn is_quit_asked_for() -> io::Result<bool> {
    if !event::poll(LOOK_INTERVAL)? {
        return Ok(false);
    }
    Ok(matches!(event::read()?, Event::Key(key) if quits(&key)))
}

fn quits(key: &KeyEvent) -> bool {
    let with_control = key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind == KeyEventKind::Press
        && match key.code {
            KeyCode::Char('q') | KeyCode::Esc => true,
            KeyCode::Char('c') => with_control,
            _ => false,
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn q_escape_and_control_c_quit() {
        let key = |code, modifiers| quits(&KeyEvent::new(code, modifiers));
        assert!(key(KeyCode::Char('q'), KeyModifiers::NONE));
        assert!(key(KeyCode::Esc, KeyModifiers::NONE));
        assert!(key(KeyCode::Char('c'), KeyModifiers::CONTROL));
        assert!(!key(KeyCode::Char('c'), KeyModifiers::NONE));
        assert!(!key(KeyCode::Enter, KeyModifiers::NONE));
    }
}
