//! What the controllers believe the arm to be: as the robot file has it, or from the space manipulator that it stands for.

use std::path::Path;

use dem_model::{DemBase, DemLink, PlanarDem, PlanarSpaceManipulator, SpaceLink, SpacecraftBody, ThreeLinkDem};
use uarm_urdf::{Arm, Selection};

use super::error::{Checker, RobotError};
use super::file::{self, ModelBase, ModelBaseNumbers, ModelLink, RobotFile};
use crate::text_file;

/// The most bytes of a URDF, which may name many meshes.
pub const MOST_URDF_BYTES: usize = 16 * 1024 * 1024;
/// How far `[model]` may be from what `[space_manipulator]` gives, relative: papers print three digits.
const ROUNDING: f64 = 0.01;

/// The arm, in both forms where the file has a space manipulator.
#[derive(Clone, Copy, Debug)]
pub struct CheckedModel {
    /// The dynamically equivalent manipulator, which the controllers compute with.
    pub model: ThreeLinkDem<f64>,
    /// The space manipulator, if the file has it.
    pub space_manipulator: Option<PlanarSpaceManipulator<f64, 2>>,
}

/// Replaces `model.urdf` by the `[space_manipulator]` that it describes; a path is relative to the folder of the robot file `name`.
///
/// # Errors
/// If the URDF cannot be read, describes no planar arm of two joints, or the file has other numbers of the arm, too.
pub fn resolve_urdf(name: &Path, file: &mut RobotFile, check: &Checker<'_>) -> Result<(), RobotError> {
    let Some(model) = &file.model else { return Ok(()) };
    let Some(manipulator) = urdf(name, model)? else { return Ok(()) };
    if file.space_manipulator.replace(manipulator).is_some() {
        return Err(check.refuse("model.urdf", "a URDF", ARM_ONCE));
    }
    file.model = None;
    Ok(())
}

const ARM_ONCE: &str = "the arm once: by a URDF, or by the numbers of [model] and [space_manipulator]";

/// The space manipulator that `model.urdf` describes, if there is one; a path is relative to the folder of the file `name`.
///
/// # Errors
/// If the URDF cannot be read, describes no planar arm of two joints, or stands beside other numbers of the arm.
pub fn urdf(name: &Path, model: &file::Model) -> Result<Option<file::SpaceManipulator>, RobotError> {
    let check = Checker::new(name);
    let Some(urdf) = &model.urdf else { return Ok(None) };
    if !model.links.is_empty() {
        return Err(check.refuse("model.urdf", urdf.display(), ARM_ONCE));
    }
    let base = match &model.base {
        Some(ModelBase::Numbers(_)) => {
            return Err(check.refuse("model.base", "numbers", "the name of a link of the URDF, or no such field"));
        }
        Some(ModelBase::Link(link)) => Some(link.clone()),
        None => None,
    };
    if urdf.as_os_str().is_empty() {
        return Err(check.refuse("model.urdf", "\"\"", "the path of a URDF, relative to the robot file"));
    }
    let path = name.parent().unwrap_or(Path::new("")).join(urdf);
    let refused = |error: String| RobotError::Urdf { robot: name.to_owned(), file: path.clone(), error };
    let text =
        text_file::read_up_to(&path, MOST_URDF_BYTES).map_err(|error| refused(format!("cannot be read: {error}")))?;
    let selection = Selection { base, tip: model.tip.clone(), spacecraft: None };
    let arm = Arm::parse(&text, &selection).and_then(|arm| arm.planar::<2>());
    let arm = arm.map_err(|error| refused(error.to_string()))?;
    let body = arm.spacecraft();
    Ok(Some(file::SpaceManipulator {
        spacecraft: file::Spacecraft {
            mass_kg: body.mass,
            inertia_kg_m2: body.inertia,
            centre_of_mass_to_joint_m: body.centre_of_mass_to_joint,
        },
        links: arm.links().iter().map(space_link_as_written).collect(),
    }))
}

fn space_link_as_written(link: &SpaceLink<f64>) -> file::SpaceLink {
    file::SpaceLink {
        mass_kg: link.mass,
        inertia_kg_m2: link.inertia,
        joint_to_centre_of_mass_m: link.joint_to_centre_of_mass,
        centre_of_mass_to_joint_m: link.centre_of_mass_to_joint,
    }
}

/// The model of a robot file, by eq. 1 where it has a space manipulator alone; where it has both, they must be the same arm.
///
/// # Errors
/// If there is neither, a body cannot exist, or the two differ.
pub fn check(file: &RobotFile, check: &Checker<'_>) -> Result<CheckedModel, RobotError> {
    let written = file.space_manipulator.as_ref();
    let space_manipulator = written.map(|written| space_manipulator(written, check)).transpose()?;
    let equivalent = space_manipulator.map(|manipulator| manipulator.dynamically_equivalent());
    let model = match (&file.model, equivalent) {
        (None, None) => return Err(check.refuse("model", "no such table", "[model], [space_manipulator], or both")),
        (None, Some(equivalent)) => dem(*equivalent.base(), *equivalent.links(), "space_manipulator", check)?,
        (Some(model), equivalent) => {
            let checked = numbers(model, check)?;
            equivalent.map_or(Ok(()), |equivalent| compare(&checked, &equivalent, check))?;
            checked
        }
    };
    Ok(CheckedModel { model, space_manipulator })
}

fn dem(
    base: DemBase<f64>,
    links: [DemLink<f64>; 2],
    field: &str,
    check: &Checker<'_>,
) -> Result<ThreeLinkDem<f64>, RobotError> {
    ThreeLinkDem::new(base, links).map_err(|error| check.refuse(field, error, "what a rigid body can have"))
}

fn numbers(model: &file::Model, check: &Checker<'_>) -> Result<ThreeLinkDem<f64>, RobotError> {
    if let Some(tip) = &model.tip {
        return Err(check.refuse("model.tip", tip, "model.urdf beside it"));
    }
    let Some(ModelBase::Numbers(ModelBaseNumbers { inertia_kg_m2, length_m })) = model.base else {
        return Err(check.refuse("model.base", "no numbers", "{ inertia_kg_m2 = ..., length_m = ... }, or model.urdf"));
    };
    let links: &[ModelLink; 2] = model.links.as_slice().try_into().map_err(|_| {
        check.refuse("model.links", format!("{} links", model.links.len()), "two links, those behind joints 2 and 3")
    })?;
    let links = links.each_ref().map(|link| DemLink {
        mass: link.mass_kg,
        inertia: link.inertia_kg_m2,
        length: link.length_m,
        centre_of_mass: link.centre_of_mass_m,
    });
    dem(DemBase { inertia: inertia_kg_m2, length: length_m }, links, "model", check)
}

fn space_manipulator(
    manipulator: &file::SpaceManipulator,
    check: &Checker<'_>,
) -> Result<PlanarSpaceManipulator<f64, 2>, RobotError> {
    let links: &[file::SpaceLink; 2] = manipulator.links.as_slice().try_into().map_err(|_| {
        check.refuse("space_manipulator.links", format!("{} links", manipulator.links.len()), "two links")
    })?;
    let spacecraft = SpacecraftBody {
        mass: manipulator.spacecraft.mass_kg,
        inertia: manipulator.spacecraft.inertia_kg_m2,
        centre_of_mass_to_joint: manipulator.spacecraft.centre_of_mass_to_joint_m,
    };
    let links = links.each_ref().map(|link| SpaceLink {
        mass: link.mass_kg,
        inertia: link.inertia_kg_m2,
        joint_to_centre_of_mass: link.joint_to_centre_of_mass_m,
        centre_of_mass_to_joint: link.centre_of_mass_to_joint_m,
    });
    PlanarSpaceManipulator::new(spacecraft, links)
        .map_err(|error| check.refuse("space_manipulator", error, "what a rigid body can have"))
}

/// Refuses a model that is not the equivalent of the space manipulator, as far as papers round. The length of the last link has no
/// effect.
fn compare(model: &ThreeLinkDem<f64>, equivalent: &PlanarDem<f64, 2>, check: &Checker<'_>) -> Result<(), RobotError> {
    let base = [
        ("model.base.inertia_kg_m2".to_owned(), model.base().inertia, equivalent.base().inertia),
        ("model.base.length_m".to_owned(), model.base().length, equivalent.base().length),
    ];
    let links = model.links().iter().zip(equivalent.links()).enumerate().flat_map(|(index, (link, of_space))| {
        let field = |name| format!("model.links[{index}].{name}");
        [
            (field("mass_kg"), link.mass, of_space.mass),
            (field("inertia_kg_m2"), link.inertia, of_space.inertia),
            (field("centre_of_mass_m"), link.centre_of_mass, of_space.centre_of_mass),
            (field("length_m"), link.length, if index == 0 { of_space.length } else { link.length }),
        ]
    });
    for (field, found, by_map) in base.into_iter().chain(links) {
        if (found - by_map).abs() > ROUNDING * by_map.abs() {
            let expected = format!(
                "{by_map:.6} as [space_manipulator] gives by eq. 1, to {:.0} %; or one of the two tables alone",
                ROUNDING * 100.0
            );
            return Err(check.refuse(field, found, expected));
        }
    }
    Ok(())
}
