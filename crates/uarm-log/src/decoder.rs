//! Records of a file to items of a run: what [`reader`](super::reader) and [`follow`](super::follow) share.

use std::collections::HashMap;

use foxglove::messages::Log;
use mcap::records::{MessageHeader, Record, op};
use prost::Message;
use uarm_loop::uarm_io::frame::Frame;
use uarm_loop::uarm_io::link::FrameDirection;

use crate::chunk::{Chunk, ChunkError};
use crate::cycle::CycleMessages;
use crate::description::{self, DescriptionError, Fields, RunDescription};
use crate::drives::{self, LoggedDrive};
use crate::keyframe;
use crate::layout::{self, LengthError};
use crate::proto::{self, can_frame};
use crate::shape::ShapeError;
use crate::time_axis::TimeAxis;
use crate::topic::{LIBRARY, Topic};
use uarm_loop::keyframe::Keyframe;
use uarm_loop::record::CycleRecord;
use uarm_loop::recording::{FrameRecord, Severity};

/// Something that a log tells.
#[derive(Clone, Debug)]
pub enum Item<const J: usize, const N: usize> {
    /// What was run; before anything else but [`Item::Machine`].
    Run(Box<RunDescription>),
    /// The machine that it ran on.
    Machine(Fields),
    /// Which drives moved the robot.
    Drives(Vec<LoggedDrive>),
    /// Which part of a run the file is, counted from 1; the first does not say so.
    Part(u32),
    /// The file beside this one in which the run goes on.
    Next(String),
    /// How the run ended.
    End(Fields),
    /// The record of a cycle.
    Cycle(Box<CycleRecord<J, N>>),
    /// A frame that was sent or received.
    Frame(FrameRecord),
    /// The inner state, and the tick that it follows.
    Keyframe(Box<Keyframe<J, N>>, Option<u64>),
    /// The health of bus and drives.
    Health(Box<proto::CanHealth>),
    /// A line of text.
    Note(LoggedNote),
    /// Why the run failed.
    Fault(proto::Fault),
    /// A part that cannot be read.
    Damage(String),
    /// The end of a file that was closed as it should be.
    Closed,
}

/// A line of text in a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedNote {
    /// The instant, ns since 1970-01-01 UTC.
    pub at: u64,
    /// The severity.
    pub severity: Severity,
    /// The text.
    pub text: String,
}

/// Turns the records of a file into items of a run with `J` joints of which `N` are active.
#[derive(Debug, Default)]
pub struct Decoder<const J: usize, const N: usize> {
    channels: HashMap<u16, Topic>,
    run: Option<Fields>,
    axis: Option<TimeAxis>,
    parts: Parts,
}

/// The messages of a cycle that were read so far.
#[derive(Debug, Default)]
struct Parts {
    control: Option<proto::ControlSample>,
    timing: Option<proto::LoopTiming>,
    drives: Option<proto::DriveStates>,
}

/// Why a record cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The container's format.
    #[error(transparent)]
    Container(#[from] mcap::McapError),
    /// A length inside a record.
    #[error(transparent)]
    Length(#[from] LengthError),
    /// A chunk.
    #[error(transparent)]
    Chunk(#[from] ChunkError),
    /// A message's format.
    #[error("{topic}: {source}")]
    Message {
        /// The topic of the message.
        topic: &'static str,
        /// Why it cannot be decoded.
        source: prost::DecodeError,
    },
    /// A message of a robot with another number of joints.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A frame that cannot be on a CAN bus.
    #[error("/can/frames: identifier {id:X}h with {length} bytes, expected at most 7FFh and 8 bytes")]
    Frame {
        /// The identifier of the frame.
        id: u32,
        /// The length of the frame, bytes.
        length: usize,
    },
    /// The metadata cannot be used.
    #[error(transparent)]
    Metadata(#[from] DescriptionError),
}

impl<const J: usize, const N: usize> Decoder<J, N> {
    /// A decoder at the beginning of a file.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a record of the file. What cannot be used becomes [`Item::Damage`].
    pub fn take(&mut self, opcode: u8, data: &[u8], emit: &mut dyn FnMut(Item<J, N>)) {
        let taken = match opcode {
            op::CHUNK => self.chunk(data, emit),
            op::FOOTER => {
                emit(Item::Closed);
                Ok(())
            }
            op::HEADER | op::CHANNEL | op::METADATA | op::MESSAGE => self.record(opcode, data, emit),
            // What is for other programs, or repeats what was read.
            _ => layout::check(opcode, data).map_err(DecodeError::from),
        };
        taken.unwrap_or_else(|error| emit(Item::Damage(error.to_string())));
    }

    fn chunk(&mut self, body: &[u8], emit: &mut dyn FnMut(Item<J, N>)) -> Result<(), DecodeError> {
        let chunk = Chunk::unpack(body)?;
        chunk.for_each(|opcode, data| {
            if matches!(opcode, op::CHANNEL | op::MESSAGE) {
                self.record(opcode, data, emit).unwrap_or_else(|error| emit(Item::Damage(error.to_string())));
            }
        })?;
        Ok(())
    }

    fn record(&mut self, opcode: u8, data: &[u8], emit: &mut dyn FnMut(Item<J, N>)) -> Result<(), DecodeError> {
        layout::check(opcode, data)?;
        self.parsed(mcap::parse_record(opcode, data)?, emit)
    }

    fn parsed(&mut self, record: Record<'_>, emit: &mut dyn FnMut(Item<J, N>)) -> Result<(), DecodeError> {
        match record {
            // The chunk that tells the channels may be damaged.
            Record::Header(header) if header.library.starts_with(LIBRARY) => {
                self.channels.extend(Topic::ALL.map(|topic| (topic.channel(), topic)));
                Ok(())
            }
            Record::Channel(channel) => {
                match Topic::from_name(&channel.topic) {
                    Some(topic) => self.channels.insert(channel.id, topic),
                    None => self.channels.remove(&channel.id),
                };
                Ok(())
            }
            Record::Metadata(metadata) => self.metadata(&metadata.name, metadata.metadata, emit),
            Record::Message { header, data } => self.message(&header, &data, emit),
            _ => Ok(()),
        }
    }

    fn metadata(&mut self, name: &str, fields: Fields, emit: &mut dyn FnMut(Item<J, N>)) -> Result<(), DecodeError> {
        match name {
            description::RUN => self.run = Some(fields),
            description::ROBOT => {
                let run = self.run.take().unwrap_or_default();
                let described = RunDescription::from_fields(run, fields)?;
                self.axis = Some(described.axis);
                emit(Item::Run(Box::new(described)));
            }
            description::MACHINE => emit(Item::Machine(fields)),
            drives::DRIVES => emit(Item::Drives(drives::drives(&fields))),
            description::PART => emit(Item::Part(description::part_number(&fields)?)),
            description::NEXT => emit(Item::Next(description::next_file(&fields)?.to_owned())),
            description::END => emit(Item::End(fields)),
            _ => {}
        }
        Ok(())
    }

    fn message(
        &mut self,
        header: &MessageHeader,
        data: &[u8],
        emit: &mut dyn FnMut(Item<J, N>),
    ) -> Result<(), DecodeError> {
        let (Some(topic), Some(axis)) = (self.channels.get(&header.channel_id).copied(), self.axis) else {
            return Ok(());
        };
        match topic {
            // For eyes: made of what is in the others.
            Topic::JointStates | Topic::Transforms | Topic::Scene => {}
            Topic::Control => self.parts.control = Some(message(topic, data)?),
            Topic::Timing => self.parts.timing = Some(message(topic, data)?),
            Topic::Drives => {
                self.parts.drives = Some(message(topic, data)?);
                if let Some(record) = self.parts.join(axis)? {
                    emit(Item::Cycle(Box::new(record)));
                }
            }
            Topic::CanFrames => emit(Item::Frame(frame(header.sequence, &message(topic, data)?, axis)?)),
            Topic::CanHealth => emit(Item::Health(Box::new(message(topic, data)?))),
            Topic::Keyframes => {
                let read: proto::Keyframe = message(topic, data)?;
                emit(Item::Keyframe(Box::new(keyframe::state(&read, axis)?), read.after_tick));
            }
            Topic::Log => emit(Item::Note(note(header.log_time, message(topic, data)?))),
            Topic::Fault => emit(Item::Fault(message(topic, data)?)),
        }
        Ok(())
    }
}

impl Parts {
    /// The record, if its three messages are there.
    fn join<const J: usize, const N: usize>(
        &mut self,
        axis: TimeAxis,
    ) -> Result<Option<CycleRecord<J, N>>, ShapeError> {
        let Self { control: Some(control), timing: Some(timing), drives: Some(drives) } = std::mem::take(self) else {
            return Ok(None);
        };
        if control.tick != timing.tick || control.tick != drives.tick {
            return Ok(None);
        }
        CycleMessages { control, timing, drives }.record(axis).map(Some)
    }
}

fn message<M: Message + Default>(topic: Topic, data: &[u8]) -> Result<M, DecodeError> {
    M::decode(data).map_err(|source| DecodeError::Message { topic: topic.name(), source })
}

fn frame(sequence: u32, message: &proto::CanFrame, axis: TimeAxis) -> Result<FrameRecord, DecodeError> {
    let wrong = || DecodeError::Frame { id: message.id, length: message.data.len() };
    let id = u16::try_from(message.id).ok().and_then(embedded_can::StandardId::new).ok_or_else(wrong)?;
    let frame = Frame::new(id, &message.data).ok_or_else(wrong)?;
    let direction = match message.direction() {
        can_frame::Direction::Sent => FrameDirection::Sent,
        can_frame::Direction::Received => FrameDirection::Received,
    };
    Ok(FrameRecord { sequence, direction, frame, at: axis.instant(message.at_ns) })
}

fn note(at: u64, log: Log) -> LoggedNote {
    use foxglove::messages::log::Level;
    let severity = match log.level() {
        Level::Error | Level::Fatal => Severity::Fatal,
        Level::Warning => Severity::Warning,
        Level::Unknown | Level::Debug | Level::Info => Severity::Info,
    };
    LoggedNote { at, severity, text: log.message }
}
