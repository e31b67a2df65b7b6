//! `uarm drive check`: whether a drive can be used, from its dictionary file or from the drive itself, and with what entry of
//! the robot file.

mod candidate;
mod judgement;
mod over_sdo;
mod report;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uarm_eds::Dictionary;
use uarm_io::drive::NodeId;
use uarm_io::drive::plan::survey_of;
use uarm_io::socketcan_link::InterfaceName;

use crate::console;
use crate::eds::{self, DictionaryObjects};
use crate::exit::Exit;
use crate::options::node_id;
use candidate::Candidate;
use judgement::{Judgement, Outcome, judge};
use report::Report;

/// Arguments of `uarm drive check`.
#[derive(Debug, clap::Args)]
#[command(
    group(clap::ArgGroup::new("source").required(true).args(["eds", "can"])),
    after_help = "\
Each row is a question of docs/wire.md, section 10. What is printed last is the joint's entry of the robot file, with all that this
drive needs. A drive on the bus is read by SDO and not written to.
Exit codes: 0 it works as the robot file has it, 3 it works with the entry that is printed, 1 it cannot be used.
Examples:
  uarm drive check --eds drive.eds
  uarm drive check --eds drive.dcf --node 3 --robot my-robot.toml --json
  uarm drive check --can can0 --node 2 --robot my-robot.toml")]
pub struct Arguments {
    /// The maker's dictionary, an EDS or DCF file
    #[arg(long, value_name = "FILE")]
    eds: Option<PathBuf>,
    /// The CAN interface on which the drive is
    #[arg(long, value_name = "INTERFACE", requires = "node")]
    can: Option<InterfaceName>,
    /// The drive's node id; without it that of the DCF, or of the first driven joint
    #[arg(long, value_parser = node_id, value_name = "1..126")]
    node: Option<NodeId>,
    /// The robot file whose joint the drive is to move; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Judges a drive.
///
/// # Errors
/// If a file cannot be read, or the drive does not answer.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let (report, outcome) = match (&arguments.eds, arguments.can) {
        (Some(file), _) => of_dictionary(file, arguments)?,
        (None, Some(interface)) => of_drive(interface, arguments)?,
        (None, None) => anyhow::bail!("a dictionary or an interface is needed"),
    };
    if arguments.json {
        console::print_json(&report)?;
    } else {
        write!(console::output(), "{report}")?;
    }
    let exit = match outcome {
        Outcome::Works => Exit::Ok,
        Outcome::WorksWith => Exit::Loss,
        Outcome::Cannot => Exit::Failure,
    };
    Ok(exit.into())
}

fn of_dictionary(file: &Path, arguments: &Arguments) -> anyhow::Result<(Report, Outcome)> {
    let dictionary = eds::read(file)?;
    let node = arguments.node.map(NodeId::raw).or(dictionary.node());
    let mut candidate = Candidate::new(arguments.robot.as_deref(), node)?;
    let mut objects = DictionaryObjects::new(&dictionary, candidate.node()?.raw());
    let judgement = judge(&mut candidate, |drive| {
        let Ok(survey) = survey_of(&mut objects, drive);
        Ok(survey)
    })?;
    report(name_of(&dictionary), &judgement, &candidate)
}

fn of_drive(interface: InterfaceName, arguments: &Arguments) -> anyhow::Result<(Report, Outcome)> {
    let mut candidate = Candidate::new(arguments.robot.as_deref(), arguments.node.map(NodeId::raw))?;
    let node = candidate.node()?;
    let mut drive = over_sdo::Drive::open(interface, node, candidate.patience()?)?;
    let judgement = judge(&mut candidate, |wishes| Ok(drive.survey(wishes)?))?;
    report(format!("the drive on {interface}"), &judgement, &candidate)
}

fn report(drive: String, judgement: &Judgement, candidate: &Candidate) -> anyhow::Result<(Report, Outcome)> {
    Ok((Report::new(drive, judgement, candidate)?, judgement.outcome))
}

fn name_of(dictionary: &Dictionary) -> String {
    let device = dictionary.device();
    let names = [&device.vendor_name, &device.product_name];
    let names: Vec<&str> = names.into_iter().flatten().map(String::as_str).collect();
    let names = if names.is_empty() { "a drive without a name".to_owned() } else { names.join(", ") };
    format!("{} ({names})", dictionary.file())
}
