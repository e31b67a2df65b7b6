//! The desired motion: a polynomial of the fifth degree from rest to rest (paper eq. 47).

use crate::Reference;
use dem_model::Scalar;
use nalgebra::{SVector, Vector2};

/// A quintic from rest at one posture to rest at another, held before it starts and after it ends.
///
/// With s = t/t_f: q_mᵈ = q_0 + (q_f − q_0)(10 s³ − 15 s⁴ + 6 s⁵) (eq. 47).
///
/// ```
/// use hinf_control::QuinticReference;
/// let reference = QuinticReference::<f64>::paper();
/// assert_eq!(reference.at(10.0).position, *reference.end());
/// assert_eq!(reference.at(10.0).velocity.norm(), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuinticReference<T: Scalar, const N: usize = 2> {
    start: SVector<T, N>,
    end: SVector<T, N>,
    duration: T,
}

/// Why a reference is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// A start or end angle is NaN or infinite.
    #[error("start and end angles must be finite numbers of radians")]
    PostureNotFinite,
    /// The duration is not a positive finite number.
    #[error("the duration is {found} s, expected a positive finite number of seconds")]
    DurationNotPositive {
        /// The duration found, s.
        found: f64,
    },
    /// The motion is so short or so long that its velocity or acceleration is no finite number.
    #[error("the motion asks for a velocity or an acceleration that is not finite: duration {duration} s")]
    MotionNotFinite {
        /// The duration found, s.
        duration: f64,
    },
}

impl<T: Scalar, const N: usize> QuinticReference<T, N> {
    /// The motion from `start` to `end` (rad, active joints) in `duration` (s, positive).
    ///
    /// # Errors
    /// [`ReferenceError`] if a number is not finite or the duration not positive.
    pub fn new(start: SVector<T, N>, end: SVector<T, N>, duration: T) -> Result<Self, ReferenceError> {
        if !start.iter().chain(end.iter()).all(|angle| angle.is_finite()) {
            return Err(ReferenceError::PostureNotFinite);
        }
        if !(duration.is_finite() && duration > T::zero()) {
            return Err(ReferenceError::DurationNotPositive { found: duration.to_f64() });
        }
        // |q̈ᵈ| ≤ 10/√3·|q_f − q_0|/t_f² and |q̇ᵈ| ≤ 15/8·|q_f − q_0|/t_f: 60 is far above every intermediate factor.
        let bound = (end - start) / duration * T::constant(60.0);
        let motion_is_finite = bound.iter().all(|velocity| velocity.is_finite() && (*velocity / duration).is_finite());
        if !motion_is_finite {
            return Err(ReferenceError::MotionNotFinite { duration: duration.to_f64() });
        }
        Ok(Self { start, end, duration })
    }

    /// Where the motion starts, rad.
    pub fn start(&self) -> &SVector<T, N> {
        &self.start
    }

    /// Where the motion ends, rad.
    pub fn end(&self) -> &SVector<T, N> {
        &self.end
    }

    /// How long the motion takes, s.
    pub fn duration(&self) -> T {
        self.duration
    }

    /// The desired motion at `time` (s, zero at the start). Rests at the start before it (also for NaN), at the end after it.
    pub fn at(&self, time: T) -> Reference<T, N> {
        if time >= self.duration {
            return Self::rest(self.end);
        }
        if time > T::zero() { self.moving(time / self.duration) } else { Self::rest(self.start) }
    }

    /// Eq. 47 and its derivatives at `s` = t/t_f within (0, 1).
    fn moving(&self, s: T) -> Reference<T, N> {
        let c = T::constant;
        let travel = self.end - self.start;
        let rest_of_way = T::one() - s;
        Reference {
            position: self.start + travel * (s * s * s * (c(10.0) - s * (c(15.0) - c(6.0) * s))),
            velocity: travel / self.duration * (c(30.0) * s * s * rest_of_way * rest_of_way),
            acceleration: travel / self.duration / self.duration
                * (c(60.0) * s * rest_of_way * (T::one() - c(2.0) * s)),
        }
    }

    fn rest(position: SVector<T, N>) -> Reference<T, N> {
        Reference { position, velocity: SVector::zeros(), acceleration: SVector::zeros() }
    }
}

impl<T: Scalar> QuinticReference<T> {
    /// The task of the paper's section 4: from (20°, 20°) to (80°, 60°) in 3 s.
    pub fn paper() -> Self {
        let radians = |degrees: f64| T::constant(degrees.to_radians());
        Self {
            start: Vector2::new(radians(20.0), radians(20.0)),
            end: Vector2::new(radians(80.0), radians(60.0)),
            duration: T::constant(3.0),
        }
    }
}
