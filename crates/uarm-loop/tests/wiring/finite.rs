//! Every number that must be finite, one at a time.

use uarm_loop::estimation::Estimate;
use uarm_loop::finite::{JointSignal, NotFinite, check_command, check_estimate};
use uarm_loop::hinf_control::{AdaptationStatus, Command};
use uarm_loop::nalgebra::Vector2;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn command() -> Command<f64> {
    Command {
        torque: Vector2::new(0.1, -0.1),
        control_input: Vector2::new(1.0, 2.0),
        adaptation: AdaptationStatus::default(),
    }
}

/// What a joint's number is refused with.
fn joint_of(refused: Result<(), NotFinite>) -> (usize, JointSignal, u64) {
    match refused {
        Err(NotFinite::Joint { joint, signal, found }) => (joint, signal, found.to_bits()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_number_of_an_estimate_is_looked_at() {
    let good = Estimate::<3>::default();
    assert_eq!(check_estimate(&good), Ok(()));
    for bad in BAD {
        for index in 0..3 {
            let refused = |change: &dyn Fn(&mut Estimate<3>)| {
                let mut estimate = good;
                change(&mut estimate);
                joint_of(check_estimate(&estimate))
            };
            let with = |signal| (index + 1, signal, bad.to_bits());
            assert_eq!(refused(&|estimate| estimate.measured[index] = bad), with(JointSignal::MeasuredAngle));
            assert_eq!(refused(&|estimate| estimate.joints[index].position = bad), with(JointSignal::Angle));
            assert_eq!(refused(&|estimate| estimate.joints[index].velocity = bad), with(JointSignal::Velocity));
            assert_eq!(refused(&|estimate| estimate.joints[index].acceleration = bad), with(JointSignal::Acceleration));
        }
    }
}

#[test]
fn every_number_of_a_command_is_looked_at() {
    assert_eq!(check_command::<3, 2>(&command(), &[1.0, -1.0, 0.0]), Ok(()));
    for bad in BAD {
        for index in 0..2 {
            let mut torque = command();
            torque.torque[index] = bad;
            assert_eq!(joint_of(check_command::<3, 2>(&torque, &[])), (index + 2, JointSignal::Torque, bad.to_bits()));
            let mut input = command();
            input.control_input[index] = bad;
            assert_eq!(
                joint_of(check_command::<3, 2>(&input, &[])),
                (index + 2, JointSignal::ControlInput, bad.to_bits())
            );
        }
        let refused = check_command::<3, 2>(&command(), &[1.0, bad, f64::NAN]);
        assert!(matches!(refused, Err(NotFinite::Parameter { number: 2, found }) if found.to_bits() == bad.to_bits()));
    }
    let mut fallback = command();
    fallback.adaptation.not_finite = true;
    assert_eq!(check_command::<3, 2>(&fallback, &[f64::NAN]), Err(NotFinite::Law));
}

#[test]
fn it_is_told_in_words() {
    for (signal, words) in [
        (JointSignal::MeasuredAngle, "joint 2: the measured angle is inf, expected a finite number"),
        (JointSignal::Angle, "joint 2: the estimated angle is inf, expected a finite number"),
        (JointSignal::Velocity, "joint 2: the estimated velocity is inf, expected a finite number"),
        (JointSignal::Acceleration, "joint 2: the estimated acceleration is inf, expected a finite number"),
        (JointSignal::Torque, "joint 2: the torque that the law asks for is inf, expected a finite number"),
        (JointSignal::ControlInput, "joint 2: the control input is inf, expected a finite number"),
    ] {
        assert_eq!(NotFinite::Joint { joint: 2, signal, found: f64::INFINITY }.to_string(), words);
    }
}
