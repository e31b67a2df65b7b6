//! What is not ideal in the simulated robot: checked.

use uarm_loop::dimensions;
use uarm_sim::{
    JointImperfections, ParameterScale, SerialImperfections, UarmImperfections, UarmParameterError, UarmPlantParameters,
};

use super::error::{Checker, RobotError};
use super::file;
use super::model::Mechanics;

/// What is not ideal in the simulated robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imperfections<const N: usize> {
    /// Of the paper's arm.
    pub uarm: UarmPlantParameters,
    /// Of any other one: by how much it is heavier than its model.
    pub scale: ParameterScale,
    /// And the friction and gains of its joints.
    pub joints: SerialImperfections<N>,
}

impl<const N: usize> Imperfections<N> {
    /// None.
    pub const NONE: Self = Self {
        uarm: UarmPlantParameters::ideal(),
        scale: ParameterScale { base: 1.0, links: 1.0 },
        joints: SerialImperfections::IDEAL,
    };
}

/// Those of a robot of `J` joints whose file has this `[plant]`.
///
/// # Errors
/// [`RobotError::Field`] for a list that is not as long as there are joints, a value out of its range, or a tilt of another arm than
/// the paper's.
pub(super) fn check<const J: usize, const N: usize>(
    plant: Option<&file::Plant>,
    mechanics: &Mechanics<N>,
    check: &Checker<'_>,
) -> Result<Imperfections<N>, RobotError> {
    let Some(plant) = plant else { return Ok(Imperfections::NONE) };
    let viscous = of_each_joint::<J>("viscous_friction_nm_s", &plant.viscous_friction_nm_s, check)?;
    let coulomb = of_each_joint::<J>("coulomb_friction_nm", &plant.coulomb_friction_nm, check)?;
    if let (Mechanics::ThreeLinks { .. }, [v1, v2, v3], [c1, c2, c3]) = (mechanics, &viscous[..], &coulomb[..]) {
        let uarm = UarmPlantParameters::new(UarmImperfections {
            viscous_friction: [*v1, *v2, *v3],
            coulomb_friction: [*c1, *c2, *c3],
            base_inertia_scale: plant.base_inertia_scale,
            link_inertia_scale: plant.link_scale,
            gain: plant.torque_gain,
            tilt: plant.tilt_m_per_s2,
        });
        return Ok(Imperfections { uarm: uarm.map_err(|error| refused(error, check))?, ..Imperfections::NONE });
    }
    if plant.tilt_m_per_s2 != [0.0; 2] {
        let expected = "[0, 0], or no such field: a tilted table is simulated of the paper's arm alone";
        return Err(check.refuse("plant.tilt_m_per_s2", format!("{:?}", plant.tilt_m_per_s2), expected));
    }
    let scale = ParameterScale {
        base: check.positive("plant.base_inertia_scale", plant.base_inertia_scale)?,
        links: check.positive("plant.link_scale", plant.link_scale)?,
    };
    let (viscous_of_arm, coulomb_of_arm) = (dimensions::active::<J, N>(&viscous), dimensions::active::<J, N>(&coulomb));
    let joints = std::array::from_fn(|joint| JointImperfections {
        viscous_friction: viscous_of_arm[joint],
        coulomb_friction: coulomb_of_arm[joint],
        gain: plant.torque_gain,
    });
    let base = |of_all: &[f64; J]| if J > N { dimensions::base::<f64, J, N>(of_all) } else { 0.0 };
    let joints = SerialImperfections::new(joints)
        .and_then(|joints| joints.with_base_friction(base(&viscous), base(&coulomb)))
        .map_err(|error| refused(error, check))?;
    Ok(Imperfections { uarm: UarmPlantParameters::ideal(), scale, joints })
}

fn of_each_joint<const J: usize>(field: &str, values: &[f64], check: &Checker<'_>) -> Result<[f64; J], RobotError> {
    values.try_into().map_err(|_| {
        check.refuse(format!("plant.{field}"), format!("{} values", values.len()), format!("{J}, one for each joint"))
    })
}

/// The simulation's names of parameters are not the file's.
fn refused(error: UarmParameterError, check: &Checker<'_>) -> RobotError {
    let field = match error.name {
        "viscous_friction" | "base viscous_friction" => "viscous_friction_nm_s",
        "coulomb_friction" | "base coulomb_friction" => "coulomb_friction_nm",
        "link_inertia_scale" => "link_scale",
        "gain" => "torque_gain",
        "tilt" => "tilt_m_per_s2",
        name => name,
    };
    check.refuse(format!("plant.{field}"), error.found, error.expected)
}
