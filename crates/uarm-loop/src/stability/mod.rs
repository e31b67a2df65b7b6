//! Is the sampled loop stable? Frozen in one configuration, at rest: exact.
//!
//! A law is proved in continuous time with true velocities. On a robot its torque is held for a period, its velocities come
//! from counts through an estimator, and the drive applies the torque some time after the counts were latched. All three are
//! delays, and a loop with too much delay swings up. Around rest in a fixed configuration q everything in it is linear:
//!
//! - the arm on its floating base without momentum, M̄(q) q̈_m = τ, q̇_b = −A(q) q̇_m, held torque: exact over a period;
//! - the estimators of the joints, which are linear difference equations ([`LinearEstimator`]);
//! - the law, τ = −K_p q̃ − K_d q̃̇ − k_v q̇_b − k_a q̈_b ([`Feedback`]);
//! - the delay from the latch of the counts to the torque, whole cycles and fractions of one ([`TransportDelay`]).
//!
//! So the loop is x_{k+1} = A(q) x_k ([`SampledLoop::transition`]), and it is stable where the spectral radius of A(q) is below
//! one. [`survey`] looks at the configurations that a task visits and at the rest of the workspace.
//!
//! What is not in it: friction, which damps; how fast the configuration changes; saturation; quantisation; the adaptation of
//! an adaptive law, whose nominal feedback alone is looked at (Φ as it starts); parameters of the real arm that are not the
//! model's. A radius below one is thus necessary, and not sufficient, for the robot.

mod delay;
mod estimator;
mod feedback;
mod sampled_loop;
mod spectrum;
pub mod survey;

pub use delay::{DelayError, TransportDelay};
pub use estimator::{LinearEstimator, NotLinear};
pub use feedback::Feedback;
pub use sampled_loop::{RestModel, SampledLoop};
pub use spectrum::spectral_radius;

#[cfg(test)]
mod tests;
