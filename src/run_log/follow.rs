//! The file, read while it grows.

use std::fs::File;
use std::io;
use std::path::Path;

use super::decoder::{Decoder, Item};
use super::records::{Records, Step};

/// Follows a log.
pub struct Follower {
    records: Records<File>,
    decoder: Decoder,
}

/// What a look at the file's end found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// The file may grow.
    Open,
    /// It will not.
    Ended,
}

impl Follower {
    /// Opens a log.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self { records: Records::new(File::open(path)?), decoder: Decoder::new(path) })
    }

    /// Gives what has come since the last call.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn catch_up(&mut self, mut emit: impl FnMut(Item)) -> io::Result<Growth> {
        loop {
            let decoder = &mut self.decoder;
            match self.records.step(|opcode, data| decoder.take(opcode, data, &mut emit))? {
                Step::Record => {}
                Step::Starved => return Ok(Growth::Open),
                Step::End => return Ok(Growth::Ended),
                Step::Broken(error) => {
                    emit(Item::Damage(error.to_string()));
                    return Ok(Growth::Ended);
                }
            }
        }
    }
}
