//! What can go wrong between master and drives; each error says which node, what was found and what was expected.

use super::disturbance::Disturbance;
use crate::drive::cia402::{PowerState, Statusword};
use crate::drive::plan::Finding;
use crate::drive::readings::Found;
use crate::drive::sdo::SdoError;
use crate::drive::words::{self, Named, Shown};
use canopen_rs::{Address, EmergencyMessage, NmtState, Value};
use core::fmt;
use core::time::Duration;

/// Why the drives did not start.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StartError<E> {
    /// The link failed.
    #[error("the CAN link failed")]
    Link(#[from] E),
    /// Another master was heard, or a drive booted anew.
    #[error("{0}")]
    Disturbed(Disturbance),
    /// A drive reported an emergency after it was addressed, and did not say that it is over.
    #[error("node {node} reports an emergency: {}", Emergency(*.message))]
    Emergency {
        /// The drive's node id.
        node: u8,
        /// The emergency message.
        message: EmergencyMessage,
    },
    /// An object could not be read or written.
    #[error(transparent)]
    Sdo(SdoError<E>),
    /// No boot-up message after the reset.
    #[error(
        "node {node} did not boot in {waited:?} after its reset: is it powered, and on this bus with this bit rate?"
    )]
    NoBootUp {
        /// The drive's node id.
        node: u8,
        /// Time waited.
        waited: Duration,
    },
    /// Not a drive.
    #[error("node {node} has device profile {profile}, expected 402, a drive")]
    NotADrive {
        /// Its node id.
        node: u8,
        /// Low word of 1000h.
        profile: u16,
    },
    /// An object reads otherwise than it was written.
    #[error("node {node}: {} was written as {} and reads {}", Named(*.object), Shown(*.written), Shown(*.found))]
    ReadBack {
        /// The drive's node id.
        node: u8,
        /// The object that was read or written.
        object: Address,
        /// The value written.
        written: Value,
        /// The value read.
        found: Value,
    },
    /// An object is not any more what it was or was written as, after another object was written.
    #[error(
        "node {node}: {} was {} and reads {} after another object was written: it belongs into drive.writes with when = \"after\"",
        Named(*.object), Shown(*.written), Shown(*.found)
    )]
    Undone {
        /// The drive's node id.
        node: u8,
        /// The object.
        object: Address,
        /// The value that it should have.
        written: Value,
        /// The value read.
        found: Value,
    },
    /// The drive is another than the configuration says.
    #[error("node {node}: {} is {}, the configuration says {}", Named(*.object), Shown(*.found), Shown(*.expected))]
    Mismatch {
        /// The drive's node id.
        node: u8,
        /// The object that was read or written.
        object: Address,
        /// The value that the configuration states.
        expected: Value,
        /// The value read.
        found: Value,
    },
    /// The drive cannot be run as the configuration says.
    #[error("node {node}: {finding}")]
    Refused {
        /// The drive's node id.
        node: u8,
        /// What was found, what was expected, and what helps.
        finding: Finding,
    },
    /// The drive's supply voltage or temperature is beyond its limits.
    #[error("node {node}: {found}")]
    Reading {
        /// The drive's node id.
        node: u8,
        /// What it reported, and what is allowed.
        found: Found,
    },
    /// The drive bore the absence of its commands.
    #[error(
        "node {node} got no command for {waited:?} and did not react, expected a fault: its timeout 1400h:05 acts only when it is enabled, or not at all; try that by hand and say how in drive.watchdog_test"
    )]
    WatchdogSilent {
        /// The drive's node id.
        node: u8,
        /// Time waited.
        waited: Duration,
    },
    /// The drive did not become operational.
    #[error("node {node} reports {}, expected NMT Operational", OptionalState(*.found))]
    NotOperational {
        /// The drive's node id.
        node: u8,
        /// Its last heartbeat.
        found: Option<NmtState>,
    },
    /// The drive did not reach a state of CiA 402.
    #[error("node {node} is in {found}, expected {expected} after {waited:?}{}", LastEmergency(*.emergency))]
    NotReached {
        /// The drive's node id.
        node: u8,
        /// The state that was wanted.
        expected: PowerState,
        /// The statusword that it reported.
        found: Statusword,
        /// Time waited.
        waited: Duration,
        /// Its last emergency message.
        emergency: Option<EmergencyMessage>,
    },
}

impl<E> From<SdoError<E>> for StartError<E> {
    fn from(error: SdoError<E>) -> Self {
        match error {
            SdoError::Link(error) => Self::Link(error),
            SdoError::Disturbed(disturbance) => Self::Disturbed(disturbance),
            error => Self::Sdo(error),
        }
    }
}

/// What goes wrong in a cycle. After any of these the robot has to be stopped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CycleError<E> {
    /// The link failed.
    #[error("the CAN link failed")]
    Link(#[from] E),
    /// Another master was heard, a drive booted anew, or two have one node id.
    #[error("{0}")]
    Disturbed(Disturbance),
    /// A drive left *Operation enabled*.
    #[error("node {node} is in {found}, expected Operation enabled{}", LastEmergency(*.emergency))]
    NotEnabled {
        /// The drive's node id.
        node: u8,
        /// The statusword that it reported.
        found: Statusword,
        /// Its last emergency message.
        emergency: Option<EmergencyMessage>,
    },
    /// A drive ignores its target torque, which it followed before.
    #[error("node {node} ignores its target torque: bit 12 is 0 in {found}, and was 1 before")]
    TargetIgnored {
        /// The drive's node id.
        node: u8,
        /// The statusword that it reported.
        found: Statusword,
    },
    /// A drive reported an emergency.
    #[error("node {node} reports an emergency: {}", Emergency(*.message))]
    Emergency {
        /// The drive's node id.
        node: u8,
        /// The emergency message.
        message: EmergencyMessage,
    },
    /// A drive's heartbeat stopped.
    #[error("node {node} has been silent for {silence:?}, expected a heartbeat within {limit:?}")]
    Lost {
        /// The drive's node id.
        node: u8,
        /// Time since its last heartbeat.
        silence: Duration,
        /// Time borne.
        limit: Duration,
    },
    /// A drive's supply voltage or temperature is beyond its limits.
    #[error("node {node}: {found}")]
    Reading {
        /// The drive's node id.
        node: u8,
        /// What it reported, and what is allowed.
        found: Found,
    },
    /// A drive does not answer what it is asked for.
    #[error("node {node} does not tell its supply voltage or temperature any more")]
    NoReading {
        /// The drive's node id.
        node: u8,
    },
    /// A drive left NMT Operational.
    #[error("node {node} reports {}, expected NMT Operational", OptionalState(Some(*.found)))]
    NotOperational {
        /// The drive's node id.
        node: u8,
        /// The NMT state that it reported.
        found: NmtState,
    },
}

/// An emergency message in words.
#[derive(Clone, Copy, Debug)]
pub struct Emergency(pub EmergencyMessage);

impl fmt::Display for Emergency {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EmergencyMessage { error_code, error_register, vendor_specific } = self.0;
        write!(formatter, "{} ({error_code:04X}h, ", words::emergency_code(error_code))?;
        write!(formatter, "error register {:02X}h, maker's bytes {vendor_specific:02X?})", error_register.0)
    }
}

struct LastEmergency(Option<EmergencyMessage>);

impl fmt::Display for LastEmergency {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(message) => write!(formatter, "; its last emergency message: {}", Emergency(message)),
            None => Ok(()),
        }
    }
}

struct OptionalState(Option<NmtState>);

impl fmt::Display for OptionalState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(words::nmt_state(self.0))
    }
}
