//! The files that commands write: one rule for all of them.
//!
//! A file is new, or replaced on an explicit wish (`--force`). A file that the command reads is never written to, by whatever
//! name or link. What is written appears as a whole: it is written beside its place and then put there. Pipes and devices are
//! written to as they are. What grows as long as a command works is at its place from the beginning. (The log of a run has a rule of its own, see [`log_files`](crate::log_files): it is never replaced.)

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Whether files may be replaced, for command lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::Args)]
pub struct Force {
    /// Replace files that are there; a file that the command reads never is
    #[arg(long)]
    force: bool,
}

/// A file that is not written, and why.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// It is there.
    #[error("{}: the file exists, expected a new one (--force replaces it)", .0.display())]
    Exists(PathBuf),
    /// It is read by the same command.
    #[error("{}: it is the input {}, expected another file", file.display(), input.display())]
    IsInput {
        /// The file.
        file: PathBuf,
        /// The input that it is.
        input: PathBuf,
    },
    /// It is no name, but a sign for standard output that the option does not have.
    #[error("-: expected a file's name (/dev/stdout is standard output, ./- a file of this name)")]
    Dash,
    /// Two outputs of one command would go there.
    #[error("{}: named for two outputs, expected a file for each", .0.display())]
    Twice(PathBuf),
    /// It cannot be written.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Why not.
        source: io::Error,
    },
}

/// The outputs of a command.
#[derive(Clone, Debug)]
pub struct OutputFiles {
    force: Force,
    /// What the command reads: device, inode and name.
    inputs: Vec<([u64; 2], PathBuf)>,
}

/// What stands where an output goes.
enum Place {
    /// Nothing.
    New,
    /// A file that is replaced.
    Replaced(PathBuf, fs::Permissions),
    /// A pipe or a device.
    Stream,
}

impl OutputFiles {
    /// The outputs of a command that reads `inputs`.
    pub fn new<'a>(force: Force, inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        let input = |path: &Path| Some((identity(&fs::metadata(path).ok()?), path.to_owned()));
        Self { force, inputs: inputs.into_iter().filter_map(input).collect() }
    }

    /// Could these be written, all of them? To be asked before the work is begun.
    ///
    /// # Errors
    /// [`OutputError`] for the first that could not.
    pub fn check<'a>(&self, files: impl IntoIterator<Item = &'a Path>) -> Result<(), OutputError> {
        let mut taken = Vec::new();
        for file in files {
            match self.place(file)? {
                Place::Stream => continue,
                Place::New => check_folder(file)?,
                Place::Replaced(..) => {}
            }
            let resolved = resolved(file);
            if taken.contains(&resolved) {
                return Err(OutputError::Twice(file.to_owned()));
            }
            taken.push(resolved);
        }
        Ok(())
    }

    /// Writes a file.
    ///
    /// # Errors
    /// [`OutputError`]; whatever stood there is unchanged then.
    pub fn write(&self, file: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), OutputError> {
        let io_error = |source| refused(file, source);
        let put = |beside: Beside, target: &Path, place: &Place| -> io::Result<()> {
            match place {
                Place::Replaced(_, permissions) => {
                    fs::set_permissions(&beside.path, permissions.clone())?;
                    fs::rename(&beside.path, target)
                }
                _ => put_new(&beside.path, target),
            }
        };
        let place = self.place(file)?;
        let target = match &place {
            Place::Stream => {
                let stream = OpenOptions::new().write(true).open(file).map_err(io_error)?;
                return written(stream, write).map_err(io_error);
            }
            Place::Replaced(target, _) => target.as_path(),
            Place::New => file,
        };
        let (beside, output) = Beside::create(target).map_err(io_error)?;
        written(output, write).and_then(|()| put(beside, target, &place)).map_err(io_error)
    }

    /// Begins a file that grows while the command works, at its place.
    ///
    /// # Errors
    /// [`OutputError`]; whatever stood there is unchanged then.
    pub fn create(&self, file: &Path) -> Result<File, OutputError> {
        let mut options = OpenOptions::new();
        options.write(true);
        let opened = match self.place(file)? {
            Place::New => options.create_new(true).open(file),
            Place::Replaced(target, _) => options.truncate(true).open(target),
            Place::Stream => options.open(file),
        };
        opened.map_err(|source| refused(file, source))
    }

    fn place(&self, file: &Path) -> Result<Place, OutputError> {
        if file == Path::new("-") {
            return Err(OutputError::Dash);
        }
        let io_error = |source| OutputError::Io { file: file.to_owned(), source };
        let metadata = match fs::metadata(file) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                // A link to nothing is there, too.
                let is_link = fs::symlink_metadata(file).is_ok();
                return if is_link { Err(OutputError::Exists(file.to_owned())) } else { Ok(Place::New) };
            }
            Err(error) => return Err(io_error(error)),
        };
        if metadata.is_dir() {
            return Err(io_error(io::Error::new(io::ErrorKind::IsADirectory, "is a folder, expected a file")));
        }
        if !metadata.is_file() {
            return Ok(Place::Stream);
        }
        let input = self.inputs.iter().find(|(input, _)| *input == identity(&metadata));
        if let Some((_, input)) = input {
            return Err(OutputError::IsInput { file: file.to_owned(), input: input.clone() });
        }
        if !self.force.force {
            return Err(OutputError::Exists(file.to_owned()));
        }
        // Behind a link, what it points to is replaced.
        let target = fs::canonicalize(file).map_err(io_error)?;
        Ok(Place::Replaced(target, metadata.permissions()))
    }
}

/// A path in JSON: what of its name is no text is `U+FFFD`.
///
/// # Errors
/// Those of the serializer.
pub fn as_text<S: serde::Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&path.as_ref().map(|path| path.to_string_lossy()), serializer)
}

/// A new file needs a folder.
fn check_folder(file: &Path) -> Result<(), OutputError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let found = fs::metadata(folder).map_err(|source| refused(file, source))?;
    if found.is_dir() { Ok(()) } else { Err(refused(file, io::ErrorKind::NotADirectory.into())) }
}

fn refused(file: &Path, source: io::Error) -> OutputError {
    match source.kind() {
        io::ErrorKind::AlreadyExists => OutputError::Exists(file.to_owned()),
        _ => OutputError::Io { file: file.to_owned(), source },
    }
}

fn identity(metadata: &fs::Metadata) -> [u64; 2] {
    [metadata.dev(), metadata.ino()]
}

/// The file by one name, whether it is there or not.
fn resolved(file: &Path) -> PathBuf {
    fs::canonicalize(file).unwrap_or_else(|_| {
        let folder = folder_of(file);
        let name = file.file_name().unwrap_or_default();
        fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned()).join(name)
    })
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn written(output: File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut output = BufWriter::new(output);
    write(&mut output)?;
    output.flush()
}

/// Puts a file where there is none.
fn put_new(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        // A file system without hard links.
        Err(_) if fs::symlink_metadata(to).is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(from, to),
    }
}

/// A file that is being written beside its place; gone with this value.
struct Beside {
    path: PathBuf,
}

impl Beside {
    fn create(target: &Path) -> io::Result<(Self, File)> {
        let mut name = OsString::from(".");
        name.push(target.file_name().unwrap_or_default());
        name.push(format!(".{}.part", std::process::id()));
        let path = folder_of(target).join(name);
        // Left by another process of this number.
        let _ = fs::remove_file(&path);
        let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
        Ok((Self { path }, file))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // After a rename it is not there any more.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("uarm-output-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            fs::create_dir_all(&path).unwrap();
            fs::write(path.join("input"), "input").unwrap();
            Self(path)
        }

        fn path(&self, name: &str) -> PathBuf {
            self.0.join(name)
        }

        fn outputs(&self, force: bool) -> OutputFiles {
            OutputFiles::new(Force { force }, [self.path("input").as_path()])
        }

        fn names(&self) -> Vec<String> {
            let entries = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
            let mut names: Vec<_> = entries.collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn hello(output: &mut dyn Write) -> io::Result<()> {
        output.write_all(b"hello")
    }

    #[test]
    fn a_file_is_new_or_replaced_on_a_wish() {
        let folder = Folder::new("new");
        let file = folder.path("file");
        folder.outputs(false).write(&file, hello).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"hello");
        fs::write(&file, "kept").unwrap();
        let refused = folder.outputs(false).write(&file, hello).unwrap_err();
        assert!(matches!(refused, OutputError::Exists(_)), "{refused}");
        assert_eq!(fs::read(&file).unwrap(), b"kept");
        folder.outputs(true).write(&file, hello).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"hello");
        assert_eq!(folder.names(), ["file", "input"], "nothing is left beside them");
    }

    #[test]
    fn a_file_that_grows_is_new_or_replaced_on_a_wish() {
        let folder = Folder::new("grows");
        let file = folder.path("file");
        folder.outputs(false).create(&file).unwrap().write_all(b"a long text").unwrap();
        assert!(matches!(folder.outputs(false).create(&file), Err(OutputError::Exists(_))));
        assert_eq!(fs::read(&file).unwrap(), b"a long text");
        folder.outputs(true).create(&file).unwrap().write_all(b"short").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"short");
        assert!(matches!(folder.outputs(true).create(&folder.path("input")), Err(OutputError::IsInput { .. })));
        folder.outputs(false).create(Path::new("/dev/null")).unwrap();
    }

    #[test]
    fn an_input_is_never_written_to_by_whatever_name() {
        let folder = Folder::new("input");
        symlink(folder.path("input"), folder.path("link")).unwrap();
        symlink("link", folder.path("link-to-link")).unwrap();
        fs::hard_link(folder.path("input"), folder.path("hard-link")).unwrap();
        for name in ["input", "link", "link-to-link", "hard-link", "../INSIDE/input"] {
            let name = name.replace("INSIDE", folder.0.file_name().unwrap().to_str().unwrap());
            for force in [false, true] {
                let outputs = folder.outputs(force);
                let refused = outputs.write(&folder.path(&name), hello).unwrap_err();
                assert!(matches!(refused, OutputError::IsInput { .. }), "{name}: {refused}");
                assert!(outputs.check([folder.path(&name).as_path()]).is_err());
                assert_eq!(fs::read(folder.path("input")).unwrap(), b"input");
            }
        }
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_what_was_there() {
        let folder = Folder::new("whole");
        let file = folder.path("file");
        fs::write(&file, "kept").unwrap();
        let fails = |output: &mut dyn Write| output.write_all(b"half").and(Err(io::Error::other("the disk is full")));
        let error = folder.outputs(true).write(&file, fails).unwrap_err().to_string();
        assert!(error.ends_with("file: the disk is full"), "{error}");
        assert_eq!(fs::read(&file).unwrap(), b"kept");
        assert!(folder.outputs(false).write(&folder.path("other"), fails).is_err());
        assert_eq!(folder.names(), ["file", "input"]);
    }

    #[test]
    fn links_to_other_files_stay_links() {
        let folder = Folder::new("links");
        fs::write(folder.path("target"), "old").unwrap();
        symlink("target", folder.path("link")).unwrap();
        symlink("nothing", folder.path("dangling")).unwrap();
        for name in ["link", "dangling"] {
            let refused = folder.outputs(false).write(&folder.path(name), hello).unwrap_err();
            assert!(matches!(refused, OutputError::Exists(_)), "{refused}");
        }
        folder.outputs(true).write(&folder.path("link"), hello).unwrap();
        assert!(fs::symlink_metadata(folder.path("link")).unwrap().is_symlink());
        assert_eq!(fs::read(folder.path("target")).unwrap(), b"hello");
    }

    #[test]
    fn devices_are_written_to_and_folders_refused() {
        let folder = Folder::new("devices");
        folder.outputs(false).write(Path::new("/dev/null"), hello).unwrap();
        assert!(matches!(folder.outputs(true).write(&folder.0, hello), Err(OutputError::Io { .. })));
        let full = folder.outputs(false).write(Path::new("/dev/full"), hello).unwrap_err();
        assert!(full.to_string().starts_with("/dev/full: "), "{full}");
    }

    #[test]
    fn two_outputs_are_two_files() {
        let folder = Folder::new("two");
        let (one, other) = (folder.path("one"), folder.0.join(".").join("one"));
        let refused = folder.outputs(true).check([one.as_path(), other.as_path()]).unwrap_err();
        assert!(matches!(refused, OutputError::Twice(_)), "{refused}");
        folder.outputs(true).check([one.as_path(), folder.path("two").as_path()]).unwrap();
    }
}
