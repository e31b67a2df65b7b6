//! Jang's benchmark (1993, section VI-D): predicting the chaotic Mackey–Glass series.
//!
//! ẋ = 0.2 x(t − τ)/(1 + x(t − τ)^10) − 0.1 x(t), x(0) = 1.2, x = 0 before. From x(t − 18), x(t − 12), x(t − 6), x(t) a
//! system predicts x(t + 6). The published errors belong to one series, and its generator has a quirk: it steps by 0.1
//! with the delayed value held over the step, and its ring of 170 values is written one place ahead of where it is read.
//! The delay is so 169 steps, 16.9, once the ring is full; with a true 17 all errors come out otherwise.

use crate::data::DataSet;
use crate::error::AnfisError;

/// Places in the generator's ring: τ = 17 in steps of 0.1.
const RING: usize = 170;
/// Steps of the generator per unit of time.
const STEPS_PER_UNIT: usize = 10;
/// Integration step.
const STEP: f64 = 0.1;
/// x(0).
const START: f64 = 1.2;
/// Time of the first pair.
const FIRST: usize = 118;
/// Pairs in each of the two sets.
const PAIRS: usize = 500;
/// How far ahead the target lies, and how far apart the inputs.
const STRIDE: usize = 6;

/// The series at t = 0, 1, …, `length` − 1.
#[must_use]
pub fn series(length: usize) -> Vec<f64> {
    let mut ring = [0.0; RING];
    let mut x = START;
    let mut samples = Vec::with_capacity(length);
    for step in 0..length * STEPS_PER_UNIT {
        if step % STEPS_PER_UNIT == 0 {
            samples.push(x);
        }
        let place = &mut ring[step % RING];
        x = runge_kutta_step(x, *place);
        *place = x;
    }
    samples
}

/// One classical Runge–Kutta step with the delayed value held.
fn runge_kutta_step(x: f64, delayed: f64) -> f64 {
    let square = delayed * delayed;
    let fourth = square * square;
    let gain = 0.2 * delayed / (1.0 + fourth * fourth * square);
    let slope = |x: f64| gain - 0.1 * x;
    let k1 = slope(x);
    let k2 = slope(x + 0.5 * STEP * k1);
    let k3 = slope(x + 0.5 * STEP * k2);
    let k4 = slope(x + STEP * k3);
    x + STEP * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
}

/// Jang's 500 training and 500 checking pairs: t = 118 … 617 and 618 … 1117.
///
/// # Errors
/// None in practice: the series is finite.
pub fn data_sets() -> Result<(DataSet, DataSet), AnfisError> {
    let x = series(FIRST + 2 * PAIRS + STRIDE);
    let pair = |t: usize| ([x[t - 3 * STRIDE], x[t - 2 * STRIDE], x[t - STRIDE], x[t]], x[t + STRIDE]);
    let pairs = |first: usize| DataSet::new((first..first + PAIRS).map(pair));
    Ok((pairs(FIRST)?, pairs(FIRST + PAIRS)?))
}
