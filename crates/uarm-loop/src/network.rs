//! What the CANopen master must know of a robot's drives.

use uarm_io::drive::network::{ConfigurationError, NetworkConfiguration, Timeouts};
use uarm_io::drive::wishes::{DriveConfiguration, HeartbeatError, Heartbeats, MAX_SETTINGS, Setting};

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
    /// A joint has more objects to write than the master holds.
    #[error("{joint}: {found} objects to write at start, expected at most {MAX_SETTINGS}")]
    Writes {
        /// The joint's name.
        joint: String,
        /// How many objects it has.
        found: usize,
    },
}

impl<const J: usize, const N: usize> Robot<J, N> {
    /// The master's configuration.
    ///
    /// # Errors
    /// [`NetworkError`] if the drives' objects cannot hold what the description says.
    pub fn network_configuration(&self) -> Result<NetworkConfiguration<J>, NetworkError> {
        for joint in &self.joints {
            if joint.writes.len() > MAX_SETTINGS {
                return Err(NetworkError::Writes { joint: joint.name.clone(), found: joint.writes.len() });
            }
        }
        let drives = self.joints.each_ref().map(drive);
        let mut configuration = NetworkConfiguration::new(drives, self.period.duration())?;
        let bus = &self.bus;
        configuration.heartbeats =
            Heartbeats::new(bus.drive_heartbeat, bus.drive_timeout, bus.controller_heartbeat, bus.controller_timeout)
                .map_err(NetworkError::Heartbeats)?;
        configuration.timeouts = Timeouts { sdo: bus.sdo_timeout, ..Timeouts::default() };
        Ok(configuration)
    }
}

fn drive(joint: &Joint) -> DriveConfiguration {
    let counts = joint.encoder.counts_per_revolution.get();
    let settings = joint.writes.iter().take(MAX_SETTINGS).map(|(address, value)| Setting::new(*address, *value));
    DriveConfiguration {
        torque_ceiling: joint.torque_scale.ceiling,
        settings: settings.collect(),
        ..DriveConfiguration::new(joint.node, counts, joint.torque_scale.rated_torque)
    }
}
