//! `uarm map`: from a space manipulator to its dynamically equivalent manipulator (paper eq. 1).

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use dem_model::{PlanarSpaceManipulator, SpaceLink, SpacecraftBody};
use serde::{Deserialize, Serialize};

use crate::console;
use crate::robot::{self, file};
use crate::text_file;

/// The longest arm that the command maps: one monomorphic copy of the map exists for each length.
const MOST_LINKS: usize = 8;

/// Arguments of `uarm map`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Without FILE: the paper's Table 1 to its Table 2. FILE is a robot file, or a file with a [space_manipulator] table alone:

  [space_manipulator]
  spacecraft = { mass_kg = 4.816, inertia_kg_m2 = 0.0153, centre_of_mass_to_joint_m = 0.253 }
  links = [ { mass_kg = 0.618, inertia_kg_m2 = 0.0075, joint_to_centre_of_mass_m = 0.120, centre_of_mass_to_joint_m = 0.118 } ]")]
pub struct Arguments {
    /// The manipulator, one to eight links behind the spacecraft
    file: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// One link of the dynamically equivalent manipulator, as printed.
#[derive(Debug, Serialize)]
struct Row {
    link: usize,
    /// Absent for link 1: the map does not define it and it has no effect.
    mass_kg: Option<f64>,
    inertia_kg_m2: f64,
    length_m: f64,
    centre_of_mass_m: f64,
}

#[derive(Deserialize)]
struct ManipulatorFile {
    space_manipulator: file::SpaceManipulator,
}

/// Prints the equivalent manipulator.
///
/// # Errors
/// If the file cannot be read or describes no manipulator.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let (path, text) = match &arguments.file {
        None => (Path::new(robot::BUILT_IN_NAME).to_owned(), robot::BUILT_IN.to_owned()),
        Some(path) => (path.clone(), text_file::read(path).with_context(|| path.display().to_string())?),
    };
    let parsed: ManipulatorFile = toml::from_str(&text).with_context(|| path.display().to_string())?;
    let rows = map(&parsed.space_manipulator).with_context(|| format!("{}: space_manipulator", path.display()))?;
    if arguments.json {
        console::print_json(&rows)?;
    } else {
        print(&mut console::output(), &rows)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn map(manipulator: &file::SpaceManipulator) -> anyhow::Result<Vec<Row>> {
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

fn map_links<const LINKS: usize>(manipulator: &file::SpaceManipulator) -> anyhow::Result<Vec<Row>> {
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
    let equivalent = PlanarSpaceManipulator::new(spacecraft, links)?.dynamically_equivalent();
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
    Ok(rows)
}

fn print(output: &mut impl Write, rows: &[Row]) -> std::io::Result<()> {
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
