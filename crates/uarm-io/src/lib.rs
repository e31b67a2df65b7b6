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
pub mod frame;
pub mod link;
#[cfg(feature = "std")]
pub mod monotonic;
pub mod real;
#[cfg(feature = "std")]
pub mod socketcan_link;
pub mod time;
pub mod torque;
