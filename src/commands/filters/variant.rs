//! The estimators that are compared, and what they make of a recording.

use core::fmt;

use uarm_io::encoder::EncoderError;
use uarm_io::estimator::{EstimatorConfiguration, EstimatorError};

use super::motion::Recording;

/// Cutoff of the paper's low-pass, rad/s: of the fit that also gave the plant (`tests/vectors/uarm_plant.json`, `wc`);
/// the paper prints none.
pub const PAPER_CUTOFF: f64 = 27.81882;

/// An estimator in the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EstimatorVariant {
    /// The low-pass of the fitted robot, its cutoff fixed at [`PAPER_CUTOFF`].
    PaperLowPass,
    /// The same filter, tuned.
    LowPass,
    /// The α-β-γ loop.
    Tracking,
    /// The steady-state Kalman filter.
    Kalman,
    /// Levant's differentiator.
    Levant,
}

impl EstimatorVariant {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::PaperLowPass, Self::LowPass, Self::Tracking, Self::Kalman, Self::Levant];

    /// The unit of its setting, with the setting's name.
    pub const fn setting_name(self) -> &'static str {
        match self {
            Self::PaperLowPass | Self::LowPass => "cutoff, rad/s",
            Self::Tracking => "bandwidth, rad/s",
            Self::Kalman => "jerk density, (rad/s³)² s",
            Self::Levant => "jerk bound, rad/s³",
        }
    }
}

impl fmt::Display for EstimatorVariant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::PaperLowPass => "low-pass (paper)",
            Self::LowPass => "low-pass (tuned)",
            Self::Tracking => "α-β-γ loop",
            Self::Kalman => "Kalman",
            Self::Levant => "Levant",
        })
    }
}

/// Why there is no study.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// An encoder that cannot be.
    #[error(transparent)]
    Encoder(#[from] EncoderError),
    /// A setting that the estimator refuses.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
}

/// The velocities that an estimator makes of a recording, both joints.
pub fn estimate(
    configuration: &EstimatorConfiguration,
    recording: &Recording,
) -> Result<Vec<[f64; 2]>, EstimatorError> {
    let mut joints = [configuration.build()?; 2];
    let velocities = recording.samples.iter().map(|sample| {
        let mut measured = sample.measured.iter();
        joints.each_mut().map(|joint| match measured.next() {
            Some(angle) => joint.update(*angle, sample.period).velocity,
            None => f64::NAN,
        })
    });
    Ok(velocities.collect())
}
