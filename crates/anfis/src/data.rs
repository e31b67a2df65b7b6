//! Sets of samples: inputs and the target that a system shall learn.

use crate::error::AnfisError;
use crate::input::Universe;
use crate::limits::in_magnitude;

/// Samples of an unknown function: per sample one value for each input, and the target. All values are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSet {
    width: usize,
    inputs: Vec<f64>,
    targets: Vec<f64>,
}

impl DataSet {
    /// Samples of `N` inputs each, as (inputs, target).
    ///
    /// # Errors
    /// [`AnfisError::TooFew`] without a sample or with `N` = 0, [`AnfisError::Sample`] for a value that is not finite or
    /// beyond [`crate::limits::MAXIMUM_MAGNITUDE`].
    ///
    /// # Example
    /// ```
    /// # use anfis::DataSet;
    /// let line = DataSet::new((0..11).map(|i| ([0.1 * f64::from(i)], 0.3 * f64::from(i))))?;
    /// assert_eq!((line.len(), line.width()), (11, 1));
    /// # Ok::<(), anfis::AnfisError>(())
    /// ```
    pub fn new<const N: usize>(samples: impl IntoIterator<Item = ([f64; N], f64)>) -> Result<Self, AnfisError> {
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        for (input, target) in samples {
            inputs.extend(input);
            targets.push(target);
        }
        Self::from_rows(N, inputs, targets)
    }

    /// Samples whose `width` inputs stand one sample after the other in `inputs`.
    ///
    /// # Errors
    /// As [`DataSet::new`]; and [`AnfisError::Length`] when `inputs` is not `width` values per target.
    pub fn from_rows(width: usize, inputs: Vec<f64>, targets: Vec<f64>) -> Result<Self, AnfisError> {
        for (what, found) in [("samples", targets.len()), ("inputs per sample", width)] {
            if found == 0 {
                return Err(AnfisError::TooFew { what, found, expected: 1 });
            }
        }
        let expected = width.saturating_mul(targets.len());
        if inputs.len() != expected {
            return Err(AnfisError::Length { what: "input values", found: inputs.len(), expected });
        }
        for (sample, (row, &target)) in inputs.chunks_exact(width).zip(&targets).enumerate() {
            if let Some(&value) = row.iter().chain([&target]).find(|value| !in_magnitude(**value)) {
                return Err(AnfisError::Sample { sample, value });
            }
        }
        Ok(Self { width, inputs, targets })
    }

    /// Number of samples, at least 1.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Number of inputs per sample.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.width
    }

    /// The samples in order, as (inputs, target).
    pub fn samples(&self) -> impl Iterator<Item = (&[f64], f64)> {
        self.inputs.chunks_exact(self.width).zip(self.targets.iter().copied())
    }

    /// The targets in order.
    #[must_use]
    pub fn targets(&self) -> &[f64] {
        &self.targets
    }

    /// The range of input `input` over the samples.
    ///
    /// # Errors
    /// [`AnfisError::Universe`] when the input does not vary: no sets can be laid out on it.
    ///
    /// # Panics
    /// When `input` is not below [`DataSet::width`].
    pub fn universe(&self, input: usize) -> Result<Universe, AnfisError> {
        assert!(input < self.width, "input {input} of a data set with {} inputs", self.width);
        let column = self.inputs.iter().skip(input).step_by(self.width);
        let (lower, upper) =
            column.fold((f64::INFINITY, f64::NEG_INFINITY), |(lower, upper), &x| (lower.min(x), upper.max(x)));
        Universe::new(lower, upper)
    }

    /// Every `one_in`-th sample, from the last of the first `one_in` on, as a checking set, the others for training.
    /// Samples of one run resemble their neighbours: where several runs are at hand, check with a run of its own.
    ///
    /// # Errors
    /// [`AnfisError::TooFew`] when one of the two would be empty.
    pub fn split(&self, one_in: usize) -> Result<(Self, Self), AnfisError> {
        let part = |checking: bool| {
            let (mut inputs, mut targets) = (Vec::new(), Vec::new());
            for (index, (row, target)) in self.samples().enumerate() {
                if (one_in > 0 && index % one_in == one_in - 1) == checking {
                    inputs.extend_from_slice(row);
                    targets.push(target);
                }
            }
            Self::from_rows(self.width, inputs, targets)
        };
        Ok((part(false)?, part(true)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_or_misshapen_is_refused() {
        let found = DataSet::new([([0.0], 1.0), ([f64::NAN], 1.0)]);
        assert!(matches!(found, Err(AnfisError::Sample { sample: 1, .. })));
        assert!(matches!(DataSet::new([([1e13], 1.0)]), Err(AnfisError::Sample { sample: 0, value: 1e13 })));
        assert!(matches!(DataSet::new::<1>([]), Err(AnfisError::TooFew { .. })));
        assert!(matches!(DataSet::from_rows(2, vec![1.0; 3], vec![1.0; 2]), Err(AnfisError::Length { .. })));
    }

    #[test]
    fn a_constant_input_has_no_universe() {
        let data = DataSet::new([([1.0, 2.0], 0.0), ([1.0, 3.0], 0.0)]).unwrap();
        assert!(matches!(data.universe(0), Err(AnfisError::Universe { .. })));
        assert_eq!(data.universe(1), Universe::new(2.0, 3.0));
    }

    #[test]
    fn a_split_takes_every_sample_once() {
        let data = DataSet::new((0..10).map(|i| ([f64::from(i)], f64::from(-i)))).unwrap();
        let (training, checking) = data.split(4).unwrap();
        assert_eq!(checking.targets(), [-3.0, -7.0]);
        assert_eq!(training.len(), 8);
        assert!(data.split(1).is_err() && data.split(0).is_err() && data.split(11).is_err());
    }
}
