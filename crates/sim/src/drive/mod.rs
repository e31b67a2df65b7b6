//! Emulated CiA 402 drives: the slaves of `uarm_io`'s master, one [`EmulatedDrive`] per joint.
//!
//! | file | subject |
//! |---|---|
//! | `dictionary` | every object: address, access, mapping, value at power-on ([`OBJECTS`]) |
//! | `services` | NMT, SDO, heartbeat, RPDO |
//! | `sdo_rules` | writes that are refused, as real drives refuse them |
//! | `power` | power state machine, torque, faults, and the objects that show them |
//! | `timers` | heartbeat and watchdogs |
//! | `encoder` | angle → counts |
//! | `faults` | what a test can break |

mod dictionary;
mod emulated;
mod encoder;
mod faults;
mod parameters;
mod power;
mod sdo_rules;
mod services;
mod timers;

pub use dictionary::{DictionaryEntry, Mappable, OBJECTS};
pub use emulated::EmulatedDrive;
pub(crate) use emulated::Reaction;
pub use encoder::{Encoder, EncoderDescription, EncoderError};
pub use faults::DriveFault;
pub use parameters::{DriveDescription, DriveError, DriveParameters};
