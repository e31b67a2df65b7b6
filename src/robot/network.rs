//! What the CANopen master must know of the drives.

use anyhow::Context;
use uarm_io::drive::network::{DriveConfiguration, Heartbeats, NetworkConfiguration, Setting, Timeouts};

use super::Robot;
use super::joint::Joint;
use crate::control_loop::JOINTS;

/// 608Fh is a ratio: so many increments in so many revolutions. The robot file counts one revolution.
const ENCODER_REVOLUTIONS: u32 = 1;

impl Robot {
    /// The master's configuration.
    ///
    /// # Errors
    /// If the drives' objects cannot hold what the robot file says.
    pub fn network_configuration(&self) -> anyhow::Result<NetworkConfiguration<JOINTS>> {
        let [first, second, third] = &self.joints;
        let drives = [drive(first)?, drive(second)?, drive(third)?];
        let mut configuration = NetworkConfiguration::new(drives, self.period.duration())?;
        let bus = &self.bus;
        configuration.heartbeats =
            Heartbeats::new(bus.drive_heartbeat, bus.drive_timeout, bus.controller_heartbeat, bus.controller_timeout)
                .context("bus")?;
        configuration.timeouts = Timeouts { sdo: bus.sdo_timeout, ..Timeouts::default() };
        Ok(configuration)
    }
}

fn drive(joint: &Joint) -> anyhow::Result<DriveConfiguration> {
    let mut settings = heapless::Vec::new();
    for (address, value) in &joint.writes {
        settings
            .push(Setting::new(*address, *value))
            .map_err(|_| anyhow::anyhow!("{}: drive.writes: more than {} objects", joint.name, settings.capacity()))?;
    }
    Ok(DriveConfiguration {
        node: joint.node,
        encoder_increments: joint.encoder.counts_per_revolution.get(),
        encoder_revolutions: ENCODER_REVOLUTIONS,
        rated_torque: joint.torque_scale.rated_torque,
        settings,
    })
}
