//! A recorded run again: bit for bit, from the start and from keyframes, over gaps, and from the bus alone.

mod patient_robot;
mod support;

use std::path::{Path, PathBuf};
use std::process::Output;

use hinf_control::Law;
use uarm::dimensions::{ACTIVE, JOINTS};
use uarm::robot::Robot;
use uarm_log::candump;
use uarm_log::replay::bus_cycles::{BusCycle, bus_cycles};
use uarm_log::replay::exact::{ExactReplay, Start};
use uarm_log::replay::source::{Behind, Source};

use support::{text, uarm};
use uarm::dimensions::RunLog;
use uarm_loop::supervisor::Authority;

/// Records a run into a new file named after `name`.
fn record(name: &str, arguments: &[&str]) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("replay");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("{name}-{}.mcap", std::process::id()));
    let output = uarm(&[&["run", "--log", path.to_str().unwrap()], arguments].concat());
    assert!(path.exists(), "{}", text(&output));
    path
}

fn replay(path: &Path, arguments: &[&str]) -> Output {
    uarm(&[&["replay", path.to_str().unwrap()], arguments].concat())
}

/// A log that a test may change before it is replayed.
struct Recorded {
    log: RunLog,
    robot: Robot,
    bus: Vec<BusCycle<JOINTS>>,
}

impl Recorded {
    fn read(path: &Path) -> Self {
        let log = RunLog::<3, 2>::read(path).unwrap();
        let robot = Robot::from_log(path, &log.run.robot).unwrap();
        let bus = bus_cycles(&log.frames, robot.description.nodes());
        Self { log, robot, bus }
    }

    fn replay(&self, start: Start) -> ExactReplay {
        let settings = self.log.run.settings().unwrap();
        let source: Source<'_, JOINTS, ACTIVE> = Source {
            robot: &self.robot.description,
            settings: &settings,
            bus: &self.bus,
            records: &self.log.cycles,
            keyframes: &self.log.keyframes,
            fault: self.log.fault.as_ref().map(|fault| fault.cause.as_str()),
            behind: Behind::Nothing,
        };
        let mut controller = self.robot.controller(settings.law, settings.guard).unwrap();
        ExactReplay::run(&source, controller.as_mut(), start).unwrap()
    }
}

#[test]
fn a_minute_of_each_controller_replays_bit_for_bit() {
    for law in Law::ALL {
        let name = law.name();
        let path = record(&format!("minute-{name}"), &["--virtual-time", "--controller", name, "--hold", "57s"]);
        let output = replay(&path, &["--json"]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["exact"]["cycles"], 20_000, "{name}");
        assert_eq!(report["exact"]["keyframes"], 60, "{name}");
        assert!(report["exact"]["signals"].as_u64().unwrap() > 800_000, "{name}");
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn a_guarded_and_disturbed_run_in_real_time_with_measured_periods_and_an_approach_replays() {
    let robot = patient_robot::write(Path::new(env!("CARGO_TARGET_TMPDIR")));
    let arguments = ["--rt", "off", "--dt", "measured", "--approach", "1s", "--controller", "fuzzy"];
    let arguments = [&arguments[..], &["--adaptation", "bounded", "--robot", robot.to_str().unwrap()]].concat();
    let path = record("real-time", &arguments);
    let output = replay(&path, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(text(&output).contains("from -1.000 s"), "{}", text(&output));
}

#[test]
fn a_trained_law_and_a_changed_robot_replay() {
    let sets = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/uarm-fuzzy-sets.toml");
    let arguments = ["--virtual-time", "--controller", "fuzzy-model", "--fuzzy-sets", sets.to_str().unwrap()];
    let path = record("trained", &[&arguments[..], &["--base-acceleration", "reduced", "--period", "2ms"]].concat());
    let output = replay(&path, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
}

#[test]
fn it_begins_at_any_keyframe() {
    let path = record("keyframes", &["--virtual-time", "--controller", "neural-model"]);
    let recorded = Recorded::read(&path);
    assert_eq!(recorded.log.keyframes.len(), 5);
    let whole = recorded.replay(Start::Beginning);
    for time in [0.5, 1.5, 2.5, 3.2] {
        let part = recorded.replay(Start::KeyframeBefore(time));
        assert!(part.is_equal(), "{part:?}");
        assert!(part.from < time && part.from > time - 1.1, "{part:?}");
        assert!(part.cycles > 0 && part.cycles < whole.cycles, "{part:?}");
        assert_eq!(part.lost_cycles, 0);
    }
    let output = replay(&path, &["--from", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
}

#[test]
fn one_bit_is_seen_and_named() {
    let path = record("one-bit", &["--virtual-time", "--controller", "adaptive"]);
    let mut recorded = Recorded::read(&path);
    let torque = &mut recorded.log.cycles[700].torque_requested[1];
    *torque = f64::from_bits(torque.to_bits() ^ 1);
    let replay = recorded.replay(Start::Beginning);
    assert_eq!((replay.differing_cycles, replay.differences.len()), (1, 1));
    let difference = &replay.differences[0];
    assert_eq!((difference.tick, difference.signal.as_str()), (700, "torque_requested_3_nm"));
    assert!(!replay.is_equal());

    // A count in a frame other than the recorded one: the estimate differs, and so does all that follows.
    let mut recorded = Recorded::read(&path);
    recorded.bus[300].counts[1] = recorded.bus[300].counts[1].map(|count| count + 1);
    let replay = recorded.replay(Start::Beginning);
    assert!(replay.differing_cycles > 100, "{}", replay.differing_cycles);
    assert_eq!(replay.differences[0].tick, 300);

    // A keyframe of another state.
    let mut recorded = Recorded::read(&path);
    recorded.log.keyframes[2].1.torque_applied.x += 1e-9;
    let replay = recorded.replay(Start::Beginning);
    assert!(replay.differences[0].signal.contains("keyframe"), "{:?}", replay.differences);
}

#[test]
fn behind_a_gap_it_goes_on_from_the_next_keyframe_and_says_what_is_lost() {
    let path = record("gap", &["--virtual-time", "--controller", "neural"]);
    let mut recorded = Recorded::read(&path);
    recorded.log.frames.drain(4_000..4_100);
    let recorded = Recorded { bus: bus_cycles(&recorded.log.frames, [1, 2, 3]), ..recorded };
    let replay = recorded.replay(Start::Beginning);
    assert!(replay.is_equal(), "{replay:?}");
    assert_eq!(replay.resumed, 1);
    assert!((10..400).contains(&replay.lost_cycles), "{replay:?}");
    assert_eq!(replay.keyframes, 3, "of the four behind a cycle, one was resumed from");
}

#[test]
fn a_fault_of_the_robot_comes_again() {
    /// Twelve times the friction that the robot file allows for: joint 3 does not move as its torque says.
    const STUCK: [&str; 2] =
        ["coulomb_friction_nm = [0.02802, 0.04985, 0.0305]", "coulomb_friction_nm = [0.02802, 0.04985, 0.9]"];
    let original = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/uarm.toml")).unwrap();
    for (name, [from, to], cause) in [
        ("narrow", ["tracking_error_limit_deg = 30.0", "tracking_error_limit_deg = 0.5"], "tracking error"),
        ("stuck", STUCK, "joint 3: the counter stands still"),
    ] {
        let changed = original.replacen(from, to, 1);
        assert_ne!(changed, original, "robots/uarm.toml has no {from}");
        let robot = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.toml"));
        std::fs::write(&robot, changed).unwrap();
        let path = record(name, &["--virtual-time", "--robot", robot.to_str().unwrap()]);
        let log = RunLog::<3, 2>::read(&path).unwrap();
        assert!(log.fault.as_ref().is_some_and(|fault| fault.cause.contains(cause)), "{name}: {:?}", log.fault);
        let output = replay(&path, &[]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output));
        assert!(text(&output).contains("the fault is the recorded one"), "{name}: {}", text(&output));

        // Of the bus alone nothing tells why the run ended.
        let dump = path.with_extension("log");
        candump::write(&log.frames, "can0", log.run.axis, std::fs::File::create(&dump).unwrap()).unwrap();
        let law = ["--controller", "nonlinear", "--adaptation", "none", "--robot", robot.to_str().unwrap()];
        let output = replay(&dump, &law);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output));
        assert!(text(&output).contains("the recording ends with the cycle of this fault: "), "{}", text(&output));
        assert!(text(&output).contains(cause), "{name}: {}", text(&output));
        let other = replay(&dump, &["--controller", "nonlinear", "--adaptation", "none"]);
        if name == "stuck" {
            assert_eq!(other.status.code(), Some(0), "friction is the plant's: {}", text(&other));
        }
    }
}

#[test]
fn a_candump_file_replays_to_the_torques_on_the_bus() {
    let arguments = ["--virtual-time", "--controller", "fuzzy", "--disturbance", "none", "--adaptation", "bounded"];
    let path = record("candump", &arguments);
    let log = RunLog::<3, 2>::read(&path).unwrap();
    let dump = path.with_extension("log");
    candump::write(&log.frames, "can0", log.run.axis, std::fs::File::create(&dump).unwrap()).unwrap();

    let output = replay(&dump, &["--controller", "fuzzy"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(text(&output).contains("1167 cycles"), "{}", text(&output));
    let output = replay(&dump, &["--controller", "fuzzy-model"]);
    assert_eq!(output.status.code(), Some(1), "another law asks for other torques: {}", text(&output));
    assert!(text(&output).contains("torque in the frame to joint 2"), "{}", text(&output));
    let output = replay(&dump, &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("--controller"), "{}", text(&output));
}

/// Neither a log nor the bus alone is taken for another run where somebody asked for its end.
#[test]
fn an_interrupted_run_replays_from_its_log_and_from_the_bus() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("replay");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("interrupted-{}.mcap", std::process::id()));
    let run = ["run", "--virtual-time", "--hold", "24h", "--controller", "neural"];
    let as_with_can = ["--disturbance", "none", "--adaptation", "bounded", "--log", path.to_str().unwrap()];
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_uarm")).args(run).args(as_with_can).spawn().unwrap();
    while !RunLog::<3, 2>::read(&path).is_ok_and(|log| !log.cycles.is_empty()) {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    rustix::process::kill_process(rustix::process::Pid::from_child(&child), rustix::process::Signal::INT).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));

    let log = RunLog::<3, 2>::read(&path).unwrap();
    let fading = log.cycles.iter().filter(|cycle| cycle.authority == Authority::Fading).count();
    assert_eq!(fading, 17, "50 ms at 3 ms");
    let shown = uarm(&["show", path.to_str().unwrap()]);
    assert!(text(&shown).contains("  stop               torques faded from "), "{}", text(&shown));
    let output = replay(&path, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(text(&output).contains("all equal, bit for bit"), "{}", text(&output));
    let dump = path.with_extension("log");
    candump::write(&log.frames, "can0", log.run.axis, std::fs::File::create(&dump).unwrap()).unwrap();
    let output = replay(&dump, &["--controller", "neural"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(text(&output).contains("torques faded from "), "{}", text(&output));
}

#[test]
fn another_controller_is_asked_on_the_same_measurements() {
    let path = record("what-if", &["--virtual-time", "--controller", "nonlinear"]);
    let same = replay(&path, &["--controller", "nonlinear", "--json"]);
    let same: serde_json::Value = serde_json::from_slice(&same.stdout).unwrap();
    assert_eq!(
        same["what_if"]["largest_difference_nm"],
        serde_json::json!([0.0, 0.0]),
        "the same law asks for the same"
    );
    assert_eq!(same["what_if"]["cycles"], 1167);

    let (figure, table) = (path.with_extension("svg"), path.with_extension("csv"));
    let arguments = ["--controller", "adaptive", "--plot", figure.to_str().unwrap(), "--csv", table.to_str().unwrap()];
    let output = replay(&path, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(text(&output).contains("open loop"), "{}", text(&output));
    assert!(std::fs::read_to_string(figure).unwrap().starts_with("<svg"));
    assert_eq!(std::fs::read_to_string(table).unwrap().lines().count(), 1 + 1167);

    let other_robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/uarm.toml");
    let output = replay(&path, &["--robot", other_robot.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let wrong = replay(&path, &["--controller", "adaptive", "--plot", "what-if.jpeg"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(text(&wrong).contains(".svg or .png"), "{}", text(&wrong));
}

#[test]
fn a_log_of_odrive_axes_is_refused_for_what_it_is() {
    let robot = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm-odrive.toml");
    let path = record("odrive", &["--virtual-time", "--robot", robot]);
    let output = replay(&path, &[]);
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("ODrive axes") && error.contains("odrive-"), "{error}");
}

#[test]
fn what_is_no_log_is_refused_by_name() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let output = replay(&manifest, &["--controller", "fuzzy"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("Cargo.toml") && text(&output).contains("line 1"), "{}", text(&output));
    assert_eq!(replay(Path::new("no/such.mcap"), &[]).status.code(), Some(1));
}

/// The log of a run in virtual time is the same file each time, whatever the writer's thread does when.
#[test]
fn a_run_in_virtual_time_gives_the_same_bytes_each_time() {
    let logs: Vec<_> = (0..3)
        .map(|number| record(&format!("bytes-{number}"), &["--virtual-time", "--controller", "fuzzy"]))
        .map(|path| std::fs::read(path).unwrap())
        .collect();
    assert!(logs[0].len() > 100_000);
    assert!(logs.iter().all(|log| *log == logs[0]));
}
