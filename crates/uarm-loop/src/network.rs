//! What the CANopen master must know of a robot's drives.

use uarm_io::drive::network::{ConfigurationError, NetworkConfiguration};
use uarm_io::drive::wishes::{DriveConfiguration, HeartbeatError, Heartbeats};

use crate::robot::{Joint, Robot};

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
        self.configuration_of(self.joints.each_ref().map(|joint| joint.drive.clone()))
    }

    /// The master's configuration for the drive of one joint alone.
    ///
    /// # Errors
    /// As [`Robot::network_configuration`].
    pub fn network_configuration_of(&self, joint: &Joint) -> Result<NetworkConfiguration<1>, NetworkError> {
        self.configuration_of([joint.drive.clone()])
    }

    fn configuration_of<const K: usize>(
        &self,
        drives: [DriveConfiguration; K],
    ) -> Result<NetworkConfiguration<K>, NetworkError> {
        let mut configuration = NetworkConfiguration::new(drives, self.period.duration())?;
        let bus = &self.bus;
        configuration.heartbeats =
            Heartbeats::new(bus.drive_heartbeat, bus.drive_timeout, bus.controller_heartbeat, bus.controller_timeout)
                .map_err(NetworkError::Heartbeats)?;
        configuration.listen = bus.listen;
        configuration.timeouts = bus.timeouts;
        configuration.sync_counter = bus.sync_counter;
        configuration.emergency_reaction = bus.emergency_reaction;
        configuration.ignored_target_reaction = bus.ignored_target_reaction;
        Ok(configuration)
    }
}
