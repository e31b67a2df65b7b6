//! `uarm show`: everything that a log tells, and what is left of a damaged one.

mod patient_robot;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A folder of this test alone, empty.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("show").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn uarm(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or_else(|| panic!("{}", text(&output.stderr)))
}

/// Runs the paper's experiment in virtual time into `run.mcap`, and returns its report.
fn recorded(folder: &Path, arguments: &[&str]) -> Value {
    let run = ["run", "--virtual-time", "--log", "run.mcap", "--json"];
    let output = uarm(folder, &[&run[..], arguments].concat());
    let reports: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    reports[0].clone()
}

fn summary(folder: &Path, log: &str) -> (i32, Value) {
    let output = uarm(folder, &["show", log, "--json"]);
    (code(&output), serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr))))
}

#[test]
fn a_whole_log_gives_the_runs_own_report_again() {
    let folder = folder("whole");
    for (controller, approach) in [("nonlinear", None), ("fuzzy-model", Some("2s"))] {
        let mut arguments = vec!["--controller", controller];
        arguments.extend(approach.iter().flat_map(|approach| ["--approach", approach]));
        let run = recorded(&folder, &arguments);
        let (code, summary) = summary(&folder, "run.mcap");
        assert_eq!(code, 0, "{summary:#}");
        // As text: every bit of L2, E, errors and peaks, the timing, and that nothing is lost.
        assert_eq!(summary["report"].to_string(), run.to_string());
        assert_eq!(summary["disagreements"], Value::Array(Vec::new()));
        assert_eq!(summary["contents"]["cycles"], run["timing"]["cycles"]);
        std::fs::remove_file(folder.join("run.mcap")).unwrap();
    }
}

#[test]
fn the_summary_tells_what_ran_where_and_how() {
    let folder = folder("summary");
    recorded(&folder, &[]);
    let output = uarm(&folder, &["show", "run.mcap"]);
    assert_eq!(code(&output), 0);
    let told = text(&output.stdout);
    for part in [
        "UARM on simulated imperfect UARM, virtual time, controller nonlinear: completed",
        "paper 0.0778",
        "in virtual time",
        "1167 cycles, ",
        "5 keyframes",
        "by                 uarm 0.1.0 (commit ",
        "real time          prefer, priority 80, processor any",
        "0 records dropped",
        "NMT Operational",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!told.contains("LOST") && !told.contains("DIFFERS") && !told.contains("FAULT"), "{told}");
}

#[test]
fn without_a_file_it_is_the_newest_log() {
    let folder = folder("newest");
    let none = uarm(&folder, &["show"]);
    assert_eq!(code(&none), 1);
    assert!(text(&none.stderr).contains("no log in runs/: name a file"), "{}", text(&none.stderr));
    for controller in ["neural", "adaptive"] {
        assert_eq!(code(&uarm(&folder, &["run", "--virtual-time", "--controller", controller])), 0);
    }
    let told = text(&uarm(&folder, &["show"]).stdout);
    assert!(told.contains("controller adaptive: completed"), "{told}");
}

#[test]
fn csv_files_hold_every_cycle_and_the_frames_are_candumps() {
    let folder = folder("exports");
    recorded(&folder, &["--controller", "fuzzy"]);
    let output = uarm(&folder, &["show", "run.mcap", "--csv", "-"]);
    assert_eq!(code(&output), 0);
    let table = text(&output.stdout);
    assert_eq!(table.lines().count(), 1 + 1167);
    let both = uarm(&folder, &["show", "run.mcap", "--csv", "shown.csv", "--candump", "frames.log"]);
    assert!(text(&both.stdout).contains("completed"), "files leave standard output to the summary");
    assert!(std::fs::read_to_string(folder.join("shown.csv")).unwrap() == table);

    let frames = std::fs::File::open(folder.join("frames.log")).unwrap();
    let mut count = 0;
    let input = std::io::BufReader::new(frames);
    let candump = uarm_log::candump::read(input, uarm_log::candump::Interface::TheOnlyOne, |_| count += 1).unwrap();
    let log = uarm::dimensions::RunLog::<3, 2>::read(&folder.join("run.mcap")).unwrap();
    assert_eq!((count, candump.left_out), (log.frames.len(), 0));
    let direct = text(&uarm(&folder, &["show", "run.mcap", "--candump", "-"]).stdout);
    assert!(direct.lines().all(|line| line.contains(" vcan0 ")), "a simulated robot's frames can be played on vcan0");
}

#[test]
fn plots_are_drawn_in_the_terminal_and_as_figures() {
    let folder = folder("plots");
    recorded(&folder, &["--controller", "adaptive"]);
    let told = text(&uarm(&folder, &["show", "run.mcap", "--plot"]).stdout);
    for part in ["Error (°) over Time (s)", "Torque (N·m)", "Attitude (°)", "joint 2", "joint 3", "base"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(told.chars().any(|sign| ('\u{2801}'..='\u{28ff}').contains(&sign)), "braille: {told}");
    assert!(!told.contains("Latency"), "virtual time has no latencies");

    let draw = |names: [&str; 2]| {
        let [svg, png] = names;
        assert_eq!(code(&uarm(&folder, &["show", "run.mcap", "--figure", svg, "--figure", png])), 0);
        names.map(|name| std::fs::read(folder.join(name)).unwrap())
    };
    let [svg, png] = draw(["one.svg", "one.png"]);
    assert!(text(&svg).starts_with("<svg"));
    roxmltree::Document::parse(&text(&svg)).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    assert!([svg, png] == draw(["other.svg", "other.png"]), "the same bytes each time");
}

#[test]
fn wrong_usage_says_what_is_expected() {
    let folder = folder("usage");
    recorded(&folder, &[]);
    for (arguments, part) in [
        (&["--figure", "run.pdf"][..], "expected a name that ends with .svg or .png"),
        (&["--csv", "-", "--json"], "can have standard output"),
        (&["--csv", "-", "--candump", "-"], "can have standard output"),
        (&["--plot", "--json"], "--json"),
    ] {
        let output = uarm(&folder, &[&["show", "run.mcap"], arguments].concat());
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(text(&output.stderr).contains(part), "{arguments:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_file_that_is_no_log_is_named() {
    let folder = folder("none");
    std::fs::write(folder.join("words.mcap"), "these are words, and no log").unwrap();
    std::fs::write(folder.join("empty.mcap"), "").unwrap();
    for name in ["words.mcap", "empty.mcap", "missing.mcap", "."] {
        let output = uarm(&folder, &["show", name]);
        assert_eq!(code(&output), 1, "{name}");
        assert!(text(&output.stderr).starts_with(&format!("uarm: {name}: ")), "{}", text(&output.stderr));
    }
}

#[test]
fn a_fault_stands_first_with_its_cause_and_the_flight_recorder() {
    let folder = folder("fault");
    // Controller 1 errs by 2.9 degrees in the middle of the motion.
    let robot = uarm::robot::BUILT_IN;
    let limit = robot.lines().find(|line| line.starts_with("tracking_error_limit_deg")).unwrap();
    std::fs::write(folder.join("robot.toml"), robot.replace(limit, "tracking_error_limit_deg = 2.0")).unwrap();
    let run = recorded(&folder, &["--robot", "robot.toml"]);
    let cause = run["fault"].as_str().unwrap();
    assert_eq!(run["fault_code"], "tracking-error");
    let output = uarm(&folder, &["show", "run.mcap", "--figure", "run.svg"]);
    assert_eq!(code(&output), 0, "a failed run's log is whole: {}", text(&output.stdout));
    let told = text(&output.stdout);
    assert!(told.starts_with(&format!("FAULT, the first cause: {cause}\n")), "{told}");
    for part in ["uarm explain tracking-error", "flight recorder    the last", "FATAL: ", "FAILED: "] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let figure = std::fs::read_to_string(folder.join("run.svg")).unwrap();
    assert!(figure.contains("flight recorder"), "the window is shaded");
    assert!(figure.contains("tracking error is"), "the figure names the cause");
    let (_, summary) = summary(&folder, "run.mcap");
    assert_eq!(summary["fault"]["cause"], cause);
    assert_eq!(summary["report"]["fault_code"], "tracking-error");
    assert_eq!(summary["fault"]["cycles"], summary["contents"]["cycles"], "the run was shorter than the window");
}

/// Numbers that look random and are the same each time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        // Marsaglia's xorshift64.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 % u64::try_from(limit).unwrap()).unwrap()
    }
}

#[test]
fn a_log_cut_anywhere_is_told_as_far_as_it_goes() {
    let folder = folder("cut");
    recorded(&folder, &[]);
    let whole = std::fs::read(folder.join("run.mcap")).unwrap();
    let mut dice = Dice(2011);
    let mut cycles_told = Vec::new();
    let lengths = (0..24).map(|_| dice.below(whole.len())).chain([0, 1, whole.len() / 2, whole.len() - 1]);
    for length in lengths {
        std::fs::write(folder.join("cut.mcap"), &whole[..length]).unwrap();
        let output = uarm(&folder, &["show", "cut.mcap", "--json"]);
        match code(&output) {
            1 => assert!(text(&output.stderr).contains("cut.mcap: not a run log: "), "{}", text(&output.stderr)),
            3 => {
                let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
                assert!(!summary["report"]["losses"].as_array().unwrap().is_empty());
                cycles_told.push((length, summary["contents"]["cycles"].as_u64().unwrap()));
            }
            other => panic!("{length} of {} bytes: exit code {other}", whole.len()),
        }
    }
    cycles_told.sort_unstable();
    assert!(cycles_told.is_sorted_by_key(|(_, cycles)| *cycles), "more bytes tell more: {cycles_told:?}");
    assert!(cycles_told.iter().any(|(_, cycles)| (200..1000).contains(cycles)), "{cycles_told:?}");
}

#[test]
fn flipped_bytes_never_make_it_panic_and_are_told() {
    let folder = folder("flipped");
    let run = recorded(&folder, &["--controller", "neural"]);
    let whole = std::fs::read(folder.join("run.mcap")).unwrap();
    let mut dice = Dice(395);
    for _ in 0..40 {
        let mut bytes = whole.clone();
        for _ in 0..=dice.below(3) {
            let at = dice.below(bytes.len());
            bytes[at] ^= 1 << dice.below(8);
        }
        std::fs::write(folder.join("flipped.mcap"), &bytes).unwrap();
        let output = uarm(&folder, &["show", "flipped.mcap", "--json"]);
        let code = code(&output);
        assert!([0, 1, 3].contains(&code), "{code}: {}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("panicked"), "{}", text(&output.stderr));
        if code == 0 {
            // The bit was in what only other programs read: the robot's shapes, the index, the schemas.
            let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!(summary["report"]["indices"], run["indices"]);
        }
    }
}

#[test]
fn a_changed_description_is_noticed() {
    let folder = folder("changed");
    recorded(&folder, &[]);
    let mut bytes = std::fs::read(folder.join("run.mcap")).unwrap();
    let wanted = b"viscous_friction_nm_s = ";
    let at = bytes.windows(wanted.len()).position(|window| window == wanted).unwrap();
    // Another digit: still a robot file.
    let digit = (at..).find(|at| (b'1'..=b'8').contains(&bytes[*at])).unwrap();
    bytes[digit] += 1;
    std::fs::write(folder.join("changed.mcap"), &bytes).unwrap();
    let (code, summary) = summary(&folder, "changed.mcap");
    assert_eq!(code, 3);
    let losses = summary["report"]["losses"].to_string();
    assert!(losses.contains("something in it is not as it was written"), "{losses}");
    assert_eq!(summary["contents"]["cycles"], 1167, "all of it is told");
}

#[test]
fn what_a_killed_process_leaves_is_told() {
    let folder = folder("killed");
    let mut running = Command::new(env!("CARGO_BIN_EXE_uarm"))
        .args(["run", "--rt", "off", "--hold", "60s", "--log", "run.mcap", "--robot"])
        .arg(patient_robot::write(&folder))
        .current_dir(&folder)
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(2_500));
    running.kill().unwrap();
    running.wait().unwrap();
    let output = uarm(&folder, &["show", "run.mcap"]);
    assert_eq!(code(&output), 3, "{}", text(&output.stderr));
    let told = text(&output.stdout);
    assert!(told.contains("no end is recorded: the process was killed, or the disk failed"), "{told}");
    let (_, summary) = summary(&folder, "run.mcap");
    let cycles = summary["contents"]["cycles"].as_u64().unwrap();
    // Two and a half seconds are 833 cycles; the start of the program, the last quarter of a second and what a loaded
    // machine skips are not there.
    assert!((50..=833).contains(&cycles), "{cycles}");
    assert_eq!(summary["disagreements"], Value::Array(Vec::new()));
}
