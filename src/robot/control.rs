//! The controllers' weights, the estimator and the loop's reactions: checked.

use std::fmt;

use hinf_control::{AdaptationGuard, AdaptationSettings, BaseAcceleration, ControllerSettings, FuzzySets, Law};
use nalgebra::SVector;
use uarm_io::encoder::CountsPerRevolution;
use uarm_io::estimator::{AnyEstimator, EstimatorConfiguration, KalmanSettings};
use uarm_io::time::Duration;
use uarm_loop::dimensions;
use uarm_loop::fade::StopRamp;
use uarm_loop::period::Period;
use uarm_loop::rest::RestVelocity;
use uarm_loop::robot::Bus;
use uarm_loop::saturation::SaturationLimit;
use uarm_loop::schedule::OverrunsInARow;

use super::arm::{Arm, LawChoice};
use super::error::{Checker, RobotError};
use super::file;
use crate::usage::UsageError;

/// Settings made for the arm in the posture `start`, rad. Where no sensor is on the base, in forms that read nothing of it.
pub(super) fn derived<const J: usize, const N: usize>(
    arm: &dyn Arm<J, N>,
    start: &SVector<f64, N>,
    check: &Checker<'_>,
) -> Result<ControllerSettings<N>, RobotError> {
    let refuse = |error: String| check.refuse("controllers", "no such table", format!("weights of its own: {error}"));
    let mut settings = arm.derived_settings(start).map_err(|error| refuse(error.to_string()))?;
    for law in Law::ALL.into_iter().filter(|_| dimensions::passive::<J, N>() == 0) {
        let choice = LawChoice { law, guard: AdaptationGuard::None, fuzzy_sets: FuzzySets::untrained() };
        if arm.reads_base(&settings, &choice).map_err(|error| refuse(error.to_string()))? {
            settings
                .set_base_acceleration(law, BaseAcceleration::Omitted)
                .map_err(|error| refuse(error.to_string()))?;
        }
    }
    Ok(settings)
}

/// Refuses a form that a command line asks for and that reads the motion of a base without a sensor.
pub(super) fn check_override<const J: usize, const N: usize>(
    settings: &ControllerSettings<N>,
    arm: &dyn Arm<J, N>,
    law: Law,
    mode: BaseAcceleration,
) -> Result<(), RobotError> {
    let choice = LawChoice { law, guard: AdaptationGuard::None, fuzzy_sets: FuzzySets::untrained() };
    let reads = |settings: &ControllerSettings<N>| arm.reads_base(settings, &choice).unwrap_or_default();
    if dimensions::passive::<J, N>() > 0 || !reads(settings) {
        return Ok(());
    }
    let allowed = BaseAcceleration::ALL.into_iter().filter(|mode| {
        let mut other = *settings;
        other.set_base_acceleration(law, *mode).is_ok() && !reads(&other)
    });
    let allowed: Vec<_> = allowed.map(BaseAcceleration::name).collect();
    Err(RobotError::Override(UsageError::new(format!(
        "--base-acceleration {} with --controller {}: it reads the motion of the base, on which the robot has no sensor, expected {}",
        mode.name(),
        law.name(),
        allowed.join(" or ")
    ))))
}

/// Checks that every law of the file can be built.
pub(super) fn check<const J: usize, const N: usize>(
    settings: &ControllerSettings<N>,
    arm: &dyn Arm<J, N>,
    check: &Checker<'_>,
) -> Result<(), RobotError> {
    for law in Law::ALL {
        // Bounded, so that the bounds are looked at as well.
        let choice = LawChoice { law, guard: AdaptationGuard::Bounded, fuzzy_sets: FuzzySets::untrained() };
        let field = |name: &str| format!("controllers.{}{name}", law.name());
        if let Some(AdaptationSettings { z, bound }) = settings.adaptation(law) {
            check.positive(&field(".z"), z)?;
            check.positive(&field(".bound"), bound)?;
        }
        let reads_base = arm
            .reads_base(settings, &choice)
            .map_err(|error| check.refuse(field(""), error, "settings with which the controller can be built"))?;
        if dimensions::passive::<J, N>() == 0 && reads_base {
            let expected = "a form that reads nothing of the base, on which the robot has no sensor: \
                            base_acceleration = \"omitted\" or \"reduced\", model_form = \"active-joints\" or \"reduced\"";
            return Err(check.refuse(field(""), "a form that reads the base's motion", expected));
        }
    }
    Ok(())
}

/// How long after SYNC positions are waited for, unless the file says: of the period, which leaves the rest for law and torques.
const FEEDBACK_SHARE: f64 = 0.75;

/// How long after SYNC positions are waited for.
pub(super) fn feedback_timeout(
    control: &file::Control,
    bus: &Bus,
    period: Period,
    check: &Checker<'_>,
) -> Result<Duration, RobotError> {
    let period = period.duration();
    let Some(microseconds) = control.feedback_timeout_us else {
        // On a slow bus, the frames of a cycle take longer than that share.
        return Ok(period.mul_f64(FEEDBACK_SHARE).max(bus.time.cyclic));
    };
    let (timeout, least) = (Duration::from_micros(microseconds.into()), bus.bit_rate.earliest_feedback());
    if timeout >= least && timeout <= period {
        return Ok(timeout);
    }
    let expected = format!(
        "{} (SYNC and one position on the bus) to {} (the period)",
        least.as_nanos().div_ceil(1_000),
        period.as_micros()
    );
    Err(check.refuse("control.feedback_timeout_us", microseconds, expected))
}

/// How many late cycles in a row end a run.
pub(super) fn overruns_in_a_row(control: &file::Control, check: &Checker<'_>) -> Result<OverrunsInARow, RobotError> {
    let Some(found) = control.overruns_in_a_row else { return Ok(OverrunsInARow::default()) };
    let expected = || format!("1 to {} late cycles", OverrunsInARow::MOST);
    OverrunsInARow::new(found).ok_or_else(|| check.refuse("control.overruns_in_a_row", found, expected()))
}

/// How long a stop that somebody asks for takes.
pub(super) fn stop_ramp(control: &file::Control, check: &Checker<'_>) -> Result<StopRamp, RobotError> {
    let Some(found) = control.stop_ramp_ms else { return Ok(StopRamp::default()) };
    let expected = || format!("0 to {} (0: no ramp)", StopRamp::LONGEST.as_millis());
    StopRamp::new(Duration::from_millis(found.into()))
        .ok_or_else(|| check.refuse("control.stop_ramp_ms", found, expected()))
}

/// How fast a joint may turn before brakes open.
pub(super) fn rest_velocity(control: &file::Control, check: &Checker<'_>) -> Result<RestVelocity, RobotError> {
    let Some(found) = control.rest_velocity_deg_per_s else { return Ok(RestVelocity::default()) };
    let expected = || format!("above 0, at most {}", RestVelocity::LARGEST_DEGREES);
    RestVelocity::from_degrees(found).ok_or_else(|| check.refuse("control.rest_velocity_deg_per_s", found, expected()))
}

/// For how long a torque may be cut.
pub(super) fn saturation_limit(control: &file::Control, check: &Checker<'_>) -> Result<SaturationLimit, RobotError> {
    let Some(found) = control.saturation_stop_ms else { return Ok(SaturationLimit::default()) };
    let expected = || format!("1 to {}", SaturationLimit::LONGEST.as_millis());
    SaturationLimit::new(Duration::from_millis(found.into()))
        .ok_or_else(|| check.refuse("control.saturation_stop_ms", found, expected()))
}

/// The estimator of one joint, whose encoder has this many counts.
pub(super) fn estimator(
    (estimator, period_us): (&file::Estimator, u32),
    counts: CountsPerRevolution,
    check: &Checker<'_>,
) -> Result<AnyEstimator<f64>, RobotError> {
    let configuration = match *estimator {
        file::Estimator::LowPass { cutoff_rad_per_s } => EstimatorConfiguration::LowPass { cutoff: cutoff_rad_per_s },
        file::Estimator::TrackingLoop { bandwidth_rad_per_s } => {
            EstimatorConfiguration::Tracking { bandwidth: bandwidth_rad_per_s }
        }
        file::Estimator::Kalman { jerk_density_rad2_per_s5 } => EstimatorConfiguration::Kalman(KalmanSettings {
            jerk_density: jerk_density_rad2_per_s5,
            // A value rounded to steps of D has the standard deviation D/sqrt(12).
            measurement_deviation: counts.resolution() / 12.0_f64.sqrt(),
            nominal_period: f64::from(period_us) * 1e-6,
        }),
        file::Estimator::Levant { jerk_bound_rad_per_s3 } => {
            EstimatorConfiguration::Levant { jerk_bound: jerk_bound_rad_per_s3 }
        }
    };
    configuration
        .build()
        .map_err(|error| check.refuse("estimator", error, "settings with which the estimator can be built"))
}

/// As messages name it: the kind in the file, and its setting.
impl fmt::Display for file::Estimator {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LowPass { cutoff_rad_per_s } => write!(formatter, "low-pass, {cutoff_rad_per_s} rad/s"),
            Self::TrackingLoop { bandwidth_rad_per_s } => {
                write!(formatter, "tracking-loop, {bandwidth_rad_per_s} rad/s")
            }
            Self::Kalman { jerk_density_rad2_per_s5 } => {
                write!(formatter, "kalman, jerk density {jerk_density_rad2_per_s5} rad2/s5")
            }
            Self::Levant { jerk_bound_rad_per_s3 } => {
                write!(formatter, "levant, jerk bound {jerk_bound_rad_per_s3} rad/s3")
            }
        }
    }
}
