//! The CANopen master of the robot's drives.
//!
//! [`DriveNetwork::start`] and [`DriveNetwork::stop`] block, with timeouts. In the cycle there are only
//! [`DriveNetwork::sync`], [`DriveNetwork::collect`], [`DriveNetwork::send_torques`] and
//! [`DriveNetwork::housekeeping`]: they read no clock, allocate nothing, and wait nowhere but in `collect`, for its
//! deadline.

mod blocking;
mod configuration;
mod cycle;
mod disturbance;
mod error;
mod foreign;
mod health;
mod inquiry;
mod learn;
mod listen;
mod master;
mod receive;
mod start;
mod stop;

pub use super::sdo::{Expected, SdoError};
pub use super::wishes::{DriveConfiguration, Heartbeats, MAX_SETTINGS, ReadBack, Setting, Settings, SyncPayload};
pub use configuration::{
    ConfigurationError, EmergencyReaction, IgnoredTargetReaction, LISTEN, NetworkConfiguration, Timeouts,
};
pub use cycle::Feedback;
pub use disturbance::Disturbance;
pub use error::{CycleError, Emergency, StartError};
pub use foreign::ForeignFrame;
pub use health::{NetworkHealth, NodeHealth};
pub use master::{DriveNetwork, LastDefence, Learned};
pub use start::Started;
pub use stop::{Confirmation, DriveStop, StopReport};

#[cfg(test)]
mod tests;
