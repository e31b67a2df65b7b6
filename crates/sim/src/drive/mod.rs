//! Emulated CiA 402 drives: the slaves of `uarm_io`'s master, one [`EmulatedDrive`] per joint.
//!
//! | file | subject |
//! |---|---|
//! | `dictionary` | every object: address, access, mapping, value at power-on ([`OBJECTS`]) |
//! | `state` | what a drive holds |
//! | `emulated` | construction, frames, time, faults brought about |
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
mod state;
mod timers;

pub use dictionary::{DictionaryEntry, Mappable, OBJECTS};
pub use encoder::{Encoder, EncoderDescription, EncoderError};
pub use faults::DriveFault;
pub use parameters::{DriveDescription, DriveError, DriveParameters};
pub use state::EmulatedDrive;
pub(crate) use state::Reaction;
