//! Text files that people write: robot files, sets, manipulators. Bounded, whatever file is named.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The most bytes of such a file: a robot file has nine thousand.
pub const MOST_BYTES: usize = 1024 * 1024;

/// Reads a text file.
///
/// # Errors
/// If it cannot be read, has more than [`MOST_BYTES`], or is no text.
pub fn read(path: &Path) -> io::Result<String> {
    read_up_to(path, MOST_BYTES)
}

/// Reads a text file of at most `most_bytes`.
///
/// # Errors
/// If it cannot be read, has more, or is no text.
pub fn read_up_to(path: &Path, most_bytes: usize) -> io::Result<String> {
    let mut bytes = Vec::new();
    let limit = u64::try_from(most_bytes).unwrap_or(u64::MAX).saturating_add(1);
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    let invalid = |message: String| io::Error::new(io::ErrorKind::InvalidData, message);
    if bytes.len() > most_bytes {
        return Err(invalid(format!("it has more than {most_bytes} bytes, expected a text file")));
    }
    String::from_utf8(bytes).map_err(|error| {
        invalid(format!("byte {} is not UTF-8, expected a text file", error.utf8_error().valid_up_to() + 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_text_file_is_refused_in_bounded_memory() {
        let message = |path: &Path| read(path).unwrap_err().to_string();
        assert!(message(Path::new("/dev/zero")).contains("more than 1048576 bytes"));
        let path = std::env::temp_dir().join(format!("uarm-text-file-{}", std::process::id()));
        std::fs::write(&path, b"ab\xff").unwrap();
        assert_eq!(message(&path), "byte 3 is not UTF-8, expected a text file");
        std::fs::write(&path, vec![b'a'; MOST_BYTES]).unwrap();
        assert_eq!(read(&path).unwrap().len(), MOST_BYTES);
        std::fs::remove_file(path).unwrap();
    }
}
