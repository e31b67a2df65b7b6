//! A robot's task on its simulated self, for commands that want to know how it ends and keep no log.

use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::run::Observer;
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;

use super::loop_thread::LoopThread;
use super::place::Place;
use crate::bought::Bought;
use crate::dimensions::Progress;
use crate::robot::Robot;
use crate::simulated_robot::{PlantChoice, SimulatedPlant};
use crate::simulation::SimulatedEnd;

/// The task of `robot` on the simulated robot with the imperfections of its file and the drives `bought`, in virtual time.
///
/// # Errors
/// If it cannot be begun.
pub fn rehearse<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    bought: &Bought<J>,
    law: Law,
    disturbance: Disturbance,
) -> anyhow::Result<SimulatedEnd<N>> {
    let settings = Settings { guard: AdaptationGuard::Bounded, disturbance, ..Settings::paper(law) };
    simulate(robot, bought, &settings, SimulatedPlant::new(robot, PlantChoice::Uarm.of(robot), disturbance)?)
}

/// A run of `robot` on `plant`, which brings its disturbance along, with the drives `bought`: the loop of `uarm run` in virtual time.
///
/// # Errors
/// If it cannot be begun.
pub fn simulate<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    bought: &Bought<J>,
    settings: &Settings,
    plant: SimulatedPlant<N>,
) -> anyhow::Result<SimulatedEnd<N>> {
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let run = LoopThread {
        robot,
        settings,
        place: &Place::SimulatedVirtualTime(PlantChoice::Uarm.of(robot)),
        bought,
        realtime: None,
        loop_side: None,
        log: None,
        observer: Observer { progress: &progress, stop: &stop },
        announcement: &[],
    };
    let finished = run.on_plant(plant)?;
    Ok(match finished.end {
        Ok(LoopEnd::Completed) => SimulatedEnd::Completed(Box::new(finished.outcome)),
        Ok(LoopEnd::Interrupted) => SimulatedEnd::Failed(anyhow::anyhow!("interrupted")),
        Err(failure) => SimulatedEnd::Failed(failure.cause),
    })
}
