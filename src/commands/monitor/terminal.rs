//! The screen and the keys.

use std::io;
use std::time::Duration;

use anyhow::Context;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::source::Source;
use super::view::View;
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

/// Shows a log until somebody quits.
///
/// # Errors
/// If the terminal or the log fails.
pub fn show(source: &mut Source, stop: &StopRequest) -> anyhow::Result<()> {
    // What is no log is told before the screen is taken.
    source.catch_up()?;
    let mut terminal = ratatui::try_init().context("the terminal")?;
    let _restore = Restore;
    while !stop.is_made() {
        source.catch_up()?;
        terminal.draw(|frame| frame.render_widget(View(&source.state), frame.area())).context("the terminal")?;
        if is_quit_asked_for().context("the keys")? {
            break;
        }
    }
    Ok(())
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
