//! The deploy binary.
#![forbid(unsafe_code)]
fn main() {}
