//! How far the premises move in each epoch, and how that distance adapts (Jang 1993, section III-B).

use crate::error::AnfisError;

/// Epochs that a heuristic looks back on: four changes of the error.
const CHANGES: usize = 4;

/// The step size's start and its two heuristics: after four decreases of the error in a row it is multiplied by
/// `increase`; after an increase, a decrease, an increase and a decrease by `decrease`. A change restarts the count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSizeRule {
    initial: f64,
    increase: f64,
    decrease: f64,
}

impl Default for StepSizeRule {
    /// Jang's: start at 0.01, ×1.1, ×0.9.
    fn default() -> Self {
        Self { initial: 0.01, increase: 1.1, decrease: 0.9 }
    }
}

impl StepSizeRule {
    /// Starts at `initial` > 0; `increase` in [1, 2], `decrease` in [0.1, 1].
    ///
    /// # Errors
    /// [`AnfisError::Training`] for a value out of its range.
    pub fn new(initial: f64, increase: f64, decrease: f64) -> Result<Self, AnfisError> {
        for (option, found, range, expected) in [
            ("initial step size", initial, 1e-12..=1e12, "within [1e-12, 1e12]"),
            ("step increase factor", increase, 1.0..=2.0, "within [1, 2]"),
            ("step decrease factor", decrease, 0.1..=1.0, "within [0.1, 1]"),
        ] {
            if !range.contains(&found) {
                return Err(AnfisError::Training { option, found, expected });
            }
        }
        Ok(Self { initial, increase, decrease })
    }

    /// The step size of the first epoch.
    #[must_use]
    pub const fn initial(&self) -> f64 {
        self.initial
    }
}

/// The step size as it adapts.
#[derive(Clone, Debug)]
pub(crate) struct StepSize {
    rule: StepSizeRule,
    current: f64,
    largest: f64,
    /// The errors since the last change of the step, at most `CHANGES` + 1.
    errors: Vec<f64>,
}

impl StepSize {
    /// Never grows beyond `largest` (or beyond its start, where that is greater).
    pub fn new(rule: StepSizeRule, largest: f64) -> Self {
        Self { rule, current: rule.initial, largest: largest.max(rule.initial), errors: Vec::new() }
    }

    pub const fn current(&self) -> f64 {
        self.current
    }

    /// Takes in the error of one more epoch.
    pub fn observe(&mut self, error: f64) {
        self.errors.push(error);
        if self.errors.len() <= CHANGES {
            return;
        }
        let fell = |pair: &[f64]| pair[1] < pair[0];
        let rose = |pair: &[f64]| pair[1] > pair[0];
        let factor = if self.errors.windows(2).all(fell) {
            self.rule.increase
        } else if self.errors.windows(2).enumerate().all(|(i, pair)| if i % 2 == 0 { rose(pair) } else { fell(pair) }) {
            self.rule.decrease
        } else {
            self.errors.remove(0);
            return;
        };
        self.current = (self.current * factor).min(self.largest);
        self.errors.drain(..CHANGES);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(errors: &[f64]) -> f64 {
        let mut step = StepSize::new(StepSizeRule::new(1.0, 1.5, 0.5).unwrap(), 2.0);
        errors.iter().for_each(|&error| step.observe(error));
        step.current()
    }

    #[test]
    fn four_decreases_lengthen_the_step() {
        assert_eq!(after(&[5.0, 4.0, 3.0, 2.0]), 1.0);
        assert_eq!(after(&[5.0, 4.0, 3.0, 2.0, 1.0]), 1.5);
        assert_eq!(after(&[5.0, 4.0, 4.0, 3.0, 2.0]), 1.0);
    }

    #[test]
    fn two_oscillations_shorten_it() {
        assert_eq!(after(&[1.0, 2.0, 1.0, 2.0, 1.0]), 0.5);
        assert_eq!(after(&[9.0, 1.0, 2.0, 1.0, 2.0, 1.0]), 0.5);
        assert_eq!(after(&[2.0, 1.0, 2.0, 1.0, 2.0]), 1.0);
    }

    #[test]
    fn a_change_restarts_the_count_and_growth_ends_at_the_largest() {
        let falling: Vec<f64> = (0..9).map(|i| -f64::from(i)).collect();
        assert_eq!(after(&falling[..8]), 1.5);
        assert_eq!(after(&falling), 2.0);
    }

    #[test]
    fn out_of_range_is_refused() {
        for (initial, increase, decrease) in [(0.0, 1.1, 0.9), (0.01, 0.9, 0.9), (0.01, 1.1, 1.1), (f64::NAN, 1.1, 0.9)]
        {
            assert!(matches!(StepSizeRule::new(initial, increase, decrease), Err(AnfisError::Training { .. })));
        }
    }
}
