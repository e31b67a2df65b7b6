//! Residuals of all windows, and the normal equations without the windows' starts.

use crate::model::Model;
use crate::sample::Sample;
use nalgebra::{DMatrix, DVector, SVector};

/// A window with the start that it is simulated from.
#[derive(Clone, Debug)]
pub(crate) struct Shot<'a, const J: usize> {
    pub(crate) window: &'a [Sample<J>],
    pub(crate) position: SVector<f64, J>,
    pub(crate) velocity: SVector<f64, J>,
}

/// Step of the finite differences, as a share of a parameter's scale; the root of the rounding error of angles of a few radians.
const STEP: f64 = 1e-6;
/// Scale of a start's angles, rad.
const ANGLE: f64 = 1e-3;
/// Scale of its velocities, rad/s.
const VELOCITY: f64 = 0.1;

impl<'a, const J: usize> Shot<'a, J> {
    /// A window, from where its first samples lie on a straight line.
    pub(crate) fn new(window: &'a [Sample<J>]) -> Self {
        const FITTED: usize = 8;
        let samples = &window[..window.len().min(FITTED)];
        let count = samples.len() as f64;
        let begin = window.first().map_or(0.0, |sample| sample.at);
        let mean = samples.iter().map(|sample| sample.at - begin).sum::<f64>() / count;
        let spread: f64 = samples.iter().map(|sample| (sample.at - begin - mean).powi(2)).sum();
        let line = |joint: usize| {
            let middle = samples.iter().map(|sample| sample.position[joint]).sum::<f64>() / count;
            let slope = samples.iter().map(|sample| (sample.at - begin - mean) * (sample.position[joint] - middle));
            let slope = slope.sum::<f64>() / spread;
            (middle - slope * mean, slope)
        };
        Self {
            window,
            position: SVector::from_fn(|joint, _| line(joint).0),
            velocity: SVector::from_fn(|joint, _| line(joint).1),
        }
    }

    /// Simulated less measured angles in units of `noise`, sample by sample and joint by joint.
    pub(crate) fn residual(
        &self,
        model: &impl Model<J>,
        values: &[f64],
        noise: &SVector<f64, J>,
    ) -> Option<DVector<f64>> {
        let angles = model.angles(values, &self.position, &self.velocity, self.window)?;
        let error = |(angles, sample): (SVector<f64, J>, &Sample<J>)| {
            (angles - SVector::from(sample.position)).component_div(noise)
        };
        let errors: Vec<_> = angles.into_iter().zip(self.window).map(error).collect();
        Some(DVector::from_iterator(errors.len() * J, errors.iter().flat_map(|error| error.iter().copied())))
    }

    /// The residual, and its derivatives by the parameters in units of `scales` and by the start in units of its own.
    fn linearised(
        &self,
        model: &impl Model<J>,
        values: &[f64],
        scales: &[f64],
        noise: &SVector<f64, J>,
    ) -> Option<Linearised> {
        let residual = self.residual(model, values, noise)?;
        let slope = |moved: DVector<f64>| (moved - &residual) / STEP;
        let mut by_parameters = DMatrix::zeros(residual.len(), values.len());
        for (index, scale) in scales.iter().enumerate() {
            let mut moved = values.to_vec();
            moved[index] += scale * STEP;
            by_parameters.set_column(index, &slope(self.residual(model, &moved, noise)?));
        }
        let mut by_start = DMatrix::zeros(residual.len(), 2 * J);
        for index in 0..2 * J {
            let mut step = DVector::zeros(2 * J);
            step[index] = STEP;
            by_start.set_column(index, &slope(self.moved(&step).residual(model, values, noise)?));
        }
        Some(Linearised { residual, by_parameters, by_start })
    }

    /// The same window from a start that is moved by `step`, in units of its own.
    pub(crate) fn moved(&self, step: &DVector<f64>) -> Self {
        let part = |first: usize, scale: f64| SVector::from_fn(|joint, _| scale * step[first + joint]);
        Self {
            window: self.window,
            position: self.position + part(0, ANGLE),
            velocity: self.velocity + part(J, VELOCITY),
        }
    }
}

struct Linearised {
    residual: DVector<f64>,
    by_parameters: DMatrix<f64>,
    by_start: DMatrix<f64>,
}

/// The normal equations of one window.
pub(crate) struct Block {
    cross: DMatrix<f64>,
    of_start: DMatrix<f64>,
    gradient_of_start: DVector<f64>,
}

/// The normal equations of all windows at one point.
pub(crate) struct Normal {
    of_parameters: DMatrix<f64>,
    gradient: DVector<f64>,
    blocks: Vec<Block>,
    /// Half of the sum of the squares of the residuals.
    pub(crate) cost: f64,
}

/// Where the equations lead to, in units of the scales.
pub(crate) struct Step {
    pub(crate) parameters: DVector<f64>,
    pub(crate) starts: Vec<DVector<f64>>,
}

impl Normal {
    /// The equations at `values` with the starts of `shots`.
    pub(crate) fn at<const J: usize>(
        model: &impl Model<J>,
        values: &[f64],
        scales: &[f64],
        shots: &[Shot<'_, J>],
        noise: &SVector<f64, J>,
    ) -> Option<Self> {
        let mut normal = Self {
            of_parameters: DMatrix::zeros(values.len(), values.len()),
            gradient: DVector::zeros(values.len()),
            blocks: Vec::with_capacity(shots.len()),
            cost: 0.0,
        };
        for shot in shots {
            let Linearised { residual, by_parameters, by_start } = shot.linearised(model, values, scales, noise)?;
            normal.of_parameters += by_parameters.tr_mul(&by_parameters);
            normal.gradient += by_parameters.tr_mul(&residual);
            normal.cost += 0.5 * residual.norm_squared();
            normal.blocks.push(Block {
                cross: by_parameters.tr_mul(&by_start),
                of_start: by_start.tr_mul(&by_start),
                gradient_of_start: by_start.tr_mul(&residual),
            });
        }
        Some(normal)
    }

    /// The step of Levenberg and Marquardt: each diagonal larger by the share `damping` (Marquardt 1963). `None` if the equations are
    /// singular, which they are not with damping. No parameter goes down by more than its `room`, negative or 0, in units of its scale:
    /// one that would is held there, and the others are solved for beside it.
    pub(crate) fn step(&self, damping: f64, room: &[f64]) -> Option<Step> {
        let (reduced, gradient) = self.reduced(damping)?;
        let parameters = held_within(&reduced, &gradient, room)?;
        let start = |block: &Block| {
            let right = &block.gradient_of_start + block.cross.tr_mul(&parameters);
            Some(-damped(&block.of_start, damping).cholesky()?.solve(&right))
        };
        let starts = self.blocks.iter().map(start).collect::<Option<_>>()?;
        Some(Step { parameters, starts })
    }

    /// The normal matrix of the parameters alone, and its gradient: starts follow the parameters.
    pub(crate) fn reduced(&self, damping: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let mut reduced = damped(&self.of_parameters, damping);
        let mut gradient = self.gradient.clone();
        for Block { cross, of_start, gradient_of_start } in &self.blocks {
            let factor = damped(of_start, damping).cholesky()?;
            reduced -= cross * factor.solve(&cross.transpose());
            gradient -= cross * factor.solve(gradient_of_start);
        }
        Some((reduced, gradient))
    }
}

/// x that solves `matrix` x = −`gradient` but for the rows in which it would be below `room`.
fn held_within(matrix: &DMatrix<f64>, gradient: &DVector<f64>, room: &[f64]) -> Option<DVector<f64>> {
    let mut held = vec![false; room.len()];
    loop {
        let (mut equations, mut right) = (matrix.clone(), -gradient);
        for (index, room) in room.iter().enumerate().filter(|(index, _)| held[*index]) {
            right -= matrix.column(index) * *room;
            equations.row_mut(index).fill(0.0);
            equations.column_mut(index).fill(0.0);
            equations[(index, index)] = 1.0;
        }
        for (index, room) in room.iter().enumerate().filter(|(index, _)| held[*index]) {
            right[index] = *room;
        }
        let step = equations.cholesky()?.solve(&right);
        let below: Vec<_> = (0..room.len()).filter(|index| !held[*index] && step[*index] < room[*index]).collect();
        if below.is_empty() {
            return Some(step);
        }
        below.into_iter().for_each(|index| held[index] = true);
    }
}

/// `matrix` with a diagonal that is larger by a share. What no residual depends on gets a diagonal of its own.
fn damped(matrix: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    const LEAST: f64 = 1e-12;
    let mut damped = matrix.clone();
    for index in 0..matrix.nrows() {
        damped[(index, index)] += damping * matrix[(index, index)].max(LEAST);
    }
    damped
}
