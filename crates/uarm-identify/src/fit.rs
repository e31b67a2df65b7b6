//! The search.

use crate::estimate::{Estimate, Identified, SearchEnd, Told};
use crate::model::{Model, Parameter};
use crate::sample::{Sample, windows};
use crate::shooting::{Normal, Shot, Step};
use nalgebra::{DMatrix, SVector};

/// Why nothing was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IdentifyError {
    /// No recording is long enough.
    #[error("no recording of at least 8 cycles")]
    TooShort,
    /// A number of a recording is not finite, or its time does not go on.
    #[error("recording {recording}, sample {sample}: expected finite numbers, and times that go on")]
    Sample {
        /// The recording, counted from 1.
        recording: usize,
        /// The sample, counted from 1.
        sample: usize,
    },
    /// The robot cannot be simulated as it is believed to be.
    #[error("the robot cannot be simulated with its nominal parameters from where the recordings begin")]
    Start,
}

/// The most steps of a search.
pub const MOST_STEPS: usize = 60;
const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e12;
/// A step that lowers the cost by a smaller share ends the search.
const SMALL_GAIN: f64 = 1e-9;

/// An eigenvalue of the normal matrix that is a smaller share of the largest one is rounding of the finite differences.
const NOTHING: f64 = 1e-12;

/// Finds the numbers of `model` that explain `recordings`, whose encoders have steps of `resolution`, rad. `after` is called with what is
/// left over after each step, in units of the encoders' rounding errors.
///
/// # Errors
/// [`IdentifyError`] if there is nothing to compare, or the nominal robot cannot be simulated.
pub fn identify<const J: usize, S: AsRef<[Sample<J>]>>(
    model: &impl Model<J>,
    recordings: &[S],
    resolution: [f64; J],
    mut after: impl FnMut(f64),
) -> Result<Identified, IdentifyError> {
    check(recordings)?;
    let noise = SVector::from(resolution.map(|step| step / 12.0_f64.sqrt()));
    let parameters = model.parameters();
    let windows = recordings.iter().flat_map(|recording| windows(recording.as_ref()));
    let shots: Vec<_> = windows.map(Shot::new).collect();
    if shots.is_empty() {
        return Err(IdentifyError::TooShort);
    }
    let mut search = Search::new(model, parameters, shots, noise).ok_or(IdentifyError::Start)?;
    let mut steps = 0;
    let mut end = SearchEnd::StepLimit;
    while steps < MOST_STEPS {
        if !search.improve() {
            end = SearchEnd::Converged;
            break;
        }
        steps += 1;
        after(search.residual());
    }
    Ok(search.found(steps, end))
}

fn check<const J: usize, S: AsRef<[Sample<J>]>>(recordings: &[S]) -> Result<(), IdentifyError> {
    for (recording, samples) in recordings.iter().enumerate() {
        let mut before = f64::NEG_INFINITY;
        for (sample, Sample { at, position, torque_before, torque, torque_at, disturbance }) in
            samples.as_ref().iter().enumerate()
        {
            let numbers = [position, torque_before, torque, disturbance].into_iter().flatten().chain([at, torque_at]);
            if *at <= before || !numbers.into_iter().all(|number| number.is_finite()) {
                return Err(IdentifyError::Sample { recording: recording + 1, sample: sample + 1 });
            }
            before = *at;
        }
    }
    Ok(())
}

struct Search<'a, M, const J: usize> {
    model: &'a M,
    parameters: Vec<Parameter>,
    scales: Vec<f64>,
    noise: SVector<f64, J>,
    values: Vec<f64>,
    shots: Vec<Shot<'a, J>>,
    normal: Normal,
    damping: f64,
}

impl<'a, M: Model<J>, const J: usize> Search<'a, M, J> {
    fn new(model: &'a M, parameters: Vec<Parameter>, shots: Vec<Shot<'a, J>>, noise: SVector<f64, J>) -> Option<Self> {
        let values: Vec<_> = parameters.iter().map(|parameter| parameter.start).collect();
        let scales: Vec<_> = parameters.iter().map(|parameter| parameter.scale).collect();
        let normal = Normal::at(model, &values, &scales, &shots, &noise)?;
        Some(Self { model, parameters, scales, noise, values, shots, normal, damping: FIRST_DAMPING })
    }

    /// Takes one step that lowers the cost; false if there is none that is worth it.
    fn improve(&mut self) -> bool {
        while self.damping < MOST_DAMPING {
            let room = self.values.iter().zip(&self.parameters).map(|(value, of)| (of.least - value) / of.scale);
            let room: Vec<_> = room.collect();
            if let Some(lower) = self.normal.step(self.damping, &room).and_then(|step| self.tried(&step)) {
                let gain = self.normal.cost - lower.normal.cost;
                let is_worth_it = gain > SMALL_GAIN * self.normal.cost;
                (self.values, self.shots, self.normal) = (lower.values, lower.shots, lower.normal);
                self.damping = (self.damping * 0.1).max(LEAST_DAMPING);
                return is_worth_it;
            }
            self.damping *= 10.0;
        }
        false
    }

    /// Where `step` leads to, if the cost is lower there.
    fn tried(&self, step: &Step) -> Option<Tried<'a, J>> {
        let moved = self.values.iter().zip(&self.parameters).zip(step.parameters.iter());
        let values: Vec<_> =
            moved.map(|((value, parameter), step)| (value + step * parameter.scale).max(parameter.least)).collect();
        let shots: Vec<_> = self.shots.iter().zip(&step.starts).map(|(shot, step)| shot.moved(step)).collect();
        let cost = |shot: &Shot<'a, J>| {
            shot.residual(self.model, &values, &self.noise).map(|residual| 0.5 * residual.norm_squared())
        };
        let cost = shots.iter().map(cost).sum::<Option<f64>>()?;
        if cost >= self.normal.cost {
            return None;
        }
        let normal = Normal::at(self.model, &values, &self.scales, &shots, &self.noise)?;
        Some(Tried { values, shots, normal })
    }

    fn found(self, steps: usize, end: SearchEnd) -> Identified {
        let residuals: Vec<_> =
            self.shots.iter().filter_map(|shot| shot.residual(self.model, &self.values, &self.noise)).collect();
        let samples: usize = residuals.iter().map(|residual| residual.len()).sum();
        let unknowns = self.values.len() + 2 * J * self.shots.len();
        let freedom = samples.saturating_sub(unknowns).max(1) as f64;
        // Residuals are in units of the encoders' rounding error: a motion too small to show it is not known any better.
        let variance = (2.0 * self.normal.cost / freedom).max(1.0);
        let correlation = correlation::<J>(residuals.iter().map(|residual| residual.as_slice()));
        let widened = variance * (1.0 + correlation.max(0.0)) / (1.0 - correlation.max(0.0));
        let free: Vec<_> = (0..self.values.len()).filter(|index| !self.is_at_least(*index)).collect();
        let covariance = self.covariance(&free);
        let error = |index: usize| {
            let place = free.iter().position(|free| *free == index)?;
            let variance = covariance.as_ref()?[(place, place)];
            (variance > 0.0).then(|| (variance * widened).sqrt() * self.scales[index])
        };
        let estimate = |(index, parameter): (usize, &Parameter)| {
            let standard_error = if self.is_at_least(index) { 0.0 } else { error(index).unwrap_or(f64::INFINITY) };
            let (value, size) = (self.values[index], self.values[index].abs().max(parameter.scale));
            let told = match (self.is_at_least(index), standard_error <= Told::LARGEST_ERROR * size) {
                (true, _) => Told::AtLeast,
                (false, true) => Told::Well,
                (false, false) => Told::NotTold,
            };
            Estimate { name: parameter.name.clone(), unit: parameter.unit, value, standard_error, told }
        };
        Identified {
            estimates: self.parameters.iter().enumerate().map(estimate).collect(),
            residual: self.residual(),
            correlation,
            confounded: covariance.as_ref().map_or_else(Vec::new, |covariance| confounded(covariance, &free)),
            samples: samples / J,
            windows: self.shots.len(),
            steps,
            end,
        }
    }

    /// Root mean square of the residuals.
    fn residual(&self) -> f64 {
        let samples: usize = self.shots.iter().map(|shot| shot.window.len() * J).sum();
        (2.0 * self.normal.cost / samples.max(1) as f64).sqrt()
    }

    fn is_at_least(&self, index: usize) -> bool {
        self.values[index] <= self.parameters[index].least
    }

    /// S⁻¹ of those parameters that are `free`, in units of their scales; what has no effect of its own has a variance beyond all others.
    fn covariance(&self, free: &[usize]) -> Option<DMatrix<f64>> {
        let (reduced, _) = self.normal.reduced(0.0)?;
        let of_free = DMatrix::from_fn(free.len(), free.len(), |row, column| reduced[(free[row], free[column])]);
        // Symmetric but for rounding.
        let eigen = (0.5 * (&of_free + of_free.transpose())).symmetric_eigen();
        let least = NOTHING * eigen.eigenvalues.max();
        let inverse = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(least).recip()));
        Some(&eigen.eigenvectors * inverse * eigen.eigenvectors.transpose())
    }
}

struct Tried<'a, const J: usize> {
    values: Vec<f64>,
    shots: Vec<Shot<'a, J>>,
    normal: Normal,
}

/// How much of a residual the next one of the same joint repeats: that of all windows, about zero.
fn correlation<'a, const J: usize>(windows: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut with_next, mut squares) = (0.0, 0.0);
    for window in windows {
        for (residual, next) in window.iter().zip(window.iter().skip(J)) {
            with_next += residual * next;
            squares += 0.5 * (residual * residual + next * next);
        }
    }
    if squares > 0.0 { with_next / squares } else { 0.0 }
}

fn confounded(covariance: &DMatrix<f64>, free: &[usize]) -> Vec<(usize, usize, f64)> {
    let mut pairs = Vec::new();
    for row in 0..free.len() {
        for column in 0..row {
            let size = (covariance[(row, row)] * covariance[(column, column)]).sqrt();
            let correlation = covariance[(row, column)] / size;
            if correlation.abs() >= Identified::CONFOUNDED {
                pairs.push((free[column], free[row], correlation));
            }
        }
    }
    pairs
}
