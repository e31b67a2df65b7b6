//! The equations of motion M v̇ + C v = τ, cut into base and arm (eq. 3).

use nalgebra::{SMatrix, SVector};

use super::base::{BaseFreedom, BaseMotion, Columns, base_twist};
use super::composite::Composite;
use super::frame::{Column, Frame};
use super::manipulator::SerialManipulator;
use crate::scalar::Scalar;

/// A state of a serial arm, but for the base's place and attitude, which have no effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SerialState<T: Scalar, const N: usize, const B: usize> {
    /// The joints' coordinates q_m in rad; in m where they slide.
    pub position: SVector<T, N>,
    /// The joints' velocities q̇_m in rad/s or m/s.
    pub velocity: SVector<T, N>,
    /// The base's velocity v_b in base axes, in rad/s and m/s: see [`BaseMotion`].
    pub base_velocity: SVector<T, B>,
}

/// M and C of a state, cut into the base (b) and the arm (m): M v̇ + C v = τ for v = [v_b; q̇_m].
///
/// C is the Christoffel matrix for quasi-velocities: that of the Levi-Civita connection of M, so that C(v) w − C(w) v
/// comes from the turning of the axes alone, and Ṁ − 2C is skew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SerialDynamics<T: Scalar, const N: usize, const B: usize> {
    /// M_bb in kg·m².
    pub mass_bb: SMatrix<T, B, B>,
    /// M_bm in kg·m²; M_mb is its transpose.
    pub mass_bm: SMatrix<T, B, N>,
    /// M_mm in kg·m².
    pub mass_mm: SMatrix<T, N, N>,
    /// C_bb in kg·m²/s.
    pub coriolis_bb: SMatrix<T, B, B>,
    /// C_bm in kg·m²/s.
    pub coriolis_bm: SMatrix<T, B, N>,
    /// C_mb in kg·m²/s.
    pub coriolis_mb: SMatrix<T, N, B>,
    /// C_mm in kg·m²/s.
    pub coriolis_mm: SMatrix<T, N, N>,
}

/// The columns of base and joints, each with all that it moves.
struct Columned<T: Scalar, const N: usize, const B: usize> {
    base: [Column<T>; B],
    whole: Composite<T>,
    arm: [(Column<T>, Composite<T>); N],
}

/// An entry of M and the two of C of a pair of columns, of which the outer one moves the `bodies`.
struct Pair<T> {
    mass: T,
    /// In the row of the inner column.
    inner_row: T,
    /// In the row of the outer column.
    outer_row: T,
}

fn pair<T: Scalar>(inner: &Column<T>, outer: &Column<T>, bodies: &Composite<T>) -> Pair<T> {
    let momentum = bodies.momentum_of(&outer.twist);
    let change = bodies.momentum_of(&outer.rate) + bodies.rate_of(&outer.twist);
    Pair {
        mass: inner.twist.power(&momentum),
        inner_row: inner.twist.power(&change),
        outer_row: inner.rate.power(&momentum) + inner.twist.angular.dot(&bodies.rate_transposed(&outer.twist)),
    }
}

/// Writes an entry; one that is out of the matrix does not exist.
pub(super) fn set<T: Scalar, const R: usize, const C: usize>(
    matrix: &mut SMatrix<T, R, C>,
    row: usize,
    column: usize,
    value: T,
) {
    if let Some(entry) = matrix.get_mut((row, column)) {
        *entry = value;
    }
}

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    /// M and C in a state, in O(N²).
    ///
    /// ```
    /// use dem_model::nalgebra::{Vector1, Vector2};
    /// use dem_model::{PlanarBaseManipulator, PlanarSpaceManipulator, SerialState};
    ///
    /// // The paper's arm as one of any kind: two joints on a base that turns in the plane.
    /// let dem = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
    /// let state = SerialState {
    ///     position: Vector2::new(0.35, 0.35),
    ///     velocity: Vector2::new(0.4, -0.2),
    ///     base_velocity: Vector1::new(0.1),
    /// };
    /// let dynamics = PlanarBaseManipulator::planar(&dem).dynamics(&state);
    /// assert!((dynamics.mass_mm - dynamics.mass_mm.transpose()).amax() < 1e-15);
    /// ```
    pub fn dynamics(&self, state: &SerialState<T, N, B>) -> SerialDynamics<T, N, B> {
        let Columned { base, whole, arm } = self.columns(state);
        let mut dynamics = SerialDynamics::zero();
        for (row, inner) in base.iter().enumerate() {
            for (column, outer) in base.iter().enumerate() {
                let pair = pair(inner, outer, &whole);
                set(&mut dynamics.mass_bb, row, column, pair.mass);
                set(&mut dynamics.coriolis_bb, row, column, pair.inner_row);
            }
            for (column, (outer, bodies)) in arm.iter().enumerate() {
                let pair = pair(inner, outer, bodies);
                set(&mut dynamics.mass_bm, row, column, pair.mass);
                set(&mut dynamics.coriolis_bm, row, column, pair.inner_row);
                set(&mut dynamics.coriolis_mb, column, row, pair.outer_row);
            }
        }
        for (column, (outer, bodies)) in arm.iter().enumerate() {
            for (row, (inner, _)) in arm.iter().enumerate().take(column + 1) {
                let pair = pair(inner, outer, bodies);
                set(&mut dynamics.mass_mm, row, column, pair.mass);
                set(&mut dynamics.mass_mm, column, row, pair.mass);
                set(&mut dynamics.coriolis_mm, column, row, pair.outer_row);
                set(&mut dynamics.coriolis_mm, row, column, pair.inner_row);
            }
        }
        dynamics
    }

    fn columns(&self, state: &SerialState<T, N, B>) -> Columned<T, N, B> {
        let twist = base_twist(&state.base_velocity);
        let base = Frame::of_base(&twist);
        let mut whole = Composite::body(&self.base, &base);
        let mut arm = [(Column::zero(), whole); N];
        let mut places = arm.iter_mut();
        self.walk(&base, &state.position, &state.velocity, |link, frame, column| {
            if let Some(place) = places.next() {
                *place = (column, Composite::body(&link.moments, frame));
            }
        });
        let mut outboard = None;
        for (_, bodies) in arm.iter_mut().rev() {
            if let Some(beyond) = outboard {
                *bodies += beyond;
            }
            outboard = Some(*bodies);
        }
        if let Some(arm) = outboard {
            whole += arm;
        }
        let columns = <BaseFreedom<B> as Columns<T, B>>::twists();
        Columned { base: columns.map(|column| Column::of_base(column, &twist)), whole, arm }
    }
}

impl<T: Scalar, const N: usize, const B: usize> SerialDynamics<T, N, B> {
    fn zero() -> Self {
        Self {
            mass_bb: SMatrix::zeros(),
            mass_bm: SMatrix::zeros(),
            mass_mm: SMatrix::zeros(),
            coriolis_bb: SMatrix::zeros(),
            coriolis_bm: SMatrix::zeros(),
            coriolis_mb: SMatrix::zeros(),
            coriolis_mm: SMatrix::zeros(),
        }
    }

    /// The generalised momentum (M_bb v_b + M_bm q̇_m, M_mb v_b + M_mm q̇_m) of a velocity, in N·m·s. The first is the
    /// angular momentum h in base axes about the base's origin, with B = 6 followed by the linear one.
    pub fn momentum(&self, base_velocity: &SVector<T, B>, velocity: &SVector<T, N>) -> (SVector<T, B>, SVector<T, N>) {
        (
            self.mass_bb * base_velocity + self.mass_bm * velocity,
            self.mass_bm.tr_mul(base_velocity) + self.mass_mm * velocity,
        )
    }

    /// ½ vᵀ M v in J.
    pub fn kinetic_energy(&self, base_velocity: &SVector<T, B>, velocity: &SVector<T, N>) -> T {
        let (base, arm) = self.momentum(base_velocity, velocity);
        (base.dot(base_velocity) + arm.dot(velocity)) * T::constant(0.5)
    }

    /// C w for a velocity w = (w_b, w_m), in N·m: the Coriolis and centrifugal torques where w is the state's own.
    pub fn coriolis_torque(
        &self,
        base_velocity: &SVector<T, B>,
        velocity: &SVector<T, N>,
    ) -> (SVector<T, B>, SVector<T, N>) {
        (
            self.coriolis_bb * base_velocity + self.coriolis_bm * velocity,
            self.coriolis_mb * base_velocity + self.coriolis_mm * velocity,
        )
    }
}
