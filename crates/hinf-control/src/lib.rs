//! Nonlinear H∞ control of free-floating space manipulators.
#![no_std]
#![forbid(unsafe_code)]

mod controller;
pub use controller::*;
