//! ODrive motor controllers on CAN, protocol *CANSimple*: the second implementation of
//! [`RobotDrives`](crate::drive::RobotDrives).
//!
//! Identifiers, fields and units are those of the maker's documentation for firmware 0.6
//! (<https://docs.odriverobotics.com/v/latest/manual/can-protocol.html>). None of this was tried on hardware.
//!
//! | module | subject |
//! |---|---|
//! | [`wire`] | identifiers and payloads of the messages used |
//! | [`axis_error`] | the axis error's bits in words |
//! | [`turns`] | positions in turns, as `f32`, to the counts of the encoder stage |
//! | [`OdriveNetwork`] | the master: start, cycle, supervision, stop |
//!
//! What differs from CANopen: there is no SYNC that makes all axes latch their positions at one instant ([`Positions`]); an
//! axis has a watchdog instead of a heartbeat consumer, fed by each torque; an axis error comes with the axis's heartbeat,
//! not at once.

pub mod axis_error;
mod configuration;
mod cycle;
mod error;
mod inquiry;
mod master;
mod start;
mod stop;
pub mod turns;
mod watched;
pub mod wire;

pub use configuration::{OdriveAxis, OdriveConfiguration, OdriveTimes, Positions};
pub use error::{ForeignCommand, OdriveCycleError, OdriveStartError};
pub use master::{Identified, OdriveNetwork};

#[cfg(test)]
mod tests;
