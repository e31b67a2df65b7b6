//! Ranges that keep every intermediate result finite.
//!
//! With data of magnitude at most 1e12 and half widths of at least 1e-12 no square, quotient or product that the training
//! forms leaves the range of `f64`, and no sum is lost to rounding altogether; real signals in SI units are decades inside.

/// Largest magnitude of a sample, a centre or an end of a universe.
pub const MAXIMUM_MAGNITUDE: f64 = 1e12;
/// Smallest span of a universe.
pub const MINIMUM_SPAN: f64 = 1e-6;
/// Smallest half width of a bell: the narrowest that the training leaves on the narrowest universe.
pub const MINIMUM_HALF_WIDTH: f64 = 1e-12;
/// Smallest steepness b: the training never takes a bell below it (b ≤ 0 would turn the bell inside out).
pub const MINIMUM_STEEPNESS: f64 = 1e-3;
/// Largest steepness b: at 1000 the bell is a rectangle for all purposes.
pub const MAXIMUM_STEEPNESS: f64 = 1e3;
/// Smallest half width that the training leaves, as a fraction of the universe's span.
pub const MINIMUM_RELATIVE_HALF_WIDTH: f64 = 1e-6;
/// Smallest span of a universe relative to the magnitude of its ends: below it the grid's centres would coincide.
pub const MINIMUM_RELATIVE_SPAN: f64 = 1e-9;
/// Largest number of rules. The least squares problem has (inputs + 1) columns per rule.
pub const MAXIMUM_RULES: usize = 4096;

/// Whether a value is finite and of an allowed magnitude.
pub(crate) fn in_magnitude(value: f64) -> bool {
    value.abs() <= MAXIMUM_MAGNITUDE
}
