//! Who is told what in a cycle.

use std::sync::Arc;

use uarm_loop::finite::{JointSignal, NotFinite};
use uarm_loop::guard::Quantity;
use uarm_loop::hinf_control::{TorqueLimiter, TorqueLimits};
use uarm_loop::nalgebra::Vector2;
use uarm_loop::plausibility::Trend;
use uarm_loop::saturation::{SaturationLimit, SaturationWatch};
use uarm_loop::signal_path::SignalFault;
use uarm_loop::supervision::model::MomentumModel;
use uarm_loop::supervision::settings::{Bandwidth, ModelError, ResidualTime, SupervisionSettings, TorqueAllowance};
use uarm_loop::supervision::{JointTraits, Supervision};
use uarm_loop::supervisor::Authority;
use uarm_loop::uarm_io::time::{Duration, Instant};

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

/// The estimator makes NaN of the angle when its acceleration is NaN.
#[test]
fn an_estimate_that_is_no_number_does_not_reach_the_law() {
    let mut law = FakeLaw::constant(0.0, 0.0);
    let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
    path.step(&tick(0, 0), Instant::default(), &[Some(0); 3], period(), Authority::Full).unwrap();
    let mut states = path.estimation.freeze();
    states[0].estimator.as_mut().unwrap().acceleration = f64::NAN;
    path.estimation.thaw(&states);
    let fault = path.step(&tick(1, 1), Instant::default(), &[Some(0); 3], period(), Authority::Full).unwrap_err();
    let SignalFault::NotFinite(NotFinite::Joint { joint: 1, signal: JointSignal::Angle, .. }) = fault else {
        panic!("{fault}")
    };
    assert_eq!(law.told.len(), 2, "only the first cycle: {:?}", law.told);
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

/// Joint 2 is asked for 0.11 N·m of 0.1 in each cycle: 3, 6 and 9 ms.
#[test]
fn lasting_saturation_ends_a_run_but_not_a_stop() {
    let steps = |authority| {
        let mut law = FakeLaw::constant(0.11, 0.0);
        let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
        path.saturation = SaturationWatch::new(SaturationLimit::new(Duration::from_millis(7)).unwrap());
        [0, 1, 2].map(|index| {
            let step = path.step(&tick(index, index.min(1)), Instant::default(), &[Some(0); 3], period(), authority);
            step.map(|_| ()).map_err(|fault| fault.to_string())
        })
    };
    let cut = "joint 2: the torque was cut by its limits for 9 ms without a break, expected at most 7 ms";
    assert_eq!(steps(Authority::Full), [Ok(()), Ok(()), Err(cut.to_owned())]);
    assert_eq!(steps(Authority::Fading), [Ok(()), Ok(()), Ok(())]);
}

/// A joint that turns by ten counts a cycle; the third SYNC is half a millisecond late.
#[test]
fn a_late_sync_makes_the_time_between_two_counts_less_certain() {
    let mut law = FakeLaw::constant(0.0, 0.0);
    let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
    let mut trend = |index: u64, microseconds: u64, count: i32| {
        let sync_sent = Instant::from_nanoseconds(microseconds * 1_000);
        let tick = tick(index, index.min(1));
        path.step(&tick, sync_sent, &[Some(0), Some(count), Some(0)], period(), Authority::Full).unwrap();
        path.freeze().joints[1].trend
    };
    trend(0, 0, 0);
    let regular = Trend { velocity: 10.0 / 0.003, span: 0.003, time_error: 0.0 };
    assert_eq!(trend(1, 3_000, 10), regular);
    let late = trend(2, 6_500, 20);
    assert_eq!((late.velocity, late.span), (regular.velocity, 0.003));
    assert!((late.time_error - 0.0005).abs() < 1e-12, "{late:?}");
}

/// Three joints of 1 kg·m² that do not act on each other.
#[derive(Debug)]
struct ThreeFlywheels;

impl MomentumModel<3> for ThreeFlywheels {
    fn inertia(&self, _: &[f64; 3]) -> [[f64; 3]; 3] {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    }

    fn velocity_torque(&self, _: &[f64; 3], _: &[f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }
}

/// Joint 3 accelerates by a count a cycle, 19 rad/s², although its motor has no torque.
#[test]
fn what_the_model_does_not_explain_ends_a_run_that_is_supervised() {
    let settings = SupervisionSettings {
        model: Arc::new(ThreeFlywheels),
        bandwidth: Bandwidth::of_period(0.003),
        model_error: ModelError::default(),
        residual_time: ResidualTime::default(),
        allowances: [None, TorqueAllowance::new(0.1), TorqueAllowance::new(0.1)],
    };
    let joints = [JointTraits { resolution: 1.7e-4, delay: 0.0 }; 3];
    let run = |supervision| {
        let mut law = FakeLaw::constant(0.0, 0.0);
        let mut path = path(&mut law, rest([0.0; 2], 1.0, 0.0));
        path.supervision = supervision;
        (0..60_u64).try_fold(None, |_, index| {
            let count = i32::try_from(index * index / 2).unwrap();
            let sync_sent = Instant::from_nanoseconds(index * 3_000_000);
            let counts = [Some(0), Some(0), Some(count)];
            let signals = path.step(&tick(index, index.min(1)), sync_sent, &counts, period(), Authority::Full)?;
            Ok(signals.residuals)
        })
    };
    assert_eq!(run(None), Ok(None));
    let SignalFault::Supervision(fault) = run(Some(Supervision::new(settings, joints))).unwrap_err() else {
        panic!("expected a contradiction of the model")
    };
    assert_eq!(fault.joint, 3);
}
