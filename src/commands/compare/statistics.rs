//! Mean and spread of a few numbers, quantiles of many.

use serde::Serialize;

/// Mean and spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The mean of the values.
    pub mean: f64,
    /// Standard deviation of the population that the numbers are a sample of (divided by n − 1); none for one number.
    pub deviation: Option<f64>,
    /// The smallest value.
    pub minimum: f64,
    /// The largest value.
    pub maximum: f64,
}

impl Summary {
    /// Summary of `values`; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len() as f64;
        let (minimum, maximum) = (values.iter().copied().reduce(f64::min)?, values.iter().copied().reduce(f64::max)?);
        // Rounding must not put the mean of equal numbers beside them.
        let mean = (values.iter().sum::<f64>() / count).clamp(minimum, maximum);
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let deviation = (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt());
        Some(Self { mean, deviation, minimum, maximum })
    }
}

/// Quantiles of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantiles {
    /// 5 %.
    pub q05: f64,
    /// 25 %.
    pub q25: f64,
    /// The median.
    pub q50: f64,
    /// 75 %.
    pub q75: f64,
    /// 95 %.
    pub q95: f64,
}

impl Quantiles {
    /// Quantiles of `values`, which must not contain NaN; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let at = |probability| quantile(&sorted, probability);
        Some(Self { q05: at(0.05)?, q25: at(0.25)?, q50: at(0.5)?, q75: at(0.75)?, q95: at(0.95)? })
    }

    /// The five, from 5 % to 95 %.
    pub const fn as_array(&self) -> [f64; 5] {
        [self.q05, self.q25, self.q50, self.q75, self.q95]
    }
}

/// The quantile of a sorted sample by linear interpolation between its neighbours (Hyndman and Fan 1996, definition 7: that
/// of NumPy and R).
fn quantile(sorted: &[f64], probability: f64) -> Option<f64> {
    let rank = probability * (sorted.len().checked_sub(1)? as f64);
    let below = *sorted.get(rank.floor() as usize)?;
    let above = *sorted.get(rank.ceil() as usize)?;
    Some(below + (above - below) * rank.fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_summary_of_known_numbers() {
        let summary = Summary::of(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
        assert_eq!((summary.mean, summary.minimum, summary.maximum), (5.0, 2.0, 9.0));
        approx::assert_relative_eq!(summary.deviation.unwrap(), (32.0_f64 / 7.0).sqrt());
        assert_eq!(Summary::of(&[0.1; 5]).unwrap().deviation, Some(0.0));
        assert_eq!(Summary::of(&[1.0]).unwrap().deviation, None);
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn quantiles_as_numpy_gives_them() {
        // numpy.quantile([15, 20, 35, 40, 50], [.05, .25, .5, .75, .95])
        let quantiles = Quantiles::of(&[50.0, 15.0, 40.0, 20.0, 35.0]).unwrap();
        for (found, expected) in quantiles.as_array().into_iter().zip([16.0, 20.0, 35.0, 40.0, 48.0]) {
            approx::assert_relative_eq!(found, expected, max_relative = 1e-14);
        }
        assert_eq!(Quantiles::of(&[]), None);
    }

    proptest! {
        // The defining property, not the formula: a share p of the sample lies at or below, 1 - p at or above.
        #[test]
        fn quantiles_cut_the_sample_where_they_say(values in prop::collection::vec(-1e3..1e3, 1..200)) {
            let quantiles = Quantiles::of(&values).unwrap().as_array();
            let steps = (values.len() - 1) as f64;
            for (quantile, probability) in quantiles.into_iter().zip([0.05, 0.25, 0.5, 0.75, 0.95]) {
                let at_most = values.iter().filter(|value| **value <= quantile + 1e-9).count() as f64;
                let at_least = values.iter().filter(|value| **value >= quantile - 1e-9).count() as f64;
                prop_assert!(at_most >= (probability * steps).floor() + 1.0 - 1e-6);
                prop_assert!(at_least >= ((1.0 - probability) * steps).floor() + 1.0 - 1e-6);
            }
        }
    }
}
