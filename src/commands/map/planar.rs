//! Space manipulators in the plane, from robot files.

use std::io::Write;
use std::path::Path;

use anyhow::Context;
use dem_model::{Joint, PlanarSpaceManipulator, SpaceLink, SpacecraftBody};
use serde::{Deserialize, Serialize};
use uarm_urdf::{Base, Names};

use super::chains::{Chains, MOST_LINKS};
use super::spatial;
use crate::robot::shape::Shape;
use crate::robot::{file, model};

/// One link of the dynamically equivalent manipulator, as printed.
#[derive(Debug, Serialize)]
pub struct Row {
    link: usize,
    /// Absent for link 1: the map does not define it and it has no effect.
    mass_kg: Option<f64>,
    inertia_kg_m2: f64,
    length_m: f64,
    centre_of_mass_m: f64,
}

/// What the command makes of a file.
pub enum Mapped {
    /// Of a manipulator in the plane.
    InPlane(Vec<Row>, Chains),
    /// Of a robot whose URDF is one in space.
    InSpace(spatial::Report, Chains),
}

#[derive(Deserialize)]
struct ManipulatorFile {
    space_manipulator: Option<file::SpaceManipulator>,
    model: Option<file::Model>,
}

/// What the command makes of the `text` of a robot file, or of a file with a `[space_manipulator]` table alone; `path` is where it was
/// read.
pub fn map(path: &Path, text: &str) -> anyhow::Result<Mapped> {
    let parsed: ManipulatorFile = toml::from_str(text)?;
    // A file with a table alone has no joints.
    if let (Ok(shape), None, Some(model)) = (Shape::of(path, text), &parsed.space_manipulator, &parsed.model)
        && shape != Shape::PAPER
        && let Some((urdf, part)) = model::urdf_and_part(path, model)?
    {
        let (report, chains) = spatial::map_selected(&urdf, &part)?;
        return Ok(Mapped::InSpace(report, chains));
    }
    let given = parsed.space_manipulator.is_some();
    let of_urdf = match parsed.model.filter(|_| !given) {
        Some(model) => model::urdf::<2>(path, &model)?,
        None => None,
    };
    let Some(manipulator) = parsed.space_manipulator.or(of_urdf) else {
        anyhow::bail!(
            "no [space_manipulator], and no [model] with a urdf: the numbers of [model] are what the map gives"
        );
    };
    let (rows, chains) = map_any(&manipulator).context("space_manipulator")?;
    Ok(Mapped::InPlane(rows, chains))
}

fn map_any(manipulator: &file::SpaceManipulator) -> anyhow::Result<(Vec<Row>, Chains)> {
    match manipulator.links.len() {
        1 => map_links::<1>(manipulator),
        2 => map_links::<2>(manipulator),
        3 => map_links::<3>(manipulator),
        4 => map_links::<4>(manipulator),
        5 => map_links::<5>(manipulator),
        6 => map_links::<6>(manipulator),
        7 => map_links::<7>(manipulator),
        8 => map_links::<8>(manipulator),
        count => anyhow::bail!("links: {count} given, expected 1 to {MOST_LINKS}"),
    }
}

fn map_links<const LINKS: usize>(manipulator: &file::SpaceManipulator) -> anyhow::Result<(Vec<Row>, Chains)> {
    let spacecraft = &manipulator.spacecraft;
    let spacecraft = SpacecraftBody {
        mass: spacecraft.mass_kg,
        inertia: spacecraft.inertia_kg_m2,
        centre_of_mass_to_joint: spacecraft.centre_of_mass_to_joint_m,
    };
    let links: [SpaceLink<f64>; LINKS] = std::array::from_fn(|index| {
        let link = &manipulator.links[index];
        SpaceLink {
            mass: link.mass_kg,
            inertia: link.inertia_kg_m2,
            joint_to_centre_of_mass: link.joint_to_centre_of_mass_m,
            centre_of_mass_to_joint: link.centre_of_mass_to_joint_m,
        }
    });
    let manipulator = PlanarSpaceManipulator::new(spacecraft, links)?;
    let equivalent = manipulator.dynamically_equivalent();
    let base = equivalent.base();
    let mut rows =
        vec![Row { link: 1, mass_kg: None, inertia_kg_m2: base.inertia, length_m: base.length, centre_of_mass_m: 0.0 }];
    rows.extend(equivalent.links().iter().enumerate().map(|(index, link)| Row {
        link: index + 2,
        mass_kg: Some(link.mass),
        inertia_kg_m2: link.inertia,
        length_m: link.length,
        centre_of_mass_m: link.centre_of_mass,
    }));
    Ok((rows, chains(&manipulator)?))
}

/// The manipulator in space.
fn chains<const LINKS: usize>(planar: &PlanarSpaceManipulator<f64, LINKS>) -> anyhow::Result<Chains> {
    let names = Names::numbered("space_manipulator", "spacecraft", LINKS);
    Ok(Chains::new(&names, Base::Planar, &planar.in_space(), &[Joint::about_z(); LINKS]))
}

/// Prints the equivalent manipulator.
pub fn print(output: &mut impl Write, rows: &[Row]) -> std::io::Result<()> {
    writeln!(output, "dynamically equivalent manipulator (paper eq. 1)")?;
    writeln!(output, "{:>5}  {:>12}  {:>14}  {:>12}  {:>12}", "link", "m (kg)", "I (kg m^2)", "W (m)", "lc (m)")?;
    for row in rows {
        let mass = row.mass_kg.map_or_else(|| "free".to_owned(), |mass| format!("{mass:.6}"));
        writeln!(
            output,
            "{:>5}  {mass:>12}  {:>14.6}  {:>12.6}  {:>12.7}",
            row.link, row.inertia_kg_m2, row.length_m, row.centre_of_mass_m
        )?;
    }
    writeln!(output, "the mass of link 1 is not defined by the map and has no effect: its centre lies on joint 1")
}
