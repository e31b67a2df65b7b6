use super::*;
use std::sync::LazyLock;

static STUDY: LazyLock<FilterStudy> = LazyLock::new(|| FilterStudy::of_the_paper().unwrap());

fn row(contender: Contender, counts: u32) -> Row {
    *STUDY.row(contender, counts, Jitter::None).unwrap()
}

#[test]
fn there_is_a_row_for_everything() {
    assert_eq!(STUDY.rows.len(), ENCODERS.len() * 2 * Contender::ALL.len());
    assert!(STUDY.rows.iter().all(|row| row.rms_error.is_finite() && row.delay.is_finite()));
    assert_eq!(*STUDY, FilterStudy::of_the_paper().unwrap());
}

/// With a fine encoder the paper's filter is all delay: one over its corner, and half a period of the difference,
/// less what the discrete filter gains on the continuous one (half a period).
#[test]
fn the_papers_filter_has_the_delay_of_its_corner() {
    let row = row(Contender::PaperLowPass, 65_536);
    assert!((row.delay - 1.0 / PAPER_CORNER).abs() < PERIOD, "{row:?}");
    assert!(row.rms_at_delay < 0.3 * row.rms_error, "{row:?}");
}

#[test]
fn no_tuned_setting_lies_at_the_end_of_its_range() {
    for row in STUDY.rows.iter().filter(|row| row.contender != Contender::PaperLowPass) {
        let counts = CountsPerRevolution::new(row.counts_per_revolution).unwrap();
        let recording = Recording::new(Motion::Disturbed, counts, Jitter::None);
        let error = |factor: f64| tuning::error(row.contender, row.setting * factor, counts, &recording).unwrap();
        assert!(error(1.0) < error(0.5_f64.powi(3)) && error(1.0) < error(2.0_f64.powi(3)), "{row:?}");
    }
}

#[test]
fn finer_encoders_make_smaller_errors() {
    for contender in Contender::ALL {
        let errors = ENCODERS.map(|counts| row(contender, counts).rms_error_disturbed);
        // Quantisation is rough: neighbours may be equal to a few per cent.
        assert!(errors.windows(2).all(|pair| pair[1] < 1.05 * pair[0]), "{contender}: {errors:?}");
        assert!(errors[5] < errors[0], "{contender}: {errors:?}");
    }
}

#[test]
fn tuning_helps_and_those_that_track_acceleration_lag_less() {
    for counts in ENCODERS {
        let paper = row(Contender::PaperLowPass, counts);
        assert!(row(Contender::LowPass, counts).rms_error_disturbed <= paper.rms_error_disturbed * 1.01);
        for contender in [Contender::Tracking, Contender::Kalman] {
            assert!(row(contender, counts).delay.abs() < 0.5 * paper.delay, "{contender} {counts}");
        }
    }
}

#[test]
fn a_varying_period_does_little_harm() {
    for row in STUDY.rows.iter().filter(|row| row.jitter == Jitter::TenPercent) {
        let steady = STUDY.row(row.contender, row.counts_per_revolution, Jitter::None).unwrap();
        assert!(row.rms_error_disturbed < 1.25 * steady.rms_error_disturbed, "{row:?} {steady:?}");
    }
}

#[test]
fn the_verdict_says_both_which_is_best_and_which_is_the_default() {
    let verdict = &STUDY.verdict;
    assert_eq!(verdict.default, Contender::PaperLowPass);
    assert_ne!(verdict.best, Contender::PaperLowPass);
    assert!(verdict.reason.contains(&verdict.best.to_string()) && verdict.reason.contains("Table 4"));
}
