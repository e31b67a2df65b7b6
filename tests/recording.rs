//! What the writer does when the disk does not: nothing that the loop would notice, and nothing lost that could be kept.

mod support;

use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use embedded_can::StandardId;
use hinf_control::Law;
use uarm::commands::figures::experiments::simulate_paper;
use uarm::dimensions::CycleRecord;
use uarm::dimensions::{ACTIVE, JOINTS, RunLog};
use uarm::robot::Robot;
use uarm::simulated_plant::PlantChoice;
use uarm_io::frame::Frame;
use uarm_io::link::FrameDirection;
use uarm_io::time::Instant;
use uarm_log::writer::LogWriter;
use uarm_loop::record::Recorder;
use uarm_loop::recording::{self, Entry, FullQueue, Leftovers, Recording, RunEnd, Severity, Sink};
use uarm_loop::settings::Settings;

/// The period of the built-in robot.
const PERIOD: Duration = Duration::from_millis(3);

/// A file that a test can read while it is written, and that may have an end.
#[derive(Clone)]
struct Disk {
    bytes: Arc<Mutex<Vec<u8>>>,
    size: usize,
}

impl Disk {
    fn of_size(size: usize) -> Self {
        Self { bytes: Arc::default(), size }
    }

    fn endless() -> Self {
        Self::of_size(usize::MAX)
    }

    fn log(&self) -> RunLog {
        RunLog::read_from(self.bytes.lock().unwrap().as_slice(), Path::new("disk")).unwrap()
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut disk = self.bytes.lock().unwrap();
        let room = self.size.saturating_sub(disk.len()).min(bytes.len());
        if room == 0 && !bytes.is_empty() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        disk.extend_from_slice(&bytes[..room]);
        Ok(room)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A sink that waits before its gate, as a writer does before a disk that stands still.
struct Gated<S> {
    sink: S,
    open: Arc<AtomicBool>,
    /// Cycles that went through the gate.
    cycles_taken: Arc<AtomicU64>,
    /// Set once an entry stands before the closed gate.
    is_waiting: Arc<AtomicBool>,
}

/// Waits for a condition that another thread brings about; fails if it does not come about in a minute.
fn wait_until(condition: impl Fn() -> bool) {
    let end = std::time::Instant::now() + Duration::from_secs(60);
    while !condition() {
        assert!(std::time::Instant::now() < end, "what is waited for does not happen");
        std::thread::sleep(Duration::from_millis(1));
    }
}

impl<S: Sink<JOINTS, ACTIVE>> Sink<JOINTS, ACTIVE> for Gated<S> {
    fn name(&self) -> String {
        self.sink.name()
    }

    fn take(&mut self, entry: Entry<'_, JOINTS, ACTIVE>) -> io::Result<()> {
        while !self.open.load(Ordering::Acquire) {
            self.is_waiting.store(true, Ordering::Release);
            std::thread::sleep(Duration::from_millis(1));
        }
        let is_cycle = matches!(entry, Entry::Cycle(_));
        self.sink.take(entry)?;
        self.cycles_taken.fetch_add(u64::from(is_cycle), Ordering::Release);
        Ok(())
    }
}

fn log_writer(disk: &Disk) -> LogWriter<Disk, JOINTS, ACTIVE> {
    support::log_writer(disk.clone(), &Settings::paper(Law::Neural), &["hello".to_owned()])
}

/// Cycles of a run, again and again, with ticks and instants that go on.
fn cycles() -> impl Iterator<Item = CycleRecord> {
    let robot = Robot::load(None).unwrap();
    let records = simulate_paper(&robot, PlantChoice::Uarm, Law::Neural).unwrap().records;
    (0_u64..).zip(records.into_iter().cycle()).map(|(tick, record)| {
        let mut record = record;
        let at = Instant::default() + PERIOD * u32::try_from(tick + 1).unwrap();
        record.tick = tick;
        record.elapsed_ticks = u64::from(tick > 0);
        record.instants.scheduled = at;
        record.instants.done = at + Duration::from_micros(200);
        record
    })
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(StandardId::new(id).unwrap(), data).unwrap()
}

/// An end like that of a run that failed.
fn failed(leftovers: &Leftovers<JOINTS, ACTIVE>, dropped: u64) -> RunEnd {
    RunEnd {
        text: "FAILED: node 2 is on fire".to_owned(),
        fault: Some("node 2 is on fire".to_owned()),
        figures: vec![("cycles".to_owned(), "17".to_owned())],
        cycles_kept: leftovers.cycles.len() as u64,
        frames_kept: leftovers.frames.len() as u64,
        dropped,
    }
}

#[test]
fn the_last_seconds_before_a_fault_are_in_the_file_though_the_disk_stood_still() {
    const CYCLES: u64 = 12_000;
    let disk = Disk::endless();
    let open = Arc::new(AtomicBool::new(true));
    let (taken, is_waiting) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
    let sink = Gated {
        sink: log_writer(&disk),
        open: Arc::clone(&open),
        cycles_taken: Arc::clone(&taken),
        is_waiting: Arc::clone(&is_waiting),
    };
    let Recording { mut loop_recorder, mut frame_recorder, writer } =
        recording::start(vec![Box::new(sink)], FullQueue::Keep, PERIOD).unwrap();
    for record in cycles().take(CYCLES as usize) {
        // From the hundredth cycle on nothing is written until the run is over.
        if record.tick == 100 {
            wait_until(|| taken.load(Ordering::Acquire) >= 100);
            open.store(false, Ordering::Release);
        }
        frame_recorder.record(FrameDirection::Sent, &frame(0x080, &[1]), record.instants.scheduled);
        loop_recorder.record(&record);
        if record.tick == 100 {
            // Later the writer would make room in a full queue, and one cycle of the lost ones would come through.
            wait_until(|| is_waiting.load(Ordering::Acquire));
        }
    }
    let dropped = writer.dropped();
    assert!(dropped > 1_000, "12 000 cycles do not fit 4000 + 2000: {dropped} lost");
    let leftovers = Leftovers::of(loop_recorder, frame_recorder);
    let end = failed(&leftovers, dropped);
    open.store(true, Ordering::Release);
    assert_eq!(writer.finish(leftovers, end), [""; 0]);

    let log = disk.log();
    let ticks: Vec<u64> = log.cycles.iter().map(|record| record.tick).collect();
    let window: Vec<u64> = (CYCLES - 1_667..CYCLES).collect();
    assert!(ticks.ends_with(&window), "the last five seconds are whole");
    assert_eq!(log.gaps(), 1, "what had to be overwritten lies in one piece before them");
    assert_eq!(ticks.len() as u64 + dropped, CYCLES, "each cycle is either there or counted as lost");
    let fault = log.fault.as_ref().expect("the fault is marked");
    assert_eq!((fault.cause.as_str(), fault.last_tick), ("node 2 is on fire", Some(CYCLES - 1)));
    assert_eq!(fault.cycles_kept, 2000);
    assert_eq!(fault.at_ns - fault.window_start_ns, 5_000_000_000);
    assert_eq!(log.end.as_ref().unwrap()["fault"], "node 2 is on fire");
    assert!(log.notes.iter().any(|note| note.text.contains("records lost: the disk is too slow")), "{:?}", log.notes);
    assert!(log.damage.iter().any(|damage| damage.contains("gaps")), "{:?}", log.damage);
}

/// The fault is when the last cycle was: not when its drives had stopped, nor where the file ends.
#[test]
fn the_window_before_a_fault_ends_with_the_last_cycle() {
    const LAST: usize = 2_000;
    let disk = Disk::endless();
    let mut log = log_writer(&disk);
    let records: Vec<_> = cycles().take(LAST + 1).collect();
    // What was kept for the writer comes after what the queue took later.
    for record in records[..LAST - 100].iter().chain(&records[LAST - 50..]).chain(&records[LAST - 100..LAST - 50]) {
        log.take(Entry::Cycle(record)).unwrap();
    }
    let stopped = records[LAST].instants.done + Duration::from_secs(7);
    let stop = frame(0x000, &[2, 0]);
    let stop = recording::FrameRecord { sequence: 0, direction: FrameDirection::Sent, frame: stop, at: stopped };
    log.take(Entry::<JOINTS, ACTIVE>::Frame(&stop)).unwrap();
    let leftovers = Leftovers { cycles: Vec::new(), frames: Vec::new(), periodic: Vec::new(), cycles_recorded: 0 };
    log.take(Entry::<JOINTS, ACTIVE>::End(&failed(&leftovers, 0))).unwrap();
    drop(log);

    let log = disk.log();
    let fault = log.fault.as_ref().unwrap();
    assert_eq!(fault.last_tick, Some(LAST as u64));
    assert_eq!(fault.at_ns, log.run.axis.at(records[LAST].instants.done));
    assert_eq!(fault.at_ns - fault.window_start_ns, 5_000_000_000);
}

#[test]
fn a_full_disk_closes_the_log_and_the_run_goes_on() {
    let disk = Disk::of_size(200_000);
    let Recording { mut loop_recorder, frame_recorder, writer } =
        recording::start(vec![Box::new(log_writer(&disk))], FullQueue::Wait, PERIOD).unwrap();
    for record in cycles().take(3_000) {
        loop_recorder.record(&record);
    }
    let failures = writer.finish(Leftovers::of(loop_recorder, frame_recorder), RunEnd::default());
    assert_eq!(failures.len(), 1);
    assert!(failures[0].contains("log disk") && failures[0].contains("no storage space"), "{failures:?}");

    let log = disk.log();
    assert!(log.cycles.len() > 300, "what fitted is there: {} cycles", log.cycles.len());
    assert_eq!(log.gaps(), 0);
    assert!(log.end.is_none() && !log.damage.is_empty(), "and the log says that it is not whole: {:?}", log.damage);
}

#[test]
fn skipped_ticks_and_emergencies_are_told_in_words() {
    let disk = Disk::endless();
    let mut log = log_writer(&disk);
    for (number, mut record) in cycles().take(2_000).enumerate() {
        if number > 10 {
            record.tick += 2 * number as u64;
            record.elapsed_ticks = 3;
        }
        log.take(Entry::Cycle(&record)).unwrap();
    }
    let emergency = frame(0x082, &[0x10, 0x43, 0x09, 0, 0, 0, 0, 0]);
    let at = Instant::from_nanoseconds(7_000_000_000);
    let record = recording::FrameRecord { sequence: 0, direction: FrameDirection::Received, frame: emergency, at };
    log.take(Entry::<JOINTS, ACTIVE>::Frame(&record)).unwrap();
    log.take(Entry::<JOINTS, ACTIVE>::End(&RunEnd::default())).unwrap();
    drop(log);

    let notes = disk.log().notes;
    assert_eq!((notes[0].severity, notes[0].text.as_str()), (Severity::Info, "hello"));
    let skipped = notes.iter().filter(|note| note.text.contains("2 ticks before it were skipped")).count();
    assert!((4..=7).contains(&skipped), "once a second: {notes:?}");
    let emergency = notes.iter().find(|note| note.text.starts_with("node 2 reports:")).expect("the emergency");
    assert!(emergency.text.contains("4310h") && emergency.severity == Severity::Warning, "{emergency:?}");
}

#[test]
fn a_chunk_is_written_every_quarter_of_a_second() {
    let disk = Disk::endless();
    let mut log = log_writer(&disk);
    for record in cycles().take(5_000) {
        log.take(Entry::Cycle(&record)).unwrap();
        if record.tick.is_multiple_of(97) {
            // As if the process were killed here.
            let last = disk.log().cycles.last().map_or(0, |last| last.tick);
            assert!(record.tick - last <= 84, "at tick {} the file ends at {last}: 84 ticks are 252 ms", record.tick);
        }
    }
}
