//! What a file holds, message by message, and what a reader makes of it.

use std::collections::BTreeMap;
use std::path::Path;

use uarm_log::cycle::CycleMessages;
use uarm_log::description::{
    ClockKind, JointDescription, LinkDescription, LogHeader, MachineDescription, ROBOT, RUN, RobotDescription,
    RunDescription,
};
use uarm_log::reader::RunLog;
use uarm_log::time_axis::TimeAxis;
use uarm_log::topic::{ENCODING, Topic};
use uarm_log::uarm_loop::record::{CycleRecord, HealthRecord};
use uarm_log::uarm_loop::recording::{Entry, FrameRecord, Note, PeriodicRecord, RunEnd, Severity, Sink};
use uarm_log::uarm_loop::uarm_io::drive::network::{NetworkHealth, NodeHealth};
use uarm_log::uarm_loop::uarm_io::drive::wire::sync_frame;
use uarm_log::uarm_loop::uarm_io::link::{FrameDirection, LinkHealth};
use uarm_log::uarm_loop::uarm_io::time::Instant;
use uarm_log::writer::LogWriter;

use crate::support::{Run, run, sync};

fn description(place: &str, axis: TimeAxis) -> RunDescription {
    let robot = RobotDescription { name: "test".to_owned(), toml: String::new(), fuzzy_sets: None };
    let Run { robot: described, settings, .. } = run(0);
    RunDescription::new(&settings, place, axis, described.period, robot)
}

fn writer(output: &mut Vec<u8>) -> LogWriter<&mut Vec<u8>, 3, 2> {
    let joints = [1, 2, 3].map(|node| JointDescription {
        name: format!("joint {node}"),
        node,
        link: LinkDescription::along_x(f64::from(node) - 1.0, f64::from(node)),
    });
    let header = LogHeader {
        name: "test.mcap",
        run: &description("simulated robot", TimeAxis::simulated()),
        machine: &MachineDescription::default(),
        joints: &joints,
        robot_source: "",
        start: Instant::default(),
        preamble: &[],
    };
    LogWriter::new(output, &header).unwrap()
}

fn take(writer: &mut LogWriter<&mut Vec<u8>, 3, 2>, entry: Entry<'_, 3, 2>) {
    Sink::<3, 2>::take(writer, entry).unwrap();
}

fn end(fault: Option<&str>) -> RunEnd {
    RunEnd { text: "over".to_owned(), fault: fault.map(str::to_owned), ..RunEnd::default() }
}

fn frame(sequence: u32) -> FrameRecord {
    FrameRecord { sequence, direction: FrameDirection::Sent, frame: sync_frame(1), at: sync(sequence.into()) }
}

fn health() -> PeriodicRecord<3, 2> {
    let network = NetworkHealth {
        nodes: [NodeHealth::default(); 3],
        frames_received: 0,
        frames_sent: 0,
        syncs: 4,
        unexpected_frames: 0,
    };
    PeriodicRecord::Health(HealthRecord { at: sync(0), network, link: LinkHealth::default() })
}

fn read(bytes: &[u8]) -> RunLog<3, 2> {
    RunLog::read_from(bytes, Path::new("test.mcap")).unwrap()
}

/// Every message is on the channel of its topic, and has the schema of that topic.
#[test]
fn every_message_goes_to_its_own_topic() {
    let run = run(2);
    let mut bytes = Vec::new();
    let mut log = writer(&mut bytes);
    for record in &run.records {
        take(&mut log, Entry::Cycle(record));
    }
    for sequence in 0..3 {
        take(&mut log, Entry::Frame(&frame(sequence)));
    }
    for _ in 0..4 {
        take(&mut log, Entry::Periodic(&health(), 0));
    }
    for _ in 0..5 {
        take(&mut log, Entry::Periodic(&PeriodicRecord::Keyframe(run.keyframes[0].1, sync(0)), 0));
    }
    take(&mut log, Entry::Note(&Note { severity: Severity::Warning, text: "a note".to_owned() }));
    take(&mut log, Entry::End(&end(Some("a cause"))));
    drop(log);

    let mut counts = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = Topic::from_name(&message.channel.topic).unwrap();
        let schema = message.channel.schema.clone().unwrap();
        assert_eq!(schema.name, topic.schema().name);
        assert_eq!((schema.encoding.as_str(), message.channel.message_encoding.as_str()), (ENCODING, ENCODING));
        *counts.entry(topic).or_insert(0) += 1;
    }
    let expected = [
        (Topic::JointStates, 2),
        (Topic::Transforms, 1),
        (Topic::Scene, 1),
        (Topic::Control, 2),
        (Topic::Timing, 2),
        (Topic::Drives, 2),
        (Topic::CanFrames, 3),
        (Topic::CanHealth, 4),
        (Topic::Keyframes, 5),
        // The note, the cause and the end.
        (Topic::Log, 3),
        (Topic::Fault, 1),
    ];
    assert_eq!(counts, expected.into());

    let log = read(&bytes);
    assert_eq!((log.cycles.as_slice(), log.frames.len()), (run.records.as_slice(), 3));
    assert_eq!((log.health.len(), log.health[3].syncs, log.keyframes.len()), (4, 4, 5));
    let notes: Vec<_> = log.notes.iter().map(|note| (note.severity, note.text.as_str())).collect();
    assert_eq!(notes, [(Severity::Warning, "a note"), (Severity::Fatal, "a cause"), (Severity::Info, "over")]);
    assert_eq!((log.fault.unwrap().last_tick, log.damage), (Some(1), Vec::<String>::new()));
}

/// What the queue did not take is written behind what came later.
#[test]
fn late_records_are_put_where_they_belong() {
    let run = run(10);
    let mut bytes = Vec::new();
    let mut log = writer(&mut bytes);
    for index in [0, 1, 2, 5, 6, 7, 8, 9, 3, 4] {
        take(&mut log, Entry::Cycle(&run.records[index]));
        take(&mut log, Entry::Frame(&frame(u32::try_from(index).unwrap())));
    }
    for (_, keyframe) in run.keyframes.iter().rev() {
        take(&mut log, Entry::Periodic(&PeriodicRecord::Keyframe(*keyframe, sync(0)), 0));
    }
    take(&mut log, Entry::End(&end(None)));
    drop(log);
    let log = read(&bytes);
    assert_eq!(log.cycles, run.records);
    assert_eq!(log.frames.iter().map(|frame| frame.sequence).collect::<Vec<_>>(), (0..10).collect::<Vec<_>>());
    assert_eq!(log.keyframes, run.keyframes);
    assert_eq!((log.gaps(), log.damage), (0, Vec::new()));
}

/// A file made by hand: a run, and messages on channels of any name.
fn file(messages: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut file = mcap::Writer::new(std::io::Cursor::new(&mut bytes)).unwrap();
    let run = description("simulated robot", TimeAxis::simulated());
    for (name, metadata) in [(RUN, run.fields.clone()), (ROBOT, run.robot.fields())] {
        file.write_metadata(&mcap::records::Metadata { name: name.to_owned(), metadata }).unwrap();
    }
    for (sequence, (topic, data)) in (0..).zip(messages) {
        let schema = file.add_schema("any", "protobuf", &[]).unwrap();
        let channel_id = file.add_channel(schema, topic, ENCODING, &BTreeMap::new()).unwrap();
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time: 0, publish_time: 0 };
        file.write_to_known_channel(&header, data).unwrap();
    }
    file.finish().unwrap();
    drop(file);
    bytes
}

/// The three messages of a cycle.
fn parts(record: &CycleRecord<3, 2>) -> [(&'static str, Vec<u8>); 3] {
    use prost::Message;
    let CycleMessages { control, timing, drives } = CycleMessages::new(record, [1, 2, 3], TimeAxis::simulated());
    [("/control", control.encode_to_vec()), ("/timing", timing.encode_to_vec()), ("/drives", drives.encode_to_vec())]
}

const NO_END: &str = "no end is recorded: the process was killed, or the disk failed";

#[test]
fn topics_that_are_not_known_are_left_out() {
    let run = run(2);
    let [control, timing, drives] = parts(&run.records[0]);
    let log = read(&file(&[("/camera", vec![0xFF; 20]), control, timing, ("/camera", vec![]), drives]));
    assert_eq!((log.cycles, log.damage), (vec![run.records[0]], vec![NO_END.to_owned()]));
}

#[test]
fn parts_of_different_cycles_are_not_joined() {
    let run = run(4);
    let [one, two, three] = [0, 1, 2].map(|index| parts(&run.records[index]));
    let [control, timing, drives] = [0, 1, 2];
    for parts in [
        [&two[control], &one[timing], &one[drives]],
        [&one[control], &two[timing], &one[drives]],
        [&one[control], &one[timing], &two[drives]],
    ] {
        let mut messages: Vec<_> = parts.into_iter().cloned().collect();
        messages.extend(three.clone());
        let log = read(&file(&messages));
        assert_eq!((log.cycles, log.damage), (vec![run.records[2]], vec![NO_END.to_owned()]));
    }
    // Nor is what is left of one cycle with what is left of another: /timing of the first is missing.
    let messages = [one[control].clone(), one[drives].clone(), two[timing].clone(), two[drives].clone()];
    assert_eq!(read(&file(&messages)).cycles, []);
    // A part is used once.
    let messages = [one.as_slice(), &one[drives..]].concat();
    assert_eq!(read(&file(&messages)).cycles, [run.records[0]]);
}

#[test]
fn a_message_of_another_format_is_damage_and_no_end() {
    let run = run(2);
    let mut messages = vec![("/control", vec![0xFF; 20])];
    messages.extend(parts(&run.records[1]));
    let log = read(&file(&messages));
    assert_eq!((log.cycles, log.damage.len()), (vec![run.records[1]], 2));
    assert!(log.damage[0].starts_with("/control: "), "{}", log.damage[0]);
}

#[test]
fn a_log_tells_the_interface_and_the_clock() {
    for (place, interface) in [("can0", Some("can0")), ("vcan12", Some("vcan12")), ("simulated robot", None)] {
        assert_eq!(description(place, TimeAxis::simulated()).interface(), interface);
    }
    assert_eq!(description("can0", TimeAxis::simulated()).clock(), ClockKind::Virtual);
    assert_eq!(description("can0", TimeAxis::with_offset(0)).clock(), ClockKind::Monotonic);
    assert_eq!(description("simulated robot", TimeAxis::monotonic()).clock(), ClockKind::Monotonic);
}
