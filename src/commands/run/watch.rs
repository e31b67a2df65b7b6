//! A line that shows how an experiment goes.

use std::io::{self, IsTerminal};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::dimensions::Progress;

/// How often the line is drawn anew.
const INTERVAL: Duration = Duration::from_millis(100);

/// Shows `progress` on standard error, if that is a terminal, until the experiment has `finished`; `duration` is that of
/// the motion, s.
pub fn show_progress<const N: usize>(progress: &Progress<N>, duration: f64, finished: impl Fn() -> bool) {
    let bar =
        if io::stderr().is_terminal() { ProgressBar::new((duration * 1e3) as u64) } else { ProgressBar::hidden() };
    bar.set_style(ProgressStyle::with_template("  {bar:30} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar()));
    while !finished() {
        let snapshot = progress.snapshot();
        let errors = snapshot.error.map(|error| format!("{:+6.2}", error.to_degrees())).join(" ");
        let torques = snapshot.torque.map(|torque| format!("{torque:+.3}")).join(" ");
        bar.set_position((snapshot.time * 1e3) as u64);
        bar.set_message(format!("{:6.2} s   error {errors} deg   torque {torques} N m", snapshot.time));
        thread::sleep(INTERVAL);
    }
    bar.finish_and_clear();
}
