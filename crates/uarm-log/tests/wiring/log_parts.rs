//! A log in parts: never more bytes than its limit, and nothing lost between them.

use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex};

use uarm_log::description::{
    JointDescription, LinkDescription, LogHeader, MachineDescription, RobotDescription, RunDescription,
};
use uarm_log::parts::{LogParts, NewestBytes, PartStore, SizeLimit};
use uarm_log::reader::{Part, RunLog};
use uarm_log::time_axis::TimeAxis;
use uarm_log::uarm_loop::hinf_control::FrozenState;
use uarm_log::uarm_loop::record::{CycleRecord, PARAMETER_CAPACITY};
use uarm_log::uarm_loop::recording::{Entry, FrameRecord, PeriodicRecord, RunEnd, Sink};
use uarm_log::uarm_loop::uarm_io::drive::DriveIdentity;
use uarm_log::uarm_loop::uarm_io::drive::wire::sync_frame;
use uarm_log::uarm_loop::uarm_io::link::FrameDirection;
use uarm_log::uarm_loop::uarm_io::time::{Duration, Instant};

use crate::support::{Run, run};

const PERIOD: Duration = Duration::from_millis(100);
/// Cycles in a second, between two keyframes.
const KEYFRAME_CYCLES: u64 = 10;
const CYCLES: u64 = 12_000;

/// Files in memory, each with the bytes that it holds; deleted ones hold none.
#[derive(Clone, Default)]
struct Disk(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    files: Vec<Vec<u8>>,
    deleted: usize,
    most: usize,
}

struct File {
    disk: Disk,
    number: usize,
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.disk.0.lock().unwrap();
        state.files[self.number].extend_from_slice(bytes);
        let total = state.files.iter().map(Vec::len).sum();
        state.most = state.most.max(total);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Disk {
    fn file(&self) -> File {
        let mut state = self.0.lock().unwrap();
        state.files.push(Vec::new());
        File { disk: self.clone(), number: state.files.len() - 1 }
    }

    fn read(&self, number: usize) -> RunLog<3, 2> {
        RunLog::read_from(self.0.lock().unwrap().files[number].as_slice(), Path::new("part")).unwrap()
    }
}

impl PartStore for Disk {
    type Output = File;

    fn create(&mut self, number: u32) -> io::Result<(File, String)> {
        Ok((self.file(), format!("part{number}")))
    }

    fn delete_oldest(&mut self) -> io::Result<()> {
        let mut state = self.0.lock().unwrap();
        let oldest = state.deleted;
        state.files[oldest].clear();
        state.deleted += 1;
        Ok(())
    }
}

/// Cycles whose parameters no compression makes smaller.
fn cycles() -> impl Iterator<Item = CycleRecord<3, 2>> {
    let mut random = 1_u64;
    let mut parameter = move || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from_bits(random >> 2)
    };
    (0..CYCLES).map(move |tick| {
        let at = Instant::default() + PERIOD * u32::try_from(tick + 1).unwrap();
        let mut record = CycleRecord { tick, elapsed_ticks: tick.min(1), ..CycleRecord::default() };
        record.instants.scheduled = at;
        record.instants.sync_sent = at;
        record.instants.done = at;
        let parameters: [f64; PARAMETER_CAPACITY] = std::array::from_fn(|_| parameter());
        record.set_parameters(&parameters);
        record
    })
}

/// Records a run as the writer thread hands it over.
fn record(limit: SizeLimit) -> Disk {
    let Run { robot, settings, keyframes, .. } = run(0);
    let described = RobotDescription { name: "test".to_owned(), toml: String::new(), fuzzy_sets: None };
    let joints = [1, 2, 3].map(|node| JointDescription {
        name: format!("joint {node}"),
        node,
        link: LinkDescription::along_x(1.0, 1.0),
    });
    let header = LogHeader {
        name: "part1",
        run: &RunDescription::new(&settings, "simulated robot", TimeAxis::simulated(), robot.period, described),
        machine: &MachineDescription::default(),
        joints: &joints,
        robot_source: "source",
        start: Instant::default(),
        preamble: &[],
    };
    let disk = Disk::default();
    let mut log = LogParts::new(disk.file(), disk.clone(), limit, &header).unwrap();
    let mut take = |entry: Entry<'_, 3, 2>| Sink::<3, 2>::take(&mut log, entry).unwrap();
    let identities = [DriveIdentity { serial: Some(7), ..DriveIdentity::default() }; 3];
    take(Entry::Periodic(&PeriodicRecord::Identities(identities, Instant::default()), 0));
    take(Entry::Periodic(&PeriodicRecord::Keyframe(keyframes[0].1, Instant::default()), 0));
    for record in cycles() {
        let (tick, at) = (record.tick, record.instants.done);
        let sequence = u32::try_from(tick).unwrap();
        take(Entry::Frame(&FrameRecord { sequence, direction: FrameDirection::Sent, frame: sync_frame(1), at }));
        take(Entry::Cycle(&record));
        if tick % KEYFRAME_CYCLES == 0 {
            let mut keyframe = keyframes[0].1;
            keyframe.controller = FrozenState::new(&[1.0]).unwrap();
            keyframe.task_clock.previous_sync = Some(at);
            keyframe.task_clock.previous_tick = tick;
            take(Entry::Periodic(&PeriodicRecord::Keyframe(keyframe, at), 0));
        }
    }
    take(Entry::End(&RunEnd { text: "over".to_owned(), ..RunEnd::default() }));
    disk
}

#[test]
fn the_newest_parts_are_kept_and_never_pass_the_limit() {
    let least = NewestBytes::least(PERIOD);
    assert_eq!(NewestBytes::new(least - 1, PERIOD), None);
    let disk = record(SizeLimit::Newest(NewestBytes::new(least, PERIOD).unwrap()));
    let (files, deleted, most) = {
        let state = disk.0.lock().unwrap();
        (state.files.len(), state.deleted, state.most)
    };
    let limit = usize::try_from(least).unwrap();
    assert!(most <= limit, "{most} of {limit} bytes");
    assert!(most > limit * 3 / 4, "{most} of {limit} bytes");
    assert!(deleted > 2 && files - deleted >= 5, "{deleted} of {files} parts are deleted");
    let mut next_tick = None;
    for number in deleted..files {
        let log = disk.read(number);
        assert_eq!(log.damage, Vec::<String>::new());
        let is_last = number + 1 == files;
        let next = (!is_last).then(|| format!("part{}", number + 2));
        assert_eq!(log.part, Part { number: u32::try_from(number + 1).unwrap(), next });
        assert_eq!(log.end.is_some(), is_last);
        assert_eq!((log.drives[0].serial, log.run.controller.as_str()), (Some(7), "nonlinear"));
        // Each begins with the keyframe of the cycle before its first, and no cycle or frame is lost between two.
        let first = log.cycles[0].tick;
        assert_eq!(log.keyframes[0].0, Some(first - 1));
        assert_eq!(u64::from(log.frames[0].sequence), first);
        assert_eq!((log.frames.len(), log.gaps()), (log.cycles.len(), 0));
        assert!(next_tick.is_none_or(|next| next == first), "{next_tick:?}, {first}");
        next_tick = Some(log.cycles.last().unwrap().tick + 1);
    }
    assert_eq!(next_tick, Some(CYCLES));
}

#[test]
fn a_log_without_a_limit_is_one_file_and_tells_of_no_parts() {
    let disk = record(SizeLimit::Unlimited);
    assert_eq!(disk.0.lock().unwrap().files.len(), 1);
    let log = disk.read(0);
    assert_eq!((log.part, log.cycles.len()), (Part::default(), usize::try_from(CYCLES).unwrap()));
    let bytes = &disk.0.lock().unwrap().files[0];
    assert!(!bytes.windows(9).any(|window| window == b"uarm.part" || window == b"uarm.next"));
}
