//! Space manipulators in space, from URDF.

use std::io::Write;

use anyhow::Context;
use dem_model::JointMotion;
use dem_model::nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use uarm_urdf::{Arm, ArmJoint, ArmLink, Base, Names, Selection, Spacecraft};

use super::chains::{Chains, MOST_LINKS};
use crate::console::in_one_line;
use crate::robot::model;

/// Which part of a URDF is meant.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Of a URDF")]
pub struct Choice {
    /// The link that is the spacecraft [default: the root]
    #[arg(long, value_name = "LINK")]
    base: Option<String>,
    /// The link whose frame is the end effector's [default: the only end of the arm]
    #[arg(long, value_name = "LINK")]
    tip: Option<String>,
    /// The mass in kg of a spacecraft that the file does not have, at the origin of the base link; it is added to what that link has
    #[arg(long, value_name = "KG", requires = "base_inertia", allow_negative_numbers = true)]
    base_mass: Option<f64>,
    /// Its inertia in kg m^2, as IXX,IYY,IZZ or IXX,IYY,IZZ,IXY,IXZ,IYZ
    #[arg(long, value_name = "NUMBERS", requires = "base_mass", value_parser = inertia, allow_hyphen_values = true)]
    base_inertia: Option<Matrix3<f64>>,
}

fn inertia(text: &str) -> Result<Matrix3<f64>, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([xx, yy, zz]) => Ok(Matrix3::from_diagonal(&Vector3::new(*xx, *yy, *zz))),
        Ok([xx, yy, zz, xy, xz, yz]) => Ok(Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)),
        _ => Err("expected three or six numbers with commas between them, such as 9.3,9.3,9.3".to_owned()),
    }
}

impl Choice {
    /// The first option given, by its name.
    pub fn given(&self) -> Option<&'static str> {
        [(self.base.is_some(), "--base"), (self.tip.is_some(), "--tip"), (self.base_mass.is_some(), "--base-mass")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
    }

    fn selection(&self) -> anyhow::Result<Selection> {
        let given = |(mass, inertia)| {
            Spacecraft::new(mass, inertia).context(
                "--base-mass, --base-inertia: expected a mass above 0 and the inertia of a body: positive definite, no principal moment larger than the two others together",
            )
        };
        let spacecraft = self.base_mass.zip(self.base_inertia).map(given).transpose()?;
        Ok(Selection { base: self.base.clone(), tip: self.tip.clone(), spacecraft })
    }
}

/// A URDF's manipulator and its equivalent, as printed.
#[derive(Debug, Serialize)]
pub struct Report {
    robot: String,
    /// Mass of spacecraft and arm.
    total_mass_kg: f64,
    /// The spacecraft, then the arm's links, each about its inboard joint (the spacecraft about its centre of mass).
    space_manipulator: Vec<BodyRow>,
    /// The base, then the arm's links.
    dynamically_equivalent: Vec<BodyRow>,
    joints: Vec<JointRow>,
    /// Joints beside the arm, taken as fixed at zero.
    locked_joints: Vec<String>,
    /// Links whose inertia no body can have: taken as they stand.
    impossible_inertias: Vec<String>,
    /// Whether [`Self::dynamically_equivalent`] can be written as URDF and MJCF: no joint slides.
    equivalent_can_be_written: bool,
}

/// A body in axes of the base while all coordinates are zero.
#[derive(Debug, Serialize)]
struct BodyRow {
    link: String,
    /// Links that are fixed to it.
    merged: Vec<String>,
    /// Absent for the base of the DEM: the map does not define it and it has no effect.
    mass_kg: Option<f64>,
    /// About the centre of mass: xx, yy, zz, xy, xz, yz.
    inertia_kg_m2: [f64; 6],
    /// From the inboard joint.
    centre_of_mass_m: [f64; 3],
    /// From the inboard joint to the next one, or to the end effector.
    length_m: [f64; 3],
}

#[derive(Debug, Serialize)]
struct JointRow {
    joint: String,
    motion: &'static str,
    axis: [f64; 3],
    /// Absent where the file has no limit.
    limits: Option<LimitsRow>,
}

#[derive(Debug, Serialize)]
struct LimitsRow {
    lower: Option<f64>,
    upper: Option<f64>,
    effort: f64,
    velocity: f64,
}

impl BodyRow {
    fn new(
        link: &ArmLink,
        mass: Option<f64>,
        inertia: &Matrix3<f64>,
        centre: &Vector3<f64>,
        length: &Vector3<f64>,
    ) -> Self {
        Self {
            link: link.name.clone(),
            merged: link.merged.clone(),
            mass_kg: mass,
            inertia_kg_m2: [inertia.m11, inertia.m22, inertia.m33, inertia.m12, inertia.m13, inertia.m23],
            centre_of_mass_m: (*centre).into(),
            length_m: (*length).into(),
        }
    }
}

fn motion(joint: &ArmJoint) -> &'static str {
    match joint.motion {
        JointMotion::Revolute => "revolute",
        JointMotion::Prismatic => "prismatic",
    }
}

/// What the command makes of the text of a URDF.
pub fn map(text: &str, choice: &Choice) -> anyhow::Result<(Report, Chains)> {
    map_selected(text, &choice.selection()?)
}

/// The same of the part that `selection` says.
pub fn map_selected(text: &str, selection: &Selection) -> anyhow::Result<(Report, Chains)> {
    let arm = Arm::parse(text, selection).map_err(hinted)?;
    match arm.joints.len() {
        1 => map_joints::<1>(&arm),
        2 => map_joints::<2>(&arm),
        3 => map_joints::<3>(&arm),
        4 => map_joints::<4>(&arm),
        5 => map_joints::<5>(&arm),
        6 => map_joints::<6>(&arm),
        7 => map_joints::<7>(&arm),
        8 => map_joints::<8>(&arm),
        count => anyhow::bail!("{count} joints between base and tip, expected 1 to {MOST_LINKS}"),
    }
}

/// The option that helps, beside the error.
fn hinted(error: uarm_urdf::UrdfError) -> anyhow::Error {
    use uarm_urdf::UrdfError::{JointKind, NoSpacecraft, NotOutboard, Roots, Tips, Unknown};
    let hint = match &error {
        Tips { .. } => Some("--tip LINK names it".to_owned()),
        Roots { .. } => Some("--base LINK names the spacecraft".to_owned()),
        NotOutboard { .. } | Unknown { .. } => Some("--base and --tip name links".to_owned()),
        NoSpacecraft { .. } => {
            Some("--base-mass and --base-inertia give a spacecraft to an arm that is described without one".to_owned())
        }
        JointKind { kind, child, .. } if kind == "floating" => {
            Some(format!("--base {child:?} if that is the spacecraft"))
        }
        _ => None,
    };
    match hint {
        Some(hint) => anyhow::anyhow!("{error} ({hint})"),
        None => error.into(),
    }
}

fn map_joints<const N: usize>(arm: &Arm) -> anyhow::Result<(Report, Chains)> {
    let (manipulator, joints) = arm.space_manipulator::<N>().context("the arm")?;
    let names = Names {
        robot: arm.name.clone(),
        first: arm.spacecraft.name.clone(),
        links: arm
            .joints
            .iter()
            .zip(&arm.links)
            .map(|(joint, link)| (joint.name.clone(), joint.limits, link.name.clone()))
            .collect(),
    };
    let dem = manipulator.dynamically_equivalent();
    let (spacecraft, base) = (manipulator.spacecraft(), dem.base());
    let none = Vector3::zeros();
    let first = &arm.spacecraft;
    let mut space = vec![BodyRow::new(
        first,
        Some(spacecraft.mass),
        &spacecraft.inertia,
        &none,
        &spacecraft.centre_of_mass_to_joint,
    )];
    let mut equivalent = vec![BodyRow::new(first, None, &base.inertia, &none, &base.length)];
    for ((link, of_space), of_dem) in arm.links.iter().zip(manipulator.links()).zip(dem.links()) {
        let centre = &of_space.joint_to_centre_of_mass;
        let length = centre + of_space.centre_of_mass_to_joint;
        space.push(BodyRow::new(link, Some(of_space.mass), &of_space.inertia, centre, &length));
        equivalent.push(BodyRow::new(link, Some(of_dem.mass), &of_dem.inertia, &of_dem.centre_of_mass, &of_dem.length));
    }
    let joint_rows = arm.joints.iter().zip(&joints).map(|(joint, checked)| JointRow {
        joint: joint.name.clone(),
        motion: motion(joint),
        axis: checked.axis().into_inner().into(),
        limits: joint.limits.map(|limits| LimitsRow {
            lower: limits.lower,
            upper: limits.upper,
            effort: limits.effort,
            velocity: limits.velocity,
        }),
    });
    let chains = Chains::new(&names, Base::Spherical, &manipulator, &joints);
    let report = Report {
        robot: arm.name.clone(),
        total_mass_kg: manipulator.total_mass(),
        space_manipulator: space,
        dynamically_equivalent: equivalent,
        joints: joint_rows.collect(),
        locked_joints: arm.locked.clone(),
        impossible_inertias: arm.impossible_inertias(),
        equivalent_can_be_written: chains.has_equivalent(),
    };
    Ok((report, chains))
}

impl Report {
    /// Prints it.
    pub fn print(&self, output: &mut impl Write) -> std::io::Result<()> {
        writeln!(output, "{}: {} joints, {:.6} kg", in_one_line(&self.robot), self.joints.len(), self.total_mass_kg)?;
        writeln!(output, "vectors in axes of the base while all coordinates are zero")?;
        for joint in &self.joints {
            let limits = match &joint.limits {
                None => "no limits in the file: they come from the robot file".to_owned(),
                Some(limits) => format!(
                    "{}; {} at most {}/s",
                    match (limits.lower, limits.upper) {
                        (Some(lower), Some(upper)) => format!("{lower} to {upper}"),
                        _ => "no range".to_owned(),
                    },
                    limits.effort,
                    limits.velocity
                ),
            };
            writeln!(
                output,
                "  joint {}: {}, axis {}, {limits}",
                in_one_line(&joint.joint),
                joint.motion,
                vector(&joint.axis)
            )?;
        }
        for joint in &self.locked_joints {
            writeln!(output, "  joint {}: beside the arm, taken as fixed at zero", in_one_line(joint))?;
        }
        for link in &self.impossible_inertias {
            writeln!(output, "  {}", model::impossible_inertia(link))?;
        }
        writeln!(output, "space manipulator")?;
        print_bodies(output, &self.space_manipulator)?;
        writeln!(output, "dynamically equivalent manipulator (paper eq. 1)")?;
        print_bodies(output, &self.dynamically_equivalent)?;
        if !self.equivalent_can_be_written {
            writeln!(
                output,
                "a prismatic joint moves the equivalent's link by a part of its coordinate, which neither URDF nor MJCF can say"
            )?;
        }
        Ok(())
    }
}

fn vector(numbers: &[f64]) -> String {
    // A number that rounds to zero is printed without a sign.
    let print = |number: &f64| format!("{:.6}", if number.abs() < 5e-7 { 0.0 } else { *number });
    numbers.iter().map(print).collect::<Vec<_>>().join(" ")
}

fn print_bodies(output: &mut impl Write, rows: &[BodyRow]) -> std::io::Result<()> {
    for row in rows {
        let mass = row.mass_kg.map_or_else(|| "mass free".to_owned(), |mass| format!("{mass:.6} kg"));
        let merged = if row.merged.is_empty() {
            String::new()
        } else {
            format!(" with {}", in_one_line(&row.merged.join(", ")))
        };
        writeln!(output, "  {}{merged}: {mass}", in_one_line(&row.link))?;
        writeln!(output, "    I (kg m^2) xx yy zz xy xz yz  {}", vector(&row.inertia_kg_m2))?;
        writeln!(output, "    centre of mass (m)            {}", vector(&row.centre_of_mass_m))?;
        writeln!(output, "    to the next joint (m)         {}", vector(&row.length_m))?;
    }
    Ok(())
}
