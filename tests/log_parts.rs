//! `uarm run --log-limit`: a log in parts, of which the newest are kept and each is a log by itself.

mod support;

use std::path::{Path, PathBuf};

use serde_json::Value;
use support::{standard_output, text, uarm};
use uarm::dimensions::RunLog;

/// Little more than the least for a period of 9 ms.
const LIMIT: u64 = 7_500_000;

fn folder(name: &str) -> PathBuf {
    let folder = support::scratch(&format!("log-parts-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The parts that are left, in the order in which they were written.
fn parts(folder: &Path) -> Vec<PathBuf> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut parts: Vec<_> = files.filter(|file| RunLog::<3, 2>::read(file).is_ok()).collect();
    parts.sort_by_key(|file| RunLog::<3, 2>::read(file).unwrap().cycles[0].tick);
    parts
}

/// Runs until more than the limit was written, and gives the report and the parts.
fn run(folder: &Path) -> (Value, Vec<PathBuf>) {
    let log = folder.join("run.mcap");
    let arguments = ["run", "--virtual-time", "--period", "9ms", "--controller", "neural", "--hold", "150s", "--json"];
    let limit = LIMIT.to_string() + "kB";
    let limit = limit.replace("000kB", "kB");
    let told = standard_output(&[&arguments[..], &["--log", log.to_str().unwrap(), "--log-limit", &limit]].concat());
    let reports: Value = serde_json::from_str(&told).unwrap();
    (reports[0].clone(), parts(folder))
}

#[test]
fn each_part_replays_and_shows_by_itself_and_only_own_files_are_deleted() {
    let folder = folder("run");
    std::fs::write(folder.join("run.part2.mcap"), "of another run").unwrap();
    let (report, parts) = run(&folder);
    assert_eq!(std::fs::read(folder.join("run.part2.mcap")).unwrap(), b"of another run");
    assert!(!folder.join("run.mcap").exists(), "the oldest part is deleted first");
    let bytes: u64 = parts.iter().map(|part| part.metadata().unwrap().len()).sum();
    assert!((LIMIT / 2..=LIMIT).contains(&bytes), "{bytes}");
    let (written, deleted) =
        (report["log_parts"]["written"].as_u64().unwrap(), report["log_parts"]["deleted"].as_u64().unwrap());
    assert_eq!(written - deleted, parts.len() as u64);
    assert!(deleted > 0 && parts.len() >= 5, "{report:#}");
    let last = parts.last().unwrap();
    assert_eq!(report["log_parts"]["last"], last.to_str().unwrap());

    let mut cycles = Vec::new();
    for part in &parts {
        let output = uarm(&["replay", part.to_str().unwrap(), "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output));
        let replay: Value = serde_json::from_slice(&output.stdout).unwrap();
        let log = RunLog::<3, 2>::read(part).unwrap();
        assert_eq!(replay["exact"]["cycles"], log.cycles.len());
        assert_eq!(replay["part"]["number"], log.part.number);
        cycles.extend(log.cycles.iter().map(|cycle| cycle.tick));
    }
    assert!(cycles.windows(2).all(|pair| pair[1] == pair[0] + 1), "cycles are missing between two parts");
    assert_eq!(cycles.last().unwrap() + 1, report["timing"]["cycles"].as_u64().unwrap());
}

/// What is of the whole run is not told of a part.
#[test]
fn show_tells_the_part_and_monitor_goes_on_to_the_newest() {
    let folder = folder("show");
    let (report, parts) = run(&folder);
    for (part, is_last) in parts.iter().zip((1..).map(|number| number == parts.len())) {
        let output = uarm(&["show", part.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output));
        let told = text(&output);
        for absent in ["L2", "E (N m s)", "paper", "verdict", "DIFFERS", "LOST"] {
            assert!(!told.contains(absent), "{absent}: {told}");
        }
        let number = RunLog::<3, 2>::read(part).unwrap().part.number;
        assert!(told.contains(&format!("  part               part {number} of a run")), "{told}");
        assert_eq!(told.contains(": completed"), is_last, "{told}");
        assert_eq!(told.contains("goes on in run.part"), !is_last, "{told}");
        assert!(told.contains("serial number 1"), "{told}");
    }
    let output = uarm(&["monitor", parts[0].to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let snapshot: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(snapshot["life"], "ended");
    assert_eq!(snapshot["cycle"]["tick"].as_u64().unwrap() + 1, report["timing"]["cycles"].as_u64().unwrap());
}

#[test]
fn a_limit_that_cannot_be_kept_is_refused_before_anything_moves() {
    let folder = folder("refused");
    let log = folder.join("run.mcap");
    let refused = |arguments: &[&str], part: &str| {
        let output = uarm(&[&["run", "--virtual-time"], arguments].concat());
        assert!(matches!(output.status.code(), Some(1 | 2)), "{}", text(&output));
        assert!(text(&output).contains(part), "{part}: {}", text(&output));
        assert!(!log.exists());
    };
    let file = log.to_str().unwrap();
    refused(&["--log", file, "--log-limit", "1MB"], "1000000 bytes, expected at least 18105152");
    refused(&["--log", file, "--log-limit", "18105151B"], "such as 500MB, 1.5GB or 2GiB");
    refused(&["--log", "none", "--log-limit", "1GB"], "--log-limit: expected a log");
    refused(&["--log", "/dev/null", "--log-limit", "1GB"], "expected a file with --log-limit");
}
