//! A run on a simulated robot in virtual time: what `uarm run --virtual-time` does, in this process, without a log.

use anyhow::Context;
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::record::Recorder;
use uarm_loop::run::{Observer, run};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{InProcessLink, Pacing, VirtualClock};

use crate::dimensions::{ACTIVE, JOINTS, Outcome, Progress};
use crate::robot::Robot;
use crate::simulated_robot::{SimulatedPlant, emulate};

/// How a simulated run ended.
#[derive(Debug)]
pub enum SimulatedEnd {
    /// The motion was completed.
    Completed(Box<Outcome>),
    /// A limit of the robot ended it.
    Failed(anyhow::Error),
}

/// Runs one experiment on `plant`, which brings its disturbance along.
///
/// # Errors
/// If the experiment cannot be begun.
pub fn simulate<R: Recorder<JOINTS, ACTIVE>>(
    robot: &Robot,
    settings: &Settings,
    plant: SimulatedPlant,
    recorder: R,
) -> anyhow::Result<(SimulatedEnd, R)> {
    let mut clock = VirtualClock::new();
    let link = InProcessLink::new(emulate(robot, plant, Pacing::WallClock)?, clock.clone());
    let mut controller = robot.controller(settings.law, settings.guard)?;
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    let finished = run(&robot.description, settings, &mut controller, link, &mut clock, recorder, observer)?;
    let end = match finished.end {
        Ok(LoopEnd::Completed) => SimulatedEnd::Completed(Box::new(finished.outcome)),
        Ok(LoopEnd::Interrupted) => SimulatedEnd::Failed(anyhow::anyhow!("interrupted")),
        Err(error) => SimulatedEnd::Failed(error.into()),
    };
    Ok((end, finished.recorder))
}

impl SimulatedEnd {
    /// What came of a run that completed.
    ///
    /// # Errors
    /// Why it did not complete, with `name`.
    pub fn completed(self, name: &str) -> anyhow::Result<Outcome> {
        match self {
            Self::Completed(outcome) => Ok(*outcome),
            Self::Failed(error) => Err(error).with_context(|| format!("the run of {name}")),
        }
    }
}
