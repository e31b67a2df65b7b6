//! The log to follow, and the wait for it.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use anyhow::{Context, ensure};

use super::state::State;
use crate::log_files::newest;
use crate::robot::shape::Shape;
use uarm_log::follow::{Follower, Growth};
use uarm_loop::stop_request::StopRequest;

/// How often a log that is not there yet is looked for.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);

/// A log and what it has told so far.
pub struct Source<const J: usize, const N: usize> {
    /// What it has told.
    pub state: State<J, N>,
    path: PathBuf,
    follower: Follower<J, N>,
}

/// The log that is meant: `file`, or the newest; with `wait` it may still be to come, and without a file is then one that
/// is newer than those there now. Nothing if `stop` was made before it came.
///
/// # Errors
/// If there is none, and none is waited for.
pub fn find(file: Option<&Path>, wait: bool, stop: &StopRequest) -> anyhow::Result<Option<PathBuf>> {
    if !wait {
        return file.map_or_else(newest, |file| Ok(file.to_owned())).map(Some);
    }
    let before = newest().ok();
    while !stop.is_made() {
        let found = match file {
            Some(file) => Some(file.to_owned()).filter(|file| file.exists()),
            None => newest().ok().filter(|newest| Some(newest) != before.as_ref()),
        };
        if found.is_some() {
            return Ok(found);
        }
        std::thread::sleep(LOOK_INTERVAL);
    }
    Ok(None)
}

impl<const J: usize, const N: usize> Source<J, N> {
    /// Opens a log.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let follower = Follower::open(path).with_context(|| path.display().to_string())?;
        Ok(Self { state: State::new(path), path: path.to_owned(), follower })
    }

    /// The shape of the robot in the log, if that is known and another one.
    pub fn other_shape(&self) -> Option<Shape> {
        self.state.shape.filter(|shape| *shape != Shape::of_joints::<J, N>())
    }

    /// Takes in what has come since the last call.
    ///
    /// # Errors
    /// If the file cannot be read, or is no log of a run.
    pub fn catch_up(&mut self) -> anyhow::Result<()> {
        let Self { state, path, follower } = self;
        while state.growth == Growth::Open {
            let caught_up = follower.catch_up(|item| state.take(item));
            state.growth = caught_up.with_context(|| path.display().to_string())?;
            if let Some(next) = state.next.take().filter(|_| state.growth == Growth::Ended) {
                *path = path.with_file_name(next);
                *follower = Follower::open(path).with_context(|| path.display().to_string())?;
                state.file.clone_from(path);
                state.growth = Growth::Open;
                continue;
            }
            state.silent_for = silence(path).with_context(|| path.display().to_string())?;
            break;
        }
        let is_log = state.run.is_some() || state.growth == Growth::Open;
        let reason = state.damage.last().map_or("no description of a run", String::as_str);
        ensure!(is_log, "{}: not a run log: {reason}", path.display());
        Ok(())
    }
}

/// How long nothing was written to the file.
fn silence(path: &Path) -> io::Result<Duration> {
    let modified = std::fs::metadata(path)?.modified()?;
    // A clock that was set back makes it none.
    Ok(SystemTime::now().duration_since(modified).unwrap_or_default())
}
