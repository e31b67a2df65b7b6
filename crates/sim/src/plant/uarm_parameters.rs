//! What is not ideal in the UARM.

use nalgebra::{Vector2, Vector3};

/// Why imperfections are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {found}, expected {expected}")]
pub struct UarmParameterError {
    /// Which parameter was refused.
    pub name: &'static str,
    /// The value that was refused.
    pub found: f64,
    /// The range that is allowed.
    pub expected: &'static str,
}

/// The UARM's imperfections, as plain numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UarmImperfections {
    /// Viscous friction b of joints 1, 2, 3, N·m·s/rad; ≥ 0.
    pub viscous_friction: [f64; 3],
    /// Coulomb friction c of joints 1, 2, 3, N·m; ≥ 0.
    pub coulomb_friction: [f64; 3],
    /// I_1 of the plant over the nominal one; > 0.
    pub base_inertia_scale: f64,
    /// I_2, I_3, m_2, m_3 of the plant over the nominal ones; > 0.
    pub link_inertia_scale: f64,
    /// Torque at the joint per commanded torque; > 0.
    pub gain: f64,
    /// Acceleration of the tilted table in the fixed frame in which q = 0 lies along +x, m/s².
    pub tilt: [f64; 2],
}

/// The UARM's imperfections, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UarmPlantParameters {
    viscous_friction: Vector3<f64>,
    coulomb_friction: Vector3<f64>,
    base_inertia_scale: f64,
    link_inertia_scale: f64,
    gain: f64,
    tilt: Vector2<f64>,
}

impl UarmPlantParameters {
    /// The velocity over which Coulomb friction changes its sign, `c tanh(q̇ / 0.02 rad/s)`: part of the fitted model.
    pub const FRICTION_TRANSITION_VELOCITY: f64 = 0.02;

    /// Checks and takes the parameters.
    ///
    /// # Errors
    /// [`UarmParameterError`] names the first one that is not finite or out of the range that its field states.
    pub fn new(imperfections: UarmImperfections) -> Result<Self, UarmParameterError> {
        let UarmImperfections { viscous_friction, coulomb_friction, gain, tilt, .. } = imperfections;
        let UarmImperfections { base_inertia_scale, link_inertia_scale, .. } = imperfections;
        for friction in viscous_friction {
            require("viscous_friction", friction, "a finite value >= 0", friction >= 0.0)?;
        }
        for friction in coulomb_friction {
            require("coulomb_friction", friction, "a finite value >= 0", friction >= 0.0)?;
        }
        let positive = |name, value| require(name, value, "a finite value > 0", value > 0.0);
        positive("base_inertia_scale", base_inertia_scale)?;
        positive("link_inertia_scale", link_inertia_scale)?;
        positive("gain", gain)?;
        for acceleration in tilt {
            require("tilt", acceleration, "a finite value", true)?;
        }
        Ok(Self {
            viscous_friction: viscous_friction.into(),
            coulomb_friction: coulomb_friction.into(),
            base_inertia_scale,
            link_inertia_scale,
            gain,
            tilt: tilt.into(),
        })
    }

    /// The fitted plant: friction, scales, gain and tilt chosen so that six controllers give about the indices of Table 4.
    ///
    /// **A fit of 13 parameters to 12 numbers, chosen after 26 fits** (the other parameters are the encoder's resolution and
    /// the velocity filter's bandwidth). It is one robot that could have given the paper's numbers, not the paper's robot.
    pub const fn fitted() -> Self {
        Self {
            viscous_friction: Vector3::new(0.0402, 0.01192, 0.01192),
            coulomb_friction: Vector3::new(0.02802, 0.04985, 0.0305),
            base_inertia_scale: 1.10368,
            link_inertia_scale: 1.36835,
            gain: 1.0022,
            tilt: Vector2::new(-0.24691, -0.11777),
        }
    }

    /// No imperfection at all.
    pub const fn ideal() -> Self {
        Self {
            viscous_friction: Vector3::new(0.0, 0.0, 0.0),
            coulomb_friction: Vector3::new(0.0, 0.0, 0.0),
            base_inertia_scale: 1.0,
            link_inertia_scale: 1.0,
            gain: 1.0,
            tilt: Vector2::new(0.0, 0.0),
        }
    }

    /// The same as plain numbers.
    pub fn imperfections(&self) -> UarmImperfections {
        UarmImperfections {
            viscous_friction: self.viscous_friction.into(),
            coulomb_friction: self.coulomb_friction.into(),
            base_inertia_scale: self.base_inertia_scale,
            link_inertia_scale: self.link_inertia_scale,
            gain: self.gain,
            tilt: self.tilt.into(),
        }
    }

    /// Viscous friction of joints 1, 2, 3, N·m·s/rad.
    pub const fn viscous_friction(&self) -> &Vector3<f64> {
        &self.viscous_friction
    }

    /// Coulomb friction of joints 1, 2, 3, N·m.
    pub const fn coulomb_friction(&self) -> &Vector3<f64> {
        &self.coulomb_friction
    }

    /// I_1 of the plant over the nominal one.
    pub const fn base_inertia_scale(&self) -> f64 {
        self.base_inertia_scale
    }

    /// I_2, I_3, m_2, m_3 of the plant over the nominal ones.
    pub const fn link_inertia_scale(&self) -> f64 {
        self.link_inertia_scale
    }

    /// Torque at the joint per commanded torque.
    pub const fn gain(&self) -> f64 {
        self.gain
    }

    /// Acceleration of the tilted table, m/s².
    pub const fn tilt(&self) -> &Vector2<f64> {
        &self.tilt
    }
}

pub(super) fn require(
    name: &'static str,
    found: f64,
    expected: &'static str,
    in_range: bool,
) -> Result<(), UarmParameterError> {
    if found.is_finite() && in_range { Ok(()) } else { Err(UarmParameterError { name, found, expected }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> UarmImperfections {
        UarmImperfections {
            viscous_friction: [0.0402, 0.01192, 0.01192],
            coulomb_friction: [0.02802, 0.04985, 0.0305],
            base_inertia_scale: 1.10368,
            link_inertia_scale: 1.36835,
            gain: 1.0022,
            tilt: [-0.24691, -0.11777],
        }
    }

    #[test]
    fn the_fitted_parameters_pass_their_own_check() {
        assert_eq!(UarmPlantParameters::new(plain()), Ok(UarmPlantParameters::fitted()));
        assert_eq!(UarmPlantParameters::fitted().imperfections(), plain());
    }

    #[test]
    fn what_no_robot_has_is_refused_by_name() {
        let name = |imperfections| UarmPlantParameters::new(imperfections).unwrap_err().name;
        assert_eq!(name(UarmImperfections { viscous_friction: [0.0, -1e-9, 0.0], ..plain() }), "viscous_friction");
        assert_eq!(name(UarmImperfections { coulomb_friction: [0.0, 0.0, f64::NAN], ..plain() }), "coulomb_friction");
        assert_eq!(name(UarmImperfections { base_inertia_scale: 0.0, ..plain() }), "base_inertia_scale");
        assert_eq!(name(UarmImperfections { link_inertia_scale: -1.0, ..plain() }), "link_inertia_scale");
        assert_eq!(name(UarmImperfections { gain: f64::INFINITY, ..plain() }), "gain");
        assert_eq!(name(UarmImperfections { tilt: [0.0, f64::NAN], ..plain() }), "tilt");
    }
}
