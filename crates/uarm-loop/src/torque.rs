//! From the law's torque to the drives': limits, the injected disturbance, per mille.

use hinf_control::{Disturbance, LimitedTorque, TorqueLimiter, TorqueNotFinite};
use nalgebra::SVector;
use uarm_io::time::Duration;
use uarm_io::torque::{TorqueError, TorqueScale};

use crate::dimensions;
use crate::fade::Fade;
use crate::supervisor::Authority;

/// Where the experiment's disturbance acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisturbanceSite {
    /// On the joints: the plant adds it by itself.
    Plant,
    /// On the torque that is sent, once a cycle, as the paper's experiments did.
    Command,
}

crate::choice! {
    DisturbanceSite:
    Plant = "plant", "On the joints: the simulated robot adds it by itself";
    Command = "command", "On the torque that is sent, once a cycle, as the paper's experiments did";
}

/// Turns the torque of a law into what the drives are sent.
#[derive(Debug)]
pub struct TorqueStage<const J: usize, const N: usize> {
    /// Saturation and rate limit of what the law asks of the active joints.
    pub limiter: TorqueLimiter<f64, N>,
    /// The same limits on what is sent in the end: nothing comes after it.
    pub output_limiter: TorqueLimiter<f64, N>,
    /// What a stop leaves of the torques.
    pub fade: Fade<N>,
    /// From N·m to each drive's per mille.
    pub scales: [TorqueScale; J],
    /// The experiment's disturbance.
    pub disturbance: Disturbance,
    /// Where the disturbance acts.
    pub site: DisturbanceSite,
}

/// A torque that a drive reported: its torque actual value 6077h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActualTorque {
    /// As the drive sent it, per mille of its rated torque.
    pub per_mille: i16,
    /// The same at the joint, N·m.
    pub newton_metres: f64,
}

/// Why there is no torque to send.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PrepareError {
    /// There is nothing to limit.
    #[error(transparent)]
    NotFinite(#[from] TorqueNotFinite),
    /// A drive cannot be sent it.
    #[error(transparent)]
    Drive(#[from] TorqueError),
}

/// The torques of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreparedTorque<const J: usize, const N: usize> {
    /// The law's torque before and after the limiter, N·m; a joint whose torque a stop has cut counts as limited, too.
    pub limited: LimitedTorque<f64, N>,
    /// The disturbance at this instant, N·m, wherever it acts.
    pub disturbance: SVector<f64, N>,
    /// What is sent, N·m: finite, and within saturation and rate.
    pub output: SVector<f64, N>,
    /// What is sent, per mille of rated torque. The passive joint's is zero.
    pub sent: [i16; J],
}

impl<const J: usize, const N: usize> TorqueStage<J, N> {
    /// Prepares the torques of one cycle at task time `time`. They have had `rise_time` seconds to change in, and the law has the
    /// `authority` that the supervisor gives it.
    ///
    /// # Errors
    /// [`PrepareError`] if a torque is no finite number.
    pub fn prepare(
        &mut self,
        torque: SVector<f64, N>,
        time: f64,
        rise_time: f64,
        authority: Authority,
    ) -> Result<PreparedTorque<J, N>, PrepareError> {
        let envelope = self.fade.envelope(authority, self.output_limiter.applied(), rise_time);
        let limited = self.limiter.limit(envelope.bound(torque), rise_time)?;
        let limited = LimitedTorque {
            requested: torque,
            limited: limited.applied.zip_map(&torque, |applied, asked| applied != asked).into(),
            ..limited
        };
        let task_time = Duration::try_from_secs_f64(time).unwrap_or(Duration::ZERO);
        let disturbance = self.disturbance.torque(task_time, 0.0);
        let commanded = match self.site {
            DisturbanceSite::Plant => limited.applied,
            DisturbanceSite::Command => limited.applied + disturbance,
        };
        let output = self.output_limiter.limit(envelope.bound(commanded), rise_time)?.applied;
        let mut sent = [0; J];
        let active = sent.iter_mut().zip(&self.scales).skip(dimensions::passive::<J, N>());
        for ((sent, scale), torque) in active.zip(&output) {
            *sent = scale.to_drive(*torque)?.per_mille;
        }
        Ok(PreparedTorque { limited, disturbance, output, sent })
    }

    /// What the drives reported, `per_mille` of each one's rated torque, and the same at the joints.
    pub fn actual(&self, per_mille: [Option<i16>; J]) -> [Option<ActualTorque>; J] {
        let mut actual = [None; J];
        for ((actual, scale), per_mille) in actual.iter_mut().zip(&self.scales).zip(per_mille) {
            *actual = per_mille.map(|per_mille| ActualTorque { per_mille, newton_metres: scale.to_joint(per_mille) });
        }
        actual
    }
}
