//! The torque trial itself: ramp up, hold, ramp down, and an end before that as soon as the joint moves too far or too fast.

use std::time::Duration;

use serde::Serialize;
use uarm_io::drive::DriveNetwork;
use uarm_io::drive::network::{CycleError, StopReport};
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};
use uarm_loop::stop_request::StopRequest;

/// Cycles over which the joint's speed is taken: a count in one cycle is no speed.
const SPEED_CYCLES: usize = 16;

/// What is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The torque, per mille as 6071h has it, in the drive's own sense.
    pub per_mille: i16,
    /// Time from zero to it, and back.
    pub ramp: Duration,
    /// How long it is held.
    pub hold: Duration,
    /// Time of a cycle.
    pub period: Duration,
    /// Counts from the start, either way, at which the trial ends.
    pub window: f64,
    /// Counts per second, either way, at which the trial ends.
    pub speed: f64,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The whole profile was run.
    Completed,
    /// The joint went as far as the window.
    LeftWindow,
    /// The joint got as fast as the limit.
    TooFast,
    /// Somebody asked for the end.
    Interrupted,
}

/// What came of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// How it ended.
    pub end: End,
    /// The largest torque that was sent, per mille, with its sign.
    pub sent_per_mille: i16,
    /// Counts from the first to the last reading.
    pub travelled_counts: i64,
    /// Time from the first SYNC to the end, s.
    pub seconds: f64,
}

impl Plan {
    /// The torque at `time`; `None` after the end.
    fn torque(&self, time: Duration) -> Option<i16> {
        let down = self.ramp + self.hold;
        let share = if time < self.ramp {
            time.as_secs_f64() / self.ramp.as_secs_f64()
        } else if time <= down {
            1.0
        } else if time < down + self.ramp {
            1.0 - (time - down).as_secs_f64() / self.ramp.as_secs_f64()
        } else {
            return None;
        };
        Some((f64::from(self.per_mille) * share).round() as i16)
    }
}

/// A drive in *Operation enabled*; brakes when it goes, whatever the reason.
pub struct Enabled<'a, L: Link, C: Clock> {
    network: &'a mut DriveNetwork<L, 1>,
    clock: &'a mut C,
    stopped: bool,
}

impl<'a, L: Link, C: Clock> Enabled<'a, L, C> {
    /// Takes a network over that was started, or whose start failed half-way.
    pub const fn new(network: &'a mut DriveNetwork<L, 1>, clock: &'a mut C) -> Self {
        Self { network, clock, stopped: false }
    }

    /// Torque 0, quick stop, power off, NMT stop.
    pub fn stop(mut self) -> StopReport<1> {
        self.stopped = true;
        self.network.stop(self.clock)
    }

    /// Runs the trial; the drive stays enabled, with the last torque sent.
    ///
    /// # Errors
    /// [`TrialError`]: anything that would end a run, and a position that does not come.
    pub fn run(&mut self, plan: &Plan, stop: &StopRequest) -> Result<Trial, TrialError<L::Error>> {
        let begin = self.clock.now();
        let mut tick = begin;
        let mut first = None;
        let mut recent = [0_i64; SPEED_CYCLES];
        let mut trial = Trial { end: End::Completed, sent_per_mille: 0, travelled_counts: 0, seconds: 0.0 };
        for cycle in 0_usize.. {
            let position = self.cycle_position(tick, plan)?;
            let first = *first.get_or_insert(position);
            let travelled = i64::from(position.wrapping_sub(first));
            let before = std::mem::replace(&mut recent[cycle % SPEED_CYCLES], travelled);
            let speed = if cycle < SPEED_CYCLES { 0 } else { travelled - before };
            trial.travelled_counts = travelled;
            trial.seconds = self.clock.now().since(begin).as_secs_f64();
            let span = plan.period.as_secs_f64() * SPEED_CYCLES as f64;
            let end = if stop.is_made() {
                Some(End::Interrupted)
            } else if travelled.unsigned_abs() as f64 > plan.window {
                Some(End::LeftWindow)
            } else if speed.unsigned_abs() as f64 > plan.speed * span {
                Some(End::TooFast)
            } else {
                None
            };
            let torque = plan.torque(tick.since(begin));
            self.network.send_torques([if end.is_some() { 0 } else { torque.unwrap_or(0) }])?;
            self.network.housekeeping(self.clock.now())?;
            if let Some(end) = end.or(torque.is_none().then_some(End::Completed)) {
                trial.end = end;
                break;
            }
            if let Some(sent) = torque.filter(|sent| sent.abs() > trial.sent_per_mille.abs()) {
                trial.sent_per_mille = sent;
            }
            tick = tick + plan.period;
            self.clock.sleep_until(tick);
        }
        Ok(trial)
    }

    /// SYNC, and the position that belongs to it.
    fn cycle_position(&mut self, tick: Instant, plan: &Plan) -> Result<i32, TrialError<L::Error>> {
        self.network.sync()?;
        // A late tick must still find its answer.
        let deadline = tick.max(self.clock.now()) + plan.period;
        let [position] = self.network.collect(deadline)?.positions;
        position.ok_or(TrialError::NoPosition)
    }
}

/// Why a trial ended that should have gone on.
#[derive(Debug, thiserror::Error)]
pub enum TrialError<E> {
    /// Bus or drive failed.
    #[error(transparent)]
    Cycle(#[from] CycleError<E>),
    /// The drive did not answer a SYNC.
    #[error("the drive sent no position in time for a SYNC")]
    NoPosition,
}

impl<L: Link, C: Clock> Drop for Enabled<'_, L, C> {
    fn drop(&mut self) {
        if !self.stopped {
            let _ = self.network.stop(self.clock);
        }
    }
}
