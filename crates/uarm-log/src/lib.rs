//! Run logs of the control loop: MCAP files with everything that a run was, for Foxglove, for people, and for a replay to
//! the bit. Also candump and CSV files.
//!
//! A log is written in chunks of at most a quarter of a second, each handed to the operating system at once: a process that
//! is killed loses no more than that. A long run is written into several files, each of which is a log by itself.
//!
//! ```
//! use uarm_log::csv;
//! use uarm_loop::record::CycleRecord;
//!
//! let cycle = CycleRecord::<3, 2> { tick: 1, time: 0.003, ..CycleRecord::default() };
//! let mut text = Vec::new();
//! csv::write(&[cycle], &mut text)?;
//! assert!(text.starts_with(b"tick,time_s,period_s,counts_1,"));
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! # Map
//!
//! | module | subject |
//! |---|---|
//! | [`writer`] | the file, written: one [`Sink`](uarm_loop::recording::Sink) of the recording |
//! | [`parts`] | a long run in several files, of which the newest are kept |
//! | [`reader`], [`follow`] | the file, or what is left of it, read; the file, read while it grows |
//! | [`ordered`] | the file, read in order in bounded memory |
//! | [`description`] | what was run, on what machine: the metadata |
//! | [`mod@drives`] | which drives moved the robot: metadata as well |
//! | [`topic`], [`proto`] | the topics, their schemas and messages |
//! | [`cycle`], [`health`], [`keyframe`], [`shape`] | records to messages and back |
//! | [`scene`] | the robot to look at: transforms and shapes |
//! | [`time_axis`] | instants of the loop on the axis of the file |
//! | [`records`], [`chunk`], [`layout`] | the file's records, also of a damaged file, in bounded memory |
//! | [`decoder`] | what they tell |
//! | [`json_topic`] | a file of one topic with JSON messages |
//! | [`regular_file`] | files opened that end: no devices, no pipes |
//! | [`signals`], [`csv`] | the signals of a cycle by name; CSV files |
//! | [`candump`] | `candump -L` files |
//! | [`replay`] | a recorded run again, bit for bit, or another controller on its measurements |
#![forbid(unsafe_code)]

pub use uarm_loop;

pub mod candump;
pub mod chunk;
pub mod csv;
pub mod cycle;
pub mod decoder;
pub mod description;
pub mod drives;
pub mod follow;
pub mod health;
pub mod json_topic;
pub mod keyframe;
pub mod layout;
pub mod ordered;
pub mod parts;
pub mod reader;
pub mod records;
pub mod regular_file;
pub mod replay;
pub mod scene;
pub mod shape;
pub mod signals;
pub mod time_axis;
pub mod topic;
pub mod writer;

/// The messages of `proto/uarm`, as compiled; they are documented there, field by field.
#[allow(missing_docs, reason = "the fields are documented in proto/uarm")]
#[allow(clippy::all, reason = "generated")]
pub mod proto {
    include!(concat!(env!("OUT_DIR"), "/uarm.rs"));
}

/// The README's example, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
