//! `uarm monitor`: a running controller, seen through the log that it writes.

mod patient_robot;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::widgets::Widget;
use serde_json::Value;
use uarm::commands::monitor::source::Source;
use uarm::commands::monitor::view::View;

/// Longer than a run takes to begin on a loaded machine.
const LONG: Duration = Duration::from_secs(30);
const A_MOMENT: Duration = Duration::from_millis(50);

/// A folder of this test alone, empty.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("monitor").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uarm"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command
}

fn uarm(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn snapshot(folder: &Path) -> Value {
    let output = uarm(folder, &["monitor", "run.mcap", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Waits for a snapshot that is as wanted.
fn until(folder: &Path, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
    let begin = Instant::now();
    loop {
        let now = snapshot(folder);
        if wanted(&now) {
            return now;
        }
        assert!(begin.elapsed() < LONG, "no {what}: {now:#}");
        std::thread::sleep(A_MOMENT);
    }
}

/// A run in real time that is ended with the test.
struct Running(Child);

impl Running {
    fn start(folder: &Path) -> Self {
        let run = ["run", "--rt", "off", "--hold", "60s", "--log", "run.mcap", "--controller", "adaptive", "--robot"];
        let robot = patient_robot::write(folder);
        let child = command(folder, &run).arg(robot).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let begin = Instant::now();
        while !folder.join("run.mcap").exists() {
            assert!(begin.elapsed() < LONG, "no log");
            std::thread::sleep(A_MOMENT);
        }
        Self(child)
    }

    fn interrupt(&mut self) {
        rustix::process::kill_process(rustix::process::Pid::from_child(&self.0), rustix::process::Signal::INT).unwrap();
        self.0.wait().unwrap();
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_running_controller_is_seen_to_move_and_to_end() {
    let folder = folder("running");
    let mut running = Running::start(&folder);
    let first = until(&folder, "motion", |now| now["cycle"]["time_s"].as_f64().is_some_and(|time| time > 0.5));
    assert_eq!(first["life"], "running");
    assert_eq!(first["run"]["controller"], "adaptive");
    assert_eq!(first["run"]["place"], "simulated imperfect UARM");
    let ticks = |now: &Value| now["cycle"]["tick"].as_u64().unwrap();
    let cycles = |now: &Value| now["timing"]["cycles"].as_u64().unwrap();
    let frames = |now: &Value| now["health"]["frames_in"].as_u64().unwrap();
    let second = until(&folder, "progress", |now| ticks(now) > ticks(&first) + 100);
    assert!(cycles(&second) > cycles(&first) && frames(&second) > frames(&first));
    let angle = |now: &Value| now["cycle"]["joints"][1]["angle_deg"].as_f64().unwrap();
    assert!(angle(&second) > angle(&first), "from 20 to 80 degrees: {} {}", angle(&first), angle(&second));
    assert_eq!(second["cycle"]["joints"][2]["drive"], "Operation enabled");

    let output = uarm(&folder, &["monitor", "--once", "run.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let view = text(&output.stdout);
    for part in ["running", "Operation enabled", "wake-up", "last cycle:", "NMT Operational", "Error (°)", "Torque"] {
        assert!(view.contains(part), "{part}: {view}");
    }

    running.interrupt();
    let ended = snapshot(&folder);
    assert_eq!(ended["life"], "ended");
    assert!(ended["told"].as_str().unwrap().starts_with("interrupted; all drives confirmed power off"), "{ended:#}");
}

#[test]
fn a_killed_run_is_silent_and_not_taken_for_a_running_one() {
    let folder = folder("killed");
    let running = Running::start(&folder);
    until(&folder, "cycle", |now| !now["cycle"].is_null());
    drop(running);
    let silent = until(&folder, "silence", |now| now["life"] == "silent");
    assert!(silent["told"].as_str().unwrap().starts_with("nothing new for "), "{silent:#}");
}

#[test]
fn a_log_is_waited_for() {
    let folder = folder("wait");
    let waiting = command(&folder, &["monitor", "--wait", "--json"]).stdout(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(uarm(&folder, &["run", "--virtual-time"]).status.code(), Some(0));
    let output = waiting.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["file"].as_str().unwrap().starts_with("runs/"), "{found:#}");
}

#[test]
fn what_is_no_log_is_named() {
    let folder = folder("none");
    std::fs::write(folder.join("words.mcap"), "these are words, and no log").unwrap();
    for (arguments, part) in [
        (&["monitor"][..], "no log in runs/: name a file"),
        (&["monitor", "words.mcap"], "uarm: words.mcap: not a run log: "),
        (&["monitor", "missing.mcap", "--json"], "uarm: missing.mcap: "),
    ] {
        let output = uarm(&folder, arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(text(&output.stderr).contains(part), "{arguments:?}: {}", text(&output.stderr));
    }
    assert_eq!(uarm(&folder, &["monitor", "--once", "--json"]).status.code(), Some(2));
}

/// A finished run in virtual time, as the monitor knows it.
fn finished(folder: &Path, arguments: &[&str]) -> Source<3, 2> {
    uarm(folder, &[&["run", "--virtual-time", "--log", "run.mcap"], arguments].concat());
    let mut source = Source::open(&folder.join("run.mcap")).unwrap();
    source.catch_up().unwrap();
    source
}

#[test]
fn the_view_shows_what_was_recorded() {
    let source = finished(&folder("view"), &["--controller", "fuzzy"]);
    let mut terminal = Terminal::new(TestBackend::new(140, 50)).unwrap();
    terminal.draw(|frame| frame.render_widget(&View::of(&source.state), frame.area())).unwrap();
    let screen = terminal.backend().to_string();
    let last = source.state.last().unwrap();
    for part in [
        "UARM on simulated imperfect UARM, virtual time, controller fuzzy".to_owned(),
        "completed".to_owned(),
        format!("tick {}", last.tick),
        format!("{:.3}", last.position[0].to_degrees()),
        format!("{:+.5}", last.torque_applied[1]),
        "1167 cycles of 3 ms, 0 deadlines missed, 0 ticks skipped".to_owned(),
        "virtual time passes only while the loop sleeps".to_owned(),
        "Operation enabled".to_owned(),
        "q, Esc or Ctrl-C: quit     the view lags behind by up to a quarter of a second".to_owned(),
    ] {
        assert!(screen.contains(&part), "{part}:\n{screen}");
    }
}

#[test]
fn a_fault_is_what_the_view_says_first() {
    let folder = folder("fault");
    let robot = uarm::robot::BUILT_IN;
    let limit = robot.lines().find(|line| line.starts_with("tracking_error_limit_deg")).unwrap();
    std::fs::write(folder.join("robot.toml"), robot.replace(limit, "tracking_error_limit_deg = 2.0")).unwrap();
    let path = folder.join("robot.toml");
    let source = finished(&folder, &["--robot", path.to_str().unwrap()]);
    let cause = source.state.fault.as_ref().unwrap().cause.clone();
    let mut buffer = Buffer::empty(Rect::new(0, 0, 160, 50));
    (&View::of(&source.state)).render(buffer.area, &mut buffer);
    let screen = uarm::inspection::plain_text::of(&buffer);
    let first = screen.lines().nth(1).unwrap();
    assert!(first.contains("FAULT: ") && first.contains(&cause), "{cause}:\n{screen}");
}

#[test]
fn no_terminal_is_too_small() {
    let source = finished(&folder("small"), &[]);
    for (width, height) in [(0, 0), (1, 1), (5, 3), (20, 10), (80, 24), (79, 37), (300, 100)] {
        let mut buffer = Buffer::empty(Rect::new(0, 0, width, height));
        (&View::of(&source.state)).render(buffer.area, &mut buffer);
        let screen = uarm::inspection::plain_text::of(&buffer);
        assert_eq!(screen.lines().count(), usize::from(height));
        assert_eq!(height >= 10, screen.contains("Joints"), "what matters most has room first:\n{screen}");
    }
}
