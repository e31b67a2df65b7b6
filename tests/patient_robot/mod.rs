//! The paper's robot, but for watchdogs that outlast what a loaded machine makes a process wait: for tests of runs in real
//! time that are about something else.

use std::path::{Path, PathBuf};

/// Its watchdogs' limits, ms.
const PATIENCE: [(&str, u32); 2] = [("controller_timeout_ms", 500), ("drive_timeout_ms", 3000)];
/// As many late cycles in a row as a robot file may allow.
const LATE_CYCLES: &str = "overruns_in_a_row = 10";

/// Writes its robot file into `folder`.
pub fn write(folder: &Path) -> PathBuf {
    let lines = uarm::robot::BUILT_IN.lines().map(|line| {
        let watchdog = PATIENCE.iter().find(|(field, _)| line.starts_with(field));
        let line = watchdog.map_or_else(|| line.to_owned(), |(field, limit)| format!("{field} = {limit}"));
        if line == "[control]" { format!("{line}\n{LATE_CYCLES}") } else { line }
    });
    let path = folder.join("patient.toml");
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n")).unwrap();
    path
}
