//! `uarm replay` of candump files as tools and users leave them.

mod support;

use std::path::PathBuf;
use std::sync::OnceLock;

use support::{scratch, standard_output, text, uarm};
use uarm_io::drive::wire::SYNC_COUNTER_OVERFLOW;

/// Cycles of the recording that the tests change.
const CYCLES: usize = 20;

/// The first cycles of a run with controller 1 as candump recorded them.
fn recording() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let log = scratch(&format!("candump-replay-{}.mcap", std::process::id()));
        let log = log.to_str().unwrap();
        let arguments = ["run", "--virtual-time", "--disturbance", "none", "--adaptation", "bounded", "--log", log];
        standard_output(&arguments);
        let all = standard_output(&["show", log, "--candump", "-"]);
        std::fs::remove_file(log).unwrap();
        let next = format!(" 080#{:02X}", CYCLES + 1);
        all.lines().take_while(|line| !line.ends_with(&next)).fold(String::new(), |text, line| text + line + "\n")
    })
}

/// Replays a recording; gives the exit code and what was printed.
#[track_caller]
fn replay(name: &str, bytes: &[u8], arguments: &[&str]) -> (i32, String) {
    let path: PathBuf = scratch(&format!("candump-{name}.log"));
    std::fs::write(&path, bytes).unwrap();
    let output = uarm(&[&["replay", path.to_str().unwrap(), "--controller", "nonlinear"], arguments].concat());
    (output.status.code().unwrap(), text(&output))
}

#[track_caller]
fn assert_told(name: &str, bytes: &[u8], code: i32, parts: &[&str]) {
    let (found, told) = replay(name, bytes, &[]);
    assert_eq!(found, code, "{told}");
    for part in parts {
        assert!(told.contains(part), "{part}: {told}");
    }
}

#[test]
fn whole_recordings_are_equal_however_they_were_kept() {
    let text = recording();
    let equal = [" 20 cycles from 0.000 s, 60 signals", "all equal, bit for bit"];
    assert_told("plain", text.as_bytes(), 0, &equal);
    assert_told("bom", format!("\u{feff}{text}").as_bytes(), 0, &equal);
    assert_told("crlf", text.replace('\n', "\r\n").as_bytes(), 0, &equal);
    assert_told("comments", format!("# recorded by hand\n\n{text}\n\n").as_bytes(), 0, &equal);
    let raw: String = text
        .lines()
        .map(|line| if line.ends_with("00000000") { format!("{line}_9\n") } else { format!("{line}\n") })
        .collect();
    assert!(raw.contains("_9\n"));
    assert_told("raw-dlc", raw.as_bytes(), 0, &equal);
}

#[test]
fn what_is_cut_or_dropped_is_told() {
    let text = recording();
    let cut = &text[..text.len() - 5];
    assert_told(
        "cut",
        cut.as_bytes(),
        3,
        &["cycles from 0.000 s", "1 lines are none of candump's, or cut", "equal, bit for bit"],
    );
    let dropped = format!("{text}DROPCOUNT: dropped 12 CAN frames on 'can0' socket (total drops 12)\n");
    assert_told("dropped", dropped.as_bytes(), 3, &[" 20 cycles", "DROPCOUNT: dropped 12"]);
    let error = "none/words";
    assert_told("words", b"none/words\n", 1, &[error, "expected a log of `uarm run`, or lines of candump -L"]);
    assert_told("empty", b"", 1, &["there is no frame in it"]);
}

/// Without the frames that answer one SYNC the law's state is unknown from there on.
#[test]
fn what_cannot_be_compared_is_counted() {
    let lines: Vec<_> = recording().lines().collect();
    let without = |wanted: &dyn Fn(usize, &str) -> bool| -> String {
        let kept = lines.iter().enumerate().filter(|(index, line)| !wanted(*index, line));
        kept.fold(String::new(), |text, (_, line)| text + line + "\n")
    };
    let sync = |number: usize| lines.iter().position(|line| line.ends_with(&format!(" 080#{number:02X}"))).unwrap();
    let answer = (sync(6)..).find(|index| lines[*index].contains(" 182#")).unwrap();
    let missing = without(&|index, _| index == answer);
    assert_told("tpdo", missing.as_bytes(), 3, &[" 5 of 20 cycles", "these are equal", "LOST               15 cycles"]);
    // A joint that stands is where it was predicted; that its position is not in the file is told all the same.
    let standing = (sync(2)..).find(|index| lines[*index].contains(" 181#")).unwrap();
    let missing = without(&|index, _| index == standing);
    assert_told(
        "standing",
        missing.as_bytes(),
        3,
        &[" 20 cycles", "all equal", "LOST               positions in 1 of"],
    );
    let missing = without(&|index, _| index == sync(6));
    assert_told("sync", missing.as_bytes(), 3, &[" 5 of 19 cycles", "LOST               14 cycles"]);
    let command = (sync(6)..).find(|index| lines[*index].contains(" 203#")).unwrap();
    let missing = without(&|index, _| index == command);
    assert_told("rpdo", missing.as_bytes(), 3, &[" 20 cycles", "59 signals", "LOST               1 torques"]);
    // Nothing to compare at all.
    let nothing = without(&|_, line| !line.contains(" 080#"));
    assert_told("syncs", nothing.as_bytes(), 1, &["NOTHING was compared"]);
    let nothing = without(&|_, line| line.contains(" 20"));
    assert_told("no-rpdo", nothing.as_bytes(), 1, &["NOTHING was compared"]);
    // What began before the recording cannot be made up.
    let late = without(&|index, _| index < sync(4));
    assert_told("late", late.as_bytes(), 1, &["its first SYNC has the number 4, expected 1"]);
}

/// The line of a TPDO with other data: statusword and position, little endian.
fn changed_answer(line: &str, change: impl Fn(&str, &str) -> String) -> String {
    let (head, data) = line.split_once('#').unwrap();
    let (statusword, position) = data.split_at(4);
    format!("{head}#{}", change(statusword, position))
}

/// The recording with the answer of node 2 to each of these SYNCs changed.
fn with_answers(syncs: std::ops::RangeInclusive<usize>, change: impl Fn(&str, &str) -> String) -> String {
    let mut sync = 0;
    let line = |line: &str| {
        sync += usize::from(line.contains(" 080#"));
        let is_changed = syncs.contains(&sync) && line.contains(" 182#");
        format!("{}\n", if is_changed { changed_answer(line, &change) } else { line.to_owned() })
    };
    recording().lines().map(line).collect()
}

/// A count that no joint can have is refused by the replay as by the loop; that the loop went on as it did says that it was another.
#[test]
fn a_changed_count_is_different_and_not_missing() {
    for counts in [3, 12, 500, -500] {
        let changed = with_answers(6..=6, |statusword, position| {
            let count = i32::from_le_bytes(u32::from_str_radix(position, 16).unwrap().to_be_bytes());
            format!("{statusword}{:08X}", u32::from_be_bytes((count + counts).to_le_bytes()))
        });
        let (code, told) = replay("count", changed.as_bytes(), &[]);
        assert_eq!(code, 1, "{counts}: {told}");
        assert!(told.contains("DIFFERENT in ") && !told.contains("LOST"), "{counts}: {told}");
    }
}

/// CiA 402: 0x1237 is Operation enabled and follows its target (bit 12), 0x0237 does not follow it, 0x1233 is Switched on.
#[test]
fn a_statusword_with_which_the_loop_would_have_stopped_is_different() {
    let of = |statusword: &'static str| with_answers(6..=6, move |_, position| format!("{statusword}{position}"));
    let is_false = |what: &str| format!("the drive of joint 2 {what} was false, replayed true");
    let enabled = is_false("is in Operation enabled");
    assert_told("switched-on", of("3312").as_bytes(), 1, &["DIFFERENT in 1 cycles", &enabled]);
    let follows = is_false("follows its target torque");
    assert_told("ignoring", of("3702").as_bytes(), 1, &["DIFFERENT in 1 cycles", &follows]);
    assert_told("as-it-was", of("3712").as_bytes(), 0, &["all equal"]);
}

/// Whose first answer is missing has no state to begin with, and says only that; so does a third one in a row, even of a joint that stands
/// where it was predicted.
#[test]
fn an_answer_without_which_the_loop_would_have_stopped_was_there() {
    let without = |node: &str, syncs: std::ops::RangeInclusive<usize>| -> String {
        let mut sync = 0;
        let lines = recording().lines().filter(|line| {
            sync += usize::from(line.contains(" 080#"));
            !(syncs.contains(&sync) && line.contains(node))
        });
        lines.map(|line| format!("{line}\n")).collect()
    };
    let (code, told) = replay("first-tpdo", without(" 182#", 1..=1).as_bytes(), &[]);
    assert_eq!(code, 1, "{told}");
    assert!(told.contains("0 of 20 cycles") && told.contains("NOTHING was compared"), "{told}");
    assert!(told.contains("LOST               20 cycles") && !told.contains("DIFFERENT"), "{told}");
    let (code, told) = replay("third-tpdo", without(" 181#", 2..=4).as_bytes(), &[]);
    assert_eq!(code, 3, "{told}");
    assert!(told.contains(" 3 of 20 cycles") && told.contains("these are equal"), "{told}");
    assert!(told.contains("LOST               17 cycles") && !told.contains("DIFFERENT"), "{told}");
}

/// Behind which line of the last cycle the file ends.
#[test]
fn a_file_that_is_cut_at_the_end_of_a_line_is_told_as_cut() {
    let lines: Vec<_> = recording().lines().collect();
    let last = format!(" 080#{CYCLES:02X}");
    let sync = lines.iter().position(|line| line.ends_with(&last)).unwrap();
    let torques: Vec<_> = (sync..lines.len()).filter(|index| lines[*index].contains(" 20")).collect();
    assert_eq!(torques.len(), 3, "one for each drive");
    let words = "LOST               the end: the file ends within a cycle";
    for end in sync..torques[2] {
        let cut: String = lines[..=end].iter().map(|line| format!("{line}\n")).collect();
        assert_told("cut-line", cut.as_bytes(), 3, &[words, "equal, bit for bit"]);
    }
    let (code, told) = replay("whole-line", recording().as_bytes(), &[]);
    assert!(code == 0 && !told.contains("LOST"), "{told}");
}

/// Each SYNC comes a second late.
#[test]
fn a_clock_that_is_set_in_each_cycle_is_told_in_one_line() {
    let mut sync = 0;
    let stretched: String = recording()
        .lines()
        .map(|line| {
            sync += i128::from(line.contains(" 080#"));
            let (time, rest) = line.strip_prefix('(').unwrap().split_once(')').unwrap();
            let (whole, fraction) = time.split_once('.').unwrap();
            let nanoseconds = whole.parse::<i128>().unwrap() * 1_000_000_000 + fraction.parse::<i128>().unwrap();
            let stepped = nanoseconds + sync * 1_000_000_000;
            format!("({}.{:09}){rest}\n", stepped / 1_000_000_000, stepped % 1_000_000_000)
        })
        .collect();
    let (code, told) = replay("stretched", stretched.as_bytes(), &[]);
    assert_eq!(code, 0, "{told}");
    assert_eq!(told.matches("clock set").count(), 6, "{told}");
    assert!(told.contains("clock set          19 times by +19.000 s in all, until "), "{told}");
}

#[test]
fn a_clock_that_was_set_is_told_and_changes_nothing() {
    let lines: Vec<_> = recording().lines().collect();
    for (name, first, seconds) in [("forward", " 080#07", 1.0), ("back", " 080#07", -3600.0), ("within", " 182#", 0.75)]
    {
        let begin = lines.iter().position(|line| line.ends_with(" 080#07")).unwrap();
        let begin = (begin..).find(|index| lines[*index].contains(first)).unwrap();
        let set = |(index, line): (usize, &&str)| {
            let (time, rest) = line.strip_prefix('(').unwrap().split_once(')').unwrap();
            let (whole, fraction) = time.split_once('.').unwrap();
            let nanoseconds = whole.parse::<i128>().unwrap() * 1_000_000_000 + fraction.parse::<i128>().unwrap();
            let step = if index >= begin { (seconds * 1e9) as i128 } else { 0 };
            let stepped = nanoseconds + step;
            format!("({}.{:09}){rest}\n", stepped / 1_000_000_000, stepped % 1_000_000_000)
        };
        let text: String = lines.iter().enumerate().map(set).collect();
        let told = format!("clock set          by {seconds:+.3} s");
        assert_told(name, text.as_bytes(), 0, &[" 20 cycles", "all equal", &told]);
    }
    assert_eq!(SYNC_COUNTER_OVERFLOW, 240, "the recording is shorter than a turn of the counter");
}

/// A replay holds some thousand cycles at a time. Where one window ends and the next begins nothing is lost, and SYNCs that nobody
/// answers any more, for longer than a window, are behind the end of the run.
#[test]
fn a_recording_of_several_windows_is_replayed_as_a_whole() {
    let log = scratch(&format!("candump-windows-{}.mcap", std::process::id()));
    let log = log.to_str().unwrap();
    let arguments = ["run", "--virtual-time", "--disturbance", "none", "--adaptation", "bounded", "--hold", "20s"];
    standard_output(&[arguments.as_slice(), &["--log", log]].concat());
    let text = standard_output(&["show", log, "--candump", "-"]);
    std::fs::remove_file(log).unwrap();
    let cycles = text.lines().filter(|line| line.contains(" 080#")).count();
    assert!(cycles > 7000, "more than one window of 4096: {cycles}");
    let equal = [&format!(" {cycles} cycles from 0.000 s"), "all equal, bit for bit"];
    assert_told("windows", text.as_bytes(), 0, &equal);
    let behind: String = (0..10_000).map(|k| format!("(0946700000.{k:05}0000) vcan0 080#01\n")).collect();
    assert_told("unanswered", format!("{text}{behind}").as_bytes(), 0, &equal);
}

#[test]
fn interfaces_are_told_apart() {
    let text = recording();
    let other: String = text.lines().map(|line| format!("{line}\n{}\n", line.replace(" vcan0 ", " can1 "))).collect();
    let (code, told) = replay("two", other.as_bytes(), &[]);
    assert_eq!(code, 1);
    assert!(told.contains("can1 (") && told.contains("vcan0 (") && told.contains("--interface"), "{told}");
    let (code, told) = replay("one-of-two", other.as_bytes(), &["--interface", "can1"]);
    assert_eq!(code, 0, "{told}");
    let (code, told) = replay("none-of-two", other.as_bytes(), &["--interface", "can7"]);
    assert_eq!(code, 1);
    assert!(told.contains("no frame of can7"), "{told}");
}

/// In the cycle that ends a run by a limit, no torque is sent: nothing is lost.
#[test]
fn a_what_if_on_a_run_that_ended_by_a_limit_loses_nothing() {
    let robot = uarm::robot::BUILT_IN.replacen("tracking_error_limit_deg = 30.0", "tracking_error_limit_deg = 0.5", 1);
    let (file, log) = (scratch("limit.toml"), scratch(&format!("limit-{}.mcap", std::process::id())));
    std::fs::write(&file, robot).unwrap();
    let run = uarm(&["run", "--virtual-time", "--robot", file.to_str().unwrap(), "--log", log.to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(1));
    let output = uarm(&["replay", log.to_str().unwrap(), "--controller", "adaptive"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(!text(&output).contains("LOST"), "{}", text(&output));
}
