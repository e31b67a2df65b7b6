//! Run logs: MCAP files with everything that a run was, for Foxglove, for `uarm show`, and for a replay to the bit.
//!
//! | module | subject |
//! |---|---|
//! | [`topic`] | the topics and their schemas |
//! | [`time_axis`] | instants of the loop on the axis of the file |
//! | [`description`] | what was run, on what machine: the metadata |
//! | [`cycle`], [`health`], [`keyframe`] | records to messages and back |
//! | [`scene`] | the robot to look at: transforms and shapes |
//! | [`place`] | where a log goes |
//! | [`writer`] | the file, written |
//! | [`records`], [`decoder`] | the file's records, and what they tell |
//! | [`reader`] | the file, or what is left of it, read |
//! | [`follow`] | the file, read while it grows |
//! | [`candump`] | `candump -L` files |
//!
//! A log is written in chunks of at most a quarter of a second, each handed to the operating system at once: a process that
//! is killed loses no more than that.

pub mod candump;
pub mod cycle;
pub mod decoder;
pub mod description;
pub mod follow;
pub mod health;
pub mod keyframe;
pub mod place;
pub mod reader;
pub mod records;
pub mod scene;
pub mod time_axis;
pub mod topic;
pub mod writer;

/// The messages of `proto/uarm`, as compiled.
#[allow(missing_docs, reason = "the fields are documented in proto/uarm where they need it")]
#[allow(clippy::all, reason = "generated")]
pub mod proto {
    include!(concat!(env!("OUT_DIR"), "/uarm.rs"));
}
