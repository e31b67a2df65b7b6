//! What recording costs the loop, which must be nothing, and what is left in the log when the disk, a drive or the process
//! fails: with the emulated robot as a second process on `vcan0`.
//!
//! Measured in guest time, as `vcan_timing.rs` is: a deadline that is missed here is missed for the recording's sake.

mod vcan_support;

use hinf_control::Law;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::io::Cursor;
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant, SystemTime};
use uarm::dimensions::RunLog;
use uarm_loop::recording::writer::FINISH_LIMIT;
use vcan_support::bus::{Bus, DEVICE_TEMPERATURE, RPDO1};
use vcan_support::disk::{Pace, Pipe, SmallDisk};
use vcan_support::process::{COARSE_STEP, Robot, Running, Scheduling, controller, describe};
use vcan_support::report::{assert_every_deadline_met, need_guest_time, report};
use vcan_support::{DRIVEN_NODE, NODES, Workshop};

/// Cycles of the paper's task at 3 ms: 3 s of motion and half a second of holding, and the cycle at 0 s.
const CYCLES: u64 = 1167;
/// How long that takes.
const TASK: Duration = Duration::from_millis(3_500);
/// Start and stop of the drives take less than this.
const START_AND_STOP: Duration = Duration::from_secs(2);
/// The flight recorder's window.
const FLIGHT_WINDOW: Duration = Duration::from_secs(5);
/// What a killed process may lose at most.
const LOSS_LIMIT: Duration = Duration::from_secs(1);

const LOSS: Option<i32> = Some(3);
const FAILURE: Option<i32> = Some(1);

/// The robot, and a controller that records into `log`, in real time.
fn start(workshop: &Workshop, bus: &Bus, log: &Path, arguments: &[&str]) -> (Robot, Running) {
    let robot = Robot::start(workshop, bus, Scheduling::Fifo, &["--step", COARSE_STEP]);
    let mut controller = controller(workshop, &["--json", "--rt", "enforce", "--log"]);
    let running = Running::start(controller.arg(log).args(arguments));
    (robot, running)
}

/// Records a run of the paper's task; nobody else is on the bus.
fn record(workshop: &Workshop, log: &Path, arguments: &[&str]) -> Output {
    let (_robot, running) = start(workshop, &Bus::open(), log, arguments);
    running.end()
}

/// Every cycle of the task was run in time, and none waited for a page of memory.
fn assert_undisturbed(output: &Output) -> Value {
    let report = report(output);
    assert_eq!(report["end"], "completed", "{}", describe(output));
    assert_eq!(report["timing"]["cycles"].as_u64(), Some(CYCLES), "{report}");
    assert_every_deadline_met(&report["timing"]);
    assert_eq!(report["page_faults"].as_u64(), Some(0), "{report}");
    report
}

/// The report tells of a loss in these words, and so does the exit code.
fn assert_loss(output: &Output, report: &Value, words: &str) {
    assert_eq!(output.status.code(), LOSS, "{}", describe(output));
    let losses = report["losses"].to_string();
    assert!(losses.contains(words), "`{words}` in {losses}");
}

fn read_bytes(bytes: Vec<u8>) -> RunLog {
    RunLog::read_from(Cursor::new(bytes), Path::new("pipe")).unwrap()
}

/// What a subcommand makes of a log.
fn exit_code(workshop: &Workshop, subcommand: &str, log: &Path) -> Option<i32> {
    let output = workshop.command().arg(subcommand).arg(log).output().unwrap();
    println!("{}", describe(&output).lines().next().unwrap_or_default());
    output.status.code()
}

/// All is there.
fn assert_whole(log: &RunLog) {
    assert_eq!(log.damage, [""; 0]);
    assert_eq!(log.cycles.len() as u64, CYCLES);
    assert_without_gaps(log);
}

/// From the first cycle on nothing is missing, as far as the log reaches.
fn assert_without_gaps(log: &RunLog) {
    assert_eq!(log.cycles.first().map(|cycle| cycle.tick), Some(0));
    assert_eq!(log.gaps(), 0);
    assert!(log.frames.windows(2).all(|pair| pair[0].sequence + 1 == pair[1].sequence), "a frame is missing");
    let last = log.cycles.last().expect("cycles").instants.sync_sent;
    let commands = |node: u8| {
        let id = RPDO1 + u16::from(node);
        log.frames.iter().filter(|frame| frame.frame.id().as_raw() == id && frame.at <= last).count()
    };
    // Beside those of the cycles there are the ones that enabled the drive.
    assert!(NODES.iter().all(|node| commands(*node) + 1 >= log.cycles.len()), "a command of some cycle is missing");
}

#[test]
fn recording_any_law_costs_no_deadline_and_no_page_fault() {
    need_guest_time();
    let workshop = Workshop::new("recording");
    for law in Law::ALL {
        let file = workshop.file(&format!("{}.mcap", law.name()));
        let output = record(&workshop, &file, &["--controller", law.name()]);
        let report = assert_undisturbed(&output);
        assert!(output.status.success(), "{}", describe(&output));
        assert_whole(&RunLog::<3, 2>::read(&file).unwrap());
        assert_eq!(exit_code(&workshop, "replay", &file), Some(0));
        let most = |latency: &str| report["timing"][latency]["maximum_ns"].as_u64().unwrap();
        let [wake_up, feedback, total] = ["wake_up", "feedback_latency", "total"].map(most);
        println!("{}: at most {wake_up} ns to wake up, {feedback} ns to the counts, {total} ns in all", law.name());
    }
}

#[test]
fn a_full_disk_costs_no_deadline_and_what_it_took_is_readable() {
    need_guest_time();
    /// Room for the first second or so.
    const KIBIBYTES: u32 = 256;
    let workshop = Workshop::new("full");
    let disk = SmallDisk::mount(workshop.file("disk"), KIBIBYTES);
    let file = disk.file("run.mcap");
    let output = record(&workshop, &file, &[]);
    assert_loss(&output, &assert_undisturbed(&output), "No space left on device");
    let log = RunLog::<3, 2>::read(&file).unwrap();
    println!("full disk: {} cycles are left; {:?}", log.cycles.len(), log.damage);
    assert_without_gaps(&log);
    assert!(log.cycles.len() > 100 && log.end.is_none());
    assert_eq!(exit_code(&workshop, "show", &file), LOSS);
}

/// Nothing moves before there is a log of it.
#[test]
fn a_disk_that_is_full_from_the_start_is_refused_before_any_drive_is_touched() {
    let workshop = Workshop::new("dev-full");
    let bus = Bus::open();
    let (_robot, running) = start(&workshop, &bus, Path::new("/dev/full"), &[]);
    let output = running.end();
    assert_eq!(output.status.code(), FAILURE, "{}", describe(&output));
    assert!(describe(&output).contains("the log /dev/full: "), "{}", describe(&output));
    let commands = |id: u16| NODES.iter().any(|node| id == RPDO1 + u16::from(*node));
    assert!(!bus.drain().iter().any(|seen| commands(seen.id)), "no drive was commanded");
}

/// The queue takes in what a slow disk leaves, and the end of the run waits for it.
#[test]
fn a_slow_disk_costs_no_deadline_and_loses_nothing() {
    need_guest_time();
    /// About half of what a run writes.
    const SLOW: Pace = Pace::BytesPerSecond(100_000);
    let workshop = Workshop::new("slow");
    let pipe = Pipe::new(workshop.file("run.mcap"), SLOW);
    let output = record(&workshop, pipe.path(), &[]);
    assert_undisturbed(&output);
    assert!(output.status.success(), "{}", describe(&output));
    assert_whole(&read_bytes(pipe.into_bytes()));
}

#[test]
fn a_disk_that_is_too_slow_or_stands_still_costs_no_deadline_and_ends_the_run_in_time() {
    need_guest_time();
    /// The test sees motion only when the loop rests.
    const SEEN_LATE: Duration = Duration::from_millis(500);
    for (pace, name) in [(Pace::BytesPerSecond(10_000), "too-slow"), (Pace::Stopped, "stalled")] {
        let workshop = Workshop::new(name);
        let bus = Bus::open();
        let pipe = Pipe::new(workshop.file("run.mcap"), Pace::Unlimited);
        let (_robot, running) = start(&workshop, &bus, pipe.path(), &[]);
        bus.wait_for_motion();
        drop(bus); // a socket that nobody reads would fill up and cost the kernel time
        let begun = Instant::now();
        pipe.set(pace);
        let output = running.end();
        let took = begun.elapsed();
        let report = assert_undisturbed(&output);
        assert_loss(&output, &report, "of 1167 cycles are lost");
        println!("{name}: the run ended after {took:?}; {}", report["losses"]);
        let least = FINISH_LIMIT + TASK - SEEN_LATE;
        assert!(took >= least && took <= FINISH_LIMIT + TASK + START_AND_STOP, "{took:?}");
        let log = read_bytes(pipe.into_bytes());
        println!("{name}: {} cycles came through; {:?}", log.cycles.len(), log.damage);
        assert_without_gaps(&log);
        assert!(log.end.is_none() && !log.damage.is_empty());
    }
}

/// The flight recorder: a drive fails while the disk stands still, and longer than the queue lasts.
#[test]
fn the_seconds_before_a_fault_reach_the_log_even_if_the_disk_stood_still_then() {
    need_guest_time();
    /// Longer than the queue lasts, and than the ring beside it.
    const STILL: Duration = Duration::from_secs(20);
    let workshop = Workshop::new("flight-recorder");
    let bus = Bus::open();
    let pipe = Pipe::new(workshop.file("run.mcap"), Pace::Unlimited);
    let (_robot, running) = start(&workshop, &bus, pipe.path(), &["--hold", "60s"]);
    bus.wait_for_motion();
    pipe.set(Pace::Stopped);
    std::thread::sleep(STILL);
    bus.send_emergency(DRIVEN_NODE, DEVICE_TEMPERATURE);
    // The drives are stopped in that time.
    std::thread::sleep(START_AND_STOP);
    let log = read_bytes(pipe.into_bytes());
    let output = running.end();

    assert_eq!(output.status.code(), FAILURE, "{}", describe(&output));
    assert_every_deadline_met(&report(&output)["timing"]);
    assert!(report(&output)["records_dropped"].as_u64() > Some(0), "the test did not wait until the ring was full");
    let fault = log.fault.as_ref().expect("a fault");
    println!("flight recorder: {fault:?}; {:?}", log.damage);
    assert!(fault.cause.contains("node 2") && fault.cause.contains("4210"), "{}", fault.cause);
    assert_eq!(report(&output)["fault"], *fault.cause);
    assert!(fault.at_ns - fault.window_start_ns >= FLIGHT_WINDOW.as_nanos() as u64);
    let in_window = |at| log.run.axis.at(at) >= fault.window_start_ns;
    let cycles: Vec<_> = log.cycles.iter().filter(|cycle| in_window(cycle.instants.scheduled)).collect();
    assert!(cycles.windows(2).all(|pair| pair[0].tick + 1 == pair[1].tick), "a cycle of the window is missing");
    assert_eq!(cycles.last().map(|cycle| cycle.tick), fault.last_tick);
    let period = log.run.period.duration();
    let expected = (FLIGHT_WINDOW.as_nanos() / period.as_nanos()) as usize;
    assert!(cycles.len().abs_diff(expected) <= 2, "{} cycles, expected about {expected}", cycles.len());
    let frames: Vec<_> = log.frames.iter().filter(|frame| in_window(frame.at)).collect();
    assert!(frames.windows(2).all(|pair| pair[0].sequence + 1 == pair[1].sequence), "a frame of the window is missing");
}

#[test]
fn a_killed_run_leaves_all_but_its_last_second() {
    need_guest_time();
    const KILLS: usize = 5;
    const SEED: u64 = 20_110_395;
    let workshop = Workshop::new("killed");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for kill in 0..KILLS {
        let after = TASK.mul_f64(random.random_range(0.0..0.9));
        let file = workshop.file(&format!("{kill}.mcap"));
        let bus = Bus::open();
        let (_robot, running) = start(&workshop, &bus, &file, &[]);
        bus.wait_for_motion();
        drop(bus);
        std::thread::sleep(after);
        let killed = SystemTime::now();
        running.signal(rustix::process::Signal::KILL);
        running.end();

        let log = RunLog::<3, 2>::read(&file).unwrap();
        let killed = killed.duration_since(SystemTime::UNIX_EPOCH).unwrap();
        let last =
            log.cycles.last().map_or(log.run.axis.at(Default::default()), |cycle| log.run.axis.at(cycle.instants.done));
        let lost = killed.saturating_sub(Duration::from_nanos(last));
        println!(
            "seed {SEED}, kill {kill}: after {after:?} of motion; {} cycles are left, {lost:?} lost",
            log.cycles.len()
        );
        assert!(lost <= LOSS_LIMIT, "{lost:?} lost");
        if !log.cycles.is_empty() {
            assert_without_gaps(&log);
        }
        assert_eq!(exit_code(&workshop, "show", &file), LOSS);
    }
}
