//! What came of a campaign, told.

use std::process::ExitCode;

use crate::campaign::store::Trials;
use crate::campaign::summary::Summary;
use crate::console;
use crate::exit::Exit;

/// Prints what came of the trials.
///
/// # Errors
/// If standard output cannot be written.
pub fn tell(trials: &Trials, json: bool) -> anyhow::Result<ExitCode> {
    let summary = Summary::new(trials);
    if json {
        console::print_json(&summary)?;
    } else {
        summary.print(&mut console::output())?;
    }
    Ok(if summary.failed.is_empty() { Exit::Ok } else { Exit::Failure }.into())
}
