//! What makers' dictionaries say, for those who ask it of a drive: the check of a drive, and the emulated drive.

mod drive;
mod objects;
mod readings;

use std::path::Path;

use anyhow::Context;
use uarm_eds::{Dictionary, LARGEST_FILE};

use crate::console;
use crate::text_file;

pub use drive::maker_dictionary;
pub use objects::DictionaryObjects;
pub use readings::{good_readings, unstated, with_good_readings};

/// Reads an EDS or DCF file, and tells on standard error what in it cannot be read.
///
/// # Errors
/// If it cannot be read, or is no such file.
pub fn read(file: &Path) -> anyhow::Result<Dictionary> {
    let name = file.display().to_string();
    let bytes = text_file::read_bytes_up_to(file, LARGEST_FILE).with_context(|| name.clone())?;
    let dictionary = Dictionary::parse(&name, &bytes)?;
    for problem in dictionary.problems() {
        console::tell(problem);
    }
    Ok(dictionary)
}
