//! Files that end: a device or a pipe that is read to its end may have none.

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

/// Opens a regular file.
///
/// # Errors
/// If it cannot be opened, or is a folder, a pipe, a socket or a device; the message says what it is.
pub fn open(path: &Path) -> io::Result<File> {
    // Asked before it is opened: opening a pipe waits for its writer.
    let kind = fs::metadata(path).map_err(|error| explained(path, error))?.file_type();
    if kind.is_file() {
        return File::open(path);
    }
    let found = if kind.is_dir() {
        "a folder"
    } else if kind.is_fifo() {
        "a pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("is {found}, expected a file")))
}

/// `-` is standard input to many programs.
fn explained(path: &Path, error: io::Error) -> io::Error {
    if path == Path::new("-") && error.kind() == io::ErrorKind::NotFound {
        let message = "standard input is not read, expected a file: write it to one first";
        return io::Error::new(io::ErrorKind::NotFound, message);
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_end_is_not_opened() {
        let message = |path: &str| open(Path::new(path)).unwrap_err().to_string();
        assert_eq!(message("/dev/zero"), "is a device, expected a file");
        assert_eq!(message("/"), "is a folder, expected a file");
        assert_eq!(message("-"), "standard input is not read, expected a file: write it to one first");
        assert!(open(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))).is_ok());
        assert_eq!(open(Path::new("no/such")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
