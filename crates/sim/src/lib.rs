//! Deterministic plants and the emulated drives that carry them.
#![forbid(unsafe_code)]

mod plant;
pub use plant::Plant;
