//! The Takagi–Sugeno systems of controllers 5 and 6 (paper eqs. 38–40).
//!
//! Per joint k nine rules over (q̃̇_k, q̃_k): IF the velocity error is A_i and the position error is B_j THEN
//! y = f_0 + f_1 q̃̇_k + f_2 q̃_k. Rule l = 3i + j fires with μ_l = min(A_i, B_j) (eq. 39), and
//! H_k = Σ_l μ_l y_l / Σ_l μ_l = ξ_kᵀΦ_k: ξ_k holds μ_l/Σμ·[1, q̃̇_k, q̃_k] rule by rule, Φ_k the 27 consequents. Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ).
//!
//! The sets are generalised bells, as ANFIS trains them (Jang 1993): A(x) = 1/(1 + |(x − c)/a|^{2b}).

use crate::{JointRegressor, TrackingError};
use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// Sets per input (paper section 4: r_1 = r_2 = 3).
pub const SETS: usize = 3;
/// Rules per joint, p_k = r_1 r_2.
pub const RULES: usize = SETS * SETS;
/// Consequents of a rule: f_0, f_1, f_2.
const CONSEQUENTS: usize = 3;
/// Adapted parameters of each joint.
pub const FUZZY_PARAMETERS: usize = RULES * CONSEQUENTS;

/// Σμ below which no rule is taken to fire. Normalising is exact well above the smallest f32, 1e-38.
const FIRING_FLOOR: f64 = 1e-30;

/// Whole exponents 2b up to this one are multiplied out.
const LARGEST_WHOLE_EXPONENT: u32 = 16;

/// A membership function A(x) = 1/(1 + |(x − c)/a|^{2b}).
///
/// Where 2b is a whole number n up to 16, as for b = 2, the power is made by squaring: n − 1 roundings at most, each half a unit
/// in the last place. For any other b it is `libm`'s, within one such unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralisedBell<T: Scalar> {
    shape: BellShape<T>,
    exponent: Exponent<T>,
}

/// 2b.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Exponent<T: Scalar> {
    Whole(u32),
    Real(T),
}

impl<T: Scalar> Exponent<T> {
    fn of(steepness: T) -> Self {
        let exponent = steepness + steepness;
        let whole = (1..=LARGEST_WHOLE_EXPONENT).find(|whole| T::constant(f64::from(*whole)) == exponent);
        whole.map_or(Self::Real(exponent), Self::Whole)
    }

    /// `base` to this power.
    fn power_of(&self, base: T) -> T {
        match *self {
            Self::Whole(exponent) => whole_power(base, exponent),
            Self::Real(exponent) => base.powf(exponent),
        }
    }
}

/// By squaring, from the lowest bit of the exponent to its highest.
fn whole_power<T: Scalar>(base: T, exponent: u32) -> T {
    let (mut power, mut square, mut left) = (T::one(), base, exponent);
    while left > 0 {
        if left % 2 == 1 {
            power *= square;
        }
        square *= square;
        left /= 2;
    }
    power
}

/// The numbers of a [`GeneralisedBell`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BellShape<T: Scalar> {
    /// c, in the unit of the input, finite.
    pub centre: T,
    /// a, in the unit of the input, positive: A is ½ at c ± a.
    pub half_width: T,
    /// b, half the exponent, positive.
    pub steepness: T,
}

/// Why a membership function is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BellError {
    /// The centre is NaN or infinite.
    #[error("the centre of a membership function must be a finite number")]
    Centre,
    /// a is not a positive finite number.
    #[error("the half width of a membership function is {found}, expected a positive finite number")]
    HalfWidth {
        /// The a found.
        found: f64,
    },
    /// b is not a positive finite number.
    #[error("the steepness of a membership function is {found}, expected a positive finite number")]
    Steepness {
        /// The b found.
        found: f64,
    },
}

impl<T: Scalar> GeneralisedBell<T> {
    /// The bell of this shape.
    ///
    /// # Errors
    /// [`BellError`] unless all are finite, a > 0 and b > 0.
    pub fn new(shape: BellShape<T>) -> Result<Self, BellError> {
        let positive = |value: T| value.is_finite() && value > T::zero();
        let BellShape { centre, half_width, steepness } = shape;
        if !centre.is_finite() {
            return Err(BellError::Centre);
        }
        if !positive(half_width) {
            return Err(BellError::HalfWidth { found: half_width.to_f64() });
        }
        if !positive(steepness) {
            return Err(BellError::Steepness { found: steepness.to_f64() });
        }
        Ok(Self::checked(shape))
    }

    fn checked(shape: BellShape<T>) -> Self {
        Self { shape, exponent: Exponent::of(shape.steepness) }
    }

    /// c, in the unit of the input.
    pub fn centre(&self) -> T {
        self.shape.centre
    }

    /// a, in the unit of the input.
    pub fn half_width(&self) -> T {
        self.shape.half_width
    }

    /// b.
    pub fn steepness(&self) -> T {
        self.shape.steepness
    }

    /// A(x), within [0, 1]: 0 far away, also where the power overflows.
    pub fn membership(&self, x: T) -> T {
        let distance = (x - self.shape.centre).abs() / self.shape.half_width;
        // 0^{2b} is taken out of powf's hands: it is 0 for every b > 0.
        if distance == T::zero() {
            return T::one();
        }
        T::one() / (T::one() + self.exponent.power_of(distance))
    }
}

/// The premises that all joints share, in rad/s and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuzzySets<T: Scalar> {
    /// A_1 … A_3 over the velocity error, rad/s.
    pub velocity: [GeneralisedBell<T>; SETS],
    /// B_1 … B_3 over the position error, rad.
    pub position: [GeneralisedBell<T>; SETS],
}

impl<T: Scalar> FuzzySets<T> {
    /// The grid before ANFIS has trained it, over the universes of the paper's Fig. 12: velocity bells at −20, 0 and 20 °/s
    /// (a = 10 °/s), position bells at −2, −0.75 and 0.5° (a = 0.625°), b = 2. The trained sets of Fig. 12 are lost.
    pub fn untrained() -> Self {
        let bell = |centre: f64, half_width: f64| {
            GeneralisedBell::checked(BellShape {
                centre: T::constant(centre.to_radians()),
                half_width: T::constant(half_width.to_radians()),
                steepness: T::constant(2.0),
            })
        };
        Self {
            velocity: [-20.0, 0.0, 20.0].map(|centre| bell(centre, 10.0)),
            position: [-2.0, -0.75, 0.5].map(|centre| bell(centre, 0.625)),
        }
    }
}

/// How a rule's two memberships become its firing strength.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Firing {
    /// The smaller one, as the paper has it (eq. 39).
    #[default]
    Minimum,
    /// Their product, as ANFIS is usually trained.
    Product,
}

/// The fuzzy systems of the joints, one for each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuzzySystem<T: Scalar> {
    sets: FuzzySets<T>,
    firing: Firing,
}

/// Ξ, and whether no rule fired for a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuzzyRegressor<T: Scalar, const N: usize = 2> {
    /// Ξ of eq. 40.
    pub regressor: JointRegressor<T, FUZZY_PARAMETERS, N>,
    /// Σμ vanished for a joint: all its rules were given the same strength.
    pub fell_back: bool,
}

impl<T: Scalar> FuzzySystem<T> {
    /// Systems with these premises and this firing. Sets that were trained with one firing should run with the same.
    pub fn new(sets: FuzzySets<T>, firing: Firing) -> Self {
        Self { sets, firing }
    }

    /// The premises.
    pub fn sets(&self) -> &FuzzySets<T> {
        &self.sets
    }

    /// The firing.
    pub fn firing(&self) -> Firing {
        self.firing
    }

    /// μ_l/Σμ of the nine rules for one joint's errors (rad/s, rad); they sum to 1. `None` where Σμ vanishes, far outside
    /// the universe.
    pub fn firing_strengths(&self, velocity_error: T, position_error: T) -> Option<SVector<T, RULES>> {
        let velocity = self.sets.velocity.map(|set| set.membership(velocity_error));
        let position = self.sets.position.map(|set| set.membership(position_error));
        let fired = velocity.map(|velocity| {
            position.map(|position| match self.firing {
                Firing::Minimum => velocity.min(position),
                Firing::Product => velocity * position,
            })
        });
        let fired = fired.as_flattened();
        let sum = fired.iter().fold(T::zero(), |sum, strength| sum + *strength);
        (sum >= T::constant(FIRING_FLOOR)).then(|| {
            let mut strengths = SVector::<T, RULES>::zeros();
            for (strength, fired) in strengths.as_mut_slice().iter_mut().zip(fired) {
                *strength = *fired / sum;
            }
            strengths
        })
    }

    /// Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ) of eq. 40. Where no rule fires, all nine are given the same strength: what bells of one width
    /// tend to as the error grows.
    pub fn regressor<const N: usize>(&self, error: &TrackingError<T, N>) -> FuzzyRegressor<T, N> {
        let mut columns = [[[T::zero(); CONSEQUENTS]; RULES]; N];
        let mut fell_back = false;
        let errors = error.velocity.iter().zip(error.position.iter());
        for (column, (&velocity_error, &position_error)) in columns.iter_mut().zip(errors) {
            let strengths = self.firing_strengths(velocity_error, position_error);
            fell_back |= strengths.is_none();
            let uniform = || SVector::repeat(T::one() / T::constant(9.0));
            let strengths: SVector<T, RULES> = strengths.unwrap_or_else(uniform);
            for (rule, strength) in column.iter_mut().zip(strengths.as_slice()) {
                *rule = [*strength, *strength * velocity_error, *strength * position_error];
            }
        }
        let mut rows = SMatrix::<T, FUZZY_PARAMETERS, N>::zeros();
        for (row, column) in rows.data.0.iter_mut().zip(&columns) {
            row.copy_from_slice(column.as_flattened());
        }
        FuzzyRegressor { regressor: JointRegressor::new(rows), fell_back }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bell(steepness: f64) -> GeneralisedBell<f64> {
        GeneralisedBell::new(BellShape { centre: 0.0, half_width: 1.0, steepness }).unwrap()
    }

    /// Powers of 3 and 1/2 have no rounding.
    #[test]
    fn a_whole_exponent_is_multiplied_out() {
        assert_eq!(bell(2.0).membership(3.0), 1.0 / 82.0);
        assert_eq!(bell(2.0).membership(-0.5), 16.0 / 17.0);
        assert_eq!(bell(0.5).membership(0.5), 2.0 / 3.0);
        assert_eq!(bell(1.5).membership(3.0), 1.0 / 28.0);
        for (exponent, power) in (1..=16).zip(core::iter::successors(Some(3.0), |power| Some(3.0 * power))) {
            assert_eq!(bell(f64::from(exponent) / 2.0).exponent, Exponent::Whole(exponent));
            assert_eq!(whole_power(3.0, exponent), power);
        }
        for exponent in [0.75, 4.2, 17.0, 1e300] {
            assert_eq!(bell(exponent / 2.0).exponent, Exponent::Real(exponent));
        }
    }

    /// `libm`'s power is within one unit in the last place, each product adds half of one.
    #[test]
    fn each_product_adds_half_a_unit_in_the_last_place() {
        for exponent in 1..=LARGEST_WHOLE_EXPONENT {
            for base in (1..1000).map(|step| f64::from(step) * 0.0037) {
                let (found, expected) = (whole_power(base, exponent), libm_power(base, exponent));
                let allowed = (0.5 * f64::from(exponent) + 0.5) * f64::EPSILON;
                assert!((found / expected - 1.0).abs() <= allowed, "{base}^{exponent}: {found:e}, not {expected:e}");
            }
        }
    }

    fn libm_power(base: f64, exponent: u32) -> f64 {
        nalgebra::ComplexField::powf(base, f64::from(exponent))
    }

    #[test]
    fn far_away_the_power_overflows_and_the_membership_is_zero() {
        assert_eq!(bell(8.0).membership(1e200), 0.0);
        assert_eq!(bell(8.0).membership(1e-200), 1.0);
    }
}
