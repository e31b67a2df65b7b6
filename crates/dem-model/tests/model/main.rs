//! The model's tests: against published vectors, against itself computed in other ways, and against the laws of
//! mechanics.

mod common;

mod equivalence;
mod kinematics;
mod properties;
mod reduction;
mod serial;
mod single_precision;
mod three_ways;
mod validation;
mod vectors;
