//! The frozen loop as one matrix.

use hinf_control::Controller;
use hinf_control::dem_model::ThreeLinkDem;
use nalgebra::{Matrix2, SMatrix, Vector2, Vector3};
use uarm_io::estimator::AnyEstimator;

use super::delay::TransportDelay;
use super::estimator::{LinearEstimator, NotLinear};
use super::feedback::Feedback;
use super::spectrum::spectral_radius;
use crate::period::Period;

/// States of the frozen loop: two angles, two velocities, three estimates of three numbers each, and the torques of the last
/// three cycles.
pub const STATES: usize = 19;

/// Where each of them begins.
const ANGLES: usize = 0;
const VELOCITIES: usize = 2;
const ESTIMATES: usize = 4;
const LAST_TORQUE: usize = 13;
const TORQUE_BEFORE: usize = 15;
const TORQUE_BEFORE_THAT: usize = 17;

/// Quantities as linear functions of the state, a row for each.
type Rows<const R: usize> = SMatrix<f64, R, STATES>;

/// All of a loop but the law and the configuration.
#[derive(Clone, Copy, Debug)]
pub struct SampledLoop {
    model: ThreeLinkDem<f64>,
    estimators: [LinearEstimator; 3],
    /// s.
    period: f64,
    delays: [TransportDelay; 2],
}

impl SampledLoop {
    /// The loop of an arm whose joints, the base first, have `estimators`, and whose driven joints have `delays`.
    ///
    /// # Errors
    /// [`NotLinear`] if an estimator is not linear.
    pub fn new(
        model: ThreeLinkDem<f64>,
        estimators: [&AnyEstimator<f64>; 3],
        period: Period,
        delays: [TransportDelay; 2],
    ) -> Result<Self, NotLinear> {
        let [base, second, third] = estimators.map(|estimator| LinearEstimator::of(estimator, period));
        Ok(Self { model, estimators: [base?, second?, third?], period: period.seconds(1), delays })
    }

    /// The same loop with other delays.
    #[must_use]
    pub const fn with_delays(self, delays: [TransportDelay; 2]) -> Self {
        Self { delays, ..self }
    }

    /// The spectral radius of the loop that `law` closes, frozen in `configuration` [q2, q3], rad.
    pub fn spectral_radius(&self, law: &mut dyn Controller<f64>, configuration: &Vector2<f64>) -> f64 {
        spectral_radius(&self.transition(&Feedback::of(law, configuration), configuration))
    }

    /// A of x_{k+1} = A x_k, x_k the state when the counts of cycle k are latched: angles and velocities of joints 2 and 3, as
    /// differences from rest; the estimates of cycle k − 1, joint by joint; the torques of cycles k − 1, k − 2, k − 3.
    pub fn transition(&self, feedback: &Feedback, configuration: &Vector2<f64>) -> SMatrix<f64, STATES, STATES> {
        let at_rest = self.model.reduced(&Vector3::new(0.0, configuration.x, configuration.y), &Vector2::zeros());
        let [angles, velocities] = [ANGLES, VELOCITIES].map(states::<2>);
        let base_angle = -(at_rest.base_coupling * angles);
        let measured = [base_angle, angles.fixed_rows::<1>(0).into_owned(), angles.fixed_rows::<1>(1).into_owned()];
        let estimates = self.estimates(&measured);
        let torque = feedback_of(feedback, &estimates);
        let torques = [torque, states(LAST_TORQUE), states(TORQUE_BEFORE), states(TORQUE_BEFORE_THAT)];
        let [impulse, displacement] = self.effect(&torques);
        // A mass matrix that is not positive definite (a model that is not finite) makes NaN, which no limit lets pass.
        let inverse = at_rest.mass.try_inverse().unwrap_or(Matrix2::repeat(f64::NAN));

        let mut next = SMatrix::<f64, STATES, STATES>::zeros();
        next.fixed_rows_mut::<2>(ANGLES).copy_from(&(angles + velocities * self.period + inverse * displacement));
        next.fixed_rows_mut::<2>(VELOCITIES).copy_from(&(velocities + inverse * impulse));
        for (joint, estimate) in estimates.iter().enumerate() {
            next.fixed_rows_mut::<3>(ESTIMATES + 3 * joint).copy_from(estimate);
        }
        let [newest, older, oldest, _] = torques;
        next.fixed_rows_mut::<2>(LAST_TORQUE).copy_from(&newest);
        next.fixed_rows_mut::<2>(TORQUE_BEFORE).copy_from(&older);
        next.fixed_rows_mut::<2>(TORQUE_BEFORE_THAT).copy_from(&oldest);
        next
    }

    /// The estimates of this cycle, joint by joint.
    fn estimates(&self, measured: &[Rows<1>; 3]) -> [Rows<3>; 3] {
        let last = [ESTIMATES, ESTIMATES + 3, ESTIMATES + 6].map(states::<3>);
        let [base, second, third] = &self.estimators;
        let [base_angle, second_angle, third_angle] = measured;
        let [last_base, last_second, last_third] = last;
        let step = |estimator: &LinearEstimator, last: Rows<3>, angle: &Rows<1>| {
            estimator.transition * last + estimator.input * angle
        };
        [
            step(base, last_base, base_angle),
            step(second, last_second, second_angle),
            step(third, last_third, third_angle),
        ]
    }

    /// ∫τ dt and ∫∫τ dt² over the coming period, for the torques of this cycle and the three before it, newest first. Joint by
    /// joint, since drives may differ.
    fn effect(&self, torques: &[Rows<2>; 4]) -> [Rows<2>; 2] {
        let mut effect = [Rows::<2>::zeros(); 2];
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
}

/// `R` states from `first` on.
fn states<const R: usize>(first: usize) -> Rows<R> {
    Rows::from_fn(|row, column| if column == first + row { 1.0 } else { 0.0 })
}

fn diagonal(entries: [f64; 2]) -> Matrix2<f64> {
    Matrix2::from_diagonal(&Vector2::from(entries))
}

/// The law's torque for the estimates of the base and of joints 2 and 3.
fn feedback_of(feedback: &Feedback, estimates: &[Rows<3>; 3]) -> Rows<2> {
    const POSITION: usize = 0;
    const VELOCITY: usize = 1;
    const ACCELERATION: usize = 2;
    let [base, second, third] = estimates;
    let of_arm =
        |quantity| Rows::<2>::from_rows(&[second.row(quantity).into_owned(), third.row(quantity).into_owned()]);
    feedback.position * of_arm(POSITION)
        + feedback.velocity * of_arm(VELOCITY)
        + feedback.base_velocity * base.row(VELOCITY)
        + feedback.base_acceleration * base.row(ACCELERATION)
}
