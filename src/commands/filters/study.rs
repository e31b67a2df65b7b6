//! Which velocity estimator for which encoder: RMS error and delay on the paper's motion, at 3 ms.
//!
//! One count of an encoder in one period is a velocity of 2π/(N T): 15 °/s at 8 000 counts per revolution, against motions
//! of 30–50 °/s. Less noise costs delay, so both are told. Each estimator has one free setting. It is tuned, for each
//! encoder, to the least RMS error of the velocity on the paper's motion *with* the paper's disturbance: on the smooth motion
//! alone the slowest filter would win, and the controller would not see the disturbance. The paper's own filter enters
//! with its cutoff as it is.

use uarm_io::encoder::CountsPerRevolution;
use uarm_io::estimator::EstimatorConfiguration;
use uarm_io::gear::GearRatio;

use super::motion::{Jitter, Motion, Recording};
use super::tuning;
use super::variant::{EstimatorVariant, PAPER_CUTOFF, StudyError, estimate};

/// Counts per revolution of the fitted plant.
pub const PAPER_COUNTS: u32 = 33_739;

/// The encoders that are compared, counts per revolution.
pub const ENCODERS: [u32; 6] = [2_000, 4_000, 8_000, 16_384, PAPER_COUNTS, 65_536];

/// One estimator on one encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Which estimator.
    pub variant: EstimatorVariant,
    /// Its settings.
    pub configuration: EstimatorConfiguration,
    /// The one setting that is tuned; see [`EstimatorVariant::setting_name`].
    pub setting: f64,
    /// The encoder.
    pub counts_per_revolution: u32,
    /// How the period varied.
    pub jitter: Jitter,
    /// RMS error of the velocity on the paper's motion, both joints, rad/s.
    pub rms_error: f64,
    /// The lag at which the estimate fits the true velocity best, least squares, s.
    pub delay: f64,
    /// RMS of what is left at that lag, rad/s: noise, for the most part.
    pub rms_at_delay: f64,
    /// RMS error of the velocity with the paper's disturbance, rad/s: what was tuned.
    pub rms_error_disturbed: f64,
}

/// Which estimator is the default, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The default of the paper's robot.
    pub default: EstimatorVariant,
    /// The least RMS error with the disturbance, on the paper's encoder without jitter.
    pub best: EstimatorVariant,
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

impl FilterStudy {
    /// The comparison on [`ENCODERS`].
    ///
    /// # Errors
    /// Never with these encoders; see [`FilterStudy::of`].
    pub fn of_the_paper() -> Result<Self, StudyError> {
        Self::of(&ENCODERS)
    }

    /// The comparison on any encoders; the verdict is about [`PAPER_COUNTS`] in any case.
    ///
    /// # Errors
    /// [`StudyError::Encoder`] for an encoder that cannot be.
    pub fn of(encoders: &[u32]) -> Result<Self, StudyError> {
        let mut rows = Vec::new();
        for counts in encoders {
            rows.extend(compare(CountsPerRevolution::new(*counts)?)?);
        }
        let paper = compare(CountsPerRevolution::new(PAPER_COUNTS)?)?;
        Ok(Self { rows, verdict: verdict(&paper) })
    }
}

/// All estimators on one encoder, tuned without jitter and measured without and with it.
fn compare(counts: CountsPerRevolution) -> Result<Vec<Row>, StudyError> {
    let disturbed = Recording::new(Motion::Disturbed, counts, Jitter::None);
    let mut rows = Vec::new();
    for jitter in [Jitter::None, Jitter::TenPercent] {
        let (plain, with_disturbance) =
            (Recording::new(Motion::Task, counts, jitter), Recording::new(Motion::Disturbed, counts, jitter));
        for variant in EstimatorVariant::ALL {
            let setting = tuning::setting(variant, counts, &disturbed)?;
            let configuration = tuning::configuration(variant, setting, counts);
            let velocities = estimate(&configuration, &plain)?;
            let delay = plain.least_squares_delay(&velocities);
            rows.push(Row {
                variant,
                configuration,
                setting,
                counts_per_revolution: counts.of_motor(GearRatio::DIRECT).unwrap_or_default(),
                jitter,
                rms_error: plain.rms_error(&velocities, 0.0),
                delay,
                rms_at_delay: plain.rms_error(&velocities, delay),
                rms_error_disturbed: with_disturbance.rms_error(&estimate(&configuration, &with_disturbance)?, 0.0),
            });
        }
    }
    Ok(rows)
}

fn verdict(rows: &[Row]) -> Verdict {
    let steady = || rows.iter().filter(|row| row.jitter == Jitter::None);
    let default = EstimatorVariant::PaperLowPass;
    let best = steady().min_by(|a, b| a.rms_error_disturbed.total_cmp(&b.rms_error_disturbed));
    let of_default = steady().find(|row| row.variant == default);
    let (Some(best), Some(of_default)) = (best, of_default) else {
        return Verdict { default, best: default, reason: "there is nothing to compare".into() };
    };
    let reason = format!(
        "By the numbers, each tuned for this motion, the best is: {} ({}: {:.4}), with {:.4} rad/s RMS under the \
         disturbance and {:.1} ms delay on {} counts per revolution; the default, {} at {} rad/s, has {:.4} rad/s and {:.1} ms. It stays the default of the \
         paper's robot all the same, because its cutoff was fitted together with the plant to the paper's Table 4: \
         the delay is part of the robot that is reproduced, and another filter would move L2 and E for a reason that \
         is not the controller's. For a robot of one's own take the best.",
        best.variant,
        best.variant.setting_name(),
        best.setting,
        best.rms_error_disturbed,
        best.delay * 1e3,
        best.counts_per_revolution,
        default,
        PAPER_CUTOFF,
        of_default.rms_error_disturbed,
        of_default.delay * 1e3,
    );
    Verdict { default, best: best.variant, reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::LazyLock;

    use crate::commands::filters::motion::PERIOD;

    static STUDY: LazyLock<FilterStudy> = LazyLock::new(|| FilterStudy::of_the_paper().unwrap());

    fn row(variant: EstimatorVariant, counts: u32) -> Row {
        *STUDY
            .rows
            .iter()
            .find(|row| (row.variant, row.counts_per_revolution, row.jitter) == (variant, counts, Jitter::None))
            .unwrap()
    }

    #[test]
    fn there_is_a_row_for_everything() {
        assert_eq!(STUDY.rows.len(), ENCODERS.len() * 2 * EstimatorVariant::ALL.len());
        assert!(STUDY.rows.iter().all(|row| row.rms_error.is_finite() && row.delay.is_finite()));
        assert_eq!(*STUDY, FilterStudy::of_the_paper().unwrap());
    }

    /// With a fine encoder the paper's filter is all delay: one over its cutoff, and half a period of the difference,
    /// less what the discrete filter gains on the continuous one (half a period).
    #[test]
    fn the_papers_filter_has_the_delay_of_its_cutoff() {
        let row = row(EstimatorVariant::PaperLowPass, 65_536);
        assert!((row.delay - 1.0 / PAPER_CUTOFF).abs() < PERIOD, "{row:?}");
        assert!(row.rms_at_delay < 0.3 * row.rms_error, "{row:?}");
    }

    #[test]
    fn no_tuned_setting_lies_at_the_end_of_its_range() {
        for row in STUDY.rows.iter().filter(|row| row.variant != EstimatorVariant::PaperLowPass) {
            let counts = CountsPerRevolution::new(row.counts_per_revolution).unwrap();
            let recording = Recording::new(Motion::Disturbed, counts, Jitter::None);
            let error = |factor: f64| tuning::error(row.variant, row.setting * factor, counts, &recording).unwrap();
            assert!(error(1.0) < error(0.5_f64.powi(3)) && error(1.0) < error(2.0_f64.powi(3)), "{row:?}");
        }
    }

    #[test]
    fn finer_encoders_make_smaller_errors() {
        for variant in EstimatorVariant::ALL {
            let errors = ENCODERS.map(|counts| row(variant, counts).rms_error_disturbed);
            // Quantisation is rough: neighbours may be equal to a few per cent.
            assert!(errors.windows(2).all(|pair| pair[1] < 1.05 * pair[0]), "{variant}: {errors:?}");
            assert!(errors[5] < errors[0], "{variant}: {errors:?}");
        }
    }

    #[test]
    fn tuning_helps_and_those_that_track_acceleration_lag_less() {
        for counts in ENCODERS {
            let paper = row(EstimatorVariant::PaperLowPass, counts);
            assert!(row(EstimatorVariant::LowPass, counts).rms_error_disturbed <= paper.rms_error_disturbed * 1.01);
            for variant in [EstimatorVariant::Tracking, EstimatorVariant::Kalman] {
                assert!(row(variant, counts).delay.abs() < 0.5 * paper.delay, "{variant} {counts}");
            }
        }
    }

    #[test]
    fn a_varying_period_does_little_harm() {
        for row in STUDY.rows.iter().filter(|row| row.jitter == Jitter::TenPercent) {
            let steady = self::row(row.variant, row.counts_per_revolution);
            assert!(row.rms_error_disturbed < 1.25 * steady.rms_error_disturbed, "{row:?} {steady:?}");
        }
    }

    #[test]
    fn the_verdict_says_both_which_is_best_and_which_is_the_default() {
        let verdict = &STUDY.verdict;
        assert_eq!(verdict.default, EstimatorVariant::PaperLowPass);
        assert_ne!(verdict.best, EstimatorVariant::PaperLowPass);
        assert!(verdict.reason.contains(&verdict.best.to_string()) && verdict.reason.contains("Table 4"));
    }
}
