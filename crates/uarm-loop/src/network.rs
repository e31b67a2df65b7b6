//! What the CANopen master must know of a robot's drives.

use uarm_io::drive::network::{ConfigurationError, NetworkConfiguration};
use uarm_io::drive::wishes::{DriveConfiguration, HeartbeatError, Heartbeats};
use uarm_io::time::Duration;

use crate::robot::{Bus, Joint, Robot};

/// Why a robot's drives cannot be described to the master.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// The drives' objects cannot hold what the description says.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// The heartbeats of the bus are refused.
    #[error("bus: {0}")]
    Heartbeats(HeartbeatError),
}

impl<const J: usize, const N: usize> Robot<J, N> {
    /// The master's configuration.
    ///
    /// # Errors
    /// [`NetworkError`] if the drives' objects cannot hold what the description says.
    pub fn network_configuration(&self) -> Result<NetworkConfiguration<J>, NetworkError> {
        let drives = self.joints.each_ref().map(|joint| joint.drive.clone());
        self.bus.network_configuration(drives, self.period.duration())
    }

    /// The master's configuration for the drive of one joint alone.
    ///
    /// # Errors
    /// As [`Robot::network_configuration`].
    pub fn network_configuration_of(&self, joint: &Joint) -> Result<NetworkConfiguration<1>, NetworkError> {
        self.bus.network_configuration([joint.drive.clone()], self.period.duration())
    }
}

impl Bus {
    /// The configuration of a master of these drives, in cycles of `period`.
    ///
    /// # Errors
    /// As [`Robot::network_configuration`].
    pub fn network_configuration<const K: usize>(
        &self,
        drives: [DriveConfiguration; K],
        period: Duration,
    ) -> Result<NetworkConfiguration<K>, NetworkError> {
        let mut configuration = NetworkConfiguration::new(drives, period)?;
        configuration.heartbeats = Heartbeats::new(
            self.drive_heartbeat,
            self.drive_timeout,
            self.controller_heartbeat,
            self.controller_timeout,
        )
        .map_err(NetworkError::Heartbeats)?;
        configuration.listen = self.listen;
        configuration.timeouts = self.timeouts;
        configuration.sync_counter = self.sync_counter;
        configuration.emergency_reaction = self.emergency_reaction;
        configuration.ignored_target_reaction = self.ignored_target_reaction;
        Ok(configuration)
    }
}
