//! Progress bars of long work.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of `length` pieces of work, called `unit`, on standard error; none where that is no terminal.
pub fn progress_bar(length: u64, unit: &str) -> ProgressBar {
    let bar = if io::stderr().is_terminal() { ProgressBar::new(length) } else { ProgressBar::hidden() };
    let style = ProgressStyle::with_template(&format!("  {{bar:30}} {{pos}} of {{len}} {unit}, {{eta}} left"));
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
