//! Where logs go, and which is the newest.

use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use anyhow::Context;
use serde::Serialize;
use uarm_log::parts::PartStore;

use crate::output_files::as_text;

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
    fs::create_dir_all(folder)?;
    // Colons are no letters of file names everywhere.
    let time = humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace(':', "-");
    create_numbered(|suffix| folder.join(format!("{time}-{controller}{suffix}.{EXTENSION}")))
}

/// Creates the first file of a name that is not taken: without a suffix, `-2`, `-3` and so on.
fn create_numbered(path: impl Fn(&str) -> PathBuf) -> io::Result<(PathBuf, File)> {
    const MOST: u32 = 1000;
    let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
    for number in 1..=MOST {
        let path = path(&if number == 1 { String::new() } else { format!("-{number}") });
        match create(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

/// The parts of a log behind the first: `run.part2.mcap` beside `run.mcap`. Only files that this run created are deleted.
#[derive(Debug)]
pub struct LogPartFiles {
    first: PathBuf,
    left: VecDeque<OwnFile>,
    written: WrittenParts,
}

/// A file that this run created.
#[derive(Debug)]
struct OwnFile {
    path: PathBuf,
    /// Device and inode: another file of its name is not ours.
    identity: [u64; 2],
}

/// What has become of the parts of a log, seen from outside of its writer.
#[derive(Clone, Debug, Default)]
pub struct WrittenParts(Arc<Mutex<PartCount>>);

/// What has become of the parts of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PartCount {
    /// Parts that were written.
    pub written: u32,
    /// Parts of them that were deleted, the oldest.
    pub deleted: u32,
    /// The last part, if it is not the first.
    #[serde(serialize_with = "as_text")]
    pub last: Option<PathBuf>,
}

impl WrittenParts {
    /// What has become of them so far.
    pub fn count(&self) -> PartCount {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn change(&self, change: impl FnOnce(&mut PartCount)) {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl LogPartFiles {
    /// Parts behind the one in `file` at `path`.
    ///
    /// # Errors
    /// If the file cannot be asked which it is.
    pub fn behind(path: &Path, file: &File, written: WrittenParts) -> io::Result<Self> {
        written.change(|count| count.written = 1);
        let left = VecDeque::from([OwnFile::new(path, file)?]);
        Ok(Self { first: path.to_owned(), left, written })
    }
}

impl OwnFile {
    fn new(path: &Path, file: &File) -> io::Result<Self> {
        Ok(Self { path: path.to_owned(), identity: identity(&file.metadata()?) })
    }
}

fn identity(metadata: &fs::Metadata) -> [u64; 2] {
    [metadata.dev(), metadata.ino()]
}

impl PartStore for LogPartFiles {
    type Output = File;

    /// A name that is taken gets a number.
    fn create(&mut self, number: u32) -> io::Result<(File, String)> {
        let stem = self.first.file_stem().unwrap_or_default().to_string_lossy();
        let extension = self.first.extension().map(|extension| format!(".{}", extension.to_string_lossy()));
        let extension = extension.unwrap_or_default();
        let (path, file) =
            create_numbered(|suffix| self.first.with_file_name(format!("{stem}.part{number}{suffix}{extension}")))?;
        self.left.push_back(OwnFile::new(&path, &file)?);
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.written.change(|count| {
            count.written += 1;
            count.last = Some(path);
        });
        Ok((file, name))
    }

    fn delete_oldest(&mut self) -> io::Result<()> {
        let Some(OwnFile { path, identity: own }) = self.left.pop_front() else { return Ok(()) };
        let found = match fs::symlink_metadata(&path) {
            Ok(found) => found,
            // Somebody else made room already.
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(named(&path, &error)),
        };
        if identity(&found) != own {
            return Err(named(&path, &"another file has its name now"));
        }
        fs::remove_file(&path).map_err(|error| named(&path, &error))?;
        self.written.change(|count| count.deleted += 1);
        Ok(())
    }
}

fn named(path: &Path, reason: &dyn std::fmt::Display) -> io::Error {
    io::Error::other(format!("{}: {reason}", path.display()))
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
    fn parts_have_names_of_their_own_and_only_own_files_are_deleted() {
        let folder = std::env::temp_dir().join(format!("uarm-parts-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("run.mcap");
        fs::write(folder.join("run.part2.mcap"), "of another run").unwrap();
        let file = create(&path).unwrap();
        let written = WrittenParts::default();
        let mut parts = LogPartFiles::behind(&path, &file, written.clone()).unwrap();
        assert_eq!(parts.create(2).unwrap().1, "run.part2-2.mcap");
        assert_eq!(parts.create(3).unwrap().1, "run.part3.mcap");
        parts.delete_oldest().unwrap();
        assert!(!path.exists());
        // Moved away, and another put in its place.
        fs::rename(folder.join("run.part2-2.mcap"), folder.join("kept.mcap")).unwrap();
        fs::write(folder.join("run.part2-2.mcap"), "not ours").unwrap();
        let refused = parts.delete_oldest().unwrap_err().to_string();
        assert!(refused.ends_with("run.part2-2.mcap: another file has its name now"), "{refused}");
        assert_eq!(fs::read(folder.join("run.part2-2.mcap")).unwrap(), b"not ours");
        fs::remove_file(folder.join("run.part3.mcap")).unwrap();
        parts.delete_oldest().unwrap();
        assert_eq!(fs::read(folder.join("run.part2.mcap")).unwrap(), b"of another run");
        let PartCount { written, deleted, last } = written.count();
        assert_eq!((written, deleted, last), (3, 1, Some(folder.join("run.part3.mcap"))));
        fs::remove_dir_all(folder).unwrap();
    }

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
