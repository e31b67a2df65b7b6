//! `uarm drive`: commissioning, one drive or one bus at a time.

mod check;
mod confirmation;
mod direction;
mod enabled;
mod patient_link;
mod profiles;
mod reference;
mod scan;
mod torque_test;

use std::process::ExitCode;

/// Arguments of `uarm drive`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    command: Command,
}

/// The steps of commissioning, a file or folder each.
#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Tell who is on the bus: nodes, identities, NMT states, cyclic traffic, emergencies, masters at work
    Scan(scan::Arguments),
    /// Judge a drive by its dictionary file or by itself: what it lacks, what helps, its entry in the robot file
    Check(check::Arguments),
    /// List the drive profiles that a robot file can name, or print one
    Profiles(profiles::Arguments),
    /// Tell which way a joint counts, while somebody turns it with the motor off
    Direction(direction::Arguments),
    /// Tell where the joints with incremental encoders are, in a pose that somebody confirms, or by a drive's own homing
    Reference(reference::Arguments),
    /// Put a small torque on one joint, watched: does it move, and which way does it count then? THE MOTOR MOVES
    TorqueTest(torque_test::Arguments),
}

/// Runs a step.
///
/// # Errors
/// Whatever made the step fail, with its context.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    match &arguments.command {
        Command::Scan(arguments) => scan::execute(arguments),
        Command::Check(arguments) => check::execute(arguments),
        Command::Profiles(arguments) => profiles::execute(arguments),
        Command::Direction(arguments) => direction::execute(arguments),
        Command::Reference(arguments) => reference::execute(arguments),
        Command::TorqueTest(arguments) => torque_test::execute(arguments),
    }
}
