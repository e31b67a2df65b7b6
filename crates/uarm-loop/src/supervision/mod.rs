//! Faults that only the model sees: an encoder that stands still, torque of the wrong sign, counts that contradict torques.
//!
//! An observer of the generalised momentum ([`observer`]) tells which torque acts on each driven joint beside its motor's. What friction,
//! gravity and an imperfect model explain is allowed ([`settings`]); what is beyond ends the run ([`decision`]). It only watches: torques
//! do not depend on it. The base is measured, and so no torque on it matters; it is not judged itself.

pub mod decision;
pub mod model;
pub mod observer;
pub mod settings;
pub mod stop;

use decision::{Contradiction, Criterion, Evidence, Suspicion};
use observer::{JointMotion, advance, noise, resume};
use settings::{SupervisionSettings, TorqueAllowance};
use stop::Torques;

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

/// How far the residual of a joint may be off, N·m.
#[derive(Clone, Copy, Debug)]
struct Noise {
    /// By rounding of the angles.
    rounding: f64,
    /// By that and by the instants of sampling.
    all: f64,
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
        let (Some(elapsed), Some(mut state)) = (observed.elapsed, self.state) else {
            self.state = Some(SupervisionState::at_rest(observed));
            return Ok(self.nothing_unexplained());
        };
        let watched = self.follow(&mut state, observed, elapsed);
        self.state = Some(state);
        watched
    }

    /// Takes the state on to this cycle, `elapsed` seconds after the last, as far as the time since then lets it.
    fn follow(
        &self,
        state: &mut SupervisionState<J>,
        observed: &Observed<'_, J>,
        elapsed: f64,
    ) -> Result<Residuals<J>, SupervisionFault> {
        let SupervisionSettings { model, bandwidth, .. } = &self.settings;
        if elapsed <= 0.0 {
            // Of two SYNCs at one instant, the second tells nothing; the torque sent at the first has not acted.
            state.replace(observed.torques);
            return Ok(Residuals { residual: state.residual(), ..self.nothing_unexplained() });
        }
        let acting = self.acting(&state.sent);
        let is_regular = (elapsed / observed.period - 1.0).abs() <= REGULAR;
        state.settling = if is_regular { (state.settling - elapsed).max(0.0) } else { SETTLING / bandwidth.get() };
        if elapsed > LONGEST_GAP * observed.period {
            resume(&mut state.motion, model.as_ref(), observed.angles, &acting, elapsed);
            state.suspicions = unsuspected(observed.counts);
            state.remember(observed.torques);
            return Ok(self.nothing_unexplained());
        }
        let inertia = advance(&mut state.motion, model.as_ref(), *bandwidth, observed.angles, &acting, elapsed);
        let judged = self.judge(state, observed, &inertia, elapsed);
        state.remember(observed.torques);
        judged
    }

    /// Judges each driven joint by its residual and its counts, at M(q) = `inertia`.
    fn judge(
        &self,
        state: &mut SupervisionState<J>,
        observed: &Observed<'_, J>,
        inertia: &[[f64; J]; J],
        elapsed: f64,
    ) -> Result<Residuals<J>, SupervisionFault> {
        let noise = self.noise(&state.motion, inertia, observed.period);
        let mut residuals = Residuals { residual: state.residual(), limit: [f64::INFINITY; J] };
        let mut fault = None;
        for index in 0..J {
            let Some((criterion, evidence)) = self.evidence(state, observed, inertia, &noise, index, elapsed) else {
                continue;
            };
            let (Some(limit), Some(suspicion)) = (residuals.limit.get_mut(index), state.suspicions.get(index)) else {
                continue;
            };
            *limit = criterion.limit(&evidence);
            let mut suspicion = *suspicion;
            let judged = if state.settling > 0.0 {
                suspicion = Suspicion::of(evidence.count);
                Ok(())
            } else if observed.is_predicted {
                suspicion.forget_motion(elapsed);
                Ok(())
            } else {
                let braking = |direction| self.braking(state, inertia, index, direction);
                suspicion.judge(&criterion, &evidence, braking)
            };
            if let Some(kept) = state.suspicions.get_mut(index) {
                *kept = suspicion;
            }
            let contradicted = |source| SupervisionFault { joint: index.saturating_add(1), source };
            fault = fault.or(judged.err().map(contradicted));
        }
        fault.map_or(Ok(residuals), Err)
    }

    /// How far rounding alone, and rounding with the instants of sampling, may put the residual of each joint off, N·m.
    fn noise(&self, motion: &[JointMotion; J], inertia: &[[f64; J]; J], period: f64) -> [Noise; J] {
        let bandwidth = self.settings.bandwidth;
        let resolutions = self.joints.map(|joint| joint.resolution);
        let mut errors = resolutions;
        for (error, motion) in errors.iter_mut().zip(motion) {
            *error += SAMPLING_SHARE * period * motion.velocity.abs();
        }
        inertia
            .map(|row| Noise { rounding: noise(&row, &resolutions, bandwidth), all: noise(&row, &errors, bandwidth) })
    }

    /// What there is on a joint, and how it is judged; nothing of one that is not.
    fn evidence(
        &self,
        state: &SupervisionState<J>,
        observed: &Observed<'_, J>,
        inertia: &[[f64; J]; J],
        noise: &[Noise; J],
        index: usize,
        elapsed: f64,
    ) -> Option<(Criterion, Evidence)> {
        let SupervisionSettings { model_error, residual_time, allowances, .. } = &self.settings;
        let criterion = Criterion {
            allowance: (*allowances.get(index)?)?,
            model_error: *model_error,
            residual_time: *residual_time,
        };
        let (motion, noise) = (state.motion.get(index)?, noise.get(index)?);
        let evidence = Evidence {
            elapsed,
            period: observed.period,
            count: *observed.counts.get(index)?,
            resolution: self.joints.get(index)?.resolution,
            velocity: motion.velocity,
            torque: motion.filtered_torque,
            residual: motion.residual,
            rounding: noise.rounding,
            noise: noise.all,
            inertia: *inertia.get(index)?.get(index)?,
        };
        Some((criterion, evidence))
    }

    /// The most that a joint that turns in `direction` can be braked by, rad/s²: see [`stop`].
    fn braking(&self, state: &SupervisionState<J>, inertia: &[[f64; J]; J], index: usize, direction: f64) -> f64 {
        let mut torques = [Torques::default(); J];
        let allowances = self.settings.allowances;
        let joints = state.motion.iter().zip(&state.suspicions).zip(allowances);
        for ((torques, ((motion, suspicion), allowance)), joint) in torques.iter_mut().zip(joints).zip(0..) {
            // What acts on a joint that moves is what the observer says, whose noise is less than what the model may be off; on one that stands, or now stops, whatever is allowed.
            let allowed = allowance.filter(|_| joint == index || suspicion.stands()).map(TorqueAllowance::get);
            let (middle, either_way) = allowed.map_or((motion.residual, 0.0), |allowed| (0.0, allowed));
            let sent = state.sent.iter().filter_map(|torques| torques.get(joint));
            let motor =
                sent.fold(Torques::between(motion.torque, motion.filtered_torque), |range, torque| range.with(*torque));
            *torques = motor.plus(middle, either_way);
        }
        let angles = state.motion.map(|joint| joint.angle);
        let velocity = state.motion.map(|joint| joint.velocity);
        let centrifugal = stop::centrifugal(self.settings.model.as_ref(), inertia, &angles, &velocity);
        let nominal = stop::strongest_braking(inertia, &torques, &centrifugal, index, direction);
        nominal * (1.0 + self.settings.model_error.get())
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

    fn residual(&self) -> [f64; J] {
        self.motion.map(|joint| joint.residual)
    }

    /// Takes `torques` for those that were sent last.
    fn replace(&mut self, torques: &[f64; J]) {
        let [_, second, third] = self.sent;
        self.sent = [*torques, second, third];
    }

    fn remember(&mut self, torques: &[f64; J]) {
        let [newest, second, _] = self.sent;
        self.sent = [*torques, newest, second];
    }
}

fn unsuspected<const J: usize>(counts: &[i32; J]) -> [Suspicion; J] {
    counts.map(Suspicion::of)
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
