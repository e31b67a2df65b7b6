//! Space manipulators and their dynamically equivalent manipulators (DEM).
#![no_std]
#![forbid(unsafe_code)]

mod scalar;
pub use scalar::Scalar;
