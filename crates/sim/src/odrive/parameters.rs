//! What an emulated axis is made of.

use crate::drive::{Encoder, EncoderDescription, EncoderError};
use core::time::Duration;
use uarm_io::drive::odrive::wire::{AxisNode, Version};
use uarm_io::encoder::Direction;
use uarm_io::gear::Transmission;

/// An emulated axis, as plain numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisDescription {
    /// Node id, 1 ..= 62.
    pub node: u8,
    /// Largest torque, N·m, above zero: the axis cuts off what is above.
    pub maximum_torque: f64,
    /// Which way it is mounted on the joint; mirrors position and torque.
    pub direction: Direction,
    /// The encoder. Positions are reported in turns, as the counter's value over its counts per revolution.
    pub encoder: EncoderDescription,
    /// `heartbeat_msg_rate_ms`; at least 1 ms.
    pub heartbeat: Duration,
    /// `encoder_msg_rate_ms`; zero: positions are sent on request only.
    pub encoder_period: Duration,
    /// When the first position is sent after power-on, for cyclic ones.
    pub encoder_phase: Duration,
    /// `watchdog_timeout`; zero: no watchdog.
    pub watchdog: Duration,
    /// How much slower its clock goes than that of the loop, parts per million.
    pub clock_error_ppm: i32,
}

/// Why an axis is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AxisDescriptionError {
    /// The node id is none that an axis may have.
    #[error("node {found} cannot be an ODrive axis's, expected 1 to 62")]
    Node {
        /// What was asked for.
        found: u8,
    },
    /// The torque is none.
    #[error("ODrive axis {node}: a largest torque of {found} N·m, expected one above 0")]
    Torque {
        /// The axis's node id.
        node: u8,
        /// What was asked for, N·m.
        found: f64,
    },
    /// A heartbeat that is too fast.
    #[error("ODrive axis {node}: a heartbeat every {found:?}, expected at least 1ms")]
    Heartbeat {
        /// The axis's node id.
        node: u8,
        /// What was asked for.
        found: Duration,
    },
    /// The encoder is refused.
    #[error("ODrive axis {node}: {error}")]
    Encoder {
        /// The axis's node id.
        node: u8,
        /// Why.
        error: EncoderError,
    },
}

/// An emulated axis's parameters, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisParameters {
    pub(super) node: AxisNode,
    pub(super) maximum_torque: f64,
    pub(super) encoder: Encoder,
    pub(super) heartbeat: Duration,
    pub(super) encoder_period: Option<Duration>,
    pub(super) encoder_phase: Duration,
    pub(super) watchdog: Option<Duration>,
    pub(super) transmission: Transmission,
    pub(super) version: Version,
    pub(super) supply: f32,
    pub(super) temperature: f32,
}

/// What it says of itself: no product of the maker, with the firmware whose messages it speaks.
const VERSION: Version = Version { protocol: 2, hardware: [0, 0, 0], firmware: [0, 6, 0], unreleased: 0 };
/// V.
const SUPPLY: f32 = 24.0;
/// °C.
const TEMPERATURE: f32 = 30.0;

/// The shortest period of a message.
const SHORTEST: Duration = Duration::from_millis(1);

impl AxisParameters {
    /// Checks and takes a description.
    ///
    /// # Errors
    /// [`AxisDescriptionError`] if a number is out of the range that its field states.
    pub fn new(description: AxisDescription) -> Result<Self, AxisDescriptionError> {
        let AxisDescription { node: raw, maximum_torque, direction, encoder, heartbeat, .. } = description;
        let node = AxisNode::new(raw).ok_or(AxisDescriptionError::Node { found: raw })?;
        if !(maximum_torque.is_finite() && maximum_torque > 0.0) {
            return Err(AxisDescriptionError::Torque { node: raw, found: maximum_torque });
        }
        if heartbeat < SHORTEST {
            return Err(AxisDescriptionError::Heartbeat { node: raw, found: heartbeat });
        }
        let encoder =
            Encoder::new(encoder, direction).map_err(|error| AxisDescriptionError::Encoder { node: raw, error })?;
        let own_time = |duration| stretched(duration, description.clock_error_ppm);
        let some = |duration: Duration| (!duration.is_zero()).then(|| own_time(duration));
        Ok(Self {
            node,
            maximum_torque,
            encoder,
            heartbeat: own_time(heartbeat),
            encoder_period: some(description.encoder_period),
            encoder_phase: own_time(description.encoder_phase),
            watchdog: some(description.watchdog),
            transmission: Transmission::DIRECT,
            version: VERSION,
            supply: SUPPLY,
            temperature: TEMPERATURE,
        })
    }

    /// The same axis on this hardware, as [`Version::product`] counts it.
    #[must_use]
    pub const fn with_product(self, product: u32) -> Self {
        let [_, major, minor, variant] = product.to_be_bytes();
        Self { version: Version { hardware: [major, minor, variant], ..self.version }, ..self }
    }

    /// The same axis with this supply, V, and this temperature of its motor, °C.
    #[must_use]
    pub const fn with_readings(self, supply: f32, temperature: f32) -> Self {
        Self { supply, temperature, ..self }
    }

    /// The same axis with a gear between its motor, on which the encoder is, and the joint.
    #[must_use]
    pub const fn behind(self, transmission: Transmission) -> Self {
        Self { transmission, ..self }
    }

    /// Node id.
    pub const fn node(&self) -> AxisNode {
        self.node
    }
}

/// What `duration` of a clock that is `ppm` parts per million slow takes.
fn stretched(duration: Duration, ppm: i32) -> Duration {
    let nanoseconds = i128::try_from(duration.as_nanos()).unwrap_or(i128::MAX);
    let stretched = nanoseconds.saturating_add(nanoseconds.saturating_mul(ppm.into()) / 1_000_000);
    Duration::from_nanos(u64::try_from(stretched).unwrap_or_default())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::odrive) fn description(node: u8) -> AxisDescription {
        AxisDescription {
            node,
            maximum_torque: 0.2,
            direction: Direction::Positive,
            encoder: EncoderDescription { counts_per_revolution: 8_192, counter_bits: 32, zero_offset: 0 },
            heartbeat: Duration::from_millis(50),
            encoder_period: Duration::ZERO,
            encoder_phase: Duration::ZERO,
            watchdog: Duration::from_millis(50),
            clock_error_ppm: 0,
        }
    }

    #[test]
    fn what_no_axis_has_is_refused() {
        for node in [0, 63, 127] {
            assert_eq!(AxisParameters::new(description(node)), Err(AxisDescriptionError::Node { found: node }));
        }
        for maximum_torque in [0.0, -1.0, f64::NAN] {
            let refused = AxisParameters::new(AxisDescription { maximum_torque, ..description(3) });
            assert!(matches!(refused, Err(AxisDescriptionError::Torque { node: 3, .. })));
        }
        let refused = AxisParameters::new(AxisDescription { heartbeat: Duration::ZERO, ..description(3) });
        assert!(matches!(refused, Err(AxisDescriptionError::Heartbeat { node: 3, .. })));
        let encoder = EncoderDescription { counts_per_revolution: 1, ..description(3).encoder };
        let refused = AxisParameters::new(AxisDescription { encoder, ..description(3) });
        assert!(matches!(refused, Err(AxisDescriptionError::Encoder { node: 3, .. })));
    }

    #[test]
    fn a_slow_clock_stretches_periods() {
        assert_eq!(stretched(Duration::from_millis(50), 100), Duration::from_micros(50_005));
        assert_eq!(stretched(Duration::from_millis(50), -100), Duration::from_micros(49_995));
    }
}
