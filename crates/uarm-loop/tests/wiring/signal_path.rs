//! Who is told what in a cycle.

use uarm_loop::guard::Quantity;
use uarm_loop::hinf_control::{TorqueLimiter, TorqueLimits};
use uarm_loop::nalgebra::Vector2;
use uarm_loop::signal_path::SignalFault;
use uarm_loop::supervisor::Authority;
use uarm_loop::uarm_io::time::Instant;

use crate::fake_path::{FakeLaw, Told, path, period, rest, tick};

#[test]
fn the_law_is_told_after_each_torque_what_was_cut_of_it() {
    let mut law = FakeLaw::constant(0.11, 0.19);
    let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
    for (index, elapsed) in [(0, 0), (1, 1), (4, 3)] {
        let signals =
            path.step(&tick(index, elapsed), Instant::default(), &[Some(0); 3], period(), Authority::Full).unwrap();
        assert_eq!(signals.torque.limited.applied, Vector2::new(0.1, 0.19));
        assert_eq!(signals.command.torque, Vector2::new(0.11, 0.19));
        assert_eq!(signals.torque.sent, [0, 500, 950]);
    }
    let limited = Told::Limited([true, false]);
    let expected = [Told::Update(0.0), limited, Told::Update(0.003), limited, Told::Update(0.009), limited];
    assert_eq!(law.told, expected);
}

/// 10 N·m/s for 3 ms are 0.03 N·m, in the first cycle too; for the 9 ms of the last they are 0.09.
#[test]
fn torques_have_the_period_to_rise_in() {
    let mut law = FakeLaw::constant(0.1, -0.2);
    let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
    let limits = TorqueLimits::new(Vector2::new(0.1, 0.2)).unwrap();
    path.torque.limiter = TorqueLimiter::new(limits.with_rate(Vector2::new(10.0, 10.0)).unwrap());
    let mut applied = |index, elapsed| {
        path.step(&tick(index, elapsed), Instant::default(), &[Some(0); 3], period(), Authority::Full)
            .unwrap()
            .torque
            .limited
            .applied
    };
    assert!((applied(0, 0) - Vector2::new(0.03, -0.03)).norm() < 1e-15);
    assert!((applied(1, 1) - Vector2::new(0.06, -0.06)).norm() < 1e-15);
    assert!((applied(4, 3) - Vector2::new(0.1, -0.15)).norm() < 1e-15);
}

#[test]
fn beyond_a_limit_the_law_is_not_asked() {
    let mut law = FakeLaw::constant(0.0, 0.0);
    let mut path = path(&mut law, rest([0.5, 0.0], 1.0, 0.0));
    path.guard.start_tolerance = 0.4;
    let fault = path.step(&tick(0, 0), Instant::default(), &[Some(0); 3], period(), Authority::Full).unwrap_err();
    let SignalFault::Limit(violation) = fault else { panic!("{fault}") };
    assert_eq!((violation.joint, violation.quantity, violation.found), (2, Quantity::StartError, -0.5));
    assert_eq!(law.told, []);
}

#[test]
fn a_law_does_not_adapt_on_a_predicted_angle() {
    let mut law = FakeLaw::constant(0.0, 0.0);
    let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
    for (index, counts) in [[Some(0); 3], [None, Some(0), Some(0)], [Some(0); 3]].iter().enumerate() {
        let index = index as u64;
        path.step(&tick(index, index.min(1)), Instant::default(), counts, period(), Authority::Full).unwrap();
    }
    let limited = Told::Limited([false; 2]);
    let expected = [Told::Update(0.0), limited, Told::Update(0.003), limited, Told::Hold, Told::Update(0.003), limited];
    assert_eq!(law.told, expected);
}
