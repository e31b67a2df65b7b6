//! Clock and link of a run, whichever they are: one loop is compiled for all, since robots differ in their joints already.

use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkError, LinkErrorKind, LinkHealth, Received};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{SocketCanError, SocketCanLink};
use uarm_io::time::{Clock, Instant};
use uarm_sim::{InProcessError, InProcessLink, VirtualClock};

use crate::simulated_plant::SimulatedPlant;
use crate::simulated_robot::SimulatedRobot;

/// The clock of a run.
#[derive(Clone, Debug)]
pub enum AnyClock {
    /// The computer's.
    Monotonic,
    /// One that passes as the loop waits.
    Virtual(VirtualClock),
}

impl Clock for AnyClock {
    fn now(&self) -> Instant {
        match self {
            Self::Monotonic => MonotonicClock.now(),
            Self::Virtual(clock) => clock.now(),
        }
    }

    fn sleep_until(&mut self, deadline: Instant) {
        match self {
            Self::Monotonic => MonotonicClock.sleep_until(deadline),
            Self::Virtual(clock) => clock.sleep_until(deadline),
        }
    }
}

/// The link of a run.
#[derive(Debug)]
#[allow(clippy::large_enum_variant)] // One of it for each run.
pub enum AnyLink<const J: usize, const N: usize> {
    /// To drives on an interface.
    Can(SocketCanLink),
    /// To a simulated robot in this process.
    Simulated(InProcessLink<SimulatedRobot<SimulatedPlant<N>, J>, AnyClock>),
}

/// What went wrong on it.
#[derive(Debug, thiserror::Error)]
pub enum AnyLinkError {
    /// On an interface.
    #[error(transparent)]
    Can(#[from] SocketCanError),
    /// In this process.
    #[error(transparent)]
    Simulated(#[from] InProcessError),
}

impl LinkError for AnyLinkError {
    fn kind(&self) -> LinkErrorKind {
        match self {
            Self::Can(error) => error.kind(),
            Self::Simulated(error) => error.kind(),
        }
    }
}

impl<const J: usize, const N: usize> Link for AnyLink<J, N> {
    type Error = AnyLinkError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, AnyLinkError> {
        Ok(match self {
            Self::Can(link) => link.send(frame)?,
            Self::Simulated(link) => link.send(frame)?,
        })
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, AnyLinkError> {
        Ok(match self {
            Self::Can(link) => link.receive(deadline)?,
            Self::Simulated(link) => link.receive(deadline)?,
        })
    }

    fn health(&self) -> LinkHealth {
        match self {
            Self::Can(link) => link.health(),
            Self::Simulated(link) => link.health(),
        }
    }
}
