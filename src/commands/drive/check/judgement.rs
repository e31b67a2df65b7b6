//! The plan for a drive, again and again with what it asks for, until it asks for nothing more.

use uarm_io::drive::plan::{Finding, Plan, Question, Verdict};
use uarm_io::drive::survey::Survey;
use uarm_io::drive::wishes::DriveConfiguration;
use uarm_io::drive::words::Named;

use super::candidate::Candidate;

/// One remedy can bring up the next question, but not for ever.
const MOST_ROUNDS: usize = 16;

/// What it comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As the robot file has it.
    Works,
    /// With the entry as it has become.
    WorksWith,
    /// Not at all.
    Cannot,
}

/// A question, what was found for it at first, and all that helps.
#[derive(Clone, Debug)]
pub struct Row {
    /// The finding for the robot file as it was given, or the one that cannot be helped.
    pub finding: Finding,
    /// What was changed for it.
    pub remedies: Vec<String>,
}

/// The rows, and what they come to.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// One for each question.
    pub rows: Vec<Row>,
    /// What they come to.
    pub outcome: Outcome,
}

/// Judges a drive of which `survey` tells, and changes the candidate as the drive needs it.
///
/// # Errors
/// If the drive cannot be asked, or the robot file is refused.
pub fn judge(
    candidate: &mut Candidate,
    mut survey: impl FnMut(&DriveConfiguration) -> anyhow::Result<Survey>,
) -> anyhow::Result<Judgement> {
    let mut judgement = Judgement { rows: Vec::new(), outcome: Outcome::Works };
    for _ in 0..MOST_ROUNDS {
        let plan = plan_for(candidate, &mut survey)?;
        if judgement.rows.is_empty() {
            judgement.rows =
                plan.findings.iter().map(|finding| Row { finding: *finding, remedies: Vec::new() }).collect();
        }
        if plan.refusal().is_none() {
            return Ok(judgement);
        }
        judgement.outcome = judgement.outcome.max_with(Outcome::WorksWith);
        let mut has_changed = false;
        for finding in plan.findings.iter().filter(|finding| finding.refuses_start()) {
            let Some(row) = judgement.rows.iter_mut().find(|row| row.finding.question == finding.question) else {
                continue;
            };
            match help(candidate, finding)?.filter(|remedy| !row.remedies.contains(remedy)) {
                Some(remedy) => {
                    row.remedies.push(remedy);
                    has_changed = true;
                }
                None => {
                    *row = Row { finding: Finding { verdict: Verdict::Cannot, ..*finding }, remedies: Vec::new() };
                    judgement.outcome = Outcome::Cannot;
                }
            }
        }
        if !has_changed {
            break;
        }
    }
    judgement.outcome = Outcome::Cannot;
    Ok(judgement)
}

/// Changes the candidate as a finding needs it, and tells how; `None` if nothing that it can say helps.
fn help(candidate: &mut Candidate, finding: &Finding) -> anyhow::Result<Option<String>> {
    // A robot file that was made for another drive.
    if finding.question == Question::Writes && candidate.leave_out(finding.object)? {
        return Ok(Some(format!("drive.writes without {}", Named(finding.object))));
    }
    let is_helped = finding.verdict != Verdict::Cannot && candidate.apply(&finding.remedy)?;
    Ok(is_helped.then(|| finding.remedy.to_string()))
}

fn plan_for(
    candidate: &Candidate,
    survey: &mut impl FnMut(&DriveConfiguration) -> anyhow::Result<Survey>,
) -> anyhow::Result<Plan> {
    let (drive, network) = candidate.wishes()?;
    Ok(network.plan(&survey(&drive)?, &drive))
}

impl Outcome {
    const fn max_with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Cannot, _) | (_, Self::Cannot) => Self::Cannot,
            (Self::WorksWith, _) | (_, Self::WorksWith) => Self::WorksWith,
            (Self::Works, Self::Works) => Self::Works,
        }
    }
}
