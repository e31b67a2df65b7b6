//! Another law, or another robot file, on the same measurements: what it would have asked for, cycle by cycle. The robot
//! did not hear it, so this is an open loop: it tells how laws differ on one motion, not where another would have led.

use uarm_loop::dimensions;
use uarm_loop::guard::JointLimits;
use uarm_loop::hinf_control::Controller;
use uarm_loop::robot::Robot;
use uarm_loop::run::signal_path;
use uarm_loop::saturation::SaturationWatch;
use uarm_loop::settings::Settings;
use uarm_loop::signal_path::SignalPath;
use uarm_loop::supervisor::Authority;

use super::bus_cycles::{BusCycle, Continuity};
use super::source::{PlacedTick, ReplayError, Source};

/// One cycle of both controllers, with `N` active joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<const N: usize> {
    /// The tick of the cycle.
    pub tick: u64,
    /// Its task time, s.
    pub time: f64,
    /// Torques of the active joints as they were applied, N·m.
    pub recorded: [f64; N],
    /// Torques as the other controller would have applied them, N·m.
    pub other: [f64; N],
}

/// What came of a what-if.
#[derive(Clone, Debug, PartialEq)]
pub struct WhatIf<const N: usize> {
    /// Every cycle that could be replayed.
    pub pairs: Vec<Pair<N>>,
    /// Cycles that could not be replayed.
    pub lost_cycles: u64,
    /// The torques of both, and their difference.
    pub summary: TorqueSummary<N>,
}

/// The torques of both controllers over a run, joint by joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueSummary<const N: usize> {
    /// Root mean square of the torque difference, N·m.
    pub rms_difference: [f64; N],
    /// Largest magnitude of the torque difference, N·m.
    pub largest_difference: [f64; N],
    /// Root mean square of the recorded torque, N·m.
    pub rms_recorded: [f64; N],
    /// Root mean square of the other torque, N·m.
    pub rms_other: [f64; N],
}

impl<const N: usize> WhatIf<N> {
    /// Runs `controller` with robot and settings of `other` on the measurements of `source`.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin.
    pub fn run<const J: usize>(
        source: &Source<'_, J, N>,
        other: &Source<'_, J, N>,
        controller: &mut dyn Controller<f64, N>,
    ) -> Result<Self, ReplayError> {
        let mut pairs = Vec::new();
        let mut run = WhatIfRun::new(other.robot, other.settings, controller)?;
        run.window(source, &mut |pair| pairs.push(pair))?;
        let WhatIfOutcome { lost_cycles, summary, .. } = run.finish()?;
        Ok(Self { pairs, lost_cycles, summary })
    }
}

/// A what-if that is given a run window by window.
pub struct WhatIfRun<'a, const J: usize, const N: usize> {
    path: SignalPath<'a, J, N>,
    has_begun: bool,
    previous: Option<PlacedTick>,
    lost_cycles: u64,
    sums: TorqueSums<N>,
}

/// What came of a what-if, but for its pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhatIfOutcome<const N: usize> {
    /// Cycles that were replayed.
    pub cycles: u64,
    /// Cycles that could not be replayed.
    pub lost_cycles: u64,
    /// The torques of both, and their difference.
    pub summary: TorqueSummary<N>,
}

impl<'a, const J: usize, const N: usize> WhatIfRun<'a, J, N> {
    /// Of `controller` with this robot and these settings.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin.
    pub fn new(
        robot: &Robot<J, N>,
        settings: &Settings,
        controller: &'a mut dyn Controller<f64, N>,
    ) -> Result<Self, ReplayError> {
        let mut path = signal_path(robot, settings, controller)?;
        open_loop(&mut path);
        Ok(Self { path, has_begun: false, previous: None, lost_cycles: 0, sums: TorqueSums::default() })
    }

    /// Gives each cycle of the next window of the run that can be replayed to `take`.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin.
    pub fn window(&mut self, source: &Source<'_, J, N>, take: &mut dyn FnMut(Pair<N>)) -> Result<(), ReplayError> {
        if source.bus.is_empty() {
            return Ok(());
        }
        if !self.has_begun {
            self.has_begun = true;
            if let Some((_, keyframe)) = source.keyframes.iter().find(|(after, _)| after.is_none()) {
                self.path
                    .thaw_measured(keyframe)
                    .map_err(|source| ReplayError::Keyframe { time: keyframe.task_clock.time, source })?;
            }
        }
        for cycle in source.bus {
            if let Some(pair) = self.cycle(source, cycle) {
                self.sums.add(&pair);
                take(pair);
            }
        }
        Ok(())
    }

    fn cycle(&mut self, source: &Source<'_, J, N>, cycle: &BusCycle<J>) -> Option<Pair<N>> {
        let placed = source.tick(cycle, self.previous);
        self.previous = Some(placed);
        let tick = placed.tick;
        let recorded = source
            .record(cycle.sync_at)
            .map(|record| record.torque_applied)
            // Only the bus was recorded: what the drives were told.
            .or_else(|| sent_torque(source, cycle));
        let (Some(counts), Some(recorded), Continuity::Whole) = (source.counts(cycle), recorded, cycle.continuity)
        else {
            // In the cycle that ended the run, no torque was sent.
            let is_end = source.is_last(cycle) && recorded.is_none();
            self.lost_cycles += u64::from(!is_end);
            return None;
        };
        // A count that the other robot's encoders would not believe is one cycle less.
        let authority = source.record(cycle.sync_at).map_or(Authority::Full, |record| record.authority);
        match self.path.step(&tick, cycle.sync_at, &counts, source.robot.period, authority) {
            Ok(signals) => {
                let other = signals.torque.limited.applied.into();
                Some(Pair { tick: tick.index, time: signals.time, recorded, other })
            }
            Err(_) => {
                self.lost_cycles += 1;
                None
            }
        }
    }

    /// What came of it.
    ///
    /// # Errors
    /// [`ReplayError::NoCycles`] if there was none.
    pub fn finish(self) -> Result<WhatIfOutcome<N>, ReplayError> {
        if !self.has_begun {
            return Err(ReplayError::NoCycles);
        }
        let cycles = u64::from(self.sums.count);
        Ok(WhatIfOutcome { cycles, lost_cycles: self.lost_cycles, summary: self.sums.summary() })
    }
}

/// The torques of the active joints that the drives were sent, N·m.
fn sent_torque<const J: usize, const N: usize>(source: &Source<'_, J, N>, cycle: &BusCycle<J>) -> Option<[f64; N]> {
    let mut torque = [0.0; J];
    for ((torque, sent), joint) in torque.iter_mut().zip(cycle.all_sent()?).zip(&source.robot.joints) {
        *torque = joint.torque_scale.to_joint(sent);
    }
    Some(dimensions::active::<J, N>(&torque).into())
}

/// Sums of squares and maxima on the way to a summary.
#[derive(Clone, Copy, Debug)]
struct TorqueSums<const N: usize> {
    count: u32,
    squared_difference: [f64; N],
    largest_difference: [f64; N],
    squared_recorded: [f64; N],
    squared_other: [f64; N],
}

impl<const N: usize> Default for TorqueSums<N> {
    fn default() -> Self {
        let zero = [0.0; N];
        Self {
            count: 0,
            squared_difference: zero,
            largest_difference: zero,
            squared_recorded: zero,
            squared_other: zero,
        }
    }
}

impl<const N: usize> TorqueSums<N> {
    fn add(&mut self, pair: &Pair<N>) {
        self.count = self.count.saturating_add(1);
        for joint in 0..N {
            let (recorded, other) = (pair.recorded[joint], pair.other[joint]);
            let difference = other - recorded;
            self.squared_difference[joint] += difference * difference;
            self.largest_difference[joint] = self.largest_difference[joint].max(difference.abs());
            self.squared_recorded[joint] += recorded * recorded;
            self.squared_other[joint] += other * other;
        }
    }

    fn summary(&self) -> TorqueSummary<N> {
        let rms = |sums: [f64; N]| sums.map(|sum| (sum / f64::from(self.count.max(1))).sqrt());
        TorqueSummary {
            rms_difference: rms(self.squared_difference),
            largest_difference: self.largest_difference,
            rms_recorded: rms(self.squared_recorded),
            rms_other: rms(self.squared_other),
        }
    }
}

/// The robot went where it went: no limit of a description ends that.
fn open_loop<const J: usize, const N: usize>(path: &mut SignalPath<'_, J, N>) {
    let unlimited = JointLimits { position: [f64::NEG_INFINITY, f64::INFINITY], velocity: f64::INFINITY };
    path.guard.joints = [unlimited; J];
    path.guard.tracking_error = f64::INFINITY;
    path.guard.start_tolerance = f64::INFINITY;
    path.saturation = SaturationWatch::unlimited();
    path.supervision = None;
}
