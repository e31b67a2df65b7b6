//! Every signal goes to its own field.

use uarm_loop::estimation::{AngleSource, Estimate};
use uarm_loop::hinf_control::{
    AdaptationStatus, BaseMeasurement, Command, LimitedTorque, Measurement, Reference, TrackingError,
};
use uarm_loop::nalgebra::Vector2;
use uarm_loop::progress::{Progress, ProgressSnapshot};
use uarm_loop::record::{CycleFlags, CycleRecord, PARAMETER_CAPACITY, Unexplained};
use uarm_loop::schedule::Tick;
use uarm_loop::signal_path::Signals;
use uarm_loop::supervision::Residuals;
use uarm_loop::supervisor::Authority;
use uarm_loop::timing::CycleInstants;
use uarm_loop::torque::PreparedTorque;
use uarm_loop::uarm_io::estimator;
use uarm_loop::uarm_io::time::Instant;

fn signals() -> Signals<3, 2> {
    let joint = |position, velocity, acceleration| estimator::Estimate { position, velocity, acceleration };
    Signals {
        authority: Authority::Fading,
        time: 1.0,
        period: 2.0,
        estimate: Estimate {
            joints: [joint(3.0, 4.0, 5.0), joint(6.0, 7.0, 8.0), joint(9.0, 10.0, 11.0)],
            measured: [12.0, 13.0, 14.0],
            sources: [AngleSource::Measured, AngleSource::Missing, AngleSource::Measured],
            counts: [35, 36, 37],
        },
        measurement: Measurement {
            position: Vector2::new(6.0, 9.0),
            velocity: Vector2::new(7.0, 10.0),
            base: BaseMeasurement::planar(4.0, 5.0),
        },
        reference: Reference {
            position: Vector2::new(15.0, 16.0),
            velocity: Vector2::new(17.0, 18.0),
            acceleration: Vector2::new(19.0, 20.0),
        },
        command: Command {
            torque: Vector2::new(21.0, 22.0),
            control_input: Vector2::new(23.0, 24.0),
            adaptation: AdaptationStatus {
                projected: true,
                at_bound: false,
                frozen: true,
                fell_back: false,
                not_finite: false,
            },
        },
        torque: PreparedTorque {
            limited: LimitedTorque {
                requested: Vector2::new(21.0, 22.0),
                applied: Vector2::new(25.0, 26.0),
                limited: [true, false],
            },
            disturbance: Vector2::new(27.0, 28.0),
            output: Vector2::new(25.0, 26.0),
            sent: [29, 30, 31],
        },
        residuals: Some(Residuals { residual: [41.0, 42.0, 43.0], limit: [44.0, 45.0, 46.0] }),
    }
}

fn record() -> CycleRecord<3, 2> {
    let at = Instant::from_nanoseconds;
    let tick = Tick { index: 32, elapsed: 33, scheduled: at(1), woke: at(2) };
    let instants = CycleInstants { scheduled: at(34), ..CycleInstants::default() };
    CycleRecord::new(&tick, &instants, &[38, 39, 40], &signals())
}

#[test]
fn a_record_takes_over_every_signal() {
    let expected = CycleRecord {
        tick: 32,
        elapsed_ticks: 33,
        time: 1.0,
        period: 2.0,
        authority: Authority::Fading,
        instants: CycleInstants { scheduled: Instant::from_nanoseconds(34), ..CycleInstants::default() },
        counts: [35, 36, 37],
        angle_sources: [AngleSource::Measured, AngleSource::Missing, AngleSource::Measured],
        statuswords: [38, 39, 40],
        measured_position: [12.0, 13.0, 14.0],
        position: [3.0, 6.0, 9.0],
        velocity: [4.0, 7.0, 10.0],
        base_acceleration: 5.0,
        reference_position: [15.0, 16.0],
        reference_velocity: [17.0, 18.0],
        reference_acceleration: [19.0, 20.0],
        control_input: [23.0, 24.0],
        torque_requested: [21.0, 22.0],
        torque_applied: [25.0, 26.0],
        torque_sent: [29, 30, 31],
        torque_actual: [None; 3],
        disturbance: [27.0, 28.0],
        unexplained: Some(Unexplained { residual: [42.0, 43.0], limit: [45.0, 46.0] }),
        parameters: [0.0; PARAMETER_CAPACITY],
        parameter_count: 0,
        flags: CycleFlags { limited: [true, false], projected: true, at_bound: false, frozen: true, fell_back: false },
    };
    assert_eq!(record(), expected);
    let mut other = signals();
    other.command.adaptation = AdaptationStatus { at_bound: true, fell_back: true, ..AdaptationStatus::default() };
    let tick = Tick { index: 0, elapsed: 0, scheduled: Instant::default(), woke: Instant::default() };
    let CycleFlags { limited, projected, at_bound, frozen, fell_back } =
        CycleRecord::new(&tick, &CycleInstants::default(), &[0; 3], &other).flags;
    assert_eq!((limited, projected, at_bound, frozen, fell_back), ([true, false], false, true, false, true));
}

#[test]
fn the_error_is_estimated_less_desired() {
    let expected = TrackingError { velocity: Vector2::new(-10.0, -8.0), position: Vector2::new(-9.0, -7.0) };
    assert_eq!(record().tracking_error(), expected);
}

#[test]
fn parameters_are_copied_as_far_as_there_is_room() {
    let mut record = record();
    record.set_parameters(&[1.5, -2.5]);
    assert_eq!((record.parameters(), record.parameter_count), ([1.5, -2.5].as_slice(), 2));
    let many: Vec<f64> = (0_u8..60).map(f64::from).collect();
    record.set_parameters(&many);
    assert_eq!(record.parameters(), &many[..54]);
}

#[test]
fn others_see_time_errors_and_applied_torques() {
    let progress = Progress::<2>::default();
    assert_eq!(progress.snapshot(), ProgressSnapshot { time: 0.0, error: [0.0; 2], torque: [0.0; 2] });
    progress.publish(&record());
    assert_eq!(progress.snapshot(), ProgressSnapshot { time: 1.0, error: [-9.0, -7.0], torque: [25.0, 26.0] });
}
