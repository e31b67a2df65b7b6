//! From the law's torque to the drives': limits, the injected disturbance, per mille.

use hinf_control::Disturbance;
use hinf_control::{LimitedTorque, TorqueLimiter};
use nalgebra::Vector2;
use uarm_io::time::Duration;
use uarm_io::torque::{TorqueError, TorqueScale};

use super::JOINTS;

/// Where the experiment's disturbance acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DisturbanceSite {
    /// On the joints: the plant knows it, as the embedded robot and `uarm plant --disturbance` do
    Plant,
    /// On the torque that is sent, once a cycle, as the paper's experiments did
    Command,
}

/// Turns the torque of a law into what the drives are sent.
#[derive(Debug)]
pub struct TorqueStage {
    /// Saturation and rate limit of the active joints.
    pub limiter: TorqueLimiter<f64>,
    /// From N·m to each drive's per mille.
    pub scales: [TorqueScale; JOINTS],
    /// The experiment's disturbance.
    pub disturbance: Disturbance,
    /// Where it acts.
    pub site: DisturbanceSite,
}

/// The torques of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreparedTorque {
    /// The law's torque before and after the limiter, N·m.
    pub limited: LimitedTorque<f64>,
    /// The disturbance at this instant, N·m, wherever it acts.
    pub disturbance: Vector2<f64>,
    /// What is sent, per mille of rated torque. The passive joint's is zero.
    pub sent: [i16; JOINTS],
}

impl TorqueStage {
    /// Prepares the torques of one cycle at task time `time`. They have had `rise_time` seconds to change in.
    ///
    /// # Errors
    /// [`TorqueError`] if a torque is no number; no law of this workspace gives one.
    pub fn prepare(&mut self, torque: Vector2<f64>, time: f64, rise_time: f64) -> Result<PreparedTorque, TorqueError> {
        let limited = self.limiter.limit(torque, rise_time);
        let task_time = Duration::try_from_secs_f64(time).unwrap_or(Duration::ZERO);
        let disturbance = self.disturbance.torque(task_time, 0.0);
        let disturbance = Vector2::new(disturbance.y, disturbance.z);
        let commanded = match self.site {
            DisturbanceSite::Plant => limited.applied,
            DisturbanceSite::Command => limited.applied + disturbance,
        };
        let [_, second, third] = &self.scales;
        let sent = [0, second.to_drive(commanded.x)?.per_mille, third.to_drive(commanded.y)?.per_mille];
        Ok(PreparedTorque { limited, disturbance, sent })
    }
}
