//! Which attenuation level a design provably has, without the paper's tacit assumption that T11 commutes with M.
//!
//! Let R and T11 = diag(t_i) be diagonal. Where the law leaves the error dynamics
//! M ṡ + C s = −R⁻¹s + T11⁻¹ω with Ṁ − 2C skew (controller 1 with the true base acceleration, or reduced), take
//! V = ½c sᵀMs + ½q̃ᵀKq̃. With eq. 9 for the level γ₀ that was designed for,
//!
//! 2(V̇ + ½x̃ᵀQx̃ + ½uᵀRu − ½γ²ωᵀω) = Σ_i [−2c/R_i + t_i²(2/R_i − 1/γ₀²)] s_i² + 2c/t_i s_iω_i − γ²ω_i²,
//!
//! which is never positive if c²/(t_i²γ²) − 2c/R_i + t_i²(2/R_i − 1/γ₀²) ≤ 0 for all i, that is, if the one number c lies
//! in all intervals t_i²γ²[1/R_i ± √(1/R_i² − (2/R_i − 1/γ₀²)/γ²)]. Then γ bounds the ratio of eq. 8. The
//! intervals only grow with γ, so the smallest such γ is found by bisection.
//!
//! At γ = γ₀ the intervals are [t_i², t_i²(2γ²/R_i − 1)]: the level designed for is proven exactly where
//! max t_i² ≤ min t_i²(2γ²/R_i − 1). T11 = tI always qualifies, and so does every row of Table 3.

use crate::Synthesis;
use crate::spectral::is_diagonal;
use dem_model::Scalar;
use nalgebra::SVector;

/// A level that [`Synthesis::proven_attenuation_level`] proves, with the storage function that proves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProvenAttenuation<T: Scalar> {
    /// γ² that the ratio of eq. 8 never exceeds.
    pub level_squared: T,
    /// c of V = ½c sᵀMs + ½q̃ᵀKq̃.
    pub storage_gain: T,
}

/// Bisections: more than the bits of a mantissa.
const BISECTIONS: usize = 64;
/// Doublings of γ² in search of a level that holds: more than the exponents of f64.
const DOUBLINGS: usize = 1100;

impl<T: Scalar, const N: usize> Synthesis<T, N> {
    /// The smallest γ² that is proven for this design, with the true base acceleration or the reduced law; `None` if the
    /// theorem does not apply: T11 is not tI, and R or T11 is not diagonal.
    ///
    /// ```
    /// use hinf_control::{ControllerSettings, Law, Synthesis};
    /// let design = Synthesis::new(&ControllerSettings::default().weights::<f64>(Law::Nonlinear))?;
    /// let proven = design.proven_attenuation_level().expect("Table 3 is diagonal");
    /// assert!((proven.level_squared - 3.526).abs() < 1e-3); // less than γ² = 4
    /// # Ok::<(), hinf_control::SynthesisError>(())
    /// ```
    pub fn proven_attenuation_level(&self) -> Option<ProvenAttenuation<T>> {
        let designed = self.attenuation_level() * self.attenuation_level();

        let t = self.t11().diagonal();
        if !(is_diagonal(self.t11()) && is_diagonal(self.control_weight())) {
            let one = t.iter().next().copied().filter(|first| t.iter().all(|other| other == first))?;
            let proven = ProvenAttenuation { level_squared: designed, storage_gain: one * one };
            return is_diagonal(self.t11()).then_some(proven);
        }
        let t_squared = t.map(|t| t * t);
        let intervals = StorageGains { t_squared, control: self.control_weight().diagonal(), designed };
        intervals.smallest_level()
    }
}

/// The intervals that c must lie in.
struct StorageGains<T: Scalar, const N: usize> {
    t_squared: SVector<T, N>,
    control: SVector<T, N>,
    /// γ₀².
    designed: T,
}

impl<T: Scalar, const N: usize> StorageGains<T, N> {
    fn smallest_level(&self) -> Option<ProvenAttenuation<T>> {
        let two = T::constant(2.0);
        let mut holds = self.designed;
        // R < γ₀²I leaves each interval non-empty for large γ, and they grow without bound.
        let mut doublings = 0;
        while self.common(holds).is_none() {
            holds *= two;
            doublings += 1;
            if doublings > DOUBLINGS {
                return None;
            }
        }
        let mut fails = T::zero();
        for _ in 0..BISECTIONS {
            let middle = (holds + fails) / two;
            if self.common(middle).is_some() {
                holds = middle;
            } else {
                fails = middle;
            }
        }
        self.common(holds).map(|storage_gain| ProvenAttenuation { level_squared: holds, storage_gain })
    }

    /// A c in all intervals for γ² = `level_squared`: the middle of what they have in common.
    fn common(&self, level_squared: T) -> Option<T> {
        let mut common: Option<(T, T)> = None;
        for (t_squared, control) in self.t_squared.iter().zip(self.control.iter()) {
            let (low, high) = self.interval(*t_squared, *control, level_squared)?;
            common = Some(common.map_or((low, high), |(lowest, highest)| (low.max(lowest), high.min(highest))));
        }
        common.filter(|(low, high)| low <= high).map(|(low, high)| (low + high) / T::constant(2.0))
    }

    fn interval(&self, t_squared: T, control: T, level_squared: T) -> Option<(T, T)> {
        let inverse = T::one() / control;
        let constant = T::constant(2.0) * inverse - T::one() / self.designed;
        let discriminant = inverse * inverse - constant / level_squared;
        if discriminant < T::zero() || level_squared <= T::zero() {
            return None;
        }
        let root = discriminant.sqrt();
        let scale = t_squared * level_squared;
        Some((scale * (inverse - root), scale * (inverse + root)))
    }
}
