//! The command line.

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::commands;
use crate::version::VERSION;

const EXIT_CODES: &str = "\
Exit codes: 0 ok, 1 failure, 2 wrong usage, 3 finished with a loss (deadlines missed, records dropped, a damaged log).
Results go to standard output (also as --json), diagnostics to standard error.
Nothing moves a motor unless an interface is named with --can.";

/// Adaptive robust control of free-floating space manipulators.
#[derive(Debug, Parser)]
#[command(name = "uarm", version = VERSION, about, after_help = EXIT_CODES, propagate_version = true)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands, one file each in [`commands`].
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the paper's experiment: on a simulated robot, or on real drives with --can
    Run(Box<commands::run::Arguments>),
    /// Run a recorded experiment again, bit for bit; or ask what another controller would have done
    Replay(Box<commands::replay::Arguments>),
    /// Look at a running controller: joints, torques, timing, bus and drives, from the log that it writes
    Monitor(commands::monitor::Arguments),
    /// Tell what is in the log of a run: summary, timing, faults, plots, CSV
    Show(commands::show::Arguments),
    /// Compare the controllers, beside the paper's Table 4, or on a thousand robots drawn around the UARM
    Compare(commands::compare::Arguments),
    /// Check a robot file before anything moves: task, limits and margins, bus time, heartbeats
    Check(commands::check::Arguments),
    /// Be the robot: emulated CANopen drives and their plant on a CAN interface
    Plant(commands::plant::Arguments),
    /// Commission drives: who is on the bus, which way a joint counts, where it is, does it move
    Drive(commands::drive::Arguments),
    /// Map a space manipulator to its dynamically equivalent manipulator (Table 1 to Table 2)
    Map(commands::map::Arguments),
    /// Compare the velocity estimators on the paper's motion
    Filters(commands::filters::Arguments),
    /// Tell whether the sampled loop is stable with its period, velocity estimator and delay
    Stability(commands::stability::Arguments),
    /// Look at this machine's real-time and CAN preconditions, and measure how late it wakes up
    Doctor(commands::doctor::Arguments),
    /// Draw faults by the thousand, and check that each run answers its own as it must
    Campaign(Box<commands::campaign::Arguments>),
    /// Explain a fault that ended a run: causes, what the log shows, what to do
    Explain(commands::explain::Arguments),
    /// Draw the paper's figures from simulated experiments, as SVG and PNG
    Figures(commands::figures::Arguments),
    /// Find friction, inertia, gain and tilt of a robot from recorded runs
    Identify(commands::identify::Arguments),
    /// Learn fuzzy sets from recorded runs with ANFIS
    Train(commands::train::Arguments),
    /// Print a completion script for a shell
    Completions(commands::completions::Arguments),
    /// Write the manual pages
    Man(commands::man::Arguments),
}

/// Runs a subcommand.
///
/// # Errors
/// Whatever made the command fail, with its context.
pub fn execute(command: &Command) -> anyhow::Result<ExitCode> {
    match command {
        Command::Run(arguments) => commands::run::execute(arguments),
        Command::Replay(arguments) => commands::replay::execute(arguments),
        Command::Monitor(arguments) => commands::monitor::execute(arguments),
        Command::Show(arguments) => commands::show::execute(arguments),
        Command::Compare(arguments) => commands::compare::execute(arguments),
        Command::Check(arguments) => commands::check::execute(arguments),
        Command::Plant(arguments) => commands::plant::execute(arguments),
        Command::Drive(arguments) => commands::drive::execute(arguments),
        Command::Map(arguments) => commands::map::execute(arguments),
        Command::Filters(arguments) => commands::filters::execute(arguments),
        Command::Stability(arguments) => commands::stability::execute(arguments),
        Command::Doctor(arguments) => commands::doctor::execute(arguments),
        Command::Campaign(arguments) => commands::campaign::execute(arguments),
        Command::Explain(arguments) => commands::explain::execute(arguments),
        Command::Figures(arguments) => commands::figures::execute(arguments),
        Command::Identify(arguments) => commands::identify::execute(arguments),
        Command::Train(arguments) => commands::train::execute(arguments),
        Command::Completions(arguments) => commands::completions::execute(arguments, CommandLine::command()),
        Command::Man(arguments) => commands::man::execute(arguments, CommandLine::command()),
    }
}
