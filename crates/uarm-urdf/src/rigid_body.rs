//! Mass, centre of mass and inertia of bodies, moved and joined.

use dem_model::nalgebra::{Isometry3, Matrix3, Vector3};

/// How far the principal moments of an inertia may miss the triangle inequality, of their sum: files have four digits or so.
const INERTIA_ROUNDING: f64 = 1e-3;

/// Whether one principal moment of an inertia is larger than the two others together, by more than files round: no body has such a one,
/// since I_xx + I_yy − I_zz = 2 ∫ z² dm.
pub(crate) fn misses_triangle_inequality(inertia: &Matrix3<f64>) -> bool {
    let moments = inertia.symmetric_eigenvalues();
    moments.max() * 2.0 > moments.sum() * (1.0 + INERTIA_ROUNDING)
}

/// A rigid body, in a frame that the context names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidBody {
    /// In kg.
    pub mass: f64,
    /// Its centre of mass in m.
    pub centre: Vector3<f64>,
    /// About the centre of mass in kg·m².
    pub inertia: Matrix3<f64>,
}

impl RigidBody {
    /// No body.
    pub(crate) fn none() -> Self {
        Self { mass: 0.0, centre: Vector3::zeros(), inertia: Matrix3::zeros() }
    }

    /// A body with its centre of mass at `centre` and an inertia about it.
    pub(crate) fn about_centre(mass: f64, centre: &Vector3<f64>, inertia: &Matrix3<f64>) -> Self {
        Self { mass, centre: *centre, inertia: *inertia }
    }

    /// The same body in another frame, to which `pose` goes from this one.
    pub(crate) fn moved(&self, pose: &Isometry3<f64>) -> Self {
        let rotation = pose.rotation.to_rotation_matrix();
        let inertia = rotation * self.inertia * rotation.transpose();
        Self {
            mass: self.mass,
            centre: pose * dem_model::nalgebra::Point3::from(self.centre) - dem_model::nalgebra::Point3::origin(),
            inertia: (inertia + inertia.transpose()) * 0.5,
        }
    }

    /// Both as one rigid body.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Self { inertia: self.inertia + other.inertia, ..*self };
        }
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        Self { mass, centre, inertia: self.about(&centre) + other.about(&centre) }
    }

    /// The inertia about a point.
    fn about(&self, point: &Vector3<f64>) -> Matrix3<f64> {
        let from = self.centre - point;
        self.inertia + (Matrix3::identity() * from.norm_squared() - from * from.transpose()) * self.mass
    }
}
