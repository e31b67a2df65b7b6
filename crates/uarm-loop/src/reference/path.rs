//! The way from start to end: one quintic, or a spline through postures.

use super::spline::Spline;
use super::via::{Passing, ViaPoint};
use hinf_control::{QuinticReference, Reference, ReferenceError};
use nalgebra::SVector;
use std::sync::Arc;

/// Why a path is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// Start, end or duration.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A posture is not after the one before it, or not before the end.
    #[error("posture {index} is at {found} s, expected at least {least} s and at most {most} s")]
    Time {
        /// Which one, from 0.
        index: usize,
        /// Its time, s.
        found: f64,
        /// The earliest that it may have, s.
        least: f64,
        /// The latest that it may have, s.
        most: f64,
    },
    /// An angle is no finite number.
    #[error("posture {index} has an angle that is no finite number")]
    NotFinite {
        /// Which one, from 0.
        index: usize,
    },
    /// The motion through the postures has a velocity or an acceleration that is not finite.
    #[error("the motion through the postures has a velocity or an acceleration that is no finite number")]
    MotionNotFinite,
}

/// The least time between two postures, s.
pub const SHORTEST_SEGMENT: f64 = 1e-3;

/// The way of `N` active joints from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Path<const N: usize> {
    /// Straight from start to end (paper eq. 47).
    Quintic(QuinticReference<f64, N>),
    /// Through postures: of all motions that pass them in time, the one with the least integral of the squared jerk.
    Spline(Arc<Spline<N>>),
}

impl<const N: usize> Path<N> {
    /// From `start` to `end` in `duration`, s, by `via`, in the order of time.
    ///
    /// # Errors
    /// [`PathError`] if a number is not finite, or times do not increase by [`SHORTEST_SEGMENT`] at least.
    pub fn new(
        start: SVector<f64, N>,
        via: &[ViaPoint<N>],
        end: SVector<f64, N>,
        duration: f64,
    ) -> Result<Self, PathError> {
        let quintic = QuinticReference::new(start, end, duration)?;
        if via.is_empty() {
            return Ok(Self::Quintic(quintic));
        }
        let mut before = 0.0;
        for (index, point) in via.iter().enumerate() {
            let (least, most) = (before + SHORTEST_SEGMENT, duration - SHORTEST_SEGMENT);
            if !(least..=most).contains(&point.time) {
                return Err(PathError::Time { index, found: point.time, least, most });
            }
            if !point.position.iter().all(|angle| angle.is_finite()) {
                return Err(PathError::NotFinite { index });
            }
            before = point.time;
        }
        let [start, end] =
            [(0.0, start), (duration, end)].map(|(time, position)| ViaPoint { time, position, passing: Passing::Stop });
        let points: Vec<_> = std::iter::once(start).chain(via.iter().copied()).chain([end]).collect();
        let spline = Spline::through(&points).filter(Spline::is_finite).ok_or(PathError::MotionNotFinite)?;
        Ok(Self::Spline(Arc::new(spline)))
    }

    /// Where it starts, rad.
    pub fn start(&self) -> &SVector<f64, N> {
        match self {
            Self::Quintic(quintic) => quintic.start(),
            Self::Spline(spline) => spline.start(),
        }
    }

    /// Where it ends, rad.
    pub fn end(&self) -> &SVector<f64, N> {
        match self {
            Self::Quintic(quintic) => quintic.end(),
            Self::Spline(spline) => spline.end(),
        }
    }

    /// How long it takes, s.
    pub fn duration(&self) -> f64 {
        match self {
            Self::Quintic(quintic) => quintic.duration(),
            Self::Spline(spline) => spline.duration(),
        }
    }

    /// The shortest time between two postures, s.
    pub fn shortest_segment(&self) -> f64 {
        match self {
            Self::Quintic(quintic) => quintic.duration(),
            Self::Spline(spline) => spline.shortest_segment(),
        }
    }

    /// The desired motion at `time`, s; at rest before the start and after the end.
    pub fn at(&self, time: f64) -> Reference<f64, N> {
        match self {
            Self::Quintic(quintic) => quintic.at(time),
            Self::Spline(spline) => spline.at(time),
        }
    }
}
