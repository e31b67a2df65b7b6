//! The generalised bell, Jang's membership function.

use std::ops::RangeInclusive;

use nalgebra::ComplexField;

use crate::error::AnfisError;
use crate::limits::{MAXIMUM_MAGNITUDE, MAXIMUM_STEEPNESS, MINIMUM_HALF_WIDTH, MINIMUM_STEEPNESS, in_magnitude};

/// The three parameters of a bell, by name: publications and programs list them in different orders.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct BellParameters {
    /// a: the distance from the centre at which μ is ½, in the unit of the input; from [`MINIMUM_HALF_WIDTH`] to
    /// [`MAXIMUM_MAGNITUDE`].
    pub half_width: f64,
    /// b: half the exponent, without unit; from [`MINIMUM_STEEPNESS`] to [`MAXIMUM_STEEPNESS`].
    pub steepness: f64,
    /// c: where μ is 1, in the unit of the input; of magnitude up to [`MAXIMUM_MAGNITUDE`].
    pub centre: f64,
}

/// A generalised bell set, μ(x) = 1 / (1 + |(x − c)/a|^2b).
///
/// μ(c) = 1, μ(c ± a) = ½ for every b, and the gradient there is ∓b/(2a).
///
/// # Example
/// ```
/// # use anfis::{Bell, BellParameters};
/// let bell = Bell::new(BellParameters { half_width: 10.0, steepness: 2.0, centre: -20.0 })?;
/// assert_eq!(bell.membership(-20.0), 1.0);
/// assert_eq!(bell.membership(-10.0), 0.5);
/// # Ok::<(), anfis::AnfisError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "BellParameters", into = "BellParameters")
)]
pub struct Bell(BellParameters);

#[cfg(feature = "serde")]
impl TryFrom<BellParameters> for Bell {
    type Error = AnfisError;

    fn try_from(parameters: BellParameters) -> Result<Self, AnfisError> {
        Self::new(parameters)
    }
}

#[cfg(feature = "serde")]
impl From<Bell> for BellParameters {
    fn from(bell: Bell) -> Self {
        bell.0
    }
}

/// Partial derivatives of ln μ at one point with respect to a, b and c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogDerivatives {
    /// ∂ln μ/∂a = 2b(1 − μ)/a, in 1 over the input's unit.
    pub half_width: f64,
    /// ∂ln μ/∂b = −2 ln|(x − c)/a| (1 − μ); 0 at the centre, its limit.
    pub steepness: f64,
    /// ∂ln μ/∂c = 2b(1 − μ)/(x − c), in 1 over the input's unit; 0 at the centre, by symmetry.
    pub centre: f64,
}

impl Bell {
    /// The bell with these parameters.
    ///
    /// # Errors
    /// [`AnfisError::HalfWidth`], [`AnfisError::Steepness`] or [`AnfisError::Centre`] for a value out of [`crate::limits`].
    pub fn new(parameters: BellParameters) -> Result<Self, AnfisError> {
        let BellParameters { half_width, steepness, centre } = parameters;
        if !(MINIMUM_HALF_WIDTH..=MAXIMUM_MAGNITUDE).contains(&half_width) {
            return Err(AnfisError::HalfWidth(half_width));
        }
        if !(MINIMUM_STEEPNESS..=MAXIMUM_STEEPNESS).contains(&steepness) {
            return Err(AnfisError::Steepness(steepness));
        }
        if !in_magnitude(centre) {
            return Err(AnfisError::Centre(centre));
        }
        Ok(Self(parameters))
    }

    /// The bell nearest to the parameters that a step of the training asks for. The function is even in a, so that its
    /// sign is dropped; a then stays above `least_half_width`, b in `steepness_range`.
    pub(crate) fn nearest(
        BellParameters { half_width, steepness, centre }: BellParameters,
        least_half_width: f64,
        steepness_range: RangeInclusive<f64>,
    ) -> Self {
        Self(BellParameters {
            half_width: half_width.abs().clamp(least_half_width.max(MINIMUM_HALF_WIDTH), MAXIMUM_MAGNITUDE),
            steepness: steepness.clamp(*steepness_range.start(), *steepness_range.end()),
            centre: centre.clamp(-MAXIMUM_MAGNITUDE, MAXIMUM_MAGNITUDE),
        })
    }

    /// The half width a, in the unit of the input.
    #[must_use]
    pub const fn half_width(&self) -> f64 {
        self.0.half_width
    }

    /// The steepness b, without unit.
    #[must_use]
    pub const fn steepness(&self) -> f64 {
        self.0.steepness
    }

    /// The centre c, in the unit of the input.
    #[must_use]
    pub const fn centre(&self) -> f64 {
        self.0.centre
    }

    /// The grade of membership μ(x), in [0, 1] for every finite `x`.
    #[must_use]
    pub fn membership(&self, x: f64) -> f64 {
        1.0 / (1.0 + self.ratio_power(x))
    }

    /// ln μ(x), finite for every finite `x`: also where μ(x) itself underflows to 0.
    #[must_use]
    pub fn log_membership(&self, x: f64) -> f64 {
        // ln(1 + e^p), written so that the exponential never overflows.
        let exponent = 2.0 * self.0.steepness * self.log_distance(x);
        -(exponent.max(0.0) + ComplexField::ln_1p(ComplexField::exp(-exponent.abs())))
    }

    /// The derivatives of ln μ at `x`. The logarithm is what the gradient needs: of a product it is a sum, and of a
    /// normalised firing strength it stays finite where all memberships vanish.
    #[must_use]
    pub fn log_derivatives(&self, x: f64) -> LogDerivatives {
        let power = self.ratio_power(x);
        let complement = if power.is_finite() { power / (1.0 + power) } else { 1.0 };
        if complement == 0.0 {
            return LogDerivatives { half_width: 0.0, steepness: 0.0, centre: 0.0 };
        }
        // Below the smallest length of this crate a distance is rounding; the floor keeps the quotient finite.
        let offset = x - self.0.centre;
        let floored = offset.abs().max(MINIMUM_HALF_WIDTH).copysign(offset);
        LogDerivatives {
            half_width: 2.0 * self.0.steepness * complement / self.0.half_width,
            steepness: -2.0 * self.log_distance(x) * complement,
            centre: 2.0 * self.0.steepness * complement / floored,
        }
    }

    /// |x − c|/a.
    fn distance(&self, x: f64) -> f64 {
        (x - self.0.centre).abs() / self.0.half_width
    }

    /// ln(|x − c|/a), with ln 0 taken as the logarithm of the smallest normal number.
    fn log_distance(&self, x: f64) -> f64 {
        ComplexField::ln(self.distance(x).max(f64::MIN_POSITIVE))
    }

    /// |(x − c)/a|^2b; may be infinite.
    fn ratio_power(&self, x: f64) -> f64 {
        ComplexField::powf(self.distance(x), 2.0 * self.0.steepness)
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    use super::*;

    fn bell(half_width: f64, steepness: f64, centre: f64) -> Result<Bell, AnfisError> {
        Bell::new(BellParameters { half_width, steepness, centre })
    }

    #[test]
    fn values_at_the_centre_and_at_half_width() {
        let bell = bell(0.625, 2.0, -0.75).unwrap();
        assert_eq!(bell.membership(-0.75), 1.0);
        assert_eq!(bell.membership(-0.125), 0.5);
        assert_eq!(bell.membership(-1.375), 0.5);
        let flat = bell.log_derivatives(-0.75);
        assert_eq!((flat.half_width, flat.steepness, flat.centre), (0.0, 0.0, 0.0));
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        for half_width in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(bell(half_width, 2.0, 0.0), Err(AnfisError::HalfWidth(_))));
        }
        for steepness in [0.0, -2.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(bell(1.0, steepness, 0.0), Err(AnfisError::Steepness(_))));
        }
        assert!(matches!(bell(1.0, 2.0, f64::NAN), Err(AnfisError::Centre(_))));
    }

    #[test]
    fn the_logarithm_survives_where_the_membership_vanishes() {
        let bell = bell(1e-3, 100.0, 0.0).unwrap();
        assert_eq!(bell.membership(1e9), 0.0);
        assert_relative_eq!(bell.log_membership(1e9), -200.0 * 1e12_f64.ln(), max_relative = 1e-14);
    }

    proptest! {
        #[test]
        fn derivatives_agree_with_central_differences(
            half_width in 0.3..3.0_f64, steepness in 0.6..4.0_f64, centre in -2.0..2.0_f64, x in -4.0..4.0_f64,
        ) {
            // Near the centre |x - c|^2b with b < 1 has no bounded second derivative: keep the difference away from it.
            prop_assume!((x - centre).abs() > 0.05);
            let at = |a, b, c| bell(a, b, c).unwrap().membership(x).ln();
            let step = 1e-6;
            let found = bell(half_width, steepness, centre).unwrap().log_derivatives(x);
            let difference = |plus: f64, minus: f64| (plus - minus) / (2.0 * step);
            // Central differences: step² truncation and eps/step rounding, both below 1e-8 here.
            let tolerance = 1e-7;
            let a = difference(at(half_width + step, steepness, centre), at(half_width - step, steepness, centre));
            let b = difference(at(half_width, steepness + step, centre), at(half_width, steepness - step, centre));
            let c = difference(at(half_width, steepness, centre + step), at(half_width, steepness, centre - step));
            prop_assert!((found.half_width - a).abs() < tolerance * (1.0 + a.abs()));
            prop_assert!((found.steepness - b).abs() < tolerance * (1.0 + b.abs()));
            prop_assert!((found.centre - c).abs() < tolerance * (1.0 + c.abs()));
        }

        #[test]
        fn nothing_is_ever_not_finite(
            half_width in 1e-12..1e12_f64, steepness in 1e-3..1e3_f64, centre in -1e12..1e12_f64, x in any::<f64>(),
        ) {
            prop_assume!(x.abs() <= MAXIMUM_MAGNITUDE);
            let bell = bell(half_width, steepness, centre).unwrap();
            prop_assert!((0.0..=1.0).contains(&bell.membership(x)));
            prop_assert!(bell.log_membership(x).is_finite());
            let d = bell.log_derivatives(x);
            prop_assert!(d.half_width.is_finite() && d.steepness.is_finite() && d.centre.is_finite());
        }
    }
}
