//! From encoder counts to rates, from torques to drives.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod drive;
pub mod frame;
pub mod link;
#[cfg(feature = "std")]
pub mod monotonic;
#[cfg(feature = "std")]
pub mod socketcan_link;
pub mod time;
