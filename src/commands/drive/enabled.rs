//! One drive in *Operation enabled*, for the steps of commissioning that move a motor: its cycle, and the braking at its end.

use std::time::Duration;

use anyhow::Context;
use uarm_io::drive::DriveNetwork;
use uarm_io::drive::cia402::Statusword;
use uarm_io::drive::network::{CycleError, StopReport};
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};

/// Cycles over which a joint's speed is taken: a count in one cycle is no speed.
const SPEED_CYCLES: usize = 16;

/// A drive in *Operation enabled*; brakes when it goes, whatever the reason.
pub struct Enabled<'a, L: Link, C: Clock> {
    network: &'a mut DriveNetwork<L, 1>,
    clock: &'a mut C,
    tick: Instant,
    stopped: bool,
}

/// What a drive answered to a SYNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// 6064h.
    pub position: i32,
    /// 6041h.
    pub statusword: Statusword,
}

impl<'a, L: Link, C: Clock> Enabled<'a, L, C> {
    /// Takes a network over that was started, or whose start failed half-way.
    pub fn new(network: &'a mut DriveNetwork<L, 1>, clock: &'a mut C) -> Self {
        let tick = clock.now();
        Self { network, clock, tick, stopped: false }
    }

    /// Torque 0, quick stop, power off, NMT stop.
    pub fn stop(mut self) -> StopReport<1> {
        self.stopped = true;
        self.network.stop(self.clock)
    }

    /// When the present cycle began, or should have.
    pub const fn tick(&self) -> Instant {
        self.tick
    }

    /// What time it is.
    pub fn now(&self) -> Instant {
        self.clock.now()
    }

    /// The drive's master.
    pub const fn network(&mut self) -> &mut DriveNetwork<L, 1> {
        self.network
    }

    /// Begins a cycle of `period`: SYNC, and the answer that belongs to it.
    ///
    /// # Errors
    /// [`CycleFailed`].
    pub fn begin_cycle(&mut self, period: Duration) -> Result<Seen, CycleFailed<L::Error>> {
        self.network.sync()?;
        // A late tick must still find its answer.
        let deadline = self.tick.max(self.clock.now()) + period;
        let feedback = self.network.collect(deadline)?;
        let ([position], [statusword]) = (feedback.positions, feedback.statuswords);
        Ok(Seen { position: position.ok_or(CycleFailed::NoPosition)?, statusword })
    }

    /// Ends a cycle whose command was sent: heartbeats, supervision, and waiting for the next tick.
    ///
    /// # Errors
    /// [`CycleFailed`].
    pub fn end_cycle(&mut self, period: Duration) -> Result<(), CycleFailed<L::Error>> {
        self.network.housekeeping(self.clock.now())?;
        self.tick = self.tick + period;
        self.clock.sleep_until(self.tick);
        Ok(())
    }
}

impl<L: Link, C: Clock> Drop for Enabled<'_, L, C> {
    fn drop(&mut self) {
        if !self.stopped {
            let _ = self.network.stop(self.clock);
        }
    }
}

/// Why a cycle cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum CycleFailed<E> {
    /// Bus or drive failed.
    #[error(transparent)]
    Cycle(#[from] CycleError<E>),
    /// The drive did not answer a SYNC.
    #[error("the drive sent no position in time for a SYNC")]
    NoPosition,
}

/// Whether the drive confirmed that its power is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brakes {
    /// It did.
    Closed,
    /// It did not.
    NotConfirmed,
}

impl std::fmt::Display for Brakes {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Closed => "power off, brake closed",
            Self::NotConfirmed => "POWER OFF AND BRAKE NOT CONFIRMED",
        })
    }
}

/// Starts the drive of `network`, lets `work` move it, and brakes in any case.
///
/// # Errors
/// That of the start or of `work`, with what came of the brakes.
pub fn enabled<L: Link, C: Clock, T>(
    network: &mut DriveNetwork<L, 1>,
    clock: &mut C,
    work: impl FnOnce(&mut Enabled<'_, L, C>) -> anyhow::Result<T>,
) -> anyhow::Result<(T, Brakes)>
where
    L::Error: Send + Sync + 'static,
{
    let started = network.start(clock);
    let mut enabled = Enabled::new(network, clock);
    let outcome = started.map_err(anyhow::Error::new).and_then(|_| work(&mut enabled));
    let brakes = if enabled.stop().all_off() { Brakes::Closed } else { Brakes::NotConfirmed };
    Ok((outcome.with_context(|| format!("ended early ({brakes})"))?, brakes))
}

/// How far a joint has moved, and how fast, from its counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    last: Option<i32>,
    travelled: i64,
    recent: [i64; SPEED_CYCLES],
    cycles: usize,
    /// Counts in the last [`SPEED_CYCLES`] cycles.
    speed_counts: i64,
}

impl Motion {
    /// Takes the counts of a cycle. A step of `most` counts or more, either way, is none of the joint: it is left out, and
    /// returned.
    pub fn note(&mut self, position: i32, most: Option<u32>) -> Option<i32> {
        let step = self.last.replace(position).map_or(0, |last| position.wrapping_sub(last));
        let jump = Some(step).filter(|step| most.is_some_and(|most| step.unsigned_abs() >= most));
        self.travelled += i64::from(if jump.is_some() { 0 } else { step });
        if let Some(oldest) = self.recent.get_mut(self.cycles % SPEED_CYCLES) {
            let before = std::mem::replace(oldest, self.travelled);
            self.cycles += 1;
            self.speed_counts = if self.cycles > SPEED_CYCLES { self.travelled - before } else { 0 };
        }
        jump
    }

    /// Counts from the first to the last.
    pub const fn travelled(&self) -> i64 {
        self.travelled
    }

    /// Counts per second, either way, in cycles of `period`.
    pub fn speed(&self, period: Duration) -> f64 {
        self.speed_counts.unsigned_abs() as f64 / (period.as_secs_f64() * SPEED_CYCLES as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn travel_and_speed_come_from_counts_that_wrap() {
        let mut motion = Motion::default();
        for cycle in 0..40 {
            motion.note(i32::MAX.wrapping_add(cycle * 3), None);
        }
        assert_eq!(motion.travelled(), 39 * 3);
        // 3 counts in each 3 ms.
        assert!((motion.speed(Duration::from_millis(3)) - 1_000.0).abs() < 1e-9);
    }

    #[test]
    fn a_counter_that_is_set_anew_has_not_moved() {
        let mut motion = Motion::default();
        assert_eq!(
            [5_000, 5_003, 0, 2].map(|counts| motion.note(counts, Some(1_000))),
            [None, None, Some(-5_003), None]
        );
        assert_eq!(motion.travelled(), 5);
    }
}
