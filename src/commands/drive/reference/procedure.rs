//! The homing procedure itself: the drive is told to start, and watched until it says that it is done.

use std::time::Duration;

use uarm_io::drive::cia402::{Command, Controlword, HomingState, Statusword};
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};
use uarm_loop::stop_request::StopRequest;

use crate::commands::drive::enabled::{CycleFailed, Enabled, Motion};

/// Cycles between *Operation enabled* and the start: the drive shows what it says of an earlier homing.
const LEAD_CYCLES: u32 = 5;
/// After so long, a method that does not move the motor has been carried out, and an error is one of this procedure.
const SETTLED: Duration = Duration::from_millis(100);
/// A step so many times larger than the velocity limit allows is none of the joint: the drive has set its counter anew.
const JUMP_FACTOR: f64 = 4.0;
/// Counts by which it must be larger at least.
const LEAST_JUMP: u32 = 16;

/// What is watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watch {
    /// The node id, for messages.
    pub node: u8,
    /// Time of a cycle.
    pub period: Duration,
    /// Counts from the start, either way, at which it ends.
    pub travel: f64,
    /// Counts per second, either way, at which it ends.
    pub speed: f64,
    /// The longest that it may take.
    pub timeout: Duration,
    /// Whether the method moves the motor.
    pub motor: Motor,
}

/// What a method does with the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motor {
    /// It turns it.
    Turns,
    /// It takes the present position for home.
    Stays,
}

impl Motor {
    /// Of a method of CiA 402.
    pub const fn of(method: i8) -> Self {
        match method {
            35 | 37 => Self::Stays,
            _ => Self::Turns,
        }
    }
}

/// Why a procedure did not end well.
#[derive(Debug, thiserror::Error)]
pub enum HomingError<E> {
    /// Bus or drive failed.
    #[error(transparent)]
    Cycle(#[from] CycleFailed<E>),
    /// Bit 13 of the statusword.
    #[error(
        "node {node} reports a homing error (bit 13 of the statusword {statusword:04X}h): it did not find home as method and switches are"
    )]
    Failed {
        /// The node id.
        node: u8,
        /// 6041h.
        statusword: u16,
    },
    /// It took too long.
    #[error(
        "node {node} is not home after {timeout:?} (statusword {statusword:04X}h, {travelled:+} counts from the start): encoder.homing.timeout_s is too short, or home was not found"
    )]
    TimedOut {
        /// The node id.
        node: u8,
        /// The time that it had.
        timeout: Duration,
        /// 6041h.
        statusword: u16,
        /// Counts from the start.
        travelled: i64,
    },
    /// The joint went further than the robot file allows.
    #[error(
        "node {node} moved by {travelled:+} counts and is not home, expected at most {most:.0} (encoder.homing.travel_deg)"
    )]
    TooFar {
        /// The node id.
        node: u8,
        /// Counts from the start.
        travelled: i64,
        /// The most that is allowed.
        most: f64,
    },
    /// The joint was faster than the robot file allows.
    #[error(
        "node {node} turned at {speed:.0} counts per second, expected at most {most:.0} (limits.velocity_deg_per_s): are encoder.homing.speeds in its unit?"
    )]
    TooFast {
        /// The node id.
        node: u8,
        /// Counts per second.
        speed: f64,
        /// The most that is allowed.
        most: f64,
    },
    /// The counter was set anew more than once.
    #[error("node {node}: 6064h jumped by {jump:+} counts again: its encoder cannot be followed")]
    Jumped {
        /// The node id.
        node: u8,
        /// The second jump, counts.
        jump: i32,
    },
    /// Somebody asked for the end.
    #[error("interrupted")]
    Interrupted,
}

/// Lets the drive home; it stays enabled.
///
/// # Errors
/// [`HomingError`].
pub fn run<L: Link, C: Clock>(
    drive: &mut Enabled<'_, L, C>,
    watch: &Watch,
    stop: &StopRequest,
) -> Result<(), HomingError<L::Error>> {
    let mut progress = Progress::new(watch, drive.tick());
    loop {
        let seen = drive.begin_cycle(watch.period)?;
        if stop.is_made() {
            return Err(HomingError::Interrupted);
        }
        if progress.note(seen.position, seen.statusword, drive.tick())? == Stage::Home {
            return Ok(());
        }
        let command = progress.command(drive.tick());
        drive.network().send_controlwords([command]).map_err(CycleFailed::from)?;
        drive.end_cycle(watch.period)?;
    }
}

/// Where a procedure is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    UnderWay,
    Home,
}

/// What was seen of it so far.
struct Progress<'a> {
    watch: &'a Watch,
    begin: Instant,
    cycles: u32,
    started: Option<Instant>,
    motion: Motion,
    jumped: bool,
    /// What the drive said before the start, until it says something else: that was of an earlier procedure.
    stale: Option<HomingState>,
}

impl<'a> Progress<'a> {
    fn new(watch: &'a Watch, begin: Instant) -> Self {
        Self { watch, begin, cycles: 0, started: None, motion: Motion::default(), jumped: false, stale: None }
    }

    fn note<E>(&mut self, position: i32, statusword: Statusword, tick: Instant) -> Result<Stage, HomingError<E>> {
        let Watch { node, period, travel, speed, timeout, .. } = *self.watch;
        let state = statusword.homing();
        let (statusword, passed) = (statusword.bits(), tick.since(self.begin));
        let jump = self.motion.note(position, Some(self.largest_step()));
        if let Some(jump) = jump.filter(|_| core::mem::replace(&mut self.jumped, true)) {
            return Err(HomingError::Jumped { node, jump });
        }
        match (self.started, state) {
            (None, _) => self.stale = Some(state),
            (Some(started), _) if !self.is_of_this(state, tick.since(started)) => {}
            (Some(_), HomingState::Failed) => return Err(HomingError::Failed { node, statusword }),
            (Some(_), HomingState::Done) => return Ok(Stage::Home),
            (Some(_), HomingState::Running | HomingState::Idle | HomingState::Attained) => {}
        }
        let travelled = self.motion.travelled();
        if travelled.unsigned_abs() as f64 > travel {
            return Err(HomingError::TooFar { node, travelled, most: travel });
        }
        let found = self.motion.speed(period);
        if found > speed {
            return Err(HomingError::TooFast { node, speed: found, most: speed });
        }
        if passed > timeout {
            return Err(HomingError::TimedOut { node, timeout, statusword, travelled });
        }
        self.cycles += 1;
        Ok(Stage::UnderWay)
    }

    /// Whether `state` tells of this procedure, so long after its start, and not of the one before it.
    fn is_of_this(&mut self, state: HomingState, since_start: Duration) -> bool {
        if self.stale.is_some_and(|stale| stale != state) {
            self.stale = None;
        }
        let settles = match state {
            HomingState::Failed => true,
            _ => self.watch.motor == Motor::Stays,
        };
        self.stale.is_none() || settles && since_start >= SETTLED
    }

    /// The controlword of this cycle.
    fn command(&mut self, tick: Instant) -> Controlword {
        let enabled = Controlword::of(Command::EnableOperation);
        if self.cycles < LEAD_CYCLES {
            return enabled;
        }
        self.started.get_or_insert(tick);
        enabled.with(Controlword::HOMING_START)
    }

    fn largest_step(&self) -> u32 {
        let counts = self.watch.speed * self.watch.period.as_secs_f64() * JUMP_FACTOR;
        (counts.ceil() as u32).saturating_add(LEAST_JUMP)
    }
}

#[cfg(test)]
mod tests;
