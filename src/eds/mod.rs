//! What makers' dictionaries say, for those who ask it of a drive: the check of a drive, and the emulated drive.

mod drive;
mod objects;

use std::path::Path;

use uarm_eds::{Dictionary, EdsError};

use crate::console;

pub use drive::maker_dictionary;
pub use objects::DictionaryObjects;

/// Reads an EDS or DCF file, and tells on standard error what in it cannot be read.
///
/// # Errors
/// If it is no such file.
pub fn read(file: &Path) -> Result<Dictionary, EdsError> {
    let dictionary = Dictionary::read(file)?;
    for problem in dictionary.problems() {
        console::tell(problem);
    }
    Ok(dictionary)
}
