//! Where logs go, and which is the newest.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::SystemTime;

use anyhow::Context;

/// The folder of logs that nobody named.
pub const FOLDER: &str = "runs";
/// What their names end with.
pub const EXTENSION: &str = "mcap";

/// What the command line says about the log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum LogChoice {
    /// `runs/<time>-<controller>.mcap`.
    #[default]
    Default,
    /// A file of this name, which must not be there yet.
    File(PathBuf),
    /// The run is not recorded.
    None,
}

impl FromStr for LogChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "none" => Ok(Self::None),
            "" | "-" | "off" | "no" | "false" => {
                Err("expected the name of a new file, or none (./off is a file of that name)".to_owned())
            }
            file => Ok(Self::File(file.into())),
        }
    }
}

impl LogChoice {
    /// Creates the log of a run with `controller`; nothing if none is wanted.
    ///
    /// # Errors
    /// If the file cannot be created, or is there already: a log is never overwritten.
    pub fn create(&self, controller: &str) -> anyhow::Result<Option<(PathBuf, File)>> {
        match self {
            Self::None => Ok(None),
            Self::File(path) => {
                let file = create(path).with_context(|| format!("--log {}", path.display()))?;
                Ok(Some((path.clone(), file)))
            }
            Self::Default => create_default(Path::new(FOLDER), controller)
                .with_context(|| format!("the log in {FOLDER}/ (--log FILE writes it elsewhere, --log none nowhere)"))
                .map(Some),
        }
    }
}

/// Pipes and devices are opened as they are.
fn create(path: &Path) -> io::Result<File> {
    let is_new_or_regular = fs::metadata(path).map_or(true, |metadata| metadata.is_file());
    OpenOptions::new().write(true).create_new(is_new_or_regular).open(path).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => io::Error::new(error.kind(), "the file exists, and a log is never overwritten"),
        _ => error,
    })
}

/// Runs that begin in the same second are numbered.
fn create_default(folder: &Path, controller: &str) -> io::Result<(PathBuf, File)> {
    const MOST_IN_A_SECOND: u32 = 1000;
    fs::create_dir_all(folder)?;
    // Colons are no letters of file names everywhere.
    let time = humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace(':', "-");
    let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
    for number in 1..=MOST_IN_A_SECOND {
        let suffix = if number == 1 { String::new() } else { format!("-{number}") };
        let path = folder.join(format!("{time}-{controller}{suffix}.{EXTENSION}"));
        match create(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

/// The newest log in the folder of logs that nobody named.
///
/// # Errors
/// If there is none.
pub fn newest() -> anyhow::Result<PathBuf> {
    let none = || format!("no log in {FOLDER}/: name a file");
    let entries = fs::read_dir(FOLDER).with_context(none)?;
    let logs = entries.filter_map(Result::ok).map(|entry| entry.path());
    let logs = logs.filter(|path| path.extension().is_some_and(|extension| extension == EXTENSION));
    let modified = |path: &PathBuf| fs::metadata(path).and_then(|metadata| metadata.modified()).ok();
    logs.max_by_key(modified).with_context(none)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_log_is_overwritten() {
        let folder = std::env::temp_dir().join(format!("uarm-place-{}", std::process::id()));
        let (first, _) = create_default(&folder, "fuzzy").unwrap();
        let (second, _) = create_default(&folder, "fuzzy").unwrap();
        assert_ne!(first, second);
        assert!(first.to_string_lossy().ends_with("-fuzzy.mcap"), "{}", first.display());
        let error = LogChoice::File(first.clone()).create("fuzzy").unwrap_err();
        assert!(format!("{error:#}").contains("never overwritten"), "{error:#}");
        assert!(LogChoice::File("/dev/null".into()).create("fuzzy").unwrap().is_some());
        assert!(LogChoice::None.create("fuzzy").unwrap().is_none());
        for mistake in ["-", "off", ""] {
            assert!(mistake.parse::<LogChoice>().unwrap_err().contains("or none"), "{mistake}");
        }
        assert_eq!("./off".parse(), Ok(LogChoice::File("./off".into())));
        fs::remove_dir_all(folder).unwrap();
    }
}
