//! Why an SDO transfer failed: which node, which object, what was found and what was expected.

use super::command::{DOWNLOAD_RESPONSE, SPECIFIER, UPLOAD_RESPONSE};
use crate::drive::network::Disturbance;
use crate::drive::words::{self, Named};
use canopen_rs::Address;
use core::fmt;
use core::time::Duration;

/// An SDO transfer that failed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SdoError<E> {
    /// The link failed.
    #[error("the CAN link failed")]
    Link(#[from] E),
    /// The bus was disturbed meanwhile.
    #[error("{0}")]
    Disturbed(Disturbance),
    /// The drive did not answer.
    #[error("node {node} did not answer for {} in {waited:?}, {attempts} times", Named(*.object))]
    Timeout {
        /// The drive's node id.
        node: u8,
        /// The object that was read or written.
        object: Address,
        /// Time waited each time.
        waited: Duration,
        /// Requests made.
        attempts: u8,
    },
    /// The drive refused.
    #[error("node {node} refused {}: {} ({code:08X}h)", Named(*.object), words::abort_code(*.code))]
    Abort {
        /// The drive's node id.
        node: u8,
        /// The object that was read or written.
        object: Address,
        /// The code it gave.
        code: u32,
    },
    /// The drive's response does not fit the request, or has another length than the object's type.
    #[error("node {node} answered for {} with command {command:02X}h, expected a {expected}", Named(*.object))]
    Response {
        /// The drive's node id.
        node: u8,
        /// The object that was read or written.
        object: Address,
        /// The command specifier, first byte of the response.
        command: u8,
        /// What was asked for.
        expected: Expected,
    },
}

/// What an SDO request asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// A value of this type.
    Value(canopen_rs::DataType),
    /// A confirmation.
    Confirmation,
}

impl Expected {
    /// True if a response with this command specifier answers a request of the other kind.
    pub(in crate::drive) const fn is_of_another(self, command: u8) -> bool {
        match self {
            Self::Value(_) => command == DOWNLOAD_RESPONSE,
            Self::Confirmation => command & SPECIFIER == UPLOAD_RESPONSE,
        }
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(data_type) => write!(formatter, "value of type {data_type:?}"),
            Self::Confirmation => formatter.write_str("confirmation"),
        }
    }
}
