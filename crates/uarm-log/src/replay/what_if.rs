//! Another law, or another robot file, on the same measurements: what it would have asked for, cycle by cycle. The robot
//! did not hear it, so this is an open loop: it tells how laws differ on one motion, not where another would have led.

use serde::Serialize;

use super::Source;
use super::bus_cycles::Continuity;
use super::exact::ReplayError;
use crate::control_loop::guard::JointLimits;
use crate::control_loop::signal_path::SignalPath;
use crate::experiment;

/// One cycle of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// The cycle.
    pub tick: u64,
    /// Its task time, s.
    pub time: f64,
    /// Torques of joints 2 and 3 as they were applied, N·m.
    pub recorded: [f64; 2],
    /// As the other would have applied them, N·m.
    pub other: [f64; 2],
}

/// What came of a what-if.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WhatIf {
    /// Every cycle that could be replayed.
    #[serde(skip)]
    pub pairs: Vec<Pair>,
    /// Cycles that could.
    pub cycles: u64,
    /// Root mean square of the torque difference of joints 2 and 3, N·m.
    pub rms_difference_nm: [f64; 2],
    /// Its largest magnitude, N·m.
    pub largest_difference_nm: [f64; 2],
    /// Root mean square of the recorded torque, N·m.
    pub rms_recorded_nm: [f64; 2],
    /// Root mean square of the other torque, N·m.
    pub rms_other_nm: [f64; 2],
    /// Cycles that could not be replayed.
    pub lost_cycles: u64,
}

impl WhatIf {
    /// Runs the law and robot of `other` on the measurements of `source`.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin.
    pub fn run(source: &Source<'_>, other: &Source<'_>) -> Result<Self, ReplayError> {
        if source.bus.is_empty() {
            return Err(ReplayError::NoCycles);
        }
        let mut controller = crate::controllers::build(other.settings.law, other.robot, other.settings.guard)
            .map_err(ReplayError::Configuration)?;
        let mut path = experiment::signal_path(other.robot, other.settings, &mut controller)
            .map_err(ReplayError::Configuration)?;
        open_loop(&mut path);
        if let Some((_, keyframe)) = source.keyframes.iter().find(|(after, _)| after.is_none()) {
            path.thaw_measured(keyframe)
                .map_err(|source| ReplayError::Keyframe { time: keyframe.task_clock.time, source })?;
        }
        let mut outcome = Self::default();
        let mut previous = None;
        for cycle in source.bus {
            let tick = source.tick(cycle, previous);
            previous = Some((tick.index, cycle.sync_at));
            let recorded = source.record(cycle.sync_at).map(|record| record.torque_applied).or_else(|| {
                // Only the bus was recorded: what the drives were told.
                let [_, second, third] = cycle.all_sent()?;
                let [_, joint_2, joint_3] = &source.robot.joints;
                Some([joint_2.torque_scale.to_joint(second), joint_3.torque_scale.to_joint(third)])
            });
            let (Some(counts), Some(recorded), Continuity::Whole) = (cycle.all_counts(), recorded, cycle.continuity)
            else {
                outcome.lost_cycles += 1;
                continue;
            };
            // A count that the other robot file's encoders would not believe is one cycle less.
            match path.step(&tick, cycle.sync_at, &counts, source.robot.period) {
                Ok(signals) => outcome.pairs.push(Pair {
                    tick: tick.index,
                    time: signals.time,
                    recorded,
                    other: signals.torque.limited.applied.into(),
                }),
                Err(_) => outcome.lost_cycles += 1,
            }
        }
        outcome.summarise();
        Ok(outcome)
    }

    fn summarise(&mut self) {
        self.cycles = u64::try_from(self.pairs.len()).unwrap_or(u64::MAX);
        let both =
            |value: fn(&Pair, usize) -> f64| [0, 1].map(|joint| rms(self.pairs.iter().map(|pair| value(pair, joint))));
        self.rms_difference_nm = both(|pair, joint| pair.other[joint] - pair.recorded[joint]);
        self.rms_recorded_nm = both(|pair, joint| pair.recorded[joint]);
        self.rms_other_nm = both(|pair, joint| pair.other[joint]);
        self.largest_difference_nm = [0, 1].map(|joint| {
            self.pairs.iter().map(|pair| (pair.other[joint] - pair.recorded[joint]).abs()).fold(0.0, f64::max)
        });
    }
}

/// The robot went where it went: no limit of a file ends that.
fn open_loop(path: &mut SignalPath<'_>) {
    let unlimited = JointLimits { position: [f64::NEG_INFINITY, f64::INFINITY], rate: f64::INFINITY };
    path.guard.joints = [unlimited; 3];
    path.guard.tracking_error = f64::INFINITY;
    path.guard.start_tolerance = f64::INFINITY;
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}
