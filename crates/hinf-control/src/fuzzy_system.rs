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

/// A membership function A(x) = 1/(1 + |(x − c)/a|^{2b}).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralisedBell<T: Scalar>(BellShape<T>);

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
        Ok(Self(shape))
    }

    /// c, in the unit of the input.
    pub fn centre(&self) -> T {
        self.0.centre
    }

    /// a, in the unit of the input.
    pub fn half_width(&self) -> T {
        self.0.half_width
    }

    /// b.
    pub fn steepness(&self) -> T {
        self.0.steepness
    }

    /// A(x), within [0, 1]: 0 far away, also where the power overflows.
    pub fn membership(&self, x: T) -> T {
        let distance = (x - self.0.centre).abs() / self.0.half_width;
        // 0^{2b} is taken out of powf's hands: it is 0 for every b > 0.
        if distance == T::zero() {
            return T::one();
        }
        T::one() / (T::one() + distance.powf(self.0.steepness + self.0.steepness))
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
            GeneralisedBell(BellShape {
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
        let pairs = velocity.iter().flat_map(|velocity| position.iter().map(move |position| (*velocity, *position)));
        let strengths = SVector::<T, RULES>::from_iterator(pairs.map(|(velocity, position)| match self.firing {
            Firing::Minimum => velocity.min(position),
            Firing::Product => velocity * position,
        }));
        let sum = strengths.sum();
        (sum >= T::constant(FIRING_FLOOR)).then(|| strengths / sum)
    }

    /// Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ) of eq. 40. Where no rule fires, all nine are given the same strength: what bells of one width
    /// tend to as the error grows.
    pub fn regressor<const N: usize>(&self, error: &TrackingError<T, N>) -> FuzzyRegressor<T, N> {
        let mut rows = SMatrix::<T, FUZZY_PARAMETERS, N>::zeros();
        let mut fell_back = false;
        let errors = error.velocity.iter().zip(error.position.iter());
        for (mut row, (&velocity_error, &position_error)) in rows.column_iter_mut().zip(errors) {
            let strengths = self.firing_strengths(velocity_error, position_error);
            fell_back |= strengths.is_none();
            let uniform = || SVector::repeat(T::one() / T::constant(9.0));
            let strengths: SVector<T, RULES> = strengths.unwrap_or_else(uniform);
            let terms = strengths.iter().flat_map(|s| [*s, *s * velocity_error, *s * position_error]);
            for (element, term) in row.iter_mut().zip(terms) {
                *element = term;
            }
        }
        FuzzyRegressor { regressor: JointRegressor::new(rows), fell_back }
    }
}
