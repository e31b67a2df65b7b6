//! Every limit of the robot, on both of its sides.

use uarm_loop::barrier::{Stopping, Times};
use uarm_loop::estimation::Estimate;
use uarm_loop::guard::{Braking, Guard, JointLimits, LimitViolation, Quantity};
use uarm_loop::hinf_control::{QuinticReference, Reference};
use uarm_loop::motion::Motion;
use uarm_loop::nalgebra::Vector2;
use uarm_loop::plausibility::AccelerationBound;
use uarm_loop::uarm_io::estimator;
use uarm_loop::uarm_io::time::Duration;

/// 40 rad/s² at most, a brake of 30 ms.
const STOPPING: Stopping = Stopping {
    acceleration: AccelerationBound { by_torque: 40.0, by_velocity: 0.0 },
    brake: Duration::from_millis(30),
    torque_delay: Duration::ZERO,
    resolution: 0.0,
};

/// Joint 1 within −1 to 2 rad and 3 rad/s, joint 2 within −0.5 to 0.75 and 4, joint 3 within −0.25 to 0.5 and 5.
const GUARD: Guard<3> = Guard {
    joints: [
        JointLimits { position: [-1.0, 2.0], velocity: 3.0 },
        JointLimits { position: [-0.5, 0.75], velocity: 4.0 },
        JointLimits { position: [-0.25, 0.5], velocity: 5.0 },
    ],
    stopping: [STOPPING; 3],
    tracking_error: 0.125,
    start_tolerance: 0.0625,
};

fn at(position: [f64; 3], velocity: [f64; 3]) -> Estimate<3> {
    let joint = |index: usize| estimator::Estimate {
        position: position[index],
        velocity: velocity[index],
        acceleration: 1e9, // nobody limits it
    };
    Estimate { joints: std::array::from_fn(joint), measured: [f64::NAN; 3], ..Estimate::default() }
}

/// A reference without tracking error, so that only the joint's own limits count.
fn tracked(estimate: &Estimate<3>) -> Reference<f64, 2> {
    reference(estimate.joints[1].position, estimate.joints[2].position)
}

fn reference(joint_2: f64, joint_3: f64) -> Reference<f64, 2> {
    Reference { position: Vector2::new(joint_2, joint_3), velocity: Vector2::zeros(), acceleration: Vector2::zeros() }
}

fn with(joint: usize, value: f64) -> [f64; 3] {
    let mut values = [0.0; 3];
    values[joint - 1] = value;
    values
}

#[test]
fn angles_are_limited_on_both_sides_of_every_joint() {
    for (joint, allowed) in [(1, [-1.0, 2.0]), (2, [-0.5, 0.75]), (3, [-0.25, 0.5])] {
        for (inside, outside) in [(allowed[0], allowed[0] - 1e-9), (allowed[1], allowed[1] + 1e-9)] {
            let check = |angle| {
                let estimate = at(with(joint, angle), [0.0; 3]);
                GUARD.check(0.25, 1, &estimate, &tracked(&estimate))
            };
            assert_eq!(check(inside), Ok(()), "joint {joint} at {inside}");
            let quantity = Quantity::Position;
            assert_eq!(
                check(outside),
                Err(LimitViolation { joint, time: 0.25, quantity, found: outside, allowed, braking: None })
            );
        }
    }
}

#[test]
fn velocities_are_limited_in_both_directions_of_every_joint() {
    for (joint, limit) in [(1, 3.0), (2, 4.0), (3, 5.0)] {
        for sign in [1.0, -1.0] {
            let check = |velocity| {
                let estimate = at([0.0; 3], with(joint, velocity));
                GUARD.check(0.25, 1, &estimate, &tracked(&estimate))
            };
            assert_eq!(check(sign * limit), Ok(()));
            let (quantity, found) = (Quantity::Velocity, sign * (limit + 1e-9));
            let allowed = [-limit, limit];
            assert_eq!(
                check(found),
                Err(LimitViolation { joint, time: 0.25, quantity, found, allowed, braking: None })
            );
        }
    }
}

#[test]
fn what_is_no_number_is_outside() {
    for joint in 1..=3 {
        let estimate = at(with(joint, f64::NAN), [0.0; 3]);
        let violation = GUARD.check(0.0, 1, &estimate, &reference(0.0, 0.0)).unwrap_err();
        assert_eq!((violation.joint, violation.quantity), (joint, Quantity::Position));
        let estimate = at([0.0; 3], with(joint, f64::NAN));
        let violation = GUARD.check(0.0, 1, &estimate, &reference(0.0, 0.0)).unwrap_err();
        assert_eq!((violation.joint, violation.quantity), (joint, Quantity::Velocity));
    }
    for (joint, reference) in [(2, reference(f64::NAN, 0.0)), (3, reference(0.0, f64::NAN))] {
        let violation = GUARD.check(0.0, 1, &at([0.0; 3], [0.0; 3]), &reference).unwrap_err();
        assert_eq!((violation.joint, violation.quantity), (joint, Quantity::TrackingError));
    }
}

/// The error is the estimated angle less the desired one, of joints 2 and 3 alone; in the first cycle it has a limit of its
/// own.
#[test]
fn both_active_joints_are_kept_near_the_reference() {
    let cases =
        [(0, Quantity::StartError, 0.0625), (1, Quantity::TrackingError, 0.125), (7, Quantity::TrackingError, 0.125)];
    for (elapsed, quantity, limit) in cases {
        for joint in [2, 3] {
            for sign in [1.0, -1.0] {
                // Joint 1 is anywhere: it has no reference.
                let check = |error: f64| {
                    let angles = if joint == 2 { [1.5, 0.25 + error, 0.0] } else { [1.5, 0.25, error] };
                    GUARD.check(0.25, elapsed, &at(angles, [0.0; 3]), &reference(0.25, 0.0))
                };
                assert_eq!(check(sign * limit), Ok(()));
                let found = sign * (limit + 2_f64.powi(-30));
                let allowed = [-limit, limit];
                assert_eq!(
                    check(found),
                    Err(LimitViolation { joint, time: 0.25, quantity, found, allowed, braking: None })
                );
            }
        }
    }
}

#[test]
fn a_violation_reads_in_degrees() {
    let allowed = [-1.0, 1.0];
    let violation =
        LimitViolation { joint: 3, time: 0.25, quantity: Quantity::Velocity, found: 2.0, allowed, braking: None };
    let text = "joint 3 at 0.250 s: velocity is 114.59 deg/s, expected -57.30 to 57.30 deg/s";
    assert_eq!(violation.to_string(), text);
    let violation = LimitViolation { quantity: Quantity::StartError, ..violation };
    let text = "joint 3 at 0.250 s: distance from the start of the motion is 114.59 deg, expected -57.30 to 57.30 deg";
    assert_eq!(violation.to_string(), text);
}

/// A task from (0.25, 0.125) rad.
fn task() -> Motion<2> {
    Motion::task(QuinticReference::new(Vector2::new(0.25, 0.125), Vector2::new(0.5, 0.25), 2.0).unwrap(), 0.0)
}

#[test]
fn a_run_that_would_begin_beyond_a_limit_is_refused_before_brakes_open() {
    let start = |joint_1: f64, joint_2: f64, joint_3: f64| GUARD.check_start(&[joint_1, joint_2, joint_3], &task());
    assert_eq!(start(2.0, 0.25 + 0.0625, 0.125 - 0.0625), Ok(()));
    let violation = start(2.0 + 1e-9, 0.25, 0.125).unwrap_err();
    assert_eq!((violation.joint, violation.quantity, violation.time), (1, Quantity::Position, 0.0));
    let violation = start(0.0, 0.25, 0.0625 - 1e-9).unwrap_err();
    assert_eq!((violation.joint, violation.quantity), (3, Quantity::StartError));
    assert_eq!(violation.allowed, [-0.0625, 0.0625]);
}

/// 15/8 of 0.75 rad in 0.25 s are 5.625 rad/s, more than joint 2 may do; in 0.375 s they are 3.75.
#[test]
fn an_approach_that_is_too_fast_is_refused_before_brakes_open() {
    let from = Vector2::new(-0.5, 0.125);
    let start = |duration: f64| {
        let motion = task().after(QuinticReference::new(from, Vector2::new(0.25, 0.125), duration).unwrap());
        GUARD.check_start(&[0.0, from.x, from.y], &motion)
    };
    assert_eq!(start(0.375), Ok(()));
    let (quantity, allowed) = (Quantity::ApproachVelocity, [-4.0, 4.0]);
    let expected = LimitViolation { joint: 2, time: -0.25, quantity, found: 5.625, allowed, braking: None };
    assert_eq!(start(0.25), Err(expected));
    assert!(expected.to_string().contains("largest velocity of the approach is 322.29 deg/s"), "{expected}");
}

/// At 2 rad/s, period 2 ms: 2.04 rad/s now, 2.2 rad/s after 4 ms and 8.48 mrad, then 66 mrad more until the brake holds.
#[test]
fn a_joint_that_could_not_be_stopped_a_cycle_later_is_stopped_now() {
    let times = Times { time: 0.25, elapsed: 0.002, period: 0.002 };
    for (joint, allowed, velocity) in [(1, [-1.0, 2.0], 3.0), (2, [-0.5, 0.75], 4.0), (3, [-0.25, 0.5], 5.0)] {
        for (direction, limit) in [(1.0, allowed[1]), (-1.0, allowed[0])] {
            let check = |angle: f64, speed: f64| {
                let before = with(joint, angle - direction * speed * 0.002).map(Some);
                GUARD.check_stopping(&times, &before, &with(joint, angle))
            };
            let last = limit - direction * 0.07448;
            assert_eq!(check(last - direction * 1e-6, 2.0), Ok(()), "joint {joint}");
            let violation = check(last + direction * 1e-6, 2.0).unwrap_err();
            assert_eq!(
                (violation.joint, violation.quantity, violation.allowed),
                (joint, Quantity::StoppingAngle, allowed)
            );
            let braking = violation.braking.unwrap();
            assert!((braking.velocity - direction * 2.0).abs() < 1e-9, "{braking:?}");
            assert_eq!(braking.brake, Duration::from_millis(30));
            let coasting =
                format!("; it turns by {:.2} deg/s, and its brake takes 30 ms (brake_ms)", direction * 114.591_559);
            assert!(violation.to_string().ends_with(&coasting), "{violation}");
            // 0.2 rad/s are gained until the stop acts.
            assert_eq!(check(0.0, velocity - 0.2001), Ok(()), "joint {joint}");
            let violation = check(0.0, velocity - 0.1999).unwrap_err();
            assert_eq!((violation.joint, violation.quantity), (joint, Quantity::StoppingVelocity));
            assert!((violation.found - direction * (velocity + 1e-4)).abs() < 1e-9);
        }
    }
}

/// Joint 3 at 4 rad/s, 0.5 per rad: joint 2 at rest gets 8 rad/s² by it, goes 2.4 mrad in the two periods and 60 mrad more until its
/// brake holds.
#[test]
fn a_fast_joint_takes_from_the_room_of_the_others() {
    let stopping = Stopping {
        acceleration: AccelerationBound { by_torque: 0.0, by_velocity: 0.5 },
        brake: Duration::from_millis(100),
        ..STOPPING
    };
    let wide = JointLimits { position: [-9.0, 9.0], velocity: 9.0 };
    let guard = Guard { joints: [wide, GUARD.joints[1], wide], stopping: [stopping; 3], ..GUARD };
    let times = Times { time: 0.25, elapsed: 0.01, period: 0.01 };
    let check = |turned: f64, angle: f64| {
        guard.check_stopping(&times, &[Some(0.0), Some(angle), Some(0.0)], &[0.0, angle, turned])
    };
    for turned in [0.04, -0.04] {
        assert_eq!(check(turned, 0.75 - 0.0624 - 1e-6), Ok(()));
        let violation = check(turned, 0.75 - 0.0624 + 1e-6).unwrap_err();
        assert_eq!((violation.joint, violation.quantity), (2, Quantity::StoppingAngle));
    }
    // In the first cycle nothing has turned yet.
    let first = Times { elapsed: 0.0, ..times };
    assert_eq!(guard.check_stopping(&first, &[None; 3], &[0.0, 0.75, 9.0]), Ok(()));
}

/// 40 rad/s² for two periods of 2 ms from rest: 0.32 mrad and 0.16 rad/s, and 4.8 mrad more until the brake holds.
#[test]
fn a_joint_at_rest_near_its_limit_is_told_to_stand_still() {
    let first = Times { time: 0.0, elapsed: 0.0, period: 0.002 };
    let check = |angle: f64| GUARD.check_stopping(&first, &[None; 3], &[angle, 0.0, 0.0]);
    assert_eq!(check(2.0 - 0.00512 - 1e-6), Ok(()));
    let violation = check(2.0 - 0.00512 + 1e-6).unwrap_err();
    assert_eq!((violation.joint, violation.quantity), (1, Quantity::StoppingAngle));
    assert_eq!(violation.braking, Some(Braking { velocity: 0.0, brake: Duration::from_millis(30) }));
}
