//! What goes wrong with the axes.

use super::turns::TurnsError;
use super::wire::{AxisNode, Heartbeat, Message, Version};
use crate::drive::readings::{Found, Quantity};
use crate::time::Duration;
use core::fmt;

/// A frame that only the axes' master sends, from somebody else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignCommand {
    /// The axis that it is for.
    pub axis: AxisNode,
    /// What it is.
    pub message: Message,
}

impl fmt::Display for ForeignCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, message } = self;
        let identifier = message.identifier(*axis).as_raw();
        write!(
            f,
            "{} to ODrive axis {axis} (identifier {identifier:03X}h) is not from this controller: ",
            message.name()
        )?;
        f.write_str("is another one running on this bus?")
    }
}

/// Why the axes did not start. After any of these the robot has to be stopped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OdriveStartError<E> {
    /// The link failed.
    #[error("the CAN link failed")]
    Link(#[from] E),
    /// Somebody else commands the axes.
    #[error("{0}")]
    AnotherMaster(ForeignCommand),
    /// More answers than requests.
    #[error("{}", Twins(*axis))]
    TwoAxes {
        /// The axis.
        axis: AxisNode,
    },
    /// No heartbeat came.
    #[error(
        "no heartbeat of ODrive axis {axis} within {waited:?}: check its supply, node_id, bit rate and heartbeat_msg_rate_ms"
    )]
    NotHeard {
        /// The axis.
        axis: AxisNode,
        /// Time waited.
        waited: Duration,
    },
    /// It is another hardware than the configuration says.
    #[error("ODrive axis {axis} says that it is {}, the configuration says product {product:08X}h", Told(*.found))]
    AnotherProduct {
        /// The axis.
        axis: AxisNode,
        /// What the configuration says.
        product: u32,
        /// What it told.
        found: Option<Version>,
    },
    /// What is watched did not come.
    #[error("ODrive axis {axis} does not tell its {} within {waited:?}: is its firmware 0.6?", quantity.name())]
    NoReading {
        /// The axis.
        axis: AxisNode,
        /// What it was asked for.
        quantity: Quantity,
        /// Time waited.
        waited: Duration,
    },
    /// Its supply voltage or temperature is beyond its limits.
    #[error("ODrive axis {axis}: {found}")]
    Reading {
        /// The axis.
        axis: AxisNode,
        /// What it reported, and what is allowed.
        found: Found,
    },
    /// It did not come to a state.
    #[error("ODrive axis {axis} is in {}, expected {expected} after {waited:?}", State(*.found))]
    NotReached {
        /// The axis.
        axis: AxisNode,
        /// What was wanted.
        expected: &'static str,
        /// Its last heartbeat.
        found: Heartbeat,
        /// Time waited.
        waited: Duration,
    },
    /// Its position did not come.
    #[error(
        "ODrive axis {axis} gave no position within {waited:?}: check encoder_msg_rate_ms (0 where positions are asked for) and that its firmware is 0.6"
    )]
    NoPosition {
        /// The axis.
        axis: AxisNode,
        /// Time waited.
        waited: Duration,
    },
    /// Its position cannot be used.
    #[error("ODrive axis {axis}: {source}")]
    Position {
        /// The axis.
        axis: AxisNode,
        /// Why.
        source: TurnsError,
    },
    /// It sends positions that nobody asked for.
    #[error(
        "ODrive axis {axis} sends positions by itself, expected only answers: set encoder_msg_rate_ms = 0 in it, or its rate in the robot file"
    )]
    Unrequested {
        /// The axis.
        axis: AxisNode,
    },
    /// It stayed armed without a torque for longer than its watchdog should allow.
    #[error("ODrive axis {axis} is in {} {waited:?} after the last torque, expected to be disarmed by its watchdog: set axis0.config.enable_watchdog and watchdog_timeout in it", State(*.found))]
    NoWatchdog {
        /// The axis.
        axis: AxisNode,
        /// Its last heartbeat.
        found: Heartbeat,
        /// Time without a torque.
        waited: Duration,
    },
}

/// What goes wrong in a cycle. After any of these the robot has to be stopped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OdriveCycleError<E> {
    /// The link failed.
    #[error("the CAN link failed")]
    Link(#[from] E),
    /// Somebody else commands the axes.
    #[error("{0}")]
    AnotherMaster(ForeignCommand),
    /// More answers than requests.
    #[error("{}", Twins(*axis))]
    TwoAxes {
        /// The axis.
        axis: AxisNode,
    },
    /// A position cannot be used.
    #[error("ODrive axis {axis}: {source}")]
    Position {
        /// The axis.
        axis: AxisNode,
        /// Why.
        source: TurnsError,
    },
    /// An axis disarmed or reports an error.
    #[error("ODrive axis {axis} is in {}, expected CLOSED_LOOP_CONTROL without error", State(*.found))]
    NotArmed {
        /// The axis.
        axis: AxisNode,
        /// Its last heartbeat.
        found: Heartbeat,
    },
    /// Its supply voltage or temperature is beyond its limits.
    #[error("ODrive axis {axis}: {found}")]
    Reading {
        /// The axis.
        axis: AxisNode,
        /// What it reported, and what is allowed.
        found: Found,
    },
    /// It does not tell any more what is watched.
    #[error("ODrive axis {axis} does not tell its {} any more", quantity.name())]
    NoReading {
        /// The axis.
        axis: AxisNode,
        /// What it was asked for.
        quantity: Quantity,
    },
    /// An axis's heartbeat stopped.
    #[error("ODrive axis {axis} has been silent for {silence:?}, expected a heartbeat within {limit:?}")]
    Lost {
        /// The axis.
        axis: AxisNode,
        /// Time since its last heartbeat.
        silence: Duration,
        /// Time borne.
        limit: Duration,
    },
}

struct Told(Option<Version>);

impl fmt::Display for Told {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(version) => write!(formatter, "product {version}"),
            None => formatter.write_str("nothing (Get_Version has no answer)"),
        }
    }
}

struct Twins(AxisNode);

impl fmt::Display for Twins {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ODrive axis {} answered more often than it was asked: are there two axes with node id {0}?", self.0)
    }
}

struct State(Heartbeat);

impl fmt::Display for State {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Heartbeat { error, state, .. } = self.0;
        if error.is_none() { write!(formatter, "{state}") } else { write!(formatter, "{state} with {error}") }
    }
}
