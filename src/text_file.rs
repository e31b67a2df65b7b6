//! Text files that people write: robot files, sets, manipulators. Bounded, whatever file is named.

use std::io::{self, Read};
use std::path::Path;

use uarm_log::regular_file;

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
    String::from_utf8(read_bytes_up_to(path, most_bytes)?).map_err(|error| {
        invalid(format!("byte {} is not UTF-8, expected a text file", error.utf8_error().valid_up_to() + 1))
    })
}

/// Reads a file of at most `most_bytes`, in whatever characters it is written.
///
/// # Errors
/// If it cannot be read, is a pipe or a device, or has more.
pub fn read_bytes_up_to(path: &Path, most_bytes: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let limit = u64::try_from(most_bytes).unwrap_or(u64::MAX).saturating_add(1);
    regular_file::open(path)?.take(limit).read_to_end(&mut bytes)?;
    if bytes.len() > most_bytes {
        return Err(invalid(format!("it has more than {most_bytes} bytes, expected a text file")));
    }
    Ok(bytes)
}

fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_text_file_is_refused_in_bounded_memory() {
        let message = |path: &Path| read(path).unwrap_err().to_string();
        assert_eq!(message(Path::new("/dev/zero")), "is a device, expected a file");
        let path = std::env::temp_dir().join(format!("uarm-text-file-{}", std::process::id()));
        std::fs::write(&path, b"ab\xff").unwrap();
        assert_eq!(message(&path), "byte 3 is not UTF-8, expected a text file");
        std::fs::write(&path, vec![b'a'; MOST_BYTES + 1]).unwrap();
        assert!(message(&path).contains("more than 1048576 bytes"));
        std::fs::write(&path, vec![b'a'; MOST_BYTES]).unwrap();
        assert_eq!(read(&path).unwrap().len(), MOST_BYTES);
        std::fs::remove_file(path).unwrap();
    }
}
