//! A file of candump, read frame by frame as often as needed.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use uarm_log::candump::{self, Candump, CandumpError, Interface};
use uarm_log::regular_file;
use uarm_log::replay::one_clock::{ClockStep, OneClock, Regularity};
use uarm_loop::recording::FrameRecord;
use uarm_loop::uarm_io::drive::wire::Channel;

/// The frames of one interface, on one clock, in a file that does not change.
pub struct BusFile {
    path: PathBuf,
    interface: Option<String>,
    regularity: Regularity,
    /// The largest number that a SYNC has.
    pub largest_counter: u8,
}

/// What a file told beside its frames.
pub struct Survey {
    pub candump: Candump,
    /// Steps of the clock that stamped the frames, which are taken out.
    pub clock_steps: Vec<ClockStep>,
}

impl BusFile {
    /// Goes through the file once.
    ///
    /// # Errors
    /// If it is none of candump's, or not of one interface.
    pub fn survey(path: &Path, interface: Option<&str>, regularity: Regularity) -> anyhow::Result<(Self, Survey)> {
        let interface = interface.map(str::to_owned);
        let mut file = Self { path: path.to_owned(), interface, regularity, largest_counter: 0 };
        let mut largest = 0;
        let survey = file.each_frame(&mut |frame| {
            if Channel::of(frame.frame.id()) == Some(Channel::Sync) {
                largest = largest.max(frame.frame.data().first().copied().unwrap_or_default());
            }
        })?;
        file.largest_counter = largest;
        Ok((file, survey))
    }

    /// Gives each frame to `take`, in its order.
    ///
    /// # Errors
    /// As [`survey`](Self::survey).
    pub fn each_frame(&self, take: &mut dyn FnMut(FrameRecord)) -> anyhow::Result<Survey> {
        let mut clock = OneClock::new(self.regularity);
        let candump = read(&self.path, self.interface.as_deref(), |frame| clock.take(frame, take))?;
        Ok(Survey { candump, clock_steps: clock.finish(take) })
    }
}

/// Reads the frames as they stand in the file.
///
/// # Errors
/// If it is none of candump's, or not of one interface.
pub fn read(path: &Path, interface: Option<&str>, take: impl FnMut(FrameRecord)) -> anyhow::Result<Candump> {
    let input = BufReader::new(regular_file::open(path).with_context(|| path.display().to_string())?);
    let wanted = interface.map_or(Interface::TheOnlyOne, Interface::Named);
    candump::read(input, wanted, take).map_err(|error| match error {
        CandumpError::Interfaces(_) => anyhow!("{}: {error}: name it with --interface", path.display()),
        error => anyhow!("{}: {error}", path.display()),
    })
}
