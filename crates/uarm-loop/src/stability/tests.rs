use std::collections::VecDeque;
use std::sync::Arc;

use hinf_control::dem_model::{ReducedDynamics, ThreeLinkDem};
use hinf_control::nalgebra::{ComplexField, DVector, Schur, Vector2, Vector3, Vector4};
use hinf_control::{
    AnyController, BaseAcceleration, BaseMeasurement, BuildContext, Controller, ControllerSettings, Law, Measurement,
    QuinticReference, Reference,
};
use uarm_io::estimator::{AnyEstimator, EstimatorConfiguration, KalmanSettings};
use uarm_io::time::Duration;

use super::survey::{Worst, task, workspace, worst};
use super::*;
use crate::period::Period;

/// The paper's filter, as fitted.
const PAPER: EstimatorConfiguration = EstimatorConfiguration::LowPass { cutoff: 27.81882 };

/// A filter whose velocity is the true one at the instant of the measurement: the least that an estimator can delay.
fn without_delay() -> EstimatorConfiguration {
    EstimatorConfiguration::Kalman(KalmanSettings {
        jerk_density: 1e12,
        measurement_deviation: 1e-5,
        nominal_period: 0.003,
    })
}

fn law(law: Law, mode: Option<BaseAcceleration>) -> AnyController<f64> {
    let mut settings = ControllerSettings::default();
    if let Some(mode) = mode {
        settings.set_base_acceleration(law, mode).unwrap();
    }
    settings.build(law, &BuildContext::new(ThreeLinkDem::table_2())).unwrap()
}

fn reduced() -> AnyController<f64> {
    law(Law::Nonlinear, Some(BaseAcceleration::Reduced))
}

fn period(microseconds: u64) -> Period {
    Period::new(Duration::from_micros(microseconds)).unwrap()
}

fn sampled(microseconds: u64, estimator: EstimatorConfiguration, cycles: f64) -> SampledLoop {
    let estimator = estimator.build().unwrap();
    let delays = [TransportDelay::cycles(cycles).unwrap(); 2];
    SampledLoop::new(Arc::new(ThreeLinkDem::table_2()), [&estimator; 3], period(microseconds), delays).unwrap()
}

/// The worst of the workspace within ±170°, the limits of the paper's robot file.
fn worst_of(sampled: &SampledLoop) -> Worst {
    let limits = [[-170.0_f64, 170.0]; 2].map(|limits| limits.map(f64::to_radians));
    worst(sampled, &mut reduced(), workspace(limits)).unwrap()
}

fn degrees(second: f64, third: f64) -> Vector2<f64> {
    Vector2::new(second.to_radians(), third.to_radians())
}

fn assert_printed(radius: f64, printed: f64) {
    assert!((radius - printed).abs() <= 0.0005, "{radius}, expected {printed}");
}

/// The numbers of the issues on real drives and on evidence, which two programs that are not ours computed.
#[test]
fn the_reduced_law_with_the_papers_filter() {
    let stretched = degrees(0.0, 0.0);
    for (microseconds, cycles, printed) in [(3_000, 1.0, 1.012), (3_000, 2.0, 1.037), (10_000, 0.0, 1.057)] {
        let worst = worst_of(&sampled(microseconds, PAPER, cycles));
        assert_printed(worst.radius, printed);
        assert!(worst.is_unstable() && (worst.configuration - stretched).norm() < 1e-9, "{worst:?}");
    }
    let undelayed = worst_of(&sampled(3_000, PAPER, 0.0));
    assert_printed(undelayed.radius, 0.991);
    assert!(!undelayed.is_unstable());
    let at_start = sampled(3_000, PAPER, 1.0).spectral_radius(&mut reduced(), &degrees(20.0, 20.0));
    assert_printed(at_start, 1.008);
}

#[test]
fn an_undelayed_velocity_bears_one_cycle_and_not_two() {
    assert_printed(worst_of(&sampled(3_000, without_delay(), 1.0)).radius, 0.990);
    assert!(worst_of(&sampled(3_000, without_delay(), 2.0)).is_unstable());
}

/// The loop itself, step by step, with the estimators' and the law's own code on the frozen arm and a queue for the delay:
/// nothing of the matrix.
struct Simulation<'a> {
    law: &'a mut AnyController<f64>,
    frozen: ReducedDynamics<f64>,
    at: Vector2<f64>,
    period: f64,
    estimators: [AnyEstimator<f64>; 3],
    waiting: VecDeque<Vector2<f64>>,
    angle: Vector2<f64>,
    velocity: Vector2<f64>,
}

impl<'a> Simulation<'a> {
    /// At rest, a little beside `at`.
    fn new(law: &'a mut AnyController<f64>, estimator: EstimatorConfiguration, at: Vector2<f64>, cycles: u32) -> Self {
        law.reset();
        let mut estimators: [AnyEstimator<f64>; 3] = core::array::from_fn(|_| estimator.build().unwrap());
        for (estimator, angle) in estimators.iter_mut().zip([0.0, at.x, at.y]) {
            estimator.reset(angle);
        }
        Self {
            law,
            frozen: ThreeLinkDem::table_2().reduced(&Vector3::new(0.0, at.x, at.y), &Vector2::zeros()),
            at,
            period: 0.003,
            estimators,
            waiting: (0..cycles).map(|_| Vector2::zeros()).collect(),
            angle: Vector2::new(1e-8, -2e-8),
            velocity: Vector2::zeros(),
        }
    }

    fn step(&mut self) {
        let measured =
            [-(self.frozen.base_coupling * self.angle).x, self.at.x + self.angle.x, self.at.y + self.angle.y];
        let [base, second, third] =
            core::array::from_fn(|joint| self.estimators[joint].update(measured[joint], self.period));
        let measurement = Measurement {
            position: Vector2::new(second.position, third.position),
            velocity: Vector2::new(second.velocity, third.velocity),
            base: BaseMeasurement::planar(base.velocity, base.acceleration),
        };
        let at_rest = Reference { position: self.at, velocity: Vector2::zeros(), acceleration: Vector2::zeros() };
        self.waiting.push_back(self.law.update(&measurement, &at_rest, self.period).torque);
        let acceleration = self.frozen.mass.try_inverse().unwrap() * self.waiting.pop_front().unwrap();
        self.angle += self.velocity * self.period + acceleration * (self.period * self.period / 2.0);
        self.velocity += acceleration * self.period;
    }
}

#[test]
fn the_matrix_moves_as_the_loop_itself_does() {
    let kalman = EstimatorConfiguration::Kalman(KalmanSettings {
        jerk_density: 1e5,
        measurement_deviation: 5.376e-5,
        nominal_period: 0.003,
    });
    let tracking = EstimatorConfiguration::Tracking { bandwidth: 100.0 };
    let laws = [
        (Law::Nonlinear, Some(BaseAcceleration::Reduced)),
        (Law::Nonlinear, Some(BaseAcceleration::Eliminated)),
        (Law::Nonlinear, Some(BaseAcceleration::Omitted)),
        (Law::Nonlinear, Some(BaseAcceleration::Measured)),
        (Law::ComputedTorque, None),
    ];
    for (law, mode) in laws {
        for (estimator, cycles) in [(PAPER, 0), (PAPER, 1), (kalman, 2), (tracking, 3)] {
            for at in [degrees(20.0, 20.0), degrees(80.0, 60.0)] {
                let mut law = self::law(law, mode);
                let sampled = sampled(3_000, estimator, f64::from(cycles));
                let matrix = sampled.transition(&Feedback::of(&mut law, &at), &at);
                let mut simulation = Simulation::new(&mut law, estimator, at, cycles);
                let mut state = DVector::<f64>::zeros(SampledLoop::<3, 2>::STATES);
                state.fixed_rows_mut::<2>(0).copy_from(&simulation.angle);
                for cycle in 0..50 {
                    // What grows fast is compared while it is small, and the law linear.
                    if state.norm() > 1e-3 {
                        break;
                    }
                    simulation.step();
                    state = &matrix * state;
                    let expected =
                        [simulation.angle.x, simulation.angle.y, simulation.velocity.x, simulation.velocity.y];
                    let difference = (state.fixed_rows::<4>(0) - Vector4::from(expected)).norm();
                    assert!(
                        difference < 1e-5 * state.norm(),
                        "{mode:?} {estimator:?} {cycles}: cycle {cycle}: {difference} of {}",
                        state.norm()
                    );
                }
            }
        }
    }
}

/// Where one oscillation grows faster than all else, its crests tell the spectral radius.
#[test]
fn the_loop_itself_grows_by_the_spectral_radius() {
    for (at, cycles, printed) in
        [(degrees(0.0, 0.0), 1, 1.012), (degrees(0.0, 0.0), 2, 1.037), (degrees(20.0, 20.0), 1, 1.008)]
    {
        let mut law = reduced();
        let mut simulation = Simulation::new(&mut law, PAPER, at, cycles);
        let mut crest = |cycles: u32| {
            (0..cycles).fold(0.0_f64, |crest, _| {
                simulation.step();
                crest.max(simulation.velocity.norm())
            })
        };
        let (_, first, _, last) = (crest(100), crest(50), crest(250), crest(50));
        assert!(((last / first).powf(1.0 / 300.0) - printed).abs() < 0.001, "{at} {cycles}");
    }
}

#[test]
fn gelfands_formula_agrees_with_the_eigenvalues() {
    for cycles in [0.0, 0.4, 1.0, 2.7] {
        let sampled = sampled(3_000, PAPER, cycles);
        for at in [degrees(0.0, 0.0), degrees(80.0, 60.0), degrees(-120.0, 90.0)] {
            let matrix = sampled.transition(&Feedback::of(&mut reduced(), &at), &at);
            let eigenvalues = Schur::new(matrix).complex_eigenvalues();
            let expected = eigenvalues.iter().map(|value| value.modulus()).fold(0.0, f64::max);
            assert!((sampled.spectral_radius(&mut reduced(), &at) - expected).abs() < 1e-6, "{cycles} {at}");
        }
    }
}

/// A fraction joins the whole numbers of cycles on both sides.
#[test]
fn a_fraction_of_a_cycle_lies_between_the_whole_ones() {
    let radius = |cycles: f64| sampled(3_000, PAPER, cycles).spectral_radius(&mut reduced(), &degrees(0.0, 0.0));
    for whole in [1.0, 2.0] {
        assert!((radius(whole - 1e-7) - radius(whole)).abs() < 1e-6);
        assert!((radius(whole + 1e-7) - radius(whole)).abs() < 1e-6);
    }
    assert!((radius(1e-7) - radius(0.0)).abs() < 1e-6);
    let between = [1.0, 1.25, 1.5, 1.75, 2.0].map(radius);
    assert!(between.windows(2).all(|pair| pair[0] < pair[1]), "{between:?}");
}

/// What a fraction of a cycle does to the arm alone: a torque of one, held, that begins within the period.
#[test]
fn a_torque_within_a_period_moves_the_arm_as_integration_does() {
    const FRACTION: f64 = 0.3;
    let at = degrees(30.0, -40.0);
    let matrix = sampled(3_000, PAPER, FRACTION).transition(&Feedback::of(&mut reduced(), &at), &at);
    let frozen = ThreeLinkDem::<f64>::table_2().reduced(&Vector3::new(0.0, at.x, at.y), &Vector2::zeros());
    // The columns of the last torque: it acts on the first 30 % of the period, and the arm coasts for the rest.
    let acceleration = frozen.mass.try_inverse().unwrap().column(0).into_owned();
    let (mut angle, mut velocity) = (Vector2::zeros(), Vector2::zeros());
    for micro in 0..3_000 {
        let acceleration = if micro < 900 { acceleration } else { Vector2::zeros() };
        angle += velocity * 1e-6 + acceleration * 0.5e-12;
        velocity += acceleration * 1e-6;
    }
    let column = matrix.column(13);
    assert!((Vector2::new(column[0], column[1]) - angle).norm() < 1e-12 * angle.norm().max(1.0));
    assert!((Vector2::new(column[2], column[3]) - velocity).norm() < 1e-10);
}

#[test]
fn an_estimators_equation_does_what_its_code_does() {
    let configurations = [
        PAPER,
        EstimatorConfiguration::Tracking { bandwidth: 80.0 },
        without_delay(),
        EstimatorConfiguration::Kalman(KalmanSettings {
            jerk_density: 50.0,
            measurement_deviation: 1e-4,
            nominal_period: 0.002,
        }),
    ];
    let mut state = 4_711_u64;
    let mut random = || {
        state = state * 48_271 % 2_147_483_647;
        state as f64 / 2_147_483_647.0 - 0.5
    };
    for configuration in configurations {
        let mut estimator: AnyEstimator<f64> = configuration.build().unwrap();
        let linear = LinearEstimator::of(&estimator, period(3_000)).unwrap();
        estimator.reset(0.3);
        let mut estimate = Vector3::new(0.3, 0.0, 0.0);
        for _ in 0..200 {
            let angle = random();
            let expected = estimator.update(angle, 0.003);
            estimate = linear.transition * estimate + linear.input * angle;
            let expected = Vector3::new(expected.position, expected.velocity, expected.acceleration);
            assert!((estimate - expected).norm() < 1e-9 * expected.norm(), "{configuration:?}");
        }
    }
    let levant = EstimatorConfiguration::Levant { jerk_bound: 20.0 }.build().unwrap();
    assert_eq!(LinearEstimator::of(&levant, period(3_000)), Err(NotLinear));
}

/// By hand: K_d = R⁻¹ + M̄Λ and K_p = R⁻¹Λ for the reduced law, the paper's weights read as blocks.
#[test]
fn the_feedback_of_the_reduced_law() {
    let at = degrees(50.0, -20.0);
    let Feedback { position, velocity, base_velocity, base_acceleration } = Feedback::of(&mut reduced(), &at);
    let frozen = ThreeLinkDem::<f64>::table_2().reduced(&Vector3::new(0.0, at.x, at.y), &Vector2::zeros());
    let diagonal = |second: f64, third: f64| nalgebra::Matrix2::from_diagonal(&Vector2::new(second, third));
    let (gain, rate) = (diagonal(1.0 / 0.9, 1.0 / 2.5), diagonal(3.0 / 0.8, 7.0_f64.sqrt() / 0.8));
    assert!((position + gain * rate).norm() < 1e-9, "{position}");
    assert!((velocity + gain + frozen.mass * rate).norm() < 1e-9, "{velocity}");
    assert!(base_velocity.norm() < 1e-9 && base_acceleration.norm() < 1e-9);
    let measured = Feedback::of(&mut law(Law::Nonlinear, Some(BaseAcceleration::Measured)), &at);
    let mass = ThreeLinkDem::<f64>::table_2().partition(&Vector3::new(0.0, at.x, at.y), &Vector3::zeros()).mass_mb;
    assert!((measured.base_acceleration - mass).norm() < 1e-9);
}

#[test]
fn a_task_is_as_unstable_as_its_worst_configuration() {
    let sampled = sampled(3_000, PAPER, 1.0);
    let along = |tolerance| worst(&sampled, &mut reduced(), task(QuinticReference::paper().into(), tolerance)).unwrap();
    assert_printed(along(0.0).radius, 1.008);
    assert_eq!(along(0.0).configuration, degrees(20.0, 20.0));
    assert!(along(0.1).radius > along(0.0).radius);
    assert!(worst(&sampled, &mut reduced(), []).is_none());
}
