//! Arms of N joints with any axes, in the plane and in space.

use super::{ArmModel, LinearModel, Momentum};
use crate::{AuxiliaryMotion, Measurement};
use dem_model::{BaseFreedom, BaseMotion, LINK_PARAMETERS, Scalar, SerialAcceleration, SerialManipulator, SerialState};
use nalgebra::{Cholesky, Const, SMatrix, SVector};

/// The state with the base's velocity as measured.
fn state<T: Scalar, const N: usize, const B: usize>(measurement: &Measurement<T, N, B>) -> SerialState<T, N, B> {
    SerialState {
        position: measurement.position,
        velocity: measurement.velocity,
        base_velocity: measurement.base.velocity,
    }
}

/// The state with the base locked.
fn locked<T: Scalar, const N: usize, const B: usize>(measurement: &Measurement<T, N, B>) -> SerialState<T, N, B> {
    SerialState { base_velocity: SVector::zeros(), ..state(measurement) }
}

/// The links' parameters, in columns.
fn groups<T: Scalar, const K: usize, const G: usize>(matrix: &SMatrix<T, K, G>) -> [SVector<T, K>; G] {
    matrix.data.0.map(SVector::from)
}

/// Roundings of an element of the diagonal that its pivot has to exceed: it is a difference of such elements.
const ROUNDINGS: f64 = 16.0;

/// The Cholesky factor of a symmetric matrix that is positive definite, and not by rounding alone. Free of the scale of each
/// joint.
fn factorise<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> Option<Cholesky<T, Const<N>>> {
    let factor = matrix.cholesky()?;
    let margin = T::default_epsilon() * T::constant(ROUNDINGS);
    let pivots = factor.l_dirty().diagonal();
    let sound = pivots.iter().zip(matrix.diagonal().iter()).all(|(pivot, entry)| *pivot * *pivot > *entry * margin);
    sound.then_some(factor)
}

impl<T: Scalar, const N: usize, const B: usize> ArmModel<T, N, B> for SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    fn arm_torque(&self, measurement: &Measurement<T, N, B>, motion: &AuxiliaryMotion<T, N>) -> SVector<T, N> {
        let dynamics = self.dynamics(&locked(measurement));
        dynamics.mass_mm * motion.acceleration + dynamics.coriolis_mm * motion.velocity
    }

    fn base_reaction(&self, measurement: &Measurement<T, N, B>) -> SVector<T, N> {
        // What moves the arm at q̈_m = 0, less what it takes on a locked base.
        let moving = SerialAcceleration { base: measurement.base.acceleration, joints: SVector::zeros() };
        let rest = SerialAcceleration { base: SVector::zeros(), joints: SVector::zeros() };
        let (_, with_base) = self.inverse_dynamics(&state(measurement), &moving);
        let (_, alone) = self.inverse_dynamics(&locked(measurement), &rest);
        with_base - alone
    }

    fn base_compensated_torque(
        &self,
        measurement: &Measurement<T, N, B>,
        arm_torque: &SVector<T, N>,
    ) -> Option<SVector<T, N>> {
        let state = state(measurement);
        let dynamics = self.dynamics(&state);
        let rest = SerialAcceleration { base: SVector::zeros(), joints: SVector::zeros() };
        let (_, arm_coriolis) = self.inverse_dynamics(&locked(measurement), &rest);
        let acceleration = factorise(&dynamics.mass_mm)?.solve(&(arm_torque - arm_coriolis));
        let coupling = dynamics.base_coupling()?;
        let inertia = dynamics.generalised_inertia(&coupling);
        let (on_base, on_arm) = dynamics.coriolis_torque(&state.base_velocity, &state.velocity);
        let torque = inertia * acceleration + on_arm - coupling.tr_mul(&on_base);
        torque.iter().all(|torque| torque.is_finite()).then_some(torque)
    }

    fn reduced_torque(
        &self,
        measurement: &Measurement<T, N, B>,
        motion: &AuxiliaryMotion<T, N>,
        momentum: Momentum,
    ) -> Option<SVector<T, N>> {
        let reduced = match momentum {
            Momentum::Zero => self.reduced(&measurement.position, &measurement.velocity, &SVector::zeros())?,
            Momentum::Measured => self.reduced_at(&state(measurement))?,
        };
        Some(reduced.mass * motion.acceleration + reduced.coriolis * motion.velocity + reduced.momentum_torque)
    }

    fn generalised_inertia(&self, position: &SVector<T, N>) -> Option<SMatrix<T, N, N>> {
        let rest = SerialState { position: *position, velocity: SVector::zeros(), base_velocity: SVector::zeros() };
        let dynamics = self.dynamics(&rest);
        Some(dynamics.generalised_inertia(&dynamics.base_coupling()?))
    }
}

/// Φ: the ten inertial parameters of each link. The base's inertia is not among them and stays nominal.
impl<T: Scalar, const N: usize, const B: usize> LinearModel<T, N, B, LINK_PARAMETERS, N> for SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    fn parameters(&self) -> SMatrix<T, LINK_PARAMETERS, N> {
        SMatrix::from_columns(&self.inertial_parameters())
    }

    fn regressor(
        &self,
        measurement: &Measurement<T, N, B>,
        motion: &AuxiliaryMotion<T, N>,
    ) -> [SMatrix<T, N, LINK_PARAMETERS>; N] {
        self.regressor(&measurement.position, &measurement.velocity, &motion.acceleration, &motion.velocity)
    }

    fn estimated_compensation(
        &self,
        parameters: &SMatrix<T, LINK_PARAMETERS, N>,
        measurement: &Measurement<T, N, B>,
        arm_torque: &SVector<T, N>,
    ) -> Option<SVector<T, N>> {
        self.with_inertial_parameters(&groups(parameters)).base_compensated_torque(measurement, arm_torque)
    }
}
