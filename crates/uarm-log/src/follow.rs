//! The file, read while it grows.

use std::fs::File;
use std::io;
use std::path::Path;

use crate::decoder::{Decoder, Item};
use crate::records::{self, Records, Step};
use crate::regular_file;

/// Follows a log of a robot with `J` joints of which `N` are active.
pub struct Follower<const J: usize, const N: usize> {
    records: Records<File>,
    decoder: Decoder<J, N>,
}

/// What a look at the file's end found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// The file may grow.
    Open,
    /// The file is complete, or cannot be read any further.
    Ended,
}

impl<const J: usize, const N: usize> Follower<J, N> {
    /// Opens a log.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self { records: Records::new(regular_file::open(path)?), decoder: Decoder::new() })
    }

    /// Gives what has come since the last call.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn catch_up(&mut self, mut emit: impl FnMut(Item<J, N>)) -> io::Result<Growth> {
        loop {
            let decoder = &mut self.decoder;
            match self.records.step(|opcode, data| decoder.take(opcode, data, &mut emit))? {
                Step::Record => {}
                Step::Starved => return Ok(Growth::Open),
                Step::End => return Ok(Growth::Ended),
                Step::Checksum { section, .. } => emit(Item::Damage(records::checksum_damage(section))),
                Step::Broken(broken) => {
                    emit(Item::Damage(broken.to_string()));
                    if self.records.find_next()?.is_none() {
                        return Ok(Growth::Ended);
                    }
                }
            }
        }
    }
}
