//! Controller 2: adaptive nonlinear H∞ control with a linear parametrisation (paper section 3.1).
//!
//! F = M_mm x1 + C_mm x2 is linear in Φ = [I2, I3, m2 lc2², m3 lc3², m3 W2², m3 W2 lc3] (eq. 13), with x1 = q̈ᵈ − Λq̃̇ and
//! x2 = q̇ᵈ − Λq̃:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 18),
//! - τ̄ = ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 19),
//! - Ξ = [x11, x11+x12, x11, x11+x12, x11, x13; 0, x11+x12, 0, x11+x12, 0, x23],
//!   x13 = (2x11 + x12) c3 − x21 q̇3 s3 − x22 (q̇2 + q̇3) s3, x23 = x11 c3 + x21 q̇2 s3.
//!
//! What τ̄ leaves out, E, is `measured` (τ_m = τ̄ + E, E by the nominal model, since the parametrisation covers F only), `eliminated` (τ_m = M̄ q̈_m + h̄ with q̈_m = M_mm⁻¹(τ̄ − C_mm q̇_m),
//! all with the estimate, eqs. 20 and 21) or `omitted` (τ_m = τ̄). A `reduced` form there is not: M̄ is rational in Φ.
//!
//! Two joints share parameters here, so that inequality 12 is proven for T11 = tI only: Φ's part of V̇ cancels if
//! c sᵀΞ = sᵀT11²Ξ. With the paper's R, T11 is diag(0.86, 2.07), and the argument has a gap.

use super::{configuration, state_is_its_estimators, velocities};
use crate::adaptation::{Adaptation, AdaptationWeight, ParameterEstimator, ScalarWeight};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError, is_usable};
use dem_model::{REGRESSOR_PARAMETERS, Scalar, ThreeLinkDem, regressor};
use nalgebra::Vector2;

/// How controller 2 has the base acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AdaptiveBaseAcceleration {
    /// As measured: reads the base velocity and acceleration.
    Measured,
    /// Eliminated by eqs. 20 and 21: reads the base velocity. Where the estimated M_mm or M_bb is singular, falls back to
    /// `Omitted` for the cycle.
    #[default]
    Eliminated,
    /// Left out, with all of E: reads nothing of the base.
    Omitted,
}

/// Controller 2.
///
/// Start it at the nominal Φ, [`ThreeLinkDem::regressor_parameters`]: at Φ = 0 the estimated M_mm is singular.
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptive<T: Scalar, Z = ScalarWeight<T>> {
    model: ThreeLinkDem<T>,
    synthesis: Synthesis<T>,
    base_acceleration: AdaptiveBaseAcceleration,
    estimator: ParameterEstimator<T, REGRESSOR_PARAMETERS, Z>,
}

impl<T: Scalar, Z: AdaptationWeight<T, REGRESSOR_PARAMETERS>> Adaptive<T, Z> {
    /// The law for a nominal `model`, whose products that Φ lacks stay as they are.
    pub fn new(
        model: ThreeLinkDem<T>,
        synthesis: Synthesis<T>,
        base_acceleration: AdaptiveBaseAcceleration,
        adaptation: Adaptation<T, REGRESSOR_PARAMETERS, Z>,
    ) -> Self {
        Self { model, synthesis, base_acceleration, estimator: ParameterEstimator::new(adaptation) }
    }

    /// τ_m for τ̄ = `arm_torque`; `None` if an estimated matrix is singular.
    fn with_base(&self, measurement: &Measurement<T>, arm_torque: &Vector2<T>) -> Option<Vector2<T>> {
        let (q, velocities, base) = (configuration(measurement), velocities(measurement), &measurement.base);
        match self.base_acceleration {
            AdaptiveBaseAcceleration::Measured => {
                let nominal = self.model.partition(&q, &velocities);
                Some(arm_torque + nominal.base_reaction(base.acceleration, base.velocity))
            }
            AdaptiveBaseAcceleration::Eliminated => {
                let estimate = self.model.with_regressor_parameters(self.estimator.parameters());
                estimate.partition(&q, &velocities).base_compensated_torque(
                    arm_torque,
                    base.velocity,
                    &measurement.velocity,
                )
            }
            AdaptiveBaseAcceleration::Omitted => Some(*arm_torque),
        }
    }
}

impl<T: Scalar, Z: AdaptationWeight<T, REGRESSOR_PARAMETERS>> Controller<T> for Adaptive<T, Z> {
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        if !is_usable(measurement, reference, period) {
            return self.estimator.fall_back();
        }
        let mut status = self.estimator.step(period);
        let error = TrackingError::new(measurement, reference);
        let motion = self.synthesis.auxiliary_motion(reference, &error);
        let regressor =
            regressor(measurement.position.y, &measurement.velocity, &motion.acceleration, &motion.velocity);
        let arm_torque = regressor * self.estimator.parameters() + self.synthesis.feedback_torque(&error);
        let torque = self.with_base(measurement, &arm_torque);
        status.fell_back |= torque.is_none();
        self.estimator.learn(&regressor.tr_mul(&self.synthesis.adaptation_signal(&error)), &mut status);
        let control_input = self.synthesis.control_input(&error);
        Command { torque: torque.unwrap_or(arm_torque), control_input, adaptation: status }.or_fallback()
    }

    state_is_its_estimators!(T);
}
