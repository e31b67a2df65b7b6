//! Disks as bad as a test needs them: one that is soon full, and a pipe whose reader is slow or stands still.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::process::succeed;

/// A file system in memory with little room. Mounting it needs root, which a guest gives.
pub struct SmallDisk(PathBuf);

impl SmallDisk {
    /// Mounts one of `kibibytes` at `folder`, which must not exist.
    pub fn mount(folder: PathBuf, kibibytes: u32) -> Self {
        std::fs::create_dir(&folder).unwrap();
        let size = format!("size={kibibytes}k");
        succeed(Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(&folder));
        Self(folder)
    }

    /// A path on it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        succeed(Command::new("umount").arg(&self.0));
    }
}

/// How fast a pipe is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    Unlimited,
    BytesPerSecond(u32),
    Stopped,
}

impl Pace {
    const UNLIMITED: u32 = u32::MAX;
    const STOPPED: u32 = 0;

    const fn to_raw(self) -> u32 {
        match self {
            Self::Unlimited => Self::UNLIMITED,
            Self::BytesPerSecond(rate) => rate,
            Self::Stopped => Self::STOPPED,
        }
    }

    const fn from_raw(raw: u32) -> Self {
        match raw {
            Self::UNLIMITED => Self::Unlimited,
            Self::STOPPED => Self::Stopped,
            rate => Self::BytesPerSecond(rate),
        }
    }
}

/// What is read at once: a page. A pipe holds sixteen of them.
const PIECE: usize = 4096;
/// How often a reader that stands still looks whether it may go on: seldom, since a guest has one processor.
const LOOK: Duration = Duration::from_millis(20);

/// A pipe with a name, and a thread that reads it.
pub struct Pipe {
    path: PathBuf,
    pace: Arc<AtomicU32>,
    reader: JoinHandle<Vec<u8>>,
}

impl Pipe {
    /// Makes one at `path`.
    pub fn new(path: PathBuf, pace: Pace) -> Self {
        succeed(Command::new("mkfifo").arg(&path));
        let pace = Arc::new(AtomicU32::new(pace.to_raw()));
        let reader = thread::spawn({
            let (path, pace) = (path.clone(), Arc::clone(&pace));
            move || read(&path, &pace)
        });
        Self { path, pace, reader }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads on at another pace.
    pub fn set(&self, pace: Pace) {
        self.pace.store(pace.to_raw(), Ordering::Relaxed);
    }

    /// Reads to the end, and gives all that came through.
    pub fn into_bytes(self) -> Vec<u8> {
        self.set(Pace::Unlimited);
        self.reader.join().unwrap()
    }
}

fn read(path: &Path, pace: &AtomicU32) -> Vec<u8> {
    let mut pipe = File::open(path).unwrap();
    let (mut all, mut piece) = (Vec::new(), [0; PIECE]);
    loop {
        match Pace::from_raw(pace.load(Ordering::Relaxed)) {
            Pace::Stopped => {
                thread::sleep(LOOK);
                continue;
            }
            Pace::BytesPerSecond(rate) => thread::sleep(Duration::from_secs_f64(PIECE as f64 / f64::from(rate))),
            Pace::Unlimited => {}
        }
        match pipe.read(&mut piece).unwrap() {
            0 => return all,
            length => all.extend_from_slice(&piece[..length]),
        }
    }
}
