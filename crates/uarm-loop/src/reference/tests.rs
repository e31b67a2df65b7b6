use super::*;
use nalgebra::{SVector, Vector1, Vector2};

fn through(time: f64, position: f64) -> ViaPoint<1> {
    ViaPoint { time, position: Vector1::new(position), passing: Passing::Through }
}

fn path(via: &[ViaPoint<1>], end: f64, duration: f64) -> TaskReference<1> {
    TaskReference::new(Path::new(Vector1::new(0.0), via, Vector1::new(end), duration).unwrap(), None)
}

/// Derivatives against differences of the motion itself.
fn assert_derivatives<const N: usize>(reference: &TaskReference<N>) {
    const STEP: f64 = 1e-5;
    for sample in 1..200 {
        let time = reference.duration() * (f64::from(sample) + 0.37) / 200.0;
        let [before, now, after] = [time - STEP, time, time + STEP].map(|time| reference.at(time));
        let velocity = (after.position - before.position) / (2.0 * STEP);
        let acceleration = (after.velocity - before.velocity) / (2.0 * STEP);
        assert!((velocity - now.velocity).norm() < 1e-6 * (1.0 + now.velocity.norm()), "{time}");
        assert!((acceleration - now.acceleration).norm() < 1e-5 * (1.0 + now.acceleration.norm()), "{time}");
    }
}

/// Integral of the squared jerk of the first joint, by the midpoint rule over differences of the acceleration.
fn jerk_cost<const N: usize>(reference: &TaskReference<N>) -> f64 {
    const SAMPLES: u32 = 20_000;
    let step = reference.duration() / f64::from(SAMPLES);
    let acceleration = |sample: u32| reference.at(step * f64::from(sample)).acceleration[0];
    (0..SAMPLES).map(|sample| ((acceleration(sample + 1) - acceleration(sample)) / step).powi(2) * step).sum()
}

#[test]
fn without_postures_it_is_the_quintic_bit_for_bit() {
    let quintic = QuinticReference::<f64, 2>::paper();
    let reference = TaskReference::from(quintic);
    let path = Path::new(*quintic.start(), &[], *quintic.end(), 3.0).unwrap();
    for sample in -10..400 {
        let time = f64::from(sample) * 0.01;
        assert_eq!(reference.at(time), quintic.at(time));
        assert_eq!(path.at(time), quintic.at(time));
    }
    assert_eq!(reference.as_quintic(), Some(&quintic));
}

/// A quintic from rest to rest is the motion of least jerk (the Euler–Lagrange equation of ∫ q⃛² dt is q⁽⁶⁾ = 0): to pass where it is
/// anyway changes nothing.
#[test]
fn postures_on_the_quintic_leave_it_as_it_is() {
    let quintic = QuinticReference::new(Vector1::new(0.0), Vector1::new(1.5), 2.0).unwrap();
    let on_the_way = |time: f64| through(time, quintic.at(time).position[0]);
    let reference = path(&[on_the_way(0.3), on_the_way(0.9), on_the_way(1.0), on_the_way(1.7)], 1.5, 2.0);
    for sample in 0..=200 {
        let time = f64::from(sample) * 0.01;
        let (found, expected) = (reference.at(time), quintic.at(time));
        assert!((found.position - expected.position).norm() < 1e-12, "{time}");
        assert!((found.velocity - expected.velocity).norm() < 1e-11, "{time}");
        assert!((found.acceleration - expected.acceleration).norm() < 1e-9, "{time}");
    }
}

/// There and back in 2 s by the posture 1 at half time: by symmetry v = 0 and the snap has no condition, a from continuity of jerk:
/// 60/T³ + 9a/T = −60/T³ − 9a/T, so a = −60/9/T².
#[test]
fn there_and_back_is_as_by_hand() {
    let reference = path(&[through(1.0, 1.0)], 0.0, 2.0);
    let middle = reference.at(1.0);
    assert!((middle.position[0] - 1.0).abs() < 1e-12 && middle.velocity[0].abs() < 1e-12);
    assert!((middle.acceleration[0] + 20.0 / 3.0).abs() < 1e-10, "{}", middle.acceleration[0]);
}

#[test]
fn it_passes_every_posture_and_ends_at_rest() {
    let positions = [Vector2::new(0.4, -0.3), Vector2::new(-0.2, 0.5), Vector2::new(0.1, 0.9)];
    let times = [0.5, 0.8, 1.9];
    let via: Vec<_> = times
        .into_iter()
        .zip(positions)
        .map(|(time, position)| ViaPoint { time, position, passing: Passing::Through })
        .collect();
    let (start, end) = (Vector2::new(0.1, 0.2), Vector2::new(-0.4, 0.3));
    let reference = TaskReference::new(Path::new(start, &via, end, 2.5).unwrap(), None);
    for point in &via {
        assert!((reference.at(point.time).position - point.position).norm() < 1e-12);
    }
    for (time, posture) in [(-1.0, start), (0.0, start), (2.5, end), (9.0, end)] {
        let rest = reference.at(time);
        assert!((rest.position - posture).norm() < 1e-15, "{time}");
        assert_eq!((rest.velocity.norm(), rest.acceleration.norm()), (0.0, 0.0), "{time}");
    }
    assert_eq!((reference.finest() * 10.0).round(), 3.0);
    assert_eq!(reference.at(f64::NAN).position, start);
    assert_derivatives(&reference);
}

/// Any other motion through the same postures has more jerk: here, those that pass one more posture, a little off.
#[test]
fn its_jerk_is_the_least() {
    let via = [through(0.5, 0.6), through(1.2, -0.4)];
    let least = path(&via, 1.0, 2.0);
    let cost = jerk_cost(&least);
    for (time, off) in [(0.2, 1e-2), (0.2, -1e-2), (0.9, 1e-2), (0.9, -1e-2), (1.6, 1e-2), (1.6, -1e-2)] {
        let mut more: Vec<_> = via.to_vec();
        more.push(through(time, least.at(time).position[0] + off));
        more.sort_by(|one, other| one.time.total_cmp(&other.time));
        assert!(jerk_cost(&path(&more, 1.0, 2.0)) > cost * (1.0 + 1e-6), "{time} {off}");
    }
}

#[test]
fn a_posture_can_be_passed_at_rest() {
    let stop = ViaPoint { passing: Passing::Stop, ..through(1.0, 0.7) };
    let reference = path(&[through(0.4, 0.5), stop, through(1.5, -0.2)], 0.3, 2.0);
    let rest = reference.at(1.0);
    assert!((rest.position[0] - 0.7).abs() < 1e-12);
    assert_eq!((rest.velocity[0], rest.acceleration[0]), (0.0, 0.0));
    // Each half is as if it were alone.
    let first = path(&[through(0.4, 0.5)], 0.7, 1.0);
    for sample in 0..100 {
        let time = f64::from(sample) * 0.01;
        assert!((reference.at(time).position - first.at(time).position).norm() < 1e-12);
    }
}

#[test]
fn ten_thousand_postures_of_a_sine_are_the_sine() {
    let sine = |time: f64| (1.0 - (0.5 * time).cos()) * 0.5;
    let via: Vec<_> = (1..10_000).map(|index| f64::from(index) * 1e-2).map(|time| through(time, sine(time))).collect();
    let reference = path(&via, sine(100.0), 100.0);
    // The ends are pulled to rest; away from them it is the sine.
    for sample in 0..1000 {
        let time = 20.0 + f64::from(sample) * 0.061;
        assert!((reference.at(time).position[0] - sine(time)).abs() < 1e-9, "{time}");
        assert!((reference.at(time).velocity[0] - 0.25 * (0.5 * time).sin()).abs() < 1e-7, "{time}");
    }
}

#[test]
fn what_is_no_path_is_refused() {
    let at = |via: &[ViaPoint<1>]| Path::new(Vector1::new(0.0), via, Vector1::new(1.0), 2.0).unwrap_err();
    for time in [0.0, -1.0, 2.0, 3.0, f64::NAN] {
        assert!(matches!(at(&[through(time, 0.5)]), PathError::Time { index: 0, .. }), "{time}");
    }
    assert!(matches!(at(&[through(1.0, 0.5), through(1.0, 0.6)]), PathError::Time { index: 1, .. }));
    assert_eq!(at(&[through(0.5, 0.5), through(1.0, f64::INFINITY)]), PathError::NotFinite { index: 1 });
    assert_eq!(at(&[through(1.0, 1e308)]), PathError::MotionNotFinite);
    assert!(matches!(Path::new(Vector1::new(0.0), &[], Vector1::new(1.0), 0.0), Err(PathError::Reference(_))));
}

fn swinging(ramp: f64) -> TaskReference<2> {
    let each = vec![
        Oscillation { joint: 0, amplitude: 0.2, frequency: 0.7, phase: 0.3 },
        Oscillation { joint: 1, amplitude: 0.1, frequency: 1.3, phase: 0.0 },
        Oscillation { joint: 1, amplitude: 0.05, frequency: 2.1, phase: -1.0 },
    ];
    let quintic = QuinticReference::new(Vector2::zeros(), Vector2::new(0.5, -0.5), 10.0).unwrap();
    TaskReference::new(Path::Quintic(quintic), Some(Oscillations::new(each, ramp).unwrap()))
}

#[test]
fn oscillations_swell_from_rest_and_end_at_rest() {
    let reference = swinging(1.0);
    assert_derivatives(&reference);
    for (time, posture) in [(0.0, reference.start()), (10.0, reference.end())] {
        let rest = reference.at(time);
        assert!((rest.position - posture).norm() < 1e-15, "{time}");
        assert_eq!((rest.velocity.norm(), rest.acceleration.norm()), (0.0, 0.0), "{time}");
    }
    // In the middle, by hand.
    let time = 5.0_f64;
    let expected = Vector2::new(
        0.25 + 0.2 * (std::f64::consts::TAU * 0.7 * time + 0.3).sin(),
        -0.25
            + 0.1 * (std::f64::consts::TAU * 1.3 * time).sin()
            + 0.05 * (std::f64::consts::TAU * 2.1 * time - 1.0).sin(),
    );
    assert!((reference.at(time).position - expected).norm() < 1e-12);
    assert_eq!(reference.as_quintic(), None);
    assert!((reference.finest() - 1.0 / 2.1).abs() < 1e-12);
    assert_derivatives(&swinging(100.0));
}

#[test]
fn what_is_no_oscillation_is_refused() {
    let one = Oscillation { joint: 0, amplitude: 0.1, frequency: 1.0, phase: 0.0 };
    let refused = |one: Oscillation, ramp| Oscillations::<2>::new(vec![one], ramp).unwrap_err();
    assert_eq!(refused(Oscillation { joint: 2, ..one }, 1.0), OscillationError::Joint { index: 0, joint: 2, last: 1 });
    for bad in [
        Oscillation { amplitude: f64::NAN, ..one },
        Oscillation { frequency: 0.0, ..one },
        Oscillation { frequency: -1.0, ..one },
        Oscillation { phase: f64::INFINITY, ..one },
    ] {
        assert_eq!(refused(bad, 1.0), OscillationError::Number { index: 0 });
    }
    assert_eq!(refused(one, 0.0), OscillationError::Ramp { found: 0.0 });
    assert!(Oscillations::<2>::new(vec![one], 1.0).is_ok());
}

/// A clone is made where a run begins, and may not allocate there.
#[test]
fn a_clone_shares_its_postures() {
    let via = [ViaPoint { time: 1.0, position: SVector::<f64, 2>::zeros(), passing: Passing::Through }];
    let path = Path::new(Vector2::zeros(), &via, Vector2::new(1.0, 1.0), 2.0).unwrap();
    let (Path::Spline(one), Path::Spline(other)) = (&path, &path.clone()) else { panic!("a spline") };
    assert!(Arc::ptr_eq(one, other));
}
