//! The file, written: one [`Sink`] of the writer thread.

use std::borrow::Cow;
use std::io::{self, BufWriter, Write};

use foxglove::messages::{Log, log};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, McapResult, WriteOptions, Writer};
use prost::Message;
use uarm_loop::uarm_io::drive::DriveIdentity;
use uarm_loop::uarm_io::drive::network::Emergency;
use uarm_loop::uarm_io::drive::wire::{Channel, DRIVE_EDS, FRAMES_DBC, decode_emergency};
use uarm_loop::uarm_io::link::FrameDirection;
use uarm_loop::uarm_io::time::{Duration, Instant};

use crate::cycle::CycleMessages;
use crate::description::{self, Fields, LogHeader};
use crate::proto::{self, can_frame};
use crate::scene::Scene;
use crate::time_axis::{TimeAxis, timestamp};
use crate::topic::{ENCODING, LIBRARY, Topic};
use crate::{drives, health, keyframe};
use uarm_loop::record::CycleRecord;
use uarm_loop::recording::{Entry, FrameRecord, Note, PeriodicRecord, RunEnd, Severity, Sink};

/// How much time a chunk spans at most: what a killed process loses. A second is promised.
const CHUNK_SPAN: Duration = Duration::from_millis(250);
/// The size at which a chunk is written earlier: Foxglove reads whole chunks.
const CHUNK_SIZE: u64 = 1024 * 1024;
/// How often shapes are repeated, so that a log that lost its beginning still shows the robot.
const SHAPES_INTERVAL: Duration = Duration::from_secs(1);
/// How often transforms are written: 66 times a second moves smoothly. The angles of each cycle are in `/joint_states`.
const TRANSFORMS_INTERVAL: Duration = Duration::from_millis(15);
/// How often skipped ticks are told of in words at most.
const LATENESS_INTERVAL: Duration = Duration::from_secs(1);
/// The flight recorder's window: the part of a log before a fault that is marked.
const FLIGHT_WINDOW: Duration = Duration::from_secs(5);

/// What a message has beside its data: opcode, length, channel, sequence, two times; and its place in the chunk's index.
const MESSAGE_BYTES: u64 = 47;
/// What the summary has for each chunk at most, with its offsets in eleven topics.
const INDEX_BYTES: u64 = 512;
/// What else closing a log adds: the schemas and channels again, statistics, metadata.
const SUMMARY_BYTES: u64 = 64 * 1024;

/// What is attached to each log, beside the robot file.
const ATTACHMENTS: [(&str, &str, &str); 2] =
    [("uarm.dbc", "text/plain", FRAMES_DBC), ("uarm-drive.eds", "text/plain", DRIVE_EDS)];

/// Writes the log of a robot with `J` joints.
pub struct LogWriter<W: Write, const J: usize, const N: usize> {
    name: String,
    writer: Writer<NoSeek<BufWriter<W>>>,
    axis: TimeAxis,
    nodes: [u8; J],
    scene: Scene<J, N>,
    buffer: Vec<u8>,
    state: State,
}

/// What a log writer remembers of the entries before.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// The latest instant of an entry.
    now: Instant,
    /// When the chunk in hand is to be written at the latest.
    flush: Instant,
    next_shapes: Instant,
    next_transforms: Instant,
    next_lateness: Instant,
    /// Tick and end of the latest cycle; what was kept for the writer comes after later ones.
    latest_cycle: Option<(u64, Instant)>,
    notes: u32,
    periodic: u32,
    /// Bytes of messages in the chunk in hand, not compressed.
    pending: u64,
    /// Chunks that were written.
    chunks: u64,
}

impl<W: Write, const J: usize, const N: usize> LogWriter<W, J, N> {
    /// Begins a log: metadata, attachments, channels, and the preamble as notes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(output: W, header: &LogHeader<'_, J>) -> McapResult<Self> {
        let LogHeader { name, run, machine, joints, robot_source, start, preamble } = header;
        let options = WriteOptions::new()
            .profile("")
            .library(format!("{LIBRARY}{}", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            // The writer thread is one thread; more would compete with the loop for processors.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_SIZE))
            .disable_seeking(true);
        let mut writer = options.create(NoSeek::new(BufWriter::new(output)))?;
        for (name, metadata) in [
            (description::RUN, run.fields.clone()),
            (description::ROBOT, run.robot.fields()),
            (description::MACHINE, machine.fields()),
        ] {
            writer.write_metadata(&Metadata { name: name.to_owned(), metadata })?;
        }
        let at = run.axis.at(*start);
        attach(&mut writer, at, "robot.toml", "application/toml", robot_source)?;
        for (name, media_type, text) in ATTACHMENTS {
            attach(&mut writer, at, name, media_type, text)?;
        }
        for topic in Topic::ALL {
            let schema = topic.schema();
            let schema = writer.add_schema(&schema.name, ENCODING, &schema.data)?;
            writer.add_channel(schema, topic.name(), ENCODING, &Fields::new())?;
        }
        let mut log = Self {
            name: (*name).to_owned(),
            writer,
            axis: run.axis,
            nodes: joints.each_ref().map(|joint| joint.node),
            scene: Scene::new(joints),
            buffer: Vec::new(),
            state: State { now: *start, flush: *start + CHUNK_SPAN, ..State::default() },
        };
        for line in *preamble {
            log.note(Severity::Info, line)?;
        }
        log.writer.flush()?;
        Ok(log)
    }

    fn put(
        &mut self,
        topic: Topic,
        sequence: u32,
        log_time: u64,
        publish_time: u64,
        message: &impl Message,
    ) -> McapResult<()> {
        self.buffer.clear();
        // A `Vec` grows: there is always room.
        message.encode(&mut self.buffer).map_err(|error| McapError::Io(io::Error::other(error)))?;
        let header = MessageHeader { channel_id: topic.channel(), sequence, log_time, publish_time };
        self.writer.write_to_known_channel(&header, &self.buffer)?;
        self.state.pending += MESSAGE_BYTES + bytes(self.buffer.len());
        if self.state.pending > CHUNK_SIZE {
            self.chunk_is_written();
        }
        Ok(())
    }

    fn chunk_is_written(&mut self) {
        self.state.pending = 0;
        self.state.chunks += 1;
    }

    /// How many bytes closing the log will add at most: the chunk in hand as it is, and the summary.
    pub(crate) fn bytes_to_close(&self) -> u64 {
        self.state.pending + SUMMARY_BYTES + (self.state.chunks + 1) * INDEX_BYTES
    }

    fn cycle(&mut self, record: &CycleRecord<J, N>) -> McapResult<()> {
        let CycleRecord { instants, tick, .. } = record;
        self.reach(instants.done);
        self.state.latest_cycle = self.state.latest_cycle.max(Some((*tick, instants.done)));
        let (due, sampled) = (self.axis.at(instants.scheduled), self.axis.at(instants.sync_sent));
        // A reader sorts by this; it wraps after five months at 3 ms.
        let sequence = wrapped(*tick);
        if instants.done >= self.state.next_shapes {
            self.state.next_shapes = instants.done + SHAPES_INTERVAL;
            self.put(Topic::Scene, sequence, due, sampled, &self.scene.shapes(sampled))?;
        }
        if instants.done >= self.state.next_transforms {
            self.state.next_transforms = instants.done + TRANSFORMS_INTERVAL;
            self.put(Topic::Transforms, sequence, due, sampled, &self.scene.transforms(record, sampled))?;
        }
        self.put(Topic::JointStates, sequence, due, sampled, &self.scene.joint_states(record, sampled))?;
        let messages = CycleMessages::new(record, self.nodes, self.axis);
        self.put(Topic::Control, sequence, due, sampled, &messages.control)?;
        self.put(Topic::Timing, sequence, due, sampled, &messages.timing)?;
        self.put(Topic::Drives, sequence, due, sampled, &messages.drives)?;
        self.note_lateness(record)?;
        self.flush_if_due()
    }

    /// Tells of skipped ticks in words, though not of each on a machine that skips all the time.
    fn note_lateness(&mut self, record: &CycleRecord<J, N>) -> McapResult<()> {
        let skipped = record.elapsed_ticks.saturating_sub(1);
        if skipped == 0 || record.instants.done < self.state.next_lateness {
            return Ok(());
        }
        self.state.next_lateness = record.instants.done + LATENESS_INTERVAL;
        self.note(Severity::Warning, &format!("tick {}: {skipped} ticks before it were skipped", record.tick))
    }

    fn frame(&mut self, record: &FrameRecord) -> McapResult<()> {
        let at = self.axis.at(record.at);
        let direction = match record.direction {
            FrameDirection::Sent => can_frame::Direction::Sent,
            FrameDirection::Received => can_frame::Direction::Received,
        };
        let message = proto::CanFrame {
            direction: direction.into(),
            id: record.frame.id().as_raw().into(),
            data: record.frame.data().to_vec(),
            at_ns: at,
        };
        self.reach(record.at);
        self.put(Topic::CanFrames, record.sequence, at, at, &message)?;
        self.note_emergency(record)
    }

    /// Tells in words what a drive has to say about itself.
    fn note_emergency(&mut self, record: &FrameRecord) -> McapResult<()> {
        let Some(Channel::Emergency(node)) = Channel::of(record.frame.id()) else { return Ok(()) };
        let message = decode_emergency(record.frame.data());
        let severity = if message.is_error_reset() { Severity::Info } else { Severity::Warning };
        self.note(severity, &format!("node {} reports: {}", node.raw(), Emergency(message)))
    }

    fn periodic(&mut self, periodic: &PeriodicRecord<J, N>, dropped: u64) -> McapResult<()> {
        let at = self.axis.at(periodic.at());
        self.state.periodic = self.state.periodic.wrapping_add(1);
        let sequence = self.state.periodic;
        match periodic {
            PeriodicRecord::Keyframe(state, _) => {
                self.put(Topic::Keyframes, sequence, at, at, &keyframe::message(state, self.axis))
            }
            PeriodicRecord::Identities(identities, _) => self.identities(identities),
            PeriodicRecord::Health(record) => {
                self.put(Topic::CanHealth, sequence, at, at, &health::message(record, dropped))
            }
        }
    }

    pub(crate) fn identities(&mut self, identities: &[DriveIdentity; J]) -> McapResult<()> {
        let metadata = drives::fields(self.nodes, identities);
        self.writer.write_metadata(&Metadata { name: drives::DRIVES.to_owned(), metadata })
    }

    /// The latest instant of an entry.
    pub(crate) fn now(&self) -> Instant {
        self.state.now
    }

    pub(crate) fn note(&mut self, severity: Severity, text: &str) -> McapResult<()> {
        let at = self.axis.at(self.state.now);
        let level = match severity {
            Severity::Info => log::Level::Info,
            Severity::Warning => log::Level::Warning,
            Severity::Fatal => log::Level::Fatal,
        };
        let message = Log {
            timestamp: Some(timestamp(at)),
            level: level.into(),
            message: text.to_owned(),
            name: "uarm".to_owned(),
            file: String::new(),
            line: 0,
        };
        self.state.notes = self.state.notes.wrapping_add(1);
        self.put(Topic::Log, self.state.notes, at, at, &message)
    }

    fn end(&mut self, end: &RunEnd) -> McapResult<()> {
        if let Some(cause) = &end.fault {
            self.note(Severity::Fatal, cause)?;
            // The drives are stopped after a fault, which may take longer than the window.
            let instant = self.state.latest_cycle.map_or(self.state.now, |(_, done)| done);
            let at = self.axis.at(instant);
            let fault = proto::Fault {
                cause: cause.clone(),
                last_tick: self.state.latest_cycle.map(|(tick, _)| tick),
                window_start_ns: self.axis.at(instant - FLIGHT_WINDOW),
                at_ns: at,
                cycles_kept: end.cycles_kept,
                frames_kept: end.frames_kept,
            };
            self.put(Topic::Fault, 1, at, at, &fault)?;
        }
        self.note(Severity::Info, &end.text)?;
        self.writer
            .write_metadata(&Metadata { name: description::END.to_owned(), metadata: description::end_fields(end) })?;
        self.writer.finish().map(drop)
    }

    fn reach(&mut self, instant: Instant) {
        self.state.now = self.state.now.max(instant);
    }

    fn flush_if_due(&mut self) -> McapResult<()> {
        if self.state.now < self.state.flush {
            return Ok(());
        }
        self.state.flush = self.state.now + CHUNK_SPAN;
        self.chunk_is_written();
        self.writer.flush()
    }

    /// Goes on with the run of which `before` has the part before: number `part`, counted from 1.
    pub(crate) fn continue_run<V: Write>(&mut self, part: u32, before: &LogWriter<V, J, N>) -> McapResult<()> {
        let State { now, next_lateness, latest_cycle, notes, periodic, .. } = before.state;
        let flush = now + CHUNK_SPAN;
        self.state = State { now, flush, next_lateness, latest_cycle, notes, periodic, ..self.state };
        self.writer
            .write_metadata(&Metadata { name: description::PART.to_owned(), metadata: description::part_fields(part) })
    }

    /// Closes a part of a run that goes on in the file `next`, beside this one.
    pub(crate) fn close_part(&mut self, next: &str) -> McapResult<()> {
        self.writer.write_metadata(&Metadata {
            name: description::NEXT.to_owned(),
            metadata: description::next_fields(next),
        })?;
        self.writer.finish().map(drop)
    }
}

fn bytes(length: usize) -> u64 {
    u64::try_from(length).unwrap_or(u64::MAX)
}

/// Channels are added in the order of the topics, and counted from 1.
fn wrapped(tick: u64) -> u32 {
    u32::try_from(tick & u64::from(u32::MAX)).unwrap_or(u32::MAX)
}

fn attach<W: Write>(
    writer: &mut Writer<NoSeek<BufWriter<W>>>,
    at: u64,
    name: &str,
    media_type: &str,
    text: &str,
) -> McapResult<()> {
    writer.attach(&Attachment {
        log_time: at,
        create_time: at,
        name: name.to_owned(),
        media_type: media_type.to_owned(),
        data: Cow::Borrowed(text.as_bytes()),
    })
}

impl<W: Write + Send, const J: usize, const N: usize> Sink<J, N> for LogWriter<W, J, N> {
    fn name(&self) -> String {
        format!("log {}", self.name)
    }

    fn take(&mut self, entry: Entry<'_, J, N>) -> io::Result<()> {
        let written = match entry {
            Entry::Cycle(record) => self.cycle(record),
            Entry::Frame(record) => self.frame(record),
            Entry::Periodic(periodic, dropped) => self.periodic(periodic, dropped),
            Entry::Note(Note { severity, text }) => self.note(*severity, text),
            Entry::Pause => self.flush_if_due(),
            Entry::End(end) => self.end(end),
        };
        written.map_err(io_error)
    }
}

/// The error of a disk as such.
pub(crate) fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}
