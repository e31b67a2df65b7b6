//! Files that commands write, and standard output and error that nobody reads.

mod support;

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use support::text;

/// A folder of one test with the log of a short run in it, `run.mcap`.
fn folder(name: &str) -> PathBuf {
    let folder = support::scratch(&format!("outputs-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let run = uarm(&folder, &["run", "--virtual-time", "--controller", "neural", "--log", "run.mcap"]);
    assert!(run.status.success(), "{}", text(&run));
    folder
}

fn uarm(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).current_dir(folder).output().unwrap()
}

/// Runs a line of bash, in which `$U` is the program.
fn bash(folder: &Path, line: &str) -> Output {
    let mut bash = Command::new("bash");
    bash.args(["-c", line]).env("U", env!("CARGO_BIN_EXE_uarm")).current_dir(folder).output().unwrap()
}

const EPOCH: [&str; 4] = ["--controller", "neural", "--epochs", "1"];

#[test]
fn an_output_in_a_folder_that_is_not_there_is_refused_before_the_work() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for arguments in [
        // Work that would take longer than anybody waits.
        &["campaign", "--seeds", "1000000000", "--output", "no-such-folder/out.jsonl"][..],
        &["compare", "--monte-carlo", "100000000", "--draws", "no-such-folder/out.jsonl"],
    ] {
        let output = uarm(folder, arguments);
        assert_eq!(output.status.code(), Some(1));
        assert!(text(&output).contains("no-such-folder"), "{}", text(&output));
    }
    let twice = ["compare", "--monte-carlo", "100000000", "--draws", "twice.out", "--csv", "twice.out"];
    let output = uarm(folder, &twice);
    assert!(text(&output).contains("named for two outputs"), "{}", text(&output));
}

#[test]
fn no_command_writes_over_what_it_reads() {
    let folder = folder("inputs");
    let csv = uarm(&folder, &["show", "run.mcap", "--csv", "run.csv"]);
    assert!(csv.status.success(), "{}", text(&csv));
    std::fs::write(folder.join("robot.toml"), uarm::robot::BUILT_IN).unwrap();
    for link in ["link.svg", "link.mcap"] {
        std::os::unix::fs::symlink("run.mcap", folder.join(link)).unwrap();
    }
    std::fs::hard_link(folder.join("run.mcap"), folder.join("hard.png")).unwrap();
    std::fs::hard_link(folder.join("robot.toml"), folder.join("robot.csv")).unwrap();
    let contents = || ["run.mcap", "run.csv", "robot.toml"].map(|name| std::fs::read(folder.join(name)).unwrap());
    let before = contents();
    let train: &[&str] = &[&["train", "run.csv", "--out", "run.csv"][..], &EPOCH].concat();
    for command in [
        &["show", "run.mcap", "--csv", "run.mcap"][..],
        &["show", "run.mcap", "--candump", "./run.mcap"],
        &["show", "run.mcap", "--csv", "link.mcap"],
        &["show", "link.mcap", "--csv", "run.mcap"],
        &["show", "run.mcap", "--figure", "link.svg"],
        &["show", "run.mcap", "--figure", "hard.png"],
        &["replay", "run.mcap", "--controller", "adaptive", "--csv", "run.mcap"],
        &["replay", "run.mcap", "--controller", "adaptive", "--plot", "link.svg"],
        &["replay", "run.mcap", "--robot", "robot.toml", "--csv", "robot.toml"],
        &["compare", "--robot", "robot.toml", "--repeat", "1", "--csv", "robot.csv"],
        &["plant", "--can", "nowhere0", "--robot", "robot.toml", "--truth", "robot.csv"],
        train,
    ] {
        for force in [&[][..], &["--force"]] {
            let output = uarm(&folder, &[command, force].concat());
            assert_eq!(output.status.code(), Some(1), "{command:?}: {}", text(&output));
            assert!(text(&output).contains("it is the input "), "{command:?}: {}", text(&output));
            assert!(contents() == before, "{command:?}");
        }
    }
}

#[test]
fn no_command_writes_over_another_file_unless_it_is_told_to() {
    let folder = folder("force");
    let out = folder.join("figures");
    std::fs::create_dir(&out).unwrap();
    let names = ["out.csv", "out.log", "out.svg", "sets.toml", "figures/fuzzy-sets.svg", "figures/overview.svg"];
    let write_all = || names.iter().for_each(|name| std::fs::write(folder.join(name), "mine").unwrap());
    let kept = || names.iter().filter(|name| std::fs::read(folder.join(name)).unwrap() == b"mine").count();
    let train: &[&str] = &[&["train", "run.mcap", "--out", "sets.toml"][..], &EPOCH].concat();
    let draw =
        [&["train", "run.mcap", "--out", "new.toml", "--figures", "figures", "--format", "svg"][..], &EPOCH].concat();
    for (command, replaced) in [
        (&["show", "run.mcap", "--csv", "out.csv", "--candump", "out.log"][..], 2),
        (&["show", "run.mcap", "--figure", "out.svg"], 1),
        (&["replay", "run.mcap", "--controller", "adaptive", "--csv", "out.csv", "--plot", "out.svg"], 2),
        (&["compare", "--repeat", "1", "--variation", "none", "--csv", "out.csv"], 1),
        (&["figures", "--out", "figures", "--format", "svg"], 1),
        (train, 1),
        (&draw, 1),
    ] {
        write_all();
        let output = uarm(&folder, command);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {}", text(&output));
        assert!(text(&output).contains("the file exists, expected a new one"), "{command:?}: {}", text(&output));
        assert_eq!(kept(), names.len(), "{command:?}");
        let output = uarm(&folder, &[command, &["--force"]].concat());
        assert_eq!(output.status.code(), Some(0), "{command:?}: {}", text(&output));
        assert_eq!(kept(), names.len() - replaced, "{command:?}");
    }
    let same = uarm(&folder, &["show", "run.mcap", "--csv", "twice", "--candump", "./twice"]);
    assert_eq!(same.status.code(), Some(1));
    assert!(text(&same).contains("named for two outputs"), "{}", text(&same));
    let hidden = std::fs::read_dir(&folder)
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().file_name().as_bytes().ends_with(b".part"));
    assert_eq!(hidden.count(), 0, "nothing is left beside them");
}

/// Without an interface nothing is replaced either.
#[test]
fn the_truth_of_a_plant_is_a_new_file() {
    let folder = folder("truth");
    let truth = folder.join("truth.csv");
    std::fs::write(&truth, "mine").unwrap();
    let command = ["plant", "--can", "nowhere0", "--truth", "truth.csv"];
    for (force, message) in [(&[][..], "the file exists, expected a new one"), (&["--force"], "nowhere0")] {
        let output = uarm(&folder, &[&command, force].concat());
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        assert!(text(&output).contains(message), "{}", text(&output));
        assert_eq!(std::fs::read(&truth).unwrap(), b"mine");
    }
}

/// Whoever reads, the exit code is that of the work, and nothing is told of it.
#[test]
fn a_reader_that_leaves_ends_the_output_and_nothing_else() {
    let folder = folder("readers");
    for command in [
        "show run.mcap --csv -",
        "show run.mcap --candump -",
        "show run.mcap --json",
        "show run.mcap",
        "show run.mcap --plot",
        "replay run.mcap",
        "replay run.mcap --controller adaptive --json",
        "monitor run.mcap --once",
        "compare --repeat 1 --variation none",
        "filters",
        "map",
        "check",
        "completions bash",
        "figures --out figures --format svg",
        "run --virtual-time --log none",
        "run --virtual-time --log none --json",
    ] {
        for reader in ["head -c 1 >/dev/null", "true"] {
            if command.starts_with("figures") {
                let _ = std::fs::remove_dir_all(folder.join("figures"));
            }
            let line = format!(
                "$U {command} 2>error | {reader}; echo ${{PIPESTATUS[0]}}; grep -v '^ \\|:.*controller\\|^on the' error"
            );
            let output = bash(&folder, &line);
            assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "0", "{command} | {reader}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.join("figures")).unwrap().count(), 14, "all figures are written");
}

#[test]
fn a_run_ends_as_it_ends_and_its_report_is_not_lost() {
    let folder = folder("run");
    for (line, code) in [
        ("$U run --virtual-time --log none 2>&1 | true; echo ${PIPESTATUS[0]}", "0"),
        ("$U run --virtual-time --log none >report 2>/dev/full; echo $?", "0"),
        ("$U run --virtual-time --log none >report 2>&-; echo $?", "0"),
        ("$U run --virtual-time --log none >&- 2>&-; echo $?", "0"),
        ("$U run --virtual-time --log none >/dev/full 2>report; echo $?", "0"),
        ("$U run --virtual-time --log none --json >/dev/full 2>report; echo $?", "0"),
        ("$U run --virtual-time --log no/such/folder/file 2>/dev/full; echo $?", "1"),
        ("$U run --no-such-option 2>/dev/full; echo $?", "2"),
    ] {
        let report = folder.join("report");
        let _ = std::fs::remove_file(&report);
        let output = bash(&folder, line);
        assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), code, "{line}: {}", text(&output));
        if report.exists() {
            let report = std::fs::read_to_string(report).unwrap();
            assert!(report.contains("completed\n  L2  "), "{line}: {report}");
        }
    }
    for command in ["completions bash", "show run.mcap", "show run.mcap --csv -", "map --json"] {
        let output = bash(&folder, &format!("$U {command} >/dev/full"));
        assert_eq!(output.status.code(), Some(1), "{command}");
        assert!(text(&output).contains("standard output: No space left"), "{command}: {}", text(&output));
        assert!(!text(&output).contains("panicked"), "{command}: {}", text(&output));
    }
}

/// Ctrl-C reaches the whole pipeline: `tee` is gone before the run is told.
#[test]
fn an_interrupted_run_whose_reader_is_gone_ends_with_its_own_code() {
    let folder = folder("interrupted");
    let line = "$U run --rt off --hold 60s --log none > >(exec sleep 0) 2>&1 & run=$!; \
                for k in $(seq 100); do sleep 0.1; grep -q SigCgt:.*[1-9a-f] /proc/$run/status && break; done; \
                sleep 1; kill -INT $run; wait $run; echo $?";
    let output = bash(&folder, line);
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "1", "{}", text(&output));
}

#[test]
fn names_do_not_reach_the_terminal_as_they_are() {
    let folder = folder("names");
    let robot = uarm::robot::BUILT_IN.replacen("name = \"UARM\"", "name = \"UARM \\u001b[31mred\\u0007\"", 1);
    assert_ne!(robot, uarm::robot::BUILT_IN);
    std::fs::write(folder.join("robot.toml"), robot).unwrap();
    let name = "log\u{1b}[2J.mcap";
    let run = ["run", "--virtual-time", "--robot", "robot.toml", "--log", name];
    for arguments in [
        &run[..],
        &["show", name],
        &["show", name, "--json"],
        &["show", name, "--plot"],
        &["replay", name],
        &["monitor", name, "--once"],
        &["show", "no\u{1b}[2J"],
        &["check", "--robot", "robot.toml"],
        &run,
    ] {
        let output = uarm(&folder, arguments);
        let printed = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
        assert!(!printed.is_empty());
        let obeyed = printed.iter().find(|byte| byte.is_ascii_control() && !b"\n\t".contains(byte));
        assert_eq!(obeyed, None, "{arguments:?}: {}", text(&output));
    }
}

#[test]
fn names_that_are_no_text_work_in_json() {
    let folder = folder("bytes");
    let name = OsStr::from_bytes(b"b\xff.mcap");
    std::fs::copy(folder.join("run.mcap"), folder.join(name)).unwrap();
    for command in ["show", "replay", "monitor"] {
        let output = Command::new(env!("CARGO_BIN_EXE_uarm"))
            .arg(command)
            .arg(name)
            .arg("--json")
            .current_dir(&folder)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{command}: {}", text(&output));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(json.to_string().contains("b\u{fffd}.mcap") || command == "monitor", "{command}: {json}");
    }
}

/// "MOTORS WILL MOVE" is not said of a run that cannot begin.
#[test]
fn nothing_is_announced_before_all_is_known_to_be_right() {
    let folder = folder("announced");
    for arguments in [
        &["run", "--can", "nosuchcan0"][..],
        &["run", "--can", "nosuchcan0", "--log", "run.mcap"],
        &["run", "--virtual-time", "--log", "run.mcap"],
    ] {
        let output = uarm(&folder, arguments);
        assert_eq!(output.status.code(), Some(1));
        let told = text(&output);
        assert!(!told.contains("MOTORS") && !told.contains("controller nonlinear"), "{arguments:?}: {told}");
        assert_eq!(told.lines().count(), 1, "{arguments:?}: {told}");
    }
}

#[test]
fn wrong_values_of_options_are_wrong_usage_and_name_the_option() {
    let folder = folder("usage");
    for (arguments, option) in [
        (&["run", "--period", "0ms"][..], "--period"),
        (&["run", "--period", "1s"], "--period"),
        (&["run", "--hold", "-1s"], "--hold"),
        (&["run", "--approach", "0s"], "--approach"),
        (&["run", "--log", "-"], "--log"),
        (&["run", "--log", "off"], "--log"),
        (&["replay", "run.mcap", "--from", "nan"], "--from"),
        (&["replay", "run.mcap", "--controller", "fuzzy", "--plot", "x.jpeg"], "--plot"),
        (&["plant", "--can", "vcan0", "--period", "0ms"], "--period"),
        (&["train", "run.mcap", "--step", "-1"], "--step"),
        (&["check", "--period", "0ms"], "--period"),
    ] {
        let output = uarm(&folder, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output));
        assert!(
            text(&output).contains(option) && text(&output).contains("expected"),
            "{arguments:?}: {}",
            text(&output)
        );
    }
}

/// What would be left out silently, and what would fill the terminal.
#[test]
fn lists_that_are_too_long_and_numbers_of_hundreds_of_digits_are_refused_in_short() {
    let folder = folder("values");
    for (from, to, part) in [
        ("start_deg = [", "start_deg = [1.0, ", "task.start_deg = 3 values: expected 2, one for each active joint"),
        (
            "viscous_friction_nm_s = [",
            "viscous_friction_nm_s = [0.0, ",
            "plant.viscous_friction_nm_s = 4 values: expected 3",
        ),
        ("velocity_deg_per_s = 720.0", "velocity_deg_per_s = 1e308", "velocity_deg_per_s = 1e308: expected"),
    ] {
        let robot = uarm::robot::BUILT_IN.replacen(from, to, 1);
        assert_ne!(robot, uarm::robot::BUILT_IN, "{from}");
        std::fs::write(folder.join("robot.toml"), robot).unwrap();
        let output = uarm(&folder, &["run", "--virtual-time", "--log", "none", "--robot", "robot.toml"]);
        assert_eq!(output.status.code(), Some(1), "{part}");
        assert!(text(&output).contains(part), "{part}: {}", text(&output));
        assert!(text(&output).len() < 300, "{}", text(&output));
    }
}
