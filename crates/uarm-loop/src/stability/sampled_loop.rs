//! The frozen loop as one matrix.

use std::fmt;
use std::sync::Arc;

use hinf_control::Controller;
use hinf_control::dem_model::{BaseFreedom, BaseMotion, SerialManipulator, ThreeLinkDem};
use nalgebra::{DMatrix, RowSVector, SMatrix, SVector, Vector2, Vector3};
use uarm_io::estimator::AnyEstimator;

use super::delay::TransportDelay;
use super::estimator::{LinearEstimator, NotLinear};
use super::feedback::Feedback;
use super::spectrum::spectral_radius;
use crate::dimensions;
use crate::period::Period;

/// Numbers of an estimate: angle, velocity, acceleration.
const OF_ESTIMATE: usize = 3;
/// Cycles whose torques still act: the longest delay.
const REMEMBERED_TORQUES: usize = 3;

/// What the frozen loop must know of an arm: how it moves from rest, its base without momentum.
pub trait RestModel<const N: usize>: fmt::Debug + Send + Sync {
    /// M̄ in kg·m² for the active joints at `configuration`, rad. NaN where a number is not finite.
    fn generalised_inertia(&self, configuration: &SVector<f64, N>) -> SMatrix<f64, N, N>;

    /// A of q̇_b = −A q̇_m, for a base that turns about one axis; zero where no sensor sees the base.
    fn base_coupling(&self, configuration: &SVector<f64, N>) -> RowSVector<f64, N>;
}

impl RestModel<2> for ThreeLinkDem<f64> {
    fn generalised_inertia(&self, configuration: &Vector2<f64>) -> SMatrix<f64, 2, 2> {
        self.reduced(&Vector3::new(0.0, configuration.x, configuration.y), &Vector2::zeros()).mass
    }

    fn base_coupling(&self, configuration: &Vector2<f64>) -> RowSVector<f64, 2> {
        self.reduced(&Vector3::new(0.0, configuration.x, configuration.y), &Vector2::zeros()).base_coupling
    }
}

impl<const N: usize, const B: usize> RestModel<N> for SerialManipulator<f64, N, B>
where
    BaseFreedom<B>: BaseMotion<f64, B>,
{
    fn generalised_inertia(&self, configuration: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let at_rest = self.reduced(configuration, &SVector::zeros(), &SVector::zeros());
        at_rest.map_or(SMatrix::repeat(f64::NAN), |at_rest| at_rest.mass)
    }

    fn base_coupling(&self, configuration: &SVector<f64, N>) -> RowSVector<f64, N> {
        let at_rest = self.reduced(configuration, &SVector::zeros(), &SVector::zeros());
        let rows = at_rest.iter().flat_map(|at_rest| at_rest.base_coupling.row_iter());
        // A base that turns about more than one axis is no joint.
        rows.take(if B == 1 { 1 } else { 0 }).next().map_or(RowSVector::zeros(), |row| row.into_owned())
    }
}

/// All of a loop of `J` joints, `N` of them active, but the law and the configuration.
#[derive(Clone, Debug)]
pub struct SampledLoop<const J: usize = 3, const N: usize = 2> {
    model: Arc<dyn RestModel<N>>,
    estimators: [LinearEstimator; J],
    /// s.
    period: f64,
    delays: [TransportDelay; N],
}

impl<const J: usize, const N: usize> SampledLoop<J, N> {
    /// States of the frozen loop: angles and velocities of the active joints, an estimate of three numbers for each joint, and the
    /// torques of the last three cycles.
    pub const STATES: usize = 2 * N + OF_ESTIMATE * J + REMEMBERED_TORQUES * N;

    /// Where each of them begins.
    const VELOCITIES: usize = N;
    const ESTIMATES: usize = 2 * N;
    const TORQUES: usize = Self::ESTIMATES + OF_ESTIMATE * J;

    /// The loop of an arm whose joints have `estimators`, and whose active joints have `delays`.
    ///
    /// # Errors
    /// [`NotLinear`] if an estimator is not linear.
    pub fn new(
        model: Arc<dyn RestModel<N>>,
        estimators: [&AnyEstimator<f64>; J],
        period: Period,
        delays: [TransportDelay; N],
    ) -> Result<Self, NotLinear> {
        let mut linear = [LinearEstimator::default(); J];
        for (linear, estimator) in linear.iter_mut().zip(estimators) {
            *linear = LinearEstimator::of(estimator, period)?;
        }
        Ok(Self { model, estimators: linear, period: period.seconds(1), delays })
    }

    /// The same loop with other delays.
    #[must_use]
    pub fn with_delays(&self, delays: [TransportDelay; N]) -> Self {
        Self { delays, ..self.clone() }
    }

    /// The spectral radius of the loop that `law` closes, frozen in `configuration`, rad.
    pub fn spectral_radius(&self, law: &mut dyn Controller<f64, N>, configuration: &SVector<f64, N>) -> f64 {
        spectral_radius(&self.transition(&Feedback::of(law, configuration), configuration))
    }

    /// A of x_{k+1} = A x_k, x_k the state when the counts of cycle k are latched: angles and velocities of the active joints, as
    /// differences from rest; the estimates of cycle k − 1, joint by joint; the torques of cycles k − 1, k − 2, k − 3.
    /// [`STATES`](Self::STATES) rows and columns.
    pub fn transition(&self, feedback: &Feedback<N>, configuration: &SVector<f64, N>) -> DMatrix<f64> {
        let (angles, velocities) = (Self::states(0, N), Self::states(Self::VELOCITIES, N));
        let estimates = self.estimates(&self.measured(configuration, &angles));
        let mut torques = vec![feedback_of::<J, N>(feedback, &estimates)];
        torques.extend((0..REMEMBERED_TORQUES).map(|age| Self::states(Self::TORQUES + age * N, N)));
        let [impulse, displacement] = self.effect(&torques);
        // A mass matrix that is not positive definite (a model that is not finite) makes NaN, which no limit lets pass.
        let mass = self.model.generalised_inertia(configuration);
        let inverse = dynamic(&mass.try_inverse().unwrap_or(SMatrix::repeat(f64::NAN)));

        let mut next =
            vec![&angles + &velocities * self.period + &inverse * displacement, velocities + inverse * impulse];
        next.extend(estimates);
        next.extend(torques.into_iter().take(REMEMBERED_TORQUES));
        let rows: Vec<_> = next.iter().flat_map(|block| block.row_iter()).collect();
        DMatrix::from_rows(&rows)
    }

    /// What the encoders see, joint by joint: a passive base turns against the arm.
    fn measured(&self, configuration: &SVector<f64, N>, angles: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
        let coupling = dynamic(&self.model.base_coupling(configuration));
        let base = std::iter::repeat_with(|| -(&coupling * angles)).take(dimensions::passive::<J, N>());
        base.chain(angles.row_iter().map(|row| DMatrix::from_rows(&[row]))).collect()
    }

    /// The estimates of this cycle, joint by joint.
    fn estimates(&self, measured: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
        let joints = self.estimators.iter().zip(measured).enumerate();
        let step = |(joint, (estimator, angle)): (usize, (&LinearEstimator, &DMatrix<f64>))| {
            let last = Self::states(Self::ESTIMATES + OF_ESTIMATE * joint, OF_ESTIMATE);
            dynamic(&estimator.transition) * last + dynamic(&estimator.input) * angle
        };
        joints.map(step).collect()
    }

    /// ∫τ dt and ∫∫τ dt² over the coming period, for the torques of this cycle and the three before it, newest first. Joint by
    /// joint, since drives may differ.
    fn effect(&self, torques: &[DMatrix<f64>]) -> [DMatrix<f64>; 2] {
        let mut effect = [(); 2].map(|()| DMatrix::zeros(N, Self::STATES));
        for (torque, age) in torques.iter().zip([0.0, 1.0, 2.0, 3.0]) {
            let shares = self.delays.map(|delay| delay.share(age));
            let duration = shares.map(|[begin, end]| self.period * (end - begin));
            // What acts from `begin` on has the rest of the period to move the joint.
            let area = shares.map(|[begin, end]| {
                0.5 * self.period * self.period * ((1.0 - begin) * (1.0 - begin) - (1.0 - end) * (1.0 - end))
            });
            let [impulse, displacement] = &mut effect;
            *impulse += diagonal(duration) * torque;
            *displacement += diagonal(area) * torque;
        }
        effect
    }

    /// `rows` states from `first` on, as linear functions of the state.
    fn states(first: usize, rows: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, Self::STATES, |row, column| if column == first + row { 1.0 } else { 0.0 })
    }
}

fn dynamic<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> DMatrix<f64> {
    DMatrix::from_iterator(R, C, matrix.iter().copied())
}

fn diagonal<const N: usize>(entries: [f64; N]) -> DMatrix<f64> {
    dynamic(&SMatrix::from_diagonal(&SVector::from(entries)))
}

/// The law's torque for the estimates of all joints.
fn feedback_of<const J: usize, const N: usize>(feedback: &Feedback<N>, estimates: &[DMatrix<f64>]) -> DMatrix<f64> {
    const POSITION: usize = 0;
    const VELOCITY: usize = 1;
    const ACCELERATION: usize = 2;
    let passive = dimensions::passive::<J, N>();
    let of_arm = |quantity: usize| {
        let rows: Vec<_> = estimates.iter().skip(passive).map(|estimate| estimate.row(quantity)).collect();
        DMatrix::from_rows(&rows)
    };
    let mut torque = dynamic(&feedback.position) * of_arm(POSITION) + dynamic(&feedback.velocity) * of_arm(VELOCITY);
    for base in estimates.iter().take(passive) {
        torque += dynamic(&feedback.base_velocity) * base.row(VELOCITY);
        torque += dynamic(&feedback.base_acceleration) * base.row(ACCELERATION);
    }
    torque
}
