//! Another law, or another robot file, on the same measurements: what it would have asked for, cycle by cycle. The robot
//! did not hear it, so this is an open loop: it tells how laws differ on one motion, not where another would have led.

use uarm_loop::dimensions;
use uarm_loop::guard::JointLimits;
use uarm_loop::hinf_control::Controller;
use uarm_loop::run::signal_path;
use uarm_loop::saturation::SaturationWatch;
use uarm_loop::signal_path::SignalPath;
use uarm_loop::supervisor::Authority;

use super::bus_cycles::{BusCycle, Continuity};
use super::source::{ReplayError, Source};

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
        if source.bus.is_empty() {
            return Err(ReplayError::NoCycles);
        }
        let mut path = signal_path(other.robot, other.settings, controller)?;
        open_loop(&mut path);
        if let Some((_, keyframe)) = source.keyframes.iter().find(|(after, _)| after.is_none()) {
            path.thaw_measured(keyframe)
                .map_err(|source| ReplayError::Keyframe { time: keyframe.task_clock.time, source })?;
        }
        let (mut pairs, mut lost_cycles) = (Vec::new(), 0);
        let mut previous = None;
        for (index, cycle) in source.bus.iter().enumerate() {
            let tick = source.tick(cycle, previous);
            previous = Some((tick.index, cycle.sync_at));
            let recorded = source
                .record(cycle.sync_at)
                .map(|record| record.torque_applied)
                // Only the bus was recorded: what the drives were told.
                .or_else(|| sent_torque(source, cycle));
            let (Some(counts), Some(recorded), Continuity::Whole) = (source.counts(cycle), recorded, cycle.continuity)
            else {
                // In the cycle that ended the run, no torque was sent.
                let is_end = index + 1 == source.bus.len() && recorded.is_none();
                lost_cycles += u64::from(!is_end);
                continue;
            };
            // A count that the other robot's encoders would not believe is one cycle less.
            let authority = source.record(cycle.sync_at).map_or(Authority::Full, |record| record.authority);
            match path.step(&tick, cycle.sync_at, &counts, source.robot.period, authority) {
                Ok(signals) => {
                    let other = signals.torque.limited.applied.into();
                    pairs.push(Pair { tick: tick.index, time: signals.time, recorded, other });
                }
                Err(_) => lost_cycles += 1,
            }
        }
        Ok(Self { summary: TorqueSummary::of(&pairs), pairs, lost_cycles })
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

impl<const N: usize> TorqueSummary<N> {
    fn of(pairs: &[Pair<N>]) -> Self {
        let each_rms = |value: fn(&Pair<N>, usize) -> f64| {
            std::array::from_fn(|joint| rms(pairs.iter().map(|pair| value(pair, joint))))
        };
        Self {
            rms_difference: each_rms(|pair, joint| pair.other[joint] - pair.recorded[joint]),
            largest_difference: std::array::from_fn(|joint| {
                pairs.iter().map(|pair| (pair.other[joint] - pair.recorded[joint]).abs()).fold(0.0, f64::max)
            }),
            rms_recorded: each_rms(|pair, joint| pair.recorded[joint]),
            rms_other: each_rms(|pair, joint| pair.other[joint]),
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
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}
