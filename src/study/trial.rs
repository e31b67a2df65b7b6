//! One experiment in virtual time, on a plant of one's choice.

use hinf_control::Disturbance;

use sim::{InProcessLink, Pacing, VirtualClock};

use super::contestant::Entrant;
use crate::control_loop::LoopEnd;
use crate::control_loop::progress::Progress;
use crate::control_loop::record::NoRecorder;
use crate::control_loop::schedule::OverrunPolicy;
use crate::control_loop::task_clock::PeriodSource;
use crate::control_loop::torque::DisturbanceSite;
use crate::controllers::AdaptationGuard;
use crate::experiment::embedded::{self, EmbeddedPlant};
use crate::experiment::{self, Outcome, Settings};
use crate::signals::StopRequest;

/// How a trial went.
#[derive(Debug)]
pub enum Trial {
    /// To its end.
    Completed(Box<Outcome>),
    /// The robot's limits ended it.
    Failed(anyhow::Error),
}

/// Runs one experiment with `entrant`'s controller on `plant`, which brings its disturbance along: what
/// `uarm run --virtual-time` does, without recording.
///
/// # Errors
/// If the experiment cannot be begun.
pub fn run(entrant: &Entrant, plant: EmbeddedPlant) -> anyhow::Result<Trial> {
    let Entrant { contestant, robot } = entrant;
    let settings = Settings {
        law: contestant.law(),
        guard: AdaptationGuard::None,
        approach: None,
        overrun: OverrunPolicy::default(),
        period_source: PeriodSource::Scheduled,
        // Only recorded: the disturbance itself is the plant's.
        disturbance: Disturbance::None,
        disturbance_site: DisturbanceSite::Plant,
    };
    let mut clock = VirtualClock::new();
    let link = InProcessLink::new(embedded::emulate(robot, plant, Pacing::WallClock)?, clock.clone());
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let (finished, NoRecorder) = experiment::run(robot, &settings, link, &mut clock, NoRecorder, &progress, &stop)?;
    Ok(match finished.end {
        Ok(LoopEnd::Completed) => Trial::Completed(Box::new(finished.outcome)),
        Ok(LoopEnd::Interrupted) => Trial::Failed(anyhow::anyhow!("interrupted")),
        Err(error) => Trial::Failed(error),
    })
}
