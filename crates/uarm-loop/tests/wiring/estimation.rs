//! Which joint is which.

use std::f64::consts::TAU;

use uarm_loop::estimation::{AngleError, AngleSource, Estimate, Estimation, EstimationError};
use uarm_loop::hinf_control::Measurement;
use uarm_loop::nalgebra::Vector2;
use uarm_loop::plausibility::Elapsed;
use uarm_loop::uarm_io::encoder::{
    CounterWidth, CountsPerRevolution, Direction, EncoderConfiguration, EncoderError, JumpLimit,
};
use uarm_loop::uarm_io::estimator::{self, EstimatorConfiguration};
use uarm_loop::uarm_io::time::Duration;

/// Joints of 64, 128 and 256 counts per revolution: powers of two, so that angles are exact.
fn estimation() -> Estimation<3> {
    let estimator = EstimatorConfiguration::LowPass { cutoff: 30.0 }.build().unwrap();
    Estimation::new([64, 128, 256].map(|counts| {
        let encoder = EncoderConfiguration {
            counts_per_revolution: CountsPerRevolution::new(counts).unwrap(),
            counter_width: CounterWidth::FULL,
            direction: Direction::Positive,
            zero: 0,
            jump_limit: JumpLimit::new(1.0, 5).unwrap(),
        };
        (encoder, estimator)
    }))
}

#[test]
fn every_count_becomes_the_angle_of_its_own_joint() {
    let estimate = estimation().estimate(&[Some(16); 3], Elapsed::exactly(0.0)).unwrap();
    assert_eq!(estimate.measured, [TAU / 4.0, TAU / 8.0, TAU / 16.0]);
    assert_eq!(estimate.position(), estimate.measured, "the first reading is a joint at rest");
    assert_eq!(estimate.velocity(), [0.0; 3]);
}

#[test]
fn a_refused_count_names_its_joint() {
    for (joint, counts) in [(1, [6, 0, 0]), (2, [0, -6, 0]), (3, [0, 0, 6])] {
        let mut estimation = estimation();
        estimation.estimate(&[Some(0); 3], Elapsed::exactly(0.0)).unwrap();
        // 1 rad/s is less than a count in 1 ms: five counts of margin are what is believed.
        let refused = estimation.estimate(&counts.map(Some), Elapsed::exactly(0.001)).unwrap();
        assert_eq!(refused.sources[joint - 1], AngleSource::Refused, "the first of two");
        let error = estimation.estimate(&counts.map(Some), Elapsed::exactly(0.001)).unwrap_err();
        let change = i64::from(counts[joint - 1]);
        let source = EncoderError::Jump { change, limit: 5, elapsed: Duration::from_millis(2) };
        assert_eq!(error, EstimationError { joint, source: source.into() });
        assert!(error.to_string().starts_with(&format!("joint {joint}: the counter went by {change} counts in 2ms")));
    }
}

#[test]
fn the_laws_see_joint_1_as_the_base_and_joints_2_and_3_as_the_arm() {
    let joint =
        |number: f64| estimator::Estimate { position: number, velocity: 10.0 * number, acceleration: 100.0 * number };
    let estimate = Estimate { joints: [joint(1.0), joint(2.0), joint(3.0)], ..Estimate::default() };
    let measurement: Measurement<f64, 2> = estimate.measurement();
    assert_eq!(measurement.position, Vector2::new(2.0, 3.0));
    assert_eq!(measurement.velocity, Vector2::new(20.0, 30.0));
    assert_eq!([measurement.base.velocity.x, measurement.base.acceleration.x], [10.0, 100.0]);
}

/// A quarter of a radian per second for a second, read every 10 ms: 256 counts per revolution, so about 10 counts.
#[test]
fn a_missing_angle_goes_on_with_the_estimated_velocity_for_two_cycles() {
    let mut estimation = estimation();
    let mut velocity = 0.0;
    for cycle in 0..100 {
        let count = (0.25 * 0.01 * f64::from(cycle) / (TAU / 256.0) + 0.5).floor() as i32;
        velocity = estimation.estimate(&[Some(0), Some(0), Some(count)], Elapsed::exactly(0.01)).unwrap().velocity()[2];
    }
    assert!((velocity - 0.25).abs() < 0.2, "{velocity}");
    let last = TAU / 256.0 * 10.0;
    for cycle in 1..=2_u8 {
        let estimate = estimation.estimate(&[Some(0), Some(0), None], Elapsed::exactly(0.01)).unwrap();
        assert_eq!(estimate.sources, [AngleSource::Measured, AngleSource::Measured, AngleSource::Missing]);
        assert_eq!(estimate.counts, [0, 0, 10]);
        let expected = last + velocity * 0.01 * f64::from(cycle);
        assert!((estimate.measured[2] - expected).abs() < 1e-12, "{} {expected}", estimate.measured[2]);
        assert!((estimate.velocity()[2] - velocity).abs() < 1e-9, "a low-pass goes on as it was");
    }
    let error = estimation.estimate(&[Some(0), Some(0), None], Elapsed::exactly(0.01)).unwrap_err();
    assert_eq!(error, EstimationError { joint: 3, source: AngleError::Missing { cycles: 3 } });
    assert_eq!(
        error.to_string(),
        "joint 3: its drive sent no position in 3 cycles in a row, expected one in 3 at least"
    );
}

#[test]
fn a_count_that_comes_ends_the_prediction() {
    let mut estimation = estimation();
    for counts in [[Some(0); 3], [None; 3], [None; 3], [Some(1); 3], [None; 3], [None; 3], [Some(0); 3]] {
        estimation.estimate(&counts, Elapsed::exactly(0.01)).unwrap();
    }
}

#[test]
fn without_a_first_count_there_is_nothing_to_predict_from() {
    let error = estimation().estimate(&[Some(0), None, Some(0)], Elapsed::exactly(0.0)).unwrap_err();
    assert_eq!(error, EstimationError { joint: 2, source: AngleError::NoneYet });
}
