//! What an emulated drive is made of.

use core::time::Duration;

use super::encoder::{Encoder, EncoderDescription, EncoderError};
use uarm_io::drive::NodeId;
use uarm_io::drive::wishes::PinnedIdentity;
use uarm_io::encoder::Direction;
use uarm_io::gear::Transmission;
use uarm_io::torque::TorqueUnit;

/// An emulated drive, as plain numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveDescription {
    /// Node on the bus, 1 ..= 126 (127 is the master's).
    pub node: u8,
    /// Rated torque of the motor at the joint, mN·m, as 6076h counts it; > 0.
    ///
    /// Whole mN·m are coarse beside the UARM's peak of about 70 mN·m, but only the unit of 6071h depends on it: torque is
    /// commanded in per mille of this value, so that a rated torque of 200 mN·m gives steps of 0.2 mN·m.
    pub rated_torque: u32,
    /// Rated current of the motor, mA, as 6075h counts it; > 0. Shown, not used.
    pub rated_current: u32,
    /// Largest torque, per mille of the rated one, as 6072h counts it: the drive cuts off what is above.
    pub maximum_torque: u16,
    /// Which way it is mounted on the joint. [`Direction::Negative`] mirrors the drive as a whole: its counts fall when the
    /// joint turns in the positive direction, and a positive torque turns the joint in the negative one.
    pub direction: Direction,
    /// The encoder.
    pub encoder: EncoderDescription,
}

/// How a drive starts, as drives do that have a past.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PowerUp {
    /// From supply or reset to the boot-up message.
    pub boot_time: Duration,
    /// The code of an emergency that it sends after each boot-up message.
    pub emergency: Option<u16>,
    /// The code of a fault that it has when it is first switched on; a fault reset clears it.
    pub fault: Option<u16>,
    /// What its counter shows when it has booted.
    pub counter: CounterAtPowerUp,
}

/// What a drive's position counter shows when it has booted from its supply or an NMT reset of the node. A reset of the
/// communication leaves the counter alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CounterAtPowerUp {
    /// The joint's angle, as an absolute encoder does.
    #[default]
    Angle,
    /// Zero, wherever the joint is, as an incremental encoder does.
    Zero,
}

/// Why a drive is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveError {
    /// The node is not one a drive may have.
    #[error("node {found} cannot be a drive's, expected 1 to 126")]
    Node {
        /// What was asked for.
        found: u8,
    },
    /// No torque, or no current.
    #[error("drive {node}: {name} is 0, expected more")]
    Zero {
        /// The drive's node id.
        node: u8,
        /// The quantity.
        name: &'static str,
    },
    /// The encoder is refused.
    #[error("drive {node}: {error}")]
    Encoder {
        /// The drive's node id.
        node: u8,
        /// Why it is refused.
        error: EncoderError,
    },
}

/// An emulated drive's parameters, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveParameters {
    node: NodeId,
    rated_torque: u32,
    rated_current: u32,
    maximum_torque: u16,
    encoder: Encoder,
    power_up: PowerUp,
    unit: TorqueUnit,
    transmission: Transmission,
    limit_switches: Option<[f64; 2]>,
    identity: PinnedIdentity,
}

impl DriveParameters {
    /// The highest node that a drive may have; the one above is the master's.
    const HIGHEST_NODE: u8 = 126;

    /// Checks and takes a description.
    ///
    /// # Errors
    /// [`DriveError`] if a number is out of the range that its field states.
    pub fn new(description: DriveDescription) -> Result<Self, DriveError> {
        let DriveDescription { node: raw, rated_torque, rated_current, maximum_torque, direction, encoder } =
            description;
        let node =
            NodeId::new(raw).ok().filter(|_| raw <= Self::HIGHEST_NODE).ok_or(DriveError::Node { found: raw })?;
        if rated_torque == 0 {
            return Err(DriveError::Zero { node: raw, name: "rated_torque" });
        }
        if rated_current == 0 {
            return Err(DriveError::Zero { node: raw, name: "rated_current" });
        }
        let encoder = Encoder::new(encoder, direction).map_err(|error| DriveError::Encoder { node: raw, error })?;
        let (power_up, unit, transmission, limit_switches, identity) = Default::default();
        Ok(Self {
            node,
            rated_torque,
            rated_current,
            maximum_torque,
            encoder,
            power_up,
            unit,
            transmission,
            limit_switches,
            identity,
        })
    }

    /// The same drive, starting so.
    #[must_use]
    pub const fn with_power_up(self, power_up: PowerUp) -> Self {
        Self { power_up, ..self }
    }

    /// The same drive, counting its rated torque in another unit.
    #[must_use]
    pub const fn with_rated_torque_unit(self, unit: TorqueUnit) -> Self {
        Self { unit, ..self }
    }

    /// How it starts.
    pub const fn power_up(&self) -> PowerUp {
        self.power_up
    }

    /// Per mille of 6076h in a N·m.
    pub(super) const fn torque_divisor(&self) -> f64 {
        match self.unit {
            TorqueUnit::MillinewtonMetre => 1e6,
            TorqueUnit::MicronewtonMetre => 1e9,
        }
    }

    /// The same drive with a gear between its motor, on which the encoder is, and the joint.
    #[must_use]
    pub const fn behind(self, transmission: Transmission) -> Self {
        Self { transmission, ..self }
    }

    /// The same drive with a limit switch at each end: on up to the first of these angles of the joint, and from the second on, rad.
    #[must_use]
    pub const fn with_limit_switches(self, angles: [f64; 2]) -> Self {
        Self { limit_switches: Some(angles), ..self }
    }

    /// The same drive with these numbers in 1018h; those that are not said are its own.
    #[must_use]
    pub const fn with_identity(self, identity: PinnedIdentity) -> Self {
        Self { identity, ..self }
    }

    /// What it says of itself beside its own: see [`with_identity`](Self::with_identity).
    pub(super) const fn identity(&self) -> PinnedIdentity {
        self.identity
    }

    /// Where the limit switches are: see [`with_limit_switches`](Self::with_limit_switches).
    pub(super) const fn limit_switches(&self) -> Option<[f64; 2]> {
        self.limit_switches
    }

    /// The gear between motor and joint.
    pub const fn transmission(&self) -> Transmission {
        self.transmission
    }

    /// Node on the bus.
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Rated torque, as 6076h counts it: mN·m unless another unit was chosen.
    pub const fn rated_torque(&self) -> u32 {
        self.rated_torque
    }

    /// Rated current, mA (6075h).
    pub const fn rated_current(&self) -> u32 {
        self.rated_current
    }

    /// Largest torque, per mille of the rated one (6072h).
    pub const fn maximum_torque(&self) -> u16 {
        self.maximum_torque
    }

    /// Which way it is mounted on the joint.
    pub const fn direction(&self) -> Direction {
        self.encoder.direction()
    }

    /// The encoder.
    pub const fn encoder(&self) -> &Encoder {
        &self.encoder
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn description(node: u8) -> DriveDescription {
        DriveDescription {
            node,
            rated_torque: 200,
            rated_current: 1_000,
            maximum_torque: 1_000,
            direction: Direction::Positive,
            encoder: EncoderDescription { counts_per_revolution: 33_739, counter_bits: 32, zero_offset: 0 },
        }
    }

    #[test]
    fn what_no_drive_has_is_refused() {
        assert!(DriveParameters::new(description(126)).is_ok());
        assert_eq!(DriveParameters::new(description(0)), Err(DriveError::Node { found: 0 }));
        assert_eq!(DriveParameters::new(description(127)), Err(DriveError::Node { found: 127 }));
        let weak = DriveDescription { rated_torque: 0, ..description(2) };
        assert_eq!(DriveParameters::new(weak), Err(DriveError::Zero { node: 2, name: "rated_torque" }));
        let cold = DriveDescription { rated_current: 0, ..description(2) };
        assert_eq!(DriveParameters::new(cold), Err(DriveError::Zero { node: 2, name: "rated_current" }));
    }
}
