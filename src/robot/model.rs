//! What the controllers believe the arm to be: as the robot file has it, or from the space manipulator that it stands for.

use std::path::{Path, PathBuf};

use std::sync::Arc;

use dem_model::{
    DemBase, DemLink, Joint, JointMotion, PlanarBaseManipulator, PlanarDem, PlanarSpaceManipulator, SpaceLink,
    SpacecraftBody, SpatialSpaceManipulator, SphericalBaseManipulator, ThreeLinkDem,
};
use nalgebra::Matrix3;
use uarm_log::description::LinkDescription;
use uarm_loop::dimensions;
use uarm_urdf::{Arm as UrdfArm, Selection, Spacecraft};

use super::arm::{self, Arm};
use super::error::{Checker, RobotError};
use super::file::{self, ModelBase, ModelBaseNumbers, ModelLink, RobotFile};
use crate::console::in_one_line;
use crate::text_file;

/// The most bytes of a URDF, which may name many meshes.
pub const MOST_URDF_BYTES: usize = 16 * 1024 * 1024;
/// How far `[model]` may be from what `[space_manipulator]` gives, relative: papers print three digits.
const ROUNDING: f64 = 0.01;

/// The arm, as the controllers believe it to be and as plants are made of it.
#[derive(Clone, Debug)]
pub struct CheckedModel<const J: usize, const N: usize> {
    /// The nominal model.
    pub arm: Arc<dyn Arm<J, N>>,
    /// The same for plants.
    pub mechanics: Mechanics<N>,
    /// Links of a URDF whose inertia no body can have.
    pub impossible_inertias: Vec<String>,
}

/// What there is to say of a `link` whose inertia no body can have: published arms have such.
pub fn impossible_inertia(link: &str) -> String {
    format!(
        "link {}: no body has this inertia, one principal moment being larger than the two others together; taken as it stands",
        in_one_line(link)
    )
}

/// What plants are made of.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant)] // One of it for each robot.
pub enum Mechanics<const N: usize> {
    /// Three links in the plane, the first of them a base with an encoder: the paper's robot.
    ThreeLinks {
        /// The dynamically equivalent manipulator.
        dem: ThreeLinkDem<f64>,
        /// The space manipulator, if the file has it.
        space: Option<PlanarSpaceManipulator<f64, 2>>,
    },
    /// Any other arm in the plane.
    Planar {
        /// The dynamically equivalent manipulator.
        dem: PlanarDem<f64, N>,
        /// The space manipulator, if the file has it.
        space: Option<PlanarSpaceManipulator<f64, N>>,
    },
    /// An arm in space.
    Spatial {
        /// The dynamically equivalent manipulator.
        dem: SphericalBaseManipulator<f64, N>,
        /// The space manipulator.
        space: SpatialSpaceManipulator<f64, N>,
        /// Its joints.
        joints: [Joint<f64>; N],
    },
}

impl<const N: usize> Mechanics<N> {
    /// The base and the links, as a log shows them: the space manipulator's if it is one in space, else its equivalent's.
    pub fn links(&self) -> Vec<LinkDescription> {
        let along_x = |base: f64, lengths: &[f64]| {
            let before = std::iter::once(0.0).chain(std::iter::once(base)).chain(lengths.iter().copied());
            let lengths = std::iter::once(base).chain(lengths.iter().copied());
            before.zip(lengths).map(|(before, length)| LinkDescription::along_x(before, length)).collect()
        };
        match self {
            Self::ThreeLinks { dem, .. } => along_x(dem.base().length, &dem.links().map(|link| link.length)),
            Self::Planar { dem, .. } => along_x(dem.base().length, &dem.links().map(|link| link.length)),
            Self::Spatial { space, joints, .. } => {
                let first = space.spacecraft().centre_of_mass_to_joint;
                let reaches = space.links().map(|link| link.joint_to_centre_of_mass + link.centre_of_mass_to_joint);
                let base = LinkDescription { reach: first.into(), ..LinkDescription::along_x(0.0, 0.0) };
                let before = std::iter::once(first).chain(reaches);
                let links = before.zip(reaches).zip(joints).map(|((before, reach), joint)| LinkDescription {
                    from_parent: before.into(),
                    axis: joint.axis().into_inner().into(),
                    reach: reach.into(),
                });
                std::iter::once(base).chain(links).collect()
            }
        }
    }
}

/// Replaces `model.urdf` by the `[space_manipulator]` that it describes; a path is relative to the folder of the robot file `name`.
///
/// # Errors
/// If the URDF cannot be read, describes no planar arm of two joints, or the file has other numbers of the arm, too.
pub fn resolve_urdf<const J: usize, const N: usize>(
    name: &Path,
    file: &mut RobotFile<N>,
    check: &Checker<'_>,
) -> Result<(), RobotError> {
    let Some(model) = &mut file.model else { return Ok(()) };
    if dimensions::passive::<J, N>() == 0 {
        return if model.urdf_text.is_some() { Ok(()) } else { with_text(name, model) };
    }
    let Some(manipulator) = urdf::<N>(name, model)? else { return Ok(()) };
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
pub fn urdf<const N: usize>(name: &Path, model: &file::Model) -> Result<Option<file::SpaceManipulator>, RobotError> {
    let check = Checker::new(name);
    let Some((path, text)) = urdf_text(name, model)? else { return Ok(None) };
    let arm = UrdfArm::parse(&text, &selection(model, &check)?).and_then(|arm| arm.planar::<N>());
    let arm = arm.map_err(|error| refused(name, &path, error.to_string()))?;
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

/// The URDF that `model.urdf` names, if there is one, and which part of it is the arm; a path is relative to the folder of the file
/// `name`.
///
/// # Errors
/// If the URDF cannot be read, or stands beside other numbers of the arm.
pub fn urdf_and_part(name: &Path, model: &file::Model) -> Result<Option<(String, Selection)>, RobotError> {
    let Some((_, text)) = urdf_text(name, model)? else { return Ok(None) };
    Ok(Some((text, selection(model, &Checker::new(name))?)))
}

/// Puts the text of a URDF in the place of its path, if there is one: a log needs no other file.
fn with_text(name: &Path, model: &mut file::Model) -> Result<(), RobotError> {
    if let Some((_, text)) = urdf_text(name, model)? {
        model.urdf_text = Some(text);
    }
    Ok(())
}

fn refused(robot: &Path, file: &Path, error: String) -> RobotError {
    RobotError::Urdf { robot: robot.to_owned(), file: file.to_owned(), error }
}

/// Path and text of the URDF that `model.urdf` names; the path is relative to the folder of the file `name`.
fn urdf_text(name: &Path, model: &file::Model) -> Result<Option<(PathBuf, String)>, RobotError> {
    let check = Checker::new(name);
    let Some(urdf) = &model.urdf else { return Ok(None) };
    if !model.links.is_empty() {
        return Err(check.refuse("model.urdf", urdf.display(), ARM_ONCE));
    }
    if urdf.as_os_str().is_empty() {
        return Err(check.refuse("model.urdf", "\"\"", "the path of a URDF, relative to the robot file"));
    }
    let path = name.parent().unwrap_or(Path::new("")).join(urdf);
    let text = text_file::read_up_to(&path, MOST_URDF_BYTES)
        .map_err(|error| refused(name, &path, format!("cannot be read: {error}")))?;
    Ok(Some((path, text)))
}

/// Which part of the URDF is the arm.
fn selection(model: &file::Model, check: &Checker<'_>) -> Result<Selection, RobotError> {
    let base = match &model.base {
        Some(ModelBase::Numbers(_)) => {
            return Err(check.refuse("model.base", "numbers", "the name of a link of the URDF, or no such field"));
        }
        Some(ModelBase::Link(link)) => Some(link.clone()),
        None => None,
    };
    let spacecraft = model.spacecraft.map(|file::UrdfSpacecraft { mass_kg, inertia_kg_m2 }| {
        let [xx, yy, zz, xy, xz, yz] = inertia_kg_m2;
        Spacecraft::new(mass_kg, Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)).ok_or_else(|| {
            let found = format!("{mass_kg} kg and {inertia_kg_m2:?} kg m2");
            check.refuse("model.spacecraft", found, "a mass above 0 and the inertia of a body: positive definite, no principal moment larger than the two others together")
        })
    });
    Ok(Selection { base, tip: model.tip.clone(), spacecraft: spacecraft.transpose()? })
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
pub fn check<const J: usize, const N: usize>(
    file: &RobotFile<N>,
    check: &Checker<'_>,
) -> Result<CheckedModel<J, N>, RobotError> {
    if let Some((model, text)) = file.model.as_ref().and_then(|model| Some((model, model.urdf_text.as_ref()?))) {
        if dimensions::passive::<J, N>() > 0 {
            return Err(check.refuse("model.urdf_text", "a text", "none behind a base with an encoder: model.urdf"));
        }
        if file.space_manipulator.is_some() {
            return Err(check.refuse("model.urdf", "a URDF", ARM_ONCE));
        }
        return in_space(model, text, check);
    }
    let written = file.space_manipulator.as_ref();
    let space = written.map(|written| space_manipulator::<N>(written, check)).transpose()?;
    let equivalent = space.map(|manipulator| manipulator.dynamically_equivalent());
    let (dem, field) = match (&file.model, equivalent) {
        (None, None) => return Err(check.refuse("model", "no such table", "[model], [space_manipulator], or both")),
        (None, Some(equivalent)) => (equivalent, "space_manipulator"),
        (Some(model), equivalent) => {
            let numbers = numbers(model, check)?;
            equivalent.map_or(Ok(()), |equivalent| compare(&numbers, &equivalent, check))?;
            (numbers, "model")
        }
    };
    if let (Some(two_links), Some(space)) = (arm::same::<_, PlanarDem<f64, 2>>(dem), arm::same(space)) {
        let dem = ThreeLinkDem::new(*two_links.base(), *two_links.links())
            .map_err(|error| check.refuse(field, error, "what a rigid body can have"))?;
        if let Some(arm) = arm::of_three_links(dem) {
            return Ok(CheckedModel {
                arm,
                mechanics: Mechanics::ThreeLinks { dem, space },
                impossible_inertias: Vec::new(),
            });
        }
    }
    let arm = Arc::new(PlanarBaseManipulator::planar(&dem));
    Ok(CheckedModel { arm, mechanics: Mechanics::Planar { dem, space }, impossible_inertias: Vec::new() })
}

/// The arm of a URDF, in space.
fn in_space<const J: usize, const N: usize>(
    model: &file::Model,
    text: &str,
    check: &Checker<'_>,
) -> Result<CheckedModel<J, N>, RobotError> {
    let path = model.urdf.clone().unwrap_or_default();
    let refused = |error: uarm_urdf::UrdfError| refused(check.file(), &path, error.to_string());
    let arm = UrdfArm::parse(text, &selection(model, check)?).map_err(refused)?;
    let (manipulator, joints) = arm.space_manipulator::<N>().map_err(refused)?;
    if let Some(index) = joints.iter().position(|joint| joint.motion() == JointMotion::Prismatic) {
        let expected = "revolute joints: the drives' encoders and limits are of angles";
        return Err(check.refuse("model.urdf", format!("joint {} slides", index + 1), expected));
    }
    let dem = SphericalBaseManipulator::dynamically_equivalent(&manipulator, joints);
    Ok(CheckedModel {
        mechanics: Mechanics::Spatial { dem, space: manipulator, joints },
        impossible_inertias: arm.impossible_inertias(),
        arm: Arc::new(dem),
    })
}

fn numbers<const N: usize>(model: &file::Model, check: &Checker<'_>) -> Result<PlanarDem<f64, N>, RobotError> {
    if let Some(tip) = &model.tip {
        return Err(check.refuse("model.tip", tip, "model.urdf beside it"));
    }
    if model.spacecraft.is_some() {
        return Err(check.refuse("model.spacecraft", "a table", "model.urdf beside it"));
    }
    let Some(ModelBase::Numbers(ModelBaseNumbers { inertia_kg_m2, length_m })) = model.base else {
        return Err(check.refuse("model.base", "no numbers", "{ inertia_kg_m2 = ..., length_m = ... }, or model.urdf"));
    };
    let links: &[ModelLink; N] = model.links.as_slice().try_into().map_err(|_| {
        check.refuse("model.links", format!("{} links", model.links.len()), format!("{N}, one for each active joint"))
    })?;
    let links = links.each_ref().map(|link| DemLink {
        mass: link.mass_kg,
        inertia: link.inertia_kg_m2,
        length: link.length_m,
        centre_of_mass: link.centre_of_mass_m,
    });
    PlanarDem::new(DemBase { inertia: inertia_kg_m2, length: length_m }, links)
        .map_err(|error| check.refuse("model", error, "what a rigid body can have"))
}

fn space_manipulator<const N: usize>(
    manipulator: &file::SpaceManipulator,
    check: &Checker<'_>,
) -> Result<PlanarSpaceManipulator<f64, N>, RobotError> {
    let links: &[file::SpaceLink; N] = manipulator.links.as_slice().try_into().map_err(|_| {
        let found = format!("{} links", manipulator.links.len());
        check.refuse("space_manipulator.links", found, format!("{N}, one for each active joint"))
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
fn compare<const N: usize>(
    model: &PlanarDem<f64, N>,
    equivalent: &PlanarDem<f64, N>,
    check: &Checker<'_>,
) -> Result<(), RobotError> {
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
            (field("length_m"), link.length, if index + 1 < N { of_space.length } else { link.length }),
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
