//! The one free setting of each estimator.

use super::motion::{PERIOD, Recording};
use super::variant::{EstimatorVariant, PAPER_CUTOFF, StudyError, estimate};
use uarm_io::encoder::CountsPerRevolution;
use uarm_io::estimator::{EstimatorConfiguration, EstimatorError, KalmanSettings};

/// Settings tried in each factor of two. The error is flat around its least value, and rough, as anything quantised:
/// a finer grid would tune to the roughness.
const PER_OCTAVE: i32 = 4;

/// The configuration of `variant` with its free setting at `setting`.
///
/// The Kalman filter knows the encoder: a quantisation step D has the standard deviation D/√12.
pub fn configuration(variant: EstimatorVariant, setting: f64, counts: CountsPerRevolution) -> EstimatorConfiguration {
    match variant {
        EstimatorVariant::PaperLowPass | EstimatorVariant::LowPass => {
            EstimatorConfiguration::LowPass { cutoff: setting }
        }
        EstimatorVariant::Tracking => EstimatorConfiguration::Tracking { bandwidth: setting },
        EstimatorVariant::Kalman => EstimatorConfiguration::Kalman(KalmanSettings {
            jerk_density: setting,
            measurement_deviation: counts.resolution() / 12.0_f64.sqrt(),
            nominal_period: PERIOD,
        }),
        EstimatorVariant::Levant => EstimatorConfiguration::Levant { jerk_bound: setting },
    }
}

/// Powers of two between which the setting is sought; `None` where there is nothing to seek.
const fn octaves(variant: EstimatorVariant) -> Option<(i32, i32)> {
    match variant {
        EstimatorVariant::PaperLowPass => None,
        // 2 … 512 rad/s: from slower than the motion to the Nyquist frequency of 3 ms, 1047 rad/s, by half.
        EstimatorVariant::LowPass | EstimatorVariant::Tracking => Some((1, 9)),
        // The jerk of motion and disturbance is 2 … 100 rad/s³; its square times some 0.01 … 1 s, with room on both sides.
        EstimatorVariant::Kalman => Some((-4, 20)),
        EstimatorVariant::Levant => Some((-2, 12)),
    }
}

/// The setting of least RMS error on `recording`.
pub fn setting(
    variant: EstimatorVariant,
    counts: CountsPerRevolution,
    recording: &Recording,
) -> Result<f64, StudyError> {
    let Some((lowest, highest)) = octaves(variant) else { return Ok(PAPER_CUTOFF) };
    let mut best = (f64::INFINITY, f64::NAN);
    for step in lowest * PER_OCTAVE..=highest * PER_OCTAVE {
        let candidate = (f64::from(step) / f64::from(PER_OCTAVE)).exp2();
        let error = error(variant, candidate, counts, recording)?;
        if error < best.0 {
            best = (error, candidate);
        }
    }
    Ok(best.1)
}

pub fn error(
    variant: EstimatorVariant,
    setting: f64,
    counts: CountsPerRevolution,
    recording: &Recording,
) -> Result<f64, EstimatorError> {
    let velocities = estimate(&configuration(variant, setting, counts), recording)?;
    Ok(recording.rms_error(&velocities, 0.0))
}
