//! The desired motion of a task: from rest to rest, on the way through given postures if there are any, with oscillations on top if
//! there are any.
//!
//! ```
//! use nalgebra::Vector2;
//! use uarm_loop::reference::{Passing, Path, TaskReference, ViaPoint};
//! let [start, end] = [Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.5)];
//! let via = ViaPoint { time: 1.0, position: Vector2::new(0.9, 0.1), passing: Passing::Through };
//! let reference = TaskReference::new(Path::new(start, &[via], end, 3.0)?, None);
//! assert!((reference.at(1.0).position - via.position).norm() < 1e-12);
//! assert!(reference.at(1.0).velocity.norm() > 0.1);
//! assert_eq!(reference.at(3.0).position, end);
//! # Ok::<(), uarm_loop::reference::PathError>(())
//! ```

mod oscillation;
mod path;
mod spline;
mod via;

pub use oscillation::{Oscillation, OscillationError, Oscillations};
pub use path::{Path, PathError, SHORTEST_SEGMENT};
pub use via::{Passing, ViaPoint};

use hinf_control::{QuinticReference, Reference};
use nalgebra::SVector;
use std::sync::Arc;

/// The desired motion of `N` active joints, rad, over time, s, from zero on. It rests at its start before, and at its end
/// afterwards.
///
/// A clone shares what the original has: it does not allocate.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskReference<const N: usize> {
    path: Path<N>,
    oscillations: Option<Arc<Oscillations<N>>>,
}

impl<const N: usize> TaskReference<N> {
    /// The motion along `path`, with `oscillations` on top.
    pub fn new(path: Path<N>, oscillations: Option<Oscillations<N>>) -> Self {
        Self { path, oscillations: oscillations.map(Arc::new) }
    }

    /// Where it starts, rad.
    pub fn start(&self) -> &SVector<f64, N> {
        self.path.start()
    }

    /// Where it ends, rad.
    pub fn end(&self) -> &SVector<f64, N> {
        self.path.end()
    }

    /// How long it takes, s.
    pub fn duration(&self) -> f64 {
        self.path.duration()
    }

    /// The single quintic (paper eq. 47) that it is, if it is one.
    pub fn as_quintic(&self) -> Option<&QuinticReference<f64, N>> {
        match &self.path {
            Path::Quintic(quintic) if self.oscillations.is_none() => Some(quintic),
            _ => None,
        }
    }

    /// The shortest time in which the motion turns from one thing to another, s: of a segment, a period, a ramp.
    pub fn finest(&self) -> f64 {
        let path = self.path.shortest_segment();
        self.oscillations.as_ref().map_or(path, |oscillations| path.min(oscillations.finest()))
    }

    /// The desired motion at `time`, s.
    pub fn at(&self, time: f64) -> Reference<f64, N> {
        let along = self.path.at(time);
        let Some(oscillations) = &self.oscillations else { return along };
        let beside = oscillations.at(time, self.duration());
        Reference {
            position: along.position + beside.position,
            velocity: along.velocity + beside.velocity,
            acceleration: along.acceleration + beside.acceleration,
        }
    }
}

impl<const N: usize> From<QuinticReference<f64, N>> for TaskReference<N> {
    fn from(quintic: QuinticReference<f64, N>) -> Self {
        Self::new(Path::Quintic(quintic), None)
    }
}

#[cfg(test)]
mod tests;
