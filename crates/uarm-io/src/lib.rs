//! From encoder counts to joint velocities, from torques to drives.
//!
//! ```
//! use uarm_io::bus_time::{BitRate, BusTime};
//! use uarm_io::encoder::CountsPerRevolution;
//! use uarm_io::estimator::{LowPassDerivative, VelocityEstimator};
//! use uarm_io::time::Duration;
//! use uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Counts to angles, angles to a velocity: a joint that turns 10 counts every 3 ms.
//! let encoder = CountsPerRevolution::new(8_000)?;
//! let mut estimator = VelocityEstimator::new(LowPassDerivative::new(27.8)?);
//! let mut velocity = 0.0;
//! for cycle in 0..200 {
//!     let angle = f64::from(10 * cycle) * encoder.resolution();
//!     velocity = estimator.update(angle, 0.003).velocity;
//! }
//! assert!((velocity - 10.0 * encoder.resolution() / 0.003).abs() < 1e-6);
//!
//! // A torque to the per mille that a drive takes.
//! let scale = TorqueScale {
//!     rated_torque: RatedTorque::from_millinewton_metres(200)?,
//!     direction: Default::default(),
//!     ceiling: TorqueCeiling::RATED,
//!     transmission: Default::default(),
//! };
//! assert_eq!(scale.to_drive(0.0706)?.per_mille, 353);
//!
//! // Three drives on 1 Mbit/s take 0.695 ms of each 3 ms at worst.
//! let bus = BusTime::of_cycle(3, BitRate::FASTEST, Duration::from_millis(3))?;
//! assert_eq!(bus.cyclic, Duration::from_micros(695));
//! # Ok(())
//! # }
//! ```
//!
//! The core is `no_std` and never allocates; time is passed in. What is marked *std* comes with the feature of that name.
//!
//! | module | subject |
//! |---|---|
//! | [`frame`], [`link`], [`time`] | the contracts: a frame, a way to send and receive it, a clock |
//! | [`encoder`] | counters that wrap → counts → angles |
//! | [`estimator`] | angles → velocities and accelerations, four ways |
//! | [`gear`] | the gear between motor and joint |
//! | [`torque`] | N·m ↔ per mille of the rated torque |
//! | [`bus_time`] | worst-case bus time of a cycle |
//! | [`drive`] | CiA 402 drives on CANopen: objects, wire, states, and their master |
//! | `monotonic`, `socketcan_link` | *std*: CLOCK_MONOTONIC and SocketCAN |
//! | `realtime`, `probe`, `finding` | *std*: the real-time thread, and what a machine offers it |
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
pub mod gear;
pub mod link;
#[cfg(feature = "std")]
pub mod monotonic;
#[cfg(feature = "std")]
pub mod probe;
#[cfg(feature = "std")]
pub mod realtime;
#[cfg(feature = "std")]
pub mod socketcan_link;
pub mod time;
pub mod torque;

pub use canopen_rs;
pub use embedded_can;
pub use nalgebra;

/// The README's example, compiled and run.
#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
struct Readme;
