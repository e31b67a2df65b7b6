//! The one free setting of each estimator.

use super::motion::Recording;
use super::{Contender, PAPER_CORNER, PERIOD, StudyError, estimate};
use uarm_io::encoder::CountsPerRevolution;
use uarm_io::estimator::{EstimatorConfiguration, EstimatorError, KalmanSettings};

/// Settings tried in each factor of two. The error is flat around its least value, and rough, as anything quantised:
/// a finer grid would tune to the roughness.
const PER_OCTAVE: i32 = 4;

/// The configuration of `contender` with its free setting at `setting`.
///
/// The Kalman filter knows the encoder: a quantisation step D has the standard deviation D/√12.
pub(super) fn configuration(contender: Contender, setting: f64, counts: CountsPerRevolution) -> EstimatorConfiguration {
    match contender {
        Contender::PaperLowPass | Contender::LowPass => EstimatorConfiguration::LowPass { cutoff: setting },
        Contender::Tracking => EstimatorConfiguration::Tracking { bandwidth: setting },
        Contender::Kalman => EstimatorConfiguration::Kalman(KalmanSettings {
            jerk_density: setting,
            measurement_deviation: counts.resolution() / 12.0_f64.sqrt(),
            nominal_period: PERIOD,
        }),
        Contender::Robust => EstimatorConfiguration::Levant { jerk_bound: setting },
    }
}

/// Powers of two between which the setting is sought; `None` where there is nothing to seek.
const fn octaves(contender: Contender) -> Option<(i32, i32)> {
    match contender {
        Contender::PaperLowPass => None,
        // 2 … 512 rad/s: from slower than the motion to the Nyquist frequency of 3 ms, 1047 rad/s, by half.
        Contender::LowPass | Contender::Tracking => Some((1, 9)),
        // The jerk of motion and disturbance is 2 … 100 rad/s³; its square times some 0.01 … 1 s, with room on both sides.
        Contender::Kalman => Some((-4, 20)),
        Contender::Robust => Some((-2, 12)),
    }
}

/// The setting of least RMS error on `recording`.
pub(super) fn setting(
    contender: Contender,
    counts: CountsPerRevolution,
    recording: &Recording,
) -> Result<f64, StudyError> {
    let Some((lowest, highest)) = octaves(contender) else { return Ok(PAPER_CORNER) };
    let mut best = (f64::INFINITY, f64::NAN);
    for step in lowest * PER_OCTAVE..=highest * PER_OCTAVE {
        let candidate = (f64::from(step) / f64::from(PER_OCTAVE)).exp2();
        let error = error(contender, candidate, counts, recording)?;
        if error < best.0 {
            best = (error, candidate);
        }
    }
    Ok(best.1)
}

pub(super) fn error(
    contender: Contender,
    setting: f64,
    counts: CountsPerRevolution,
    recording: &Recording,
) -> Result<f64, EstimatorError> {
    let rates = estimate(&configuration(contender, setting, counts), recording)?;
    Ok(recording.rms_error(&rates, 0.0))
}
