//! Which rate estimator for which encoder: RMS error and delay on the paper's motion, at 3 ms.
//!
//! One count of an encoder in one period is a rate of 2π/(N T): 15 °/s at 8 000 counts per revolution, against motions
//! of 30–50 °/s. Less noise costs delay, so both are told. Each estimator has one free setting. It is tuned, for each
//! encoder, to the least RMS error of the rate on the paper's motion *with* the paper's disturbance: on the smooth motion
//! alone the slowest filter would win, and the controller would not see the disturbance. The paper's own filter enters
//! with its corner as it is.
//!
//! ```
//! use uarm::filter_study::{Contender, FilterStudy};
//! let study = FilterStudy::of_the_paper().unwrap();
//! let row = study.row(Contender::PaperLowPass, 33_739, uarm::filter_study::Jitter::None).unwrap();
//! assert!((0.030..0.045).contains(&row.delay)); // about 1/ω_c = 36 ms
//! ```

mod motion;
mod tuning;

pub use motion::Jitter;

use core::fmt;
use motion::{Motion, Recording};
use uarm_io::encoder::{CountsPerRevolution, EncoderError};
use uarm_io::estimator::{EstimatorConfiguration, EstimatorError};

/// Corner of the paper's low-pass, rad/s: of the fit that also gave the plant (`tests/vectors/uarm_plant.json`, `wc`);
/// the paper prints none.
pub const PAPER_CORNER: f64 = 27.81882;

/// Counts per revolution of the fitted plant.
pub const PAPER_COUNTS: u32 = 33_739;

/// The encoders that are compared, counts per revolution.
pub const ENCODERS: [u32; 6] = [2_000, 4_000, 8_000, 16_384, PAPER_COUNTS, 65_536];

/// The sampling period of the paper's robot, s.
pub const PERIOD: f64 = 0.003;

/// An estimator in the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Contender {
    /// The low-pass of the fitted robot, its corner fixed at [`PAPER_CORNER`].
    PaperLowPass,
    /// The same filter, tuned.
    LowPass,
    /// The α-β-γ loop.
    Tracking,
    /// The steady-state Kalman filter.
    Kalman,
    /// Levant's differentiator.
    Robust,
}

impl Contender {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::PaperLowPass, Self::LowPass, Self::Tracking, Self::Kalman, Self::Robust];

    /// The unit of its setting, with the setting's name.
    pub const fn setting_name(self) -> &'static str {
        match self {
            Self::PaperLowPass | Self::LowPass => "corner, rad/s",
            Self::Tracking => "bandwidth, rad/s",
            Self::Kalman => "jerk density, (rad/s³)² s",
            Self::Robust => "jerk bound, rad/s³",
        }
    }
}

impl fmt::Display for Contender {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::PaperLowPass => "low-pass (paper)",
            Self::LowPass => "low-pass (tuned)",
            Self::Tracking => "α-β-γ loop",
            Self::Kalman => "Kalman",
            Self::Robust => "Levant",
        })
    }
}

/// One estimator on one encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Which estimator.
    pub contender: Contender,
    /// Its settings.
    pub configuration: EstimatorConfiguration,
    /// The one setting that is tuned; see [`Contender::setting_name`].
    pub setting: f64,
    /// The encoder.
    pub counts_per_revolution: u32,
    /// How the period varied.
    pub jitter: Jitter,
    /// RMS error of the rate on the paper's motion, both joints, rad/s.
    pub rms_error: f64,
    /// The lag at which the estimate fits the true rate best, least squares, s.
    pub delay: f64,
    /// RMS of what is left at that lag, rad/s: noise, for the most part.
    pub rms_at_delay: f64,
    /// RMS error of the rate with the paper's disturbance, rad/s: what was tuned.
    pub rms_error_disturbed: f64,
}

/// Which estimator is the default, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The default of the paper's robot.
    pub default: Contender,
    /// The least RMS error with the disturbance, on the paper's encoder without jitter.
    pub best: Contender,
    /// Why the default is what it is, in words with numbers.
    pub reason: String,
}

/// The whole comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterStudy {
    /// By encoder, then jitter, then estimator.
    pub rows: Vec<Row>,
    /// The conclusion.
    pub verdict: Verdict,
}

/// Why there is no study.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// An encoder that is none.
    #[error(transparent)]
    Encoder(#[from] EncoderError),
    /// A setting that is none.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
}

impl FilterStudy {
    /// The comparison on [`ENCODERS`].
    ///
    /// # Errors
    /// None with these encoders; see [`FilterStudy::of`].
    pub fn of_the_paper() -> Result<Self, StudyError> {
        Self::of(&ENCODERS)
    }

    /// The comparison on any encoders; the verdict is about [`PAPER_COUNTS`] in any case.
    ///
    /// # Errors
    /// [`StudyError::Encoder`] for an encoder that is none.
    pub fn of(encoders: &[u32]) -> Result<Self, StudyError> {
        let mut rows = Vec::new();
        for counts in encoders {
            rows.extend(compare(CountsPerRevolution::new(*counts)?)?);
        }
        let paper = compare(CountsPerRevolution::new(PAPER_COUNTS)?)?;
        Ok(Self { rows, verdict: verdict(&paper) })
    }

    /// The row of one estimator, encoder and jitter.
    pub fn row(&self, contender: Contender, counts_per_revolution: u32, jitter: Jitter) -> Option<&Row> {
        self.rows.iter().find(|row| {
            (row.contender, row.counts_per_revolution, row.jitter) == (contender, counts_per_revolution, jitter)
        })
    }
}

/// All estimators on one encoder, tuned without jitter and measured without and with it.
fn compare(counts: CountsPerRevolution) -> Result<Vec<Row>, StudyError> {
    let disturbed = Recording::new(Motion::Disturbed, counts, Jitter::None);
    let mut rows = Vec::new();
    for jitter in [Jitter::None, Jitter::TenPercent] {
        let (plain, with_disturbance) =
            (Recording::new(Motion::Task, counts, jitter), Recording::new(Motion::Disturbed, counts, jitter));
        for contender in Contender::ALL {
            let setting = tuning::setting(contender, counts, &disturbed)?;
            let configuration = tuning::configuration(contender, setting, counts);
            let rates = estimate(&configuration, &plain)?;
            let delay = plain.least_squares_delay(&rates);
            rows.push(Row {
                contender,
                configuration,
                setting,
                counts_per_revolution: counts.get(),
                jitter,
                rms_error: plain.rms_error(&rates, 0.0),
                delay,
                rms_at_delay: plain.rms_error(&rates, delay),
                rms_error_disturbed: with_disturbance.rms_error(&estimate(&configuration, &with_disturbance)?, 0.0),
            });
        }
    }
    Ok(rows)
}

/// The rates that an estimator makes of a recording, both joints.
fn estimate(configuration: &EstimatorConfiguration, recording: &Recording) -> Result<Vec<[f64; 2]>, EstimatorError> {
    let mut joints = [configuration.build()?; 2];
    let rates = recording.samples.iter().map(|sample| {
        let mut measured = sample.measured.iter();
        joints.each_mut().map(|joint| match measured.next() {
            Some(angle) => joint.update(*angle, sample.period).velocity,
            None => f64::NAN,
        })
    });
    Ok(rates.collect())
}

fn verdict(rows: &[Row]) -> Verdict {
    let steady = || rows.iter().filter(|row| row.jitter == Jitter::None);
    let default = Contender::PaperLowPass;
    let best = steady().min_by(|a, b| a.rms_error_disturbed.total_cmp(&b.rms_error_disturbed));
    let of_default = steady().find(|row| row.contender == default);
    let (Some(best), Some(of_default)) = (best, of_default) else {
        return Verdict { default, best: default, reason: "there is nothing to compare".into() };
    };
    let reason = format!(
        "By the numbers, each tuned for this motion, the best is: {} ({}: {:.4}), with {:.4} rad/s RMS under the \
         disturbance and {:.1} ms delay on {} counts per revolution; the default, {} at {} rad/s, has {:.4} rad/s and {:.1} ms. It stays the default of the \
         paper's robot all the same, because its corner was fitted together with the plant to the paper's Table 4: \
         the delay is part of the robot that is reproduced, and another filter would move L2 and E for a reason that \
         is not the controller's. For a robot of one's own take the best.",
        best.contender,
        best.contender.setting_name(),
        best.setting,
        best.rms_error_disturbed,
        best.delay * 1e3,
        best.counts_per_revolution,
        default,
        PAPER_CORNER,
        of_default.rms_error_disturbed,
        of_default.delay * 1e3,
    );
    Verdict { default, best: best.contender, reason }
}

#[cfg(test)]
mod tests;
