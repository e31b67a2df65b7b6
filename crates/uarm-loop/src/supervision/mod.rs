//! Faults that only the model sees: an encoder that stands still, torque of the wrong sign, counts that contradict torques.
//!
//! An observer of the generalised momentum ([`observer`]) tells which torque acts on each driven joint beside its motor's. What friction,
//! gravity and an imperfect model explain is allowed ([`settings`]); what is beyond ends the run ([`decision`]). It only watches: torques
//! do not depend on it. The base is measured, and so no torque on it matters; it is not judged itself.

pub mod decision;
pub mod model;
pub mod observer;
pub mod settings;

use decision::{Contradiction, Criterion, Evidence, Suspicion};
use observer::{JointMotion, advance, noise, resume};
use settings::{SupervisionSettings, TorqueAllowance};

/// How many of the torques that were sent last may act within one period: a delay is shorter than two periods.
pub const REMEMBERED_TORQUES: usize = 3;
/// How far the instants of sampling may be off, as a share of the period: drives that sample in a cycle of their own.
const SAMPLING_SHARE: f64 = 0.25;
/// After how many periods without a cycle the observer begins anew.
const LONGEST_GAP: f64 = 3.0;

/// How far the time between two SYNCs may be off the period, as a share of it, for them to be judged.
const REGULAR: f64 = 0.5;
/// For how long nothing is judged after a cycle that was further off, in time constants of the observer.
const SETTLING: f64 = 3.0;

/// What is fixed of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointTraits {
    /// One count, rad.
    pub resolution: f64,
    /// From the SYNC that latches its count until the torque made of it acts, in periods: 0 to 2.
    pub delay: f64,
}

/// Watches `J` joints.
#[derive(Clone, Debug)]
pub struct Supervision<const J: usize> {
    settings: SupervisionSettings<J>,
    joints: [JointTraits; J],
    state: Option<SupervisionState<J>>,
}

/// The whole inner state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupervisionState<const J: usize> {
    /// The joints as the observer knows them.
    pub motion: [JointMotion; J],
    /// What speaks against them.
    pub suspicions: [Suspicion; J],
    /// The torques that were sent, the newest first, N·m.
    pub sent: [[f64; J]; REMEMBERED_TORQUES],
    /// For how long nothing is judged yet after a cycle that did not come in time, s.
    pub settling: f64,
}

/// What is told of one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a, const J: usize> {
    /// Seconds since the SYNC of the cycle before; nothing in the first.
    pub elapsed: Option<f64>,
    /// The loop's period, s.
    pub period: f64,
    /// Angles, rad.
    pub angles: &'a [f64; J],
    /// Counts.
    pub counts: &'a [i32; J],
    /// Whether some of them are predicted: then nothing is judged.
    pub is_predicted: bool,
    /// The torques that this cycle sends, N·m.
    pub torques: &'a [f64; J],
}

/// What the observer gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals<const J: usize> {
    /// Torques that the model does not explain, N·m.
    pub residual: [f64; J],
    /// How large they may be, N·m; infinite for a joint that is not judged.
    pub limit: [f64; J],
}

/// A joint whose counts and torques the model does not explain.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("joint {joint}: {source}")]
pub struct SupervisionFault {
    /// The joint, counted from 1.
    pub joint: usize,
    /// What contradicts the model.
    pub source: Contradiction,
}

impl<const J: usize> Supervision<J> {
    /// Nothing is known of the `joints` yet: they are at rest.
    pub const fn new(settings: SupervisionSettings<J>, joints: [JointTraits; J]) -> Self {
        Self { settings, joints, state: None }
    }

    /// The whole inner state; nothing before the first cycle.
    pub const fn freeze(&self) -> Option<SupervisionState<J>> {
        self.state
    }

    /// Goes on from a frozen state.
    pub const fn thaw(&mut self, state: Option<SupervisionState<J>>) {
        self.state = state;
    }

    /// Takes in one cycle.
    ///
    /// # Errors
    /// [`SupervisionFault`] for the first joint that contradicts the model.
    pub fn watch(&mut self, observed: &Observed<'_, J>) -> Result<Residuals<J>, SupervisionFault> {
        let SupervisionSettings { model, bandwidth, model_error, residual_time, allowances } = &self.settings;
        let (Some(elapsed), Some(mut state)) = (observed.elapsed, self.state) else {
            self.state = Some(SupervisionState::at_rest(observed));
            return Ok(self.nothing_unexplained());
        };
        if elapsed <= 0.0 {
            // Of two SYNCs at one instant, the second tells nothing; the torque sent at the first has not acted.
            state.sent = {
                let [_, second, third] = state.sent;
                [*observed.torques, second, third]
            };
            self.state = Some(state);
            return Ok(Residuals { residual: state.motion.map(|joint| joint.residual), ..self.nothing_unexplained() });
        }
        let acting = self.acting(&state.sent);
        let is_regular = (elapsed / observed.period - 1.0).abs() <= REGULAR;
        state.settling = if is_regular { (state.settling - elapsed).max(0.0) } else { SETTLING / bandwidth.get() };
        if elapsed > LONGEST_GAP * observed.period {
            resume(&mut state.motion, model.as_ref(), observed.angles, &acting, elapsed);
            state.suspicions = unsuspected(observed.counts);
            state.remember(observed.torques);
            self.state = Some(state);
            return Ok(self.nothing_unexplained());
        }
        let inertia = advance(&mut state.motion, model.as_ref(), *bandwidth, observed.angles, &acting, elapsed);
        state.remember(observed.torques);

        let resolutions = self.joints.map(|joint| joint.resolution);
        let mut errors = resolutions;
        for (error, motion) in errors.iter_mut().zip(&state.motion) {
            *error += SAMPLING_SHARE * observed.period * motion.velocity.abs();
        }
        let mut residuals = Residuals { residual: state.motion.map(|joint| joint.residual), limit: [f64::INFINITY; J] };
        let mut fault = None;
        let joints = state.motion.iter().zip(&mut state.suspicions).zip(&self.joints).zip(observed.counts);
        let rows = joints.zip(inertia.iter().enumerate()).zip(allowances).zip(&mut residuals.limit);
        for ((((((motion, suspicion), joint), count), (index, row)), allowance), limit) in rows {
            let Some(allowance) = *allowance else { continue };
            let criterion = Criterion { allowance, model_error: *model_error, residual_time: *residual_time };
            let evidence = Evidence {
                elapsed,
                count: *count,
                resolution: joint.resolution,
                velocity: motion.velocity,
                torque: motion.filtered_torque,
                residual: motion.residual,
                rounding: noise(row, &resolutions, *bandwidth),
                noise: noise(row, &errors, *bandwidth),
                inertia: row.get(index).copied().unwrap_or_default(),
            };
            *limit = criterion.limit(&evidence);
            if state.settling > 0.0 {
                *suspicion = Suspicion { count: *count, ..Suspicion::default() };
                continue;
            }
            if observed.is_predicted {
                continue;
            }
            if let Err(source) = suspicion.judge(&criterion, &evidence) {
                fault = fault.or(Some(SupervisionFault { joint: index.saturating_add(1), source }));
            }
        }
        self.state = Some(state);
        fault.map_or(Ok(residuals), Err)
    }

    fn nothing_unexplained(&self) -> Residuals<J> {
        let limit = |allowance: Option<TorqueAllowance>| allowance.map_or(f64::INFINITY, TorqueAllowance::get);
        Residuals { residual: [0.0; J], limit: self.settings.allowances.map(limit) }
    }

    /// The mean torques between the last SYNC and this one, N·m.
    fn acting(&self, sent: &[[f64; J]; REMEMBERED_TORQUES]) -> [f64; J] {
        let mut acting = [0.0; J];
        for (torques, age) in sent.iter().zip([0.0, 1.0, 2.0]) {
            for ((acting, torque), joint) in acting.iter_mut().zip(torques).zip(&self.joints) {
                *acting += torque * (1.0 - (joint.delay - age).abs()).max(0.0);
            }
        }
        acting
    }
}

impl<const J: usize> SupervisionState<J> {
    fn at_rest(observed: &Observed<'_, J>) -> Self {
        Self {
            motion: observed.angles.map(|angle| JointMotion { angle, ..JointMotion::default() }),
            suspicions: unsuspected(observed.counts),
            sent: [*observed.torques, [0.0; J], [0.0; J]],
            settling: 0.0,
        }
    }

    fn remember(&mut self, torques: &[f64; J]) {
        let [newest, second, _] = self.sent;
        self.sent = [*torques, newest, second];
    }
}

fn unsuspected<const J: usize>(counts: &[i32; J]) -> [Suspicion; J] {
    counts.map(|count| Suspicion { count, ..Suspicion::default() })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use uarm_io::time::Duration;

    use super::model::MomentumModel;
    use super::settings::{Bandwidth, ModelError, ResidualTime};
    use super::*;

    /// A base and a joint that know nothing of each other, of 1 and 0.05 kg·m².
    #[derive(Debug)]
    struct Apart;

    impl MomentumModel<2> for Apart {
        fn inertia(&self, _: &[f64; 2]) -> [[f64; 2]; 2] {
            [[1.0, 0.0], [0.0, 0.05]]
        }
        fn velocity_torque(&self, _: &[f64; 2], _: &[f64; 2]) -> [f64; 2] {
            [0.0; 2]
        }
    }

    const PERIOD: f64 = 3e-3;

    fn supervision() -> Supervision<2> {
        let settings = SupervisionSettings {
            model: Arc::new(Apart),
            bandwidth: Bandwidth::of_period(PERIOD),
            model_error: ModelError::default(),
            residual_time: ResidualTime::new(Duration::from_millis(10)).unwrap(),
            allowances: [None, TorqueAllowance::new(0.1)],
        };
        Supervision::new(settings, [JointTraits { resolution: 1e-4, delay: 0.0 }; 2])
    }

    /// A cycle `elapsed` seconds after the last, with the joint at `angle` under `torque`.
    fn cycle(
        supervision: &mut Supervision<2>,
        elapsed: Option<f64>,
        angle: f64,
        torque: f64,
    ) -> Result<Residuals<2>, SupervisionFault> {
        let count = (angle / 1e-4).round() as i32;
        supervision.watch(&Observed {
            elapsed,
            period: PERIOD,
            angles: &[angle, angle],
            counts: &[count, count],
            is_predicted: false,
            torques: &[0.0, torque],
        })
    }

    /// 1 rad/s, whenever SYNCs come: two at one instant, late ones, and a standstill of the computer.
    #[test]
    fn late_cycles_are_no_fault() {
        let mut supervision = supervision();
        let mut at = 0.0;
        cycle(&mut supervision, None, 0.0, 0.0).unwrap();
        // It comes to that speed within its allowance: by 0.09 N·m of something else.
        while at < 1.0 / 1.8 {
            at += PERIOD;
            cycle(&mut supervision, Some(PERIOD), 0.9 * at * at, 0.0).unwrap();
        }
        let (start, velocity) = (0.9 * at * at, 1.8 * at);
        let mut since = 0.0;
        for elapsed in [3e-3, 6.5e-3, 0.0, 1e-5, 2.5e-3, 8e-3, 1e-3, 3e-3, 0.2, 0.0, 3e-3, 3e-3, 3e-3] {
            since += elapsed;
            let found = cycle(&mut supervision, Some(elapsed), start + velocity * since, 0.0).unwrap();
            assert!(found.residual[1].abs() < 0.1, "{elapsed}: {found:?}");
        }
    }

    #[test]
    fn the_joint_is_named_and_the_base_is_not_judged() {
        let mut supervision = supervision();
        let mut watched = (0..100).map(|step| cycle(&mut supervision, (step > 0).then_some(PERIOD), 0.0, 0.2));
        let fault = watched.find_map(Result::err).unwrap();
        assert_eq!(fault.joint, 2);
        assert!(matches!(fault.source, Contradiction::Stuck { .. }), "{fault}");
    }

    #[test]
    fn a_torque_acts_after_its_delay() {
        let mut supervision = supervision();
        let sent = [[3.0, 3.0], [2.0, 2.0], [1.0, 1.0]];
        for (delay, expected) in [(0.0, 3.0), (0.25, 2.75), (1.0, 2.0), (1.5, 1.5)] {
            supervision.joints = [JointTraits { delay, ..JointTraits::default() }; 2];
            assert_eq!(supervision.acting(&sent), [expected; 2], "{delay}");
        }
    }
}
