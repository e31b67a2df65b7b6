//! Sinusoids on top of a path, as one identifies a robot with.

use hinf_control::Reference;
use nalgebra::SVector;
use std::f64::consts::TAU;

/// One sinusoid of one joint: A sin(2π f t + φ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// The active joint, from 0.
    pub joint: usize,
    /// A, rad.
    pub amplitude: f64,
    /// f, Hz; above zero.
    pub frequency: f64,
    /// φ, rad.
    pub phase: f64,
}

/// Why oscillations are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OscillationError {
    /// There is no such joint.
    #[error("oscillation {index} is of active joint {joint}, expected one from 0 to {last}")]
    Joint {
        /// Which one, from 0.
        index: usize,
        /// Its joint.
        joint: usize,
        /// The last joint that there is.
        last: usize,
    },
    /// A number is none, or the frequency is not above zero.
    #[error("oscillation {index} has a number that is not finite, or a frequency that is not above 0")]
    Number {
        /// Which one, from 0.
        index: usize,
    },
    /// The ramp is not above zero.
    #[error("the ramp of the oscillations is {found} s, expected more than 0 s and no infinity")]
    Ramp {
        /// Its length, s.
        found: f64,
    },
}

/// The sum of sinusoids of `N` active joints, which swells from rest and dies away to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Oscillations<const N: usize> {
    each: Vec<Oscillation>,
    ramp: f64,
}

impl<const N: usize> Oscillations<N> {
    /// `each`, whose amplitudes swell and die away in `ramp`, s, by a polynomial of the fifth degree; in half the motion at most.
    ///
    /// # Errors
    /// [`OscillationError`] if a number is not finite, a joint is not there, or frequency or ramp are not above zero.
    pub fn new(each: Vec<Oscillation>, ramp: f64) -> Result<Self, OscillationError> {
        for (index, Oscillation { joint, amplitude, frequency, phase }) in each.iter().enumerate() {
            if *joint >= N {
                return Err(OscillationError::Joint { index, joint: *joint, last: N.saturating_sub(1) });
            }
            let is_finite = [amplitude, frequency, phase].into_iter().all(|number| number.is_finite());
            if !is_finite || *frequency <= 0.0 {
                return Err(OscillationError::Number { index });
            }
        }
        if !(ramp.is_finite() && ramp > 0.0) {
            return Err(OscillationError::Ramp { found: ramp });
        }
        Ok(Self { each, ramp })
    }

    /// The shortest period, or the ramp, s.
    pub(super) fn finest(&self) -> f64 {
        self.each.iter().map(|oscillation| 1.0 / oscillation.frequency).fold(self.ramp, f64::min)
    }

    /// What they add at `time` of a motion of `duration`, s.
    pub(super) fn at(&self, time: f64, duration: f64) -> Reference<f64, N> {
        let window = Window::at(time, duration, self.ramp.min(0.5 * duration));
        let mut sum = Reference {
            position: SVector::<f64, N>::zeros(),
            velocity: SVector::zeros(),
            acceleration: SVector::zeros(),
        };
        for Oscillation { joint, amplitude, frequency, phase } in &self.each {
            let angular = TAU * frequency;
            let (sine, cosine) = (angular * time + phase).sin_cos();
            let [x, v, a] = [sine, angular * cosine, -angular * angular * sine].map(|value| amplitude * value);
            let [position, velocity, acceleration] = window.times([x, v, a]);
            for (sum, value) in
                [(&mut sum.position, position), (&mut sum.velocity, velocity), (&mut sum.acceleration, acceleration)]
            {
                if let Some(sum) = sum.get_mut(*joint) {
                    *sum += value;
                }
            }
        }
        sum
    }
}

/// What amplitudes are multiplied with, and its derivatives: from 0 up to 1 and back, at rest at both ends.
struct Window {
    value: f64,
    first: f64,
    second: f64,
}

impl Window {
    fn at(time: f64, duration: f64, ramp: f64) -> Self {
        let (elapsed, direction) = if time + time < duration { (time, 1.0) } else { (duration - time, -1.0) };
        if elapsed >= ramp {
            return Self { value: 1.0, first: 0.0, second: 0.0 };
        }
        if elapsed <= 0.0 || elapsed.is_nan() {
            return Self { value: 0.0, first: 0.0, second: 0.0 };
        }
        let s = elapsed / ramp;
        let rest = 1.0 - s;
        Self {
            value: s * s * s * (10.0 - s * (15.0 - 6.0 * s)),
            first: direction * 30.0 * s * s * rest * rest / ramp,
            second: 60.0 * s * rest * (1.0 - 2.0 * s) / (ramp * ramp),
        }
    }

    /// The product with a value and its derivatives, by the product rule.
    fn times(&self, [x, v, a]: [f64; 3]) -> [f64; 3] {
        [self.value * x, self.first * x + self.value * v, self.second * x + 2.0 * self.first * v + self.value * a]
    }
}
