//! `uarm map`: from a space manipulator to its dynamically equivalent manipulator (paper eq. 1).

mod chains;
mod planar;
mod spatial;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;

use crate::console;
use crate::robot;
use crate::text_file;

/// Arguments of `uarm map`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Without FILE: the paper's Table 1 to its Table 2. FILE is a robot file, a file with a [space_manipulator] table alone, or a URDF of a serial arm in space:

  [space_manipulator]
  spacecraft = { mass_kg = 4.816, inertia_kg_m2 = 0.0153, centre_of_mass_to_joint_m = 0.253 }
  links = [ { mass_kg = 0.618, inertia_kg_m2 = 0.0075, joint_to_centre_of_mass_m = 0.120, centre_of_mass_to_joint_m = 0.118 } ]

Of a URDF, links joined by fixed joints become one body; meshes, transmissions and gravity are left out.

  uarm map arm.urdf --tip tool --dem-mjcf dem.xml        the equivalent manipulator, for MuJoCo
  uarm map iiwa.urdf --base-mass 200 --base-inertia 30,30,30    an arm that is described without a spacecraft")]
pub struct Arguments {
    /// The manipulator, one to eight links behind the spacecraft
    file: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: chains::Outputs,
    #[command(flatten)]
    choice: spatial::Choice,
}

/// Prints the equivalent manipulator, and writes what was asked for.
///
/// # Errors
/// If the file cannot be read or describes no manipulator, or a file cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let (path, text) = match &arguments.file {
        None => (Path::new(robot::BUILT_IN_NAME).to_owned(), robot::BUILT_IN.to_owned()),
        Some(path) => (
            path.clone(),
            text_file::read_up_to(path, robot::model::MOST_URDF_BYTES).with_context(|| path.display().to_string())?,
        ),
    };
    let named = || path.display().to_string();
    let is_urdf = path.extension().is_some_and(|extension| extension == "urdf" || extension == "xml");
    // A TOML file cannot begin so, and XML has to.
    if is_urdf || text.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
        let (report, chains) = spatial::map(&text, &arguments.choice).with_context(named)?;
        arguments.outputs.write(&chains, arguments.file.as_deref())?;
        if arguments.json { console::print_json(&report)? } else { report.print(&mut console::output())? }
    } else {
        if let Some(option) = arguments.choice.given() {
            anyhow::bail!("{}: {option} is for a URDF, and this is none", path.display());
        }
        match planar::map(&path, &text).with_context(named)? {
            planar::Mapped::InPlane(rows, chains) => {
                arguments.outputs.write(&chains, arguments.file.as_deref())?;
                if arguments.json { console::print_json(&rows)? } else { planar::print(&mut console::output(), &rows)? }
            }
            planar::Mapped::InSpace(report, chains) => {
                arguments.outputs.write(&chains, arguments.file.as_deref())?;
                if arguments.json { console::print_json(&report)? } else { report.print(&mut console::output())? }
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
