//! What people read, as it is printed: reports, tables and help texts. `INSTA_UPDATE=always cargo test --test snapshots`
//! writes them anew after a change that is meant; the difference is then reviewed like any other.

mod support;

use std::path::Path;
use std::process::Command;

/// Wide enough for the tables; help texts wrap at it.
const COLUMNS: &str = "120";

/// What differs from machine to machine or from commit to commit.
const VARIABLE: [(&str, &str); 2] =
    [(r"\(commit [^)]*\)", "(commit [commit])"), (r"(?m)^  on  .*$", "  on                 [machine]")];

/// Runs `uarm`, which must succeed, in a folder of this test's own, and compares what it prints.
#[track_caller]
fn assert_prints(name: &str, folder: &Path, arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_uarm"))
        .args(arguments)
        .current_dir(folder)
        .env("COLUMNS", COLUMNS)
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", support::text(&output));
    let printed = format!(
        "{}--- standard error ---\n{}",
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap()
    );
    insta::with_settings!({
        filters => VARIABLE,
        prepend_module_to_snapshot => false,
        omit_expression => true,
        description => format!("uarm {}", arguments.join(" ")),
    }, {
        insta::assert_snapshot!(name, printed);
    });
}

/// A new folder.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = support::scratch(&format!("snapshots-{name}"));
    // Of an earlier test run; a log is never overwritten.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn a_run_and_what_its_log_tells() {
    let folder = folder("run");
    assert_prints("run", &folder, &["run", "--virtual-time", "--log", "run.mcap"]);
    assert_prints("show", &folder, &["show", "run.mcap"]);
    assert_prints("show-plot", &folder, &["show", "run.mcap", "--plot"]);
    assert_prints("replay", &folder, &["replay", "run.mcap"]);
    assert_prints("replay-another-law", &folder, &["replay", "run.mcap", "--controller", "adaptive"]);
    assert_prints("monitor-once", &folder, &["monitor", "run.mcap", "--once"]);
}

#[test]
fn a_law_that_the_paper_does_not_have_is_reported_without_its_numbers() {
    let arguments = ["run", "--virtual-time", "--controller", "computed-torque", "--repeat", "2", "--log", "none"];
    assert_prints("run-computed-torque-twice", &folder("repeat"), &arguments);
}

#[test]
fn the_comparison_of_the_controllers() {
    assert_prints("compare", &folder("compare"), &["compare", "--repeat", "1", "--variation", "none"]);
}

#[test]
fn the_margins_of_the_papers_robot() {
    assert_prints("check", &folder("check"), &["check"]);
}

#[test]
fn the_faults_that_end_a_run() {
    assert_prints("explain", &folder("explain"), &["explain"]);
}

#[test]
fn the_map_from_the_space_manipulator_to_its_equivalent() {
    assert_prints("map", &folder("map"), &["map"]);
}

#[test]
fn the_comparison_of_the_velocity_estimators() {
    assert_prints("filters", &folder("filters"), &["filters"]);
}

#[test]
fn the_help_of_each_subcommand() {
    use clap::CommandFactory;
    let folder = folder("help");
    assert_prints("help", &folder, &["--help"]);
    for words in subcommands(&uarm::cli::CommandLine::command()) {
        let mut arguments: Vec<_> = words.iter().map(String::as_str).collect();
        arguments.push("--help");
        assert_prints(&format!("help-{}", words.join("-")), &folder, &arguments);
    }
}

/// Every subcommand and those below it, each as the words that call it.
fn subcommands(command: &clap::Command) -> Vec<Vec<String>> {
    let mut all = Vec::new();
    for subcommand in command.get_subcommands() {
        let name = subcommand.get_name().to_owned();
        all.push(vec![name.clone()]);
        all.extend(subcommands(subcommand).into_iter().map(|words| [vec![name.clone()], words].concat()));
    }
    all
}
