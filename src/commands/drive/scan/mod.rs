//! `uarm drive scan`: who is on the bus. It listens, then asks; it commands nothing.

mod identity;
mod survey;
mod text;

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{InterfaceName, Reception, SocketCanLink};

use super::patient_link::PatientLink;
use crate::console;
use crate::exit::Exit;
use crate::signals;
use survey::{Asking, Scan};

/// Arguments of `uarm drive scan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
First it listens and sends nothing. Then it asks node ids 1 to 126 who they are, by SDO uploads: no NMT command, no SYNC.
It does not ask where a master is at work, or where the interface reports errors: is this the bus's bit rate?
Exit code 1 if no node was found.
Examples:
  uarm drive scan --can can0                  listen for 3 s, then ask
  uarm drive scan --can can0 --passive --seconds 60 --json")]
pub struct Arguments {
    /// The CAN interface
    #[arg(long, value_name = "INTERFACE")]
    can: InterfaceName,
    /// How long to listen
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=86_400), value_name = "N")]
    seconds: u32,
    /// Only listen: send nothing at all
    #[arg(long, conflicts_with = "active")]
    passive: bool,
    /// Ask for identities also where a master is at work or the interface reports errors
    #[arg(long)]
    active: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Scans the bus and prints who is there.
///
/// # Errors
/// If the interface cannot be used or goes away.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let stop = signals::stop_request().context("signal handlers")?;
    let mut link = PatientLink(SocketCanLink::open(arguments.can, Reception::Everything)?);
    let asking = match (arguments.passive, arguments.active) {
        (true, _) => Asking::Never,
        (false, true) => Asking::Always,
        (false, false) => Asking::UnlessDisturbing,
    };
    let listening = Duration::from_secs(arguments.seconds.into());
    console::tell(format_args!("listening on {} for {} s", arguments.can, arguments.seconds));
    let scan = Scan::make(&mut link, &MonotonicClock, listening, asking, &stop)?;
    if arguments.json {
        console::print_json(&scan)?;
    } else {
        console::output().write_all(text::scan(&arguments.can.to_string(), &scan).as_bytes())?;
    }
    Ok(if scan.nodes().is_empty() { Exit::Failure } else { Exit::Ok }.into())
}
