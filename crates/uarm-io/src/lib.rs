//! From encoder counts to rates, from torques to drives.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

#[cfg(test)]
extern crate std;

pub mod bus_time;
pub mod drive;
pub mod encoder;
pub mod estimator;
#[cfg(feature = "std")]
pub mod finding;
pub mod frame;
pub mod link;
#[cfg(feature = "std")]
pub mod monotonic;
#[cfg(feature = "std")]
pub mod probe;
pub mod real;
#[cfg(feature = "std")]
pub mod realtime;
#[cfg(feature = "std")]
pub mod socketcan_link;
pub mod time;
pub mod torque;
