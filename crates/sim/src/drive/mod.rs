//! Emulated CiA 402 drives: the slaves of `uarm_io`'s master, one [`EmulatedDrive`] per joint.
//!
//! | file | subject |
//! |---|---|
//! | `dictionary` | every object of its own: address, access, mapping, value at power-on ([`OBJECTS`]) |
//! | `objects` | which objects a drive has: its own, or those of a maker's dictionary ([`DriveDictionary`]) |
//! | `memory` | what a drive remembers from one frame to the next |
//! | `numbers` | integers of any type |
//! | `state` | what a drive holds |
//! | `emulated` | construction, frames, time, faults brought about |
//! | `services` | NMT, boot, heartbeat, SYNC; what is done about objects that were written |
//! | `pdos` | RPDOs and TPDOs |
//! | `sdo` | the SDO server |
//! | `errors` | error register and history, emergencies |
//! | `sdo_rules` | writes that are refused, as real drives refuse them |
//! | `power` | power state machine, torque, faults, and the objects that show them |
//! | `homing` | finding the home position by itself |
//! | `homing_state` | what is remembered of that |
//! | `speed_loop` | turning the motor for that |
//! | `timers` | heartbeat and watchdogs |
//! | `encoder` | angle → counts |
//! | `faults` | what a test can break |

mod dictionary;
mod emulated;
mod encoder;
mod errors;
mod faults;
mod homing;
mod homing_state;
mod memory;
mod numbers;
mod objects;
mod parameters;
mod pdos;
mod power;
mod sdo;
mod sdo_rules;
mod services;
mod speed_loop;
mod state;
mod timers;

pub use canopen_rs::AccessType;
pub use dictionary::{CAPACITY, DictionaryEntry, Mappable, OBJECTS};
pub use encoder::{Encoder, EncoderDescription, EncoderError};
pub use faults::DriveFault;
pub use numbers::value_of;
pub use objects::{DictionaryError, DriveDictionary, DriveObject};
pub use parameters::{CounterAtPowerUp, DriveDescription, DriveError, DriveParameters, PowerUp};
pub use state::EmulatedDrive;
pub(crate) use state::Reaction;
