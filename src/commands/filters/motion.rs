//! The motions that are estimated, as an encoder sees them.

use core::f64::consts::PI;
use dem_model::ThreeLinkDem;
use hinf_control::{QuinticReference, Reference};
use nalgebra::{Vector2, Vector3};
use uarm_io::encoder::CountsPerRevolution;

/// The sampling period of the paper's robot, s.
pub const PERIOD: f64 = 0.003;

/// How the period varies around [`PERIOD`]; the estimators are told the true one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Jitter {
    /// The period is constant.
    None,
    /// Evenly within ±10 %, far more than a real-time kernel shows.
    TenPercent,
}

/// A motion of the two active joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The paper's quintic.
    Task,
    /// The quintic, and on top of it what the paper's disturbance does to the arm where no controller holds it: the
    /// joint accelerations at the middle posture times e^(−5s) sin(6πs), s = t − 1 s (eq. 48).
    Disturbed,
}

/// Eq. 48: decay 1/s, frequency rad/s, start s, torques N·m.
const DECAY: f64 = 5.0;
const FREQUENCY: f64 = 6.0 * PI;
const START: f64 = 1.0;
const TORQUES: Vector2<f64> = Vector2::new(0.075, 0.05);

/// One sampling instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub time: f64,
    /// Since the sample before, s.
    pub period: f64,
    /// What the encoders say, rad.
    pub measured: [f64; 2],
}

/// A motion through an encoder.
#[derive(Clone, Debug)]
pub struct Recording {
    truth: Truth,
    pub samples: Vec<Sample>,
}

/// The motion itself, at any time.
#[derive(Clone, Copy, Debug)]
struct Truth {
    task: QuinticReference<f64>,
    /// Peak of the disturbing acceleration, rad/s²; zero without disturbance.
    disturbance: Vector2<f64>,
}

impl Truth {
    fn new(motion: Motion) -> Self {
        let task = QuinticReference::paper();
        let disturbance = match motion {
            Motion::Task => Vector2::zeros(),
            Motion::Disturbed => {
                let middle = (task.start() + task.end()) * 0.5;
                let posture = Vector3::new(0.0, middle.x, middle.y);
                let force = Vector3::new(0.0, TORQUES.x, TORQUES.y);
                let acceleration = ThreeLinkDem::table_2().forward_dynamics(&posture, &Vector3::zeros(), &force);
                Vector2::new(acceleration.y, acceleration.z)
            }
        };
        Self { task, disturbance }
    }

    fn at(&self, time: f64) -> Reference<f64> {
        let task = self.task.at(time);
        let since = (time - START).max(0.0);
        let squared = DECAY * DECAY + FREQUENCY * FREQUENCY;
        let (sine, cosine) = (FREQUENCY * since).sin_cos();
        let fading = (-DECAY * since).exp();
        // The disturbing acceleration, and its first and second integral in closed form.
        let acceleration = fading * sine;
        let rate = (FREQUENCY - fading * (DECAY * sine + FREQUENCY * cosine)) / squared;
        let of_cosine = (DECAY + fading * (FREQUENCY * sine - DECAY * cosine)) / squared;
        let position = (FREQUENCY * since - DECAY * rate - FREQUENCY * of_cosine) / squared;
        Reference {
            position: task.position + self.disturbance * position,
            velocity: task.velocity + self.disturbance * rate,
            acceleration: task.acceleration + self.disturbance * acceleration,
        }
    }
}

impl Recording {
    /// `motion` through an encoder, sampled until its end.
    pub fn new(motion: Motion, counts: CountsPerRevolution, jitter: Jitter) -> Self {
        let truth = Truth::new(motion);
        let mut random = Sequence::default();
        let mut samples = Vec::new();
        let (mut time, mut period) = (0.0, 0.0);
        while time <= truth.task.duration() {
            let angles: [f64; 2] = truth.at(time).position.into();
            let measured = angles.map(|angle| counts.count_at(angle) as f64 * counts.resolution());
            samples.push(Sample { time, period, measured });
            period = match jitter {
                Jitter::None => PERIOD,
                Jitter::TenPercent => PERIOD * (0.9 + 0.2 * random.next()),
            };
            time += period;
        }
        Self { truth, samples }
    }

    /// RMS of estimated minus true velocity, both joints, the truth taken `delay` s earlier, rad/s.
    pub fn rms_error(&self, velocities: &[[f64; 2]], delay: f64) -> f64 {
        let squares: f64 = self.residuals(velocities, delay).map(|(residual, _)| residual.norm_squared()).sum();
        (squares / (2 * self.samples.len()) as f64).sqrt()
    }

    /// The lag d that makes Σ ‖estimate(t) − velocity(t − d)‖² least, s, by Gauss–Newton: the residual's derivative to d is
    /// the acceleration.
    pub fn least_squares_delay(&self, velocities: &[[f64; 2]]) -> f64 {
        /// The motion is smooth over the delays that occur; four steps leave nothing visible.
        const STEPS: u32 = 8;
        (0..STEPS).fold(0.0, |delay, _| {
            let (numerator, denominator) =
                self.residuals(velocities, delay).fold((0.0, 0.0), |(above, below), (residual, acceleration)| {
                    (above + residual.dot(&acceleration), below + acceleration.norm_squared())
                });
            delay - numerator / denominator
        })
    }

    /// Estimate minus truth, and the true acceleration, `delay` s earlier.
    fn residuals<'a>(
        &'a self,
        velocities: &'a [[f64; 2]],
        delay: f64,
    ) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + 'a {
        self.samples.iter().zip(velocities).map(move |(sample, velocity)| {
            let truth = self.truth.at(sample.time - delay);
            (Vector2::from(*velocity) - truth.velocity, truth.acceleration)
        })
    }
}

/// A repeatable sequence in 0 … 1: Lehmer's generator with the multiplier of MINSTD.
struct Sequence(u64);

impl Default for Sequence {
    fn default() -> Self {
        Self(1)
    }
}

impl Sequence {
    fn next(&mut self) -> f64 {
        const MODULUS: u64 = 2_147_483_647;
        self.0 = self.0 * 48_271 % MODULUS;
        self.0 as f64 / MODULUS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// The closed forms against Simpson's rule on the acceleration.
    #[test]
    fn the_disturbed_motion_is_the_integral_of_its_acceleration() {
        let truth = Truth::new(Motion::Disturbed);
        let (mut rate, mut position) = (truth.at(START).velocity, truth.at(START).position);
        let step = 1e-4;
        for k in 0..10_000 {
            let at = |fraction: f64| truth.at(START + (f64::from(k) + fraction) * step);
            position += (at(0.0).velocity + at(0.5).velocity * 4.0 + at(1.0).velocity) * (step / 6.0);
            rate += (at(0.0).acceleration + at(0.5).acceleration * 4.0 + at(1.0).acceleration) * (step / 6.0);
        }
        // Simpson's error at this step is far below; 10 000 sums round to about 1e-13.
        assert_relative_eq!(rate, truth.at(START + 1.0).velocity, max_relative = 1e-10);
        assert_relative_eq!(position, truth.at(START + 1.0).position, max_relative = 1e-10);
    }

    #[test]
    fn a_known_delay_is_found() {
        let counts = CountsPerRevolution::new(65_536).unwrap();
        let recording = Recording::new(Motion::Task, counts, Jitter::TenPercent);
        for delay in [-0.01, 0.0, 0.02, 0.08] {
            let velocities: Vec<[f64; 2]> =
                recording.samples.iter().map(|s| recording.truth.at(s.time - delay).velocity.into()).collect();
            assert_relative_eq!(recording.least_squares_delay(&velocities), delay, epsilon = 1e-9);
            assert!(recording.rms_error(&velocities, delay) < 1e-12);
        }
    }
}
