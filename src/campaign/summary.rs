//! What came of a campaign, by kind of fault.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

use super::store::{CampaignHeader, Trials};
use super::trial::Trial;

/// What came of a campaign.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// What it is of.
    pub campaign: CampaignHeader,
    /// Trials that were made.
    pub trials: usize,
    /// The kinds of fault, by name.
    pub faults: BTreeMap<String, FaultSummary>,
    /// Trials in which something was not as it must be.
    pub failed: Vec<Trial>,
}

/// What came of the trials with one kind of fault.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FaultSummary {
    /// Trials.
    pub trials: usize,
    /// How they ended, by name.
    pub ends: BTreeMap<String, usize>,
    /// The longest time from the fault to closed brakes, ms.
    pub slowest_reaction_ms: Option<f64>,
    /// Trials in which something was not as it must be.
    pub failed: usize,
}

impl Summary {
    /// The summary of `trials`.
    pub fn new(trials: &Trials) -> Self {
        let mut faults: BTreeMap<String, FaultSummary> = BTreeMap::new();
        for trial in &trials.results {
            faults.entry(trial.fault.clone()).or_default().add(trial);
        }
        let failed = trials.results.iter().filter(|trial| !trial.is_good()).cloned().collect();
        Self { campaign: trials.header.clone(), trials: trials.results.len(), faults, failed }
    }

    /// Prints it for people.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn print(&self, output: &mut impl Write) -> io::Result<()> {
        let CampaignHeader { robot, first_seed, seeds, .. } = &self.campaign;
        let last = first_seed + seeds.saturating_sub(1);
        writeln!(output, "{robot}: {} trials of the seeds {first_seed} to {last}", self.trials)?;
        writeln!(output, "  {:<20} {:>6} {:>6} {:>12}  ends", "fault", "trials", "failed", "slowest (ms)")?;
        for (name, fault) in &self.faults {
            let slowest = fault.slowest_reaction_ms.map_or_else(|| "-".to_owned(), |slowest| format!("{slowest:.2}"));
            let ends: Vec<_> = fault.ends.iter().map(|(end, count)| format!("{end} {count}")).collect();
            let (trials, failed) = (fault.trials, fault.failed);
            writeln!(output, "  {name:<20} {trials:>6} {failed:>6} {slowest:>12}  {}", ends.join(", "))?;
        }
        for trial in self.failed.iter().take(MOST_FAILURES) {
            let Trial { seed, controller, detail, joint, at_s, violations, .. } = trial;
            writeln!(output, "FAILED seed {seed}: {controller}, {detail}, joint {joint}, at {at_s:.3} s")?;
            for violation in violations {
                writeln!(output, "  {violation}")?;
            }
            writeln!(output, "  again, with the same robot file: uarm campaign --first {seed} --seeds 1")?;
        }
        match self.failed.len() {
            _ if self.trials == 0 => writeln!(output, "no seed is in this part: nothing was tried"),
            0 => writeln!(output, "everything was as it must be"),
            failed => writeln!(output, "{failed} of {} trials failed", self.trials),
        }
    }
}

/// Failed trials that are told one by one; all are counted, and are in JSON and file.
const MOST_FAILURES: usize = 20;

impl FaultSummary {
    fn add(&mut self, trial: &Trial) {
        self.trials += 1;
        *self.ends.entry(trial.end.clone()).or_default() += 1;
        self.failed += usize::from(!trial.is_good());
        let slowest = self.slowest_reaction_ms.into_iter().chain(trial.reaction_ms);
        self.slowest_reaction_ms = slowest.reduce(f64::max);
    }
}
