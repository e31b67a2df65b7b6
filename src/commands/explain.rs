//! `uarm explain`: what a fault means, what causes it, what the log shows and what to do.

use std::io::Write;
use std::process::ExitCode;

use serde::Serialize;
use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;

use crate::console;
use crate::options::choice;

/// Arguments of `uarm explain`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  uarm explain                    all faults, a line each
  uarm explain tracking-error     causes, what the log shows, what to do

A report, its JSON (`fault_code`) and a log's end name the fault that ended a run.")]
pub struct Arguments {
    /// The fault; without it all are listed
    #[arg(value_parser = choice::<FaultCode>(), hide_possible_values = true, value_name = "FAULT")]
    fault: Option<FaultCode>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What is told of a fault.
#[derive(Debug, Serialize)]
struct Explanation {
    fault: FaultCode,
    meaning: &'static str,
    page: &'static str,
}

impl Explanation {
    fn new(fault: FaultCode) -> Self {
        Self { fault, meaning: fault.description(), page: page(fault) }
    }
}

/// Prints the page of a fault, or the list of all.
///
/// # Errors
/// If standard output cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    match (arguments.fault, arguments.json) {
        (Some(fault), true) => console::print_json(&Explanation::new(fault))?,
        (Some(fault), false) => write!(console::output(), "{}", page(fault))?,
        (None, true) => console::print_json(&FaultCode::ALL.iter().copied().map(Explanation::new).collect::<Vec<_>>())?,
        (None, false) => list(&mut console::output())?,
    }
    Ok(ExitCode::SUCCESS)
}

fn list(output: &mut impl Write) -> std::io::Result<()> {
    let width = FaultCode::ALL.iter().map(|fault| fault.name().len()).max().unwrap_or_default();
    for fault in FaultCode::ALL {
        writeln!(output, "{:<width$}  {}", fault.name(), fault.description())?;
    }
    Ok(())
}

/// The page of docs/faults, built in.
const fn page(fault: FaultCode) -> &'static str {
    macro_rules! pages {
        ($($fault:ident = $file:literal,)+) => {
            match fault {
                $(FaultCode::$fault => include_str!(concat!("../../docs/faults/", $file, ".md")),)+
            }
        };
    }
    pages! {
        LinkFailed = "link-failed",
        DriveNotFound = "drive-not-found",
        DriveRefused = "drive-refused",
        DriveNotReady = "drive-not-ready",
        WatchdogSilent = "watchdog-silent",
        StartPosition = "start-position",
        JointTurning = "joint-turning",
        ApproachImpossible = "approach-impossible",
        OtherMaster = "other-master",
        DriveRebooted = "drive-rebooted",
        TwoDrivesOneNode = "two-drives-one-node",
        FeedbackMissing = "feedback-missing",
        DriveNotEnabled = "drive-not-enabled",
        TargetIgnored = "target-ignored",
        DriveEmergency = "drive-emergency",
        DriveSilent = "drive-silent",
        DriveNotOperational = "drive-not-operational",
        SupplyVoltage = "supply-voltage",
        Temperature = "temperature",
        ReadingMissing = "reading-missing",
        EncoderImplausible = "encoder-implausible",
        JointAngle = "joint-angle",
        JointVelocity = "joint-velocity",
        TrackingError = "tracking-error",
        TorqueInvalid = "torque-invalid",
        NotFinite = "not-finite",
        TorqueSaturated = "torque-saturated",
        EncoderStuck = "encoder-stuck",
        TorqueReversed = "torque-reversed",
        ModelContradicted = "model-contradicted",
        Overrun = "overrun",
        StopUnconfirmed = "stop-unconfirmed",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_fault_has_its_own_page_with_causes_log_and_cures() {
        for fault in FaultCode::ALL {
            let page = page(*fault);
            assert!(page.starts_with(&format!("# `{}`: ", fault.name())), "{fault:?}: {page}");
            for heading in ["\n## Causes\n\n- ", "\n## In the log\n\n", "\n## What to do\n\n- "] {
                assert_eq!(page.matches(heading).count(), 1, "{fault:?}: {heading:?}");
            }
        }
    }

    #[test]
    fn every_page_is_that_of_a_fault() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/faults");
        let pages = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let faults = FaultCode::ALL.iter().map(|fault| format!("{}.md", fault.name()));
        assert_eq!(pages.collect::<BTreeSet<_>>(), faults.collect());
    }
}
