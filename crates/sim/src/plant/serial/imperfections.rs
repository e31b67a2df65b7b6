//! What is not ideal in an arm of N joints.

use crate::plant::uarm_parameters::{UarmParameterError, UarmPlantParameters, require};
use dem_model::{BaseFreedom, BaseMotion};
use nalgebra::{ComplexField, SVector};

/// What is not ideal in a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointImperfections {
    /// Viscous friction b, N·m·s/rad or N·s/m; ≥ 0.
    pub viscous_friction: f64,
    /// Coulomb friction c, N·m or N; ≥ 0.
    pub coulomb_friction: f64,
    /// Torque at the joint per commanded torque; > 0.
    pub gain: f64,
}

/// Friction and gains of an arm, checked.
///
/// Friction is −b q̇ − c tanh(q̇/v₀) with v₀ = [`UarmPlantParameters::FRICTION_TRANSITION_VELOCITY`], in rad/s or m/s. That of
/// a spherical base, b and c being the same about each axis, is −(b + c tanh(|ω|/v₀)/|ω|) ω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialImperfections<const N: usize> {
    joints: [JointImperfections; N],
    base: BaseFriction,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct BaseFriction {
    viscous: f64,
    coulomb: f64,
}

impl JointImperfections {
    /// None.
    pub const IDEAL: Self = Self { viscous_friction: 0.0, coulomb_friction: 0.0, gain: 1.0 };

    fn friction(&self, velocity: f64) -> f64 {
        -self.viscous_friction * velocity - self.coulomb_friction * smoothed_sign(velocity)
    }
}

impl<const N: usize> SerialImperfections<N> {
    /// None.
    pub const IDEAL: Self =
        Self { joints: [JointImperfections::IDEAL; N], base: BaseFriction { viscous: 0.0, coulomb: 0.0 } };

    /// Checks and takes the joints' imperfections; the base's joint has no friction.
    ///
    /// # Errors
    /// [`UarmParameterError`] names the first value that is not finite or out of the range that its field states.
    pub fn new(joints: [JointImperfections; N]) -> Result<Self, UarmParameterError> {
        for joint in &joints {
            not_negative("viscous_friction", joint.viscous_friction)?;
            not_negative("coulomb_friction", joint.coulomb_friction)?;
            require("gain", joint.gain, "a finite value > 0", joint.gain > 0.0)?;
        }
        Ok(Self { joints, ..Self::IDEAL })
    }

    /// The same, with friction in the joint on which the base of a DEM turns: `viscous` in N·m·s/rad and `coulomb` in N·m,
    /// both ≥ 0. A spacecraft that floats has nothing to rub against: there it has no effect.
    ///
    /// # Errors
    /// [`UarmParameterError`] if a value is not finite or negative.
    pub fn with_base_friction(mut self, viscous: f64, coulomb: f64) -> Result<Self, UarmParameterError> {
        not_negative("base viscous_friction", viscous)?;
        not_negative("base coulomb_friction", coulomb)?;
        self.base = BaseFriction { viscous, coulomb };
        Ok(self)
    }

    /// The torques at the joints for `commanded` ones while they move at `velocity`, N·m or N.
    pub(super) fn joint_torque(&self, commanded: &SVector<f64, N>, velocity: &SVector<f64, N>) -> SVector<f64, N> {
        let torques = self.joints.iter().zip(commanded.iter().zip(velocity.iter()));
        SVector::from_iterator(
            torques.map(|(joint, (torque, velocity))| torque * joint.gain + joint.friction(*velocity)),
        )
    }

    /// The friction on a base that moves at `velocity`.
    pub(super) fn base_torque<const B: usize>(&self, velocity: &SVector<f64, B>) -> SVector<f64, B>
    where
        BaseFreedom<B>: BaseMotion<f64, B>,
    {
        let speed = velocity.norm();
        if B == FLOATING || speed == 0.0 {
            return SVector::zeros();
        }
        velocity * -(self.base.viscous + self.base.coulomb * smoothed_sign(speed) / speed)
    }
}

/// The degrees of freedom of a base that is on no joint.
const FLOATING: usize = 6;

fn smoothed_sign(velocity: f64) -> f64 {
    ComplexField::tanh(velocity / UarmPlantParameters::FRICTION_TRANSITION_VELOCITY)
}

fn not_negative(name: &'static str, found: f64) -> Result<(), UarmParameterError> {
    require(name, found, "a finite value >= 0", found >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2, Vector3, Vector6};

    #[test]
    fn what_no_joint_has_is_refused_by_name() {
        let name = |joint| SerialImperfections::new([JointImperfections::IDEAL, joint]).unwrap_err().name;
        let ideal = JointImperfections::IDEAL;
        assert_eq!(name(JointImperfections { viscous_friction: -1.0, ..ideal }), "viscous_friction");
        assert_eq!(name(JointImperfections { coulomb_friction: f64::NAN, ..ideal }), "coulomb_friction");
        assert_eq!(name(JointImperfections { gain: 0.0, ..ideal }), "gain");
        let base = |viscous, coulomb| SerialImperfections::<1>::IDEAL.with_base_friction(viscous, coulomb);
        assert_eq!(base(-1.0, 0.0).unwrap_err().name, "base viscous_friction");
        assert_eq!(base(0.0, f64::INFINITY).unwrap_err().name, "base coulomb_friction");
    }

    /// At many times the transition velocity the smoothed sign is one: b q̇ + c.
    #[test]
    fn friction_and_gain_are_those_of_the_joint() {
        let joint = JointImperfections { viscous_friction: 2.0, coulomb_friction: 0.5, gain: 1.25 };
        let imperfections = SerialImperfections::new([JointImperfections::IDEAL, joint]).unwrap();
        let torque = imperfections.joint_torque(&Vector2::new(4.0, 4.0), &Vector2::new(1.0, -3.0));
        approx::assert_relative_eq!(torque, Vector2::new(4.0, 5.0 + 6.0 + 0.5), max_relative = 1e-12);
    }

    /// Along the rate, and on each base that has a joint.
    #[test]
    fn a_base_on_a_joint_is_braked_against_its_rate() {
        let imperfections = SerialImperfections::<1>::IDEAL.with_base_friction(2.0, 0.5).unwrap();
        let spherical = imperfections.base_torque(&Vector3::new(0.6, 0.0, -0.8));
        approx::assert_relative_eq!(spherical, Vector3::new(-1.5, 0.0, 2.0), max_relative = 1e-12);
        let planar = imperfections.base_torque(&Vector1::new(-3.0));
        approx::assert_relative_eq!(planar, Vector1::new(6.5), max_relative = 1e-12);
        assert_eq!(imperfections.base_torque(&Vector3::zeros()), Vector3::zeros());
        assert_eq!(imperfections.base_torque(&Vector6::repeat(1.0)), Vector6::zeros());
    }
}
