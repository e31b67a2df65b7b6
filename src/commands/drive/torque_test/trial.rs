//! The torque trial itself: ramp up, hold, ramp down, and an end before that as soon as the joint moves too far or too fast.

use std::time::Duration;

use serde::Serialize;
use uarm_io::link::Link;
use uarm_io::time::Clock;
use uarm_loop::stop_request::StopRequest;

use crate::commands::drive::enabled::{CycleFailed, Enabled, Motion};

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

    /// Why a trial ends before its time.
    fn end(&self, motion: &Motion, stop: &StopRequest) -> Option<End> {
        if stop.is_made() {
            Some(End::Interrupted)
        } else if motion.travelled().unsigned_abs() as f64 > self.window {
            Some(End::LeftWindow)
        } else if motion.speed(self.period) > self.speed {
            Some(End::TooFast)
        } else {
            None
        }
    }
}

/// Runs the trial; the drive stays enabled, with the last torque sent.
///
/// # Errors
/// [`CycleFailed`]: anything that would end a run, and a position that does not come.
pub fn run<L: Link, C: Clock>(
    drive: &mut Enabled<'_, L, C>,
    plan: &Plan,
    stop: &StopRequest,
) -> Result<Trial, CycleFailed<L::Error>> {
    let begin = drive.tick();
    let mut motion = Motion::default();
    let mut trial = Trial { end: End::Completed, sent_per_mille: 0, travelled_counts: 0, seconds: 0.0 };
    loop {
        let torque = plan.torque(drive.tick().since(begin));
        motion.note(drive.begin_cycle(plan.period)?.position, None);
        trial.travelled_counts = motion.travelled();
        trial.seconds = drive.now().since(begin).as_secs_f64();
        let end = plan.end(&motion, stop);
        drive.network().send_torques([if end.is_some() { 0 } else { torque.unwrap_or(0) }])?;
        if let Some(end) = end.or(torque.is_none().then_some(End::Completed)) {
            trial.end = end;
            return Ok(trial);
        }
        if let Some(sent) = torque.filter(|sent| sent.abs() > trial.sent_per_mille.abs()) {
            trial.sent_per_mille = sent;
        }
        drive.end_cycle(plan.period)?;
    }
}
