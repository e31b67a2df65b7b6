//! `uarm drive profiles`: the drive profiles that are built in.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::builder::PossibleValuesParser;
use serde::Serialize;

use crate::console;
use crate::robot::profile::{Profile, SHIPPED};

/// Arguments of `uarm drive profiles`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A robot file names one in a joint's drive: `profile = \"elmo-gold\"`. What the robot file says itself wins. None has been tried on
hardware: `uarm drive check` tells what the drive at hand says.
Examples:
  uarm drive profiles
  uarm drive profiles elmo-gold > my-drive.toml     to change it, and name it as `profile = \"./my-drive.toml\"`")]
pub struct Arguments {
    /// Print this profile, as a file
    #[arg(value_parser = PossibleValuesParser::new(SHIPPED.map(|(name, _)| name)), value_name = "PROFILE", conflicts_with = "json")]
    profile: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Row {
    name: &'static str,
    drives: String,
    evidence: String,
    text: &'static str,
}

/// Lists the profiles, or prints one.
///
/// # Errors
/// If standard output cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let mut output = console::output();
    if let Some(name) = &arguments.profile {
        let found = SHIPPED.iter().find(|(shipped, _)| shipped == name);
        write!(output, "{}", found.map_or("", |(_, text)| text))?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows = SHIPPED.iter().map(|(name, text)| {
        let Profile { drives, evidence, .. } = Profile::parse(Path::new(name), text)?;
        Ok(Row { name, drives, evidence, text })
    });
    let rows = rows.collect::<anyhow::Result<Vec<Row>>>()?;
    if arguments.json {
        console::print_json(&rows)?;
    } else {
        for Row { name, drives, evidence, .. } in rows {
            writeln!(output, "{name:<12}  {drives}: {evidence}")?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
