//! One seed: run, and held against what must be true of any run.

use std::cell::RefCell;
use std::rc::Rc;

use hinf_control::{AdaptationGuard, Disturbance};
use serde::{Deserialize, Serialize};
use uarm_io::drive::DriveNetwork;
use uarm_io::time::Duration;
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::fault_code::Coded;
use uarm_loop::run::{Observer, run};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{InProcessLink, IntegrationStep, Pacing, VirtualClock};

use super::expectation::Expectation;
use super::injection::{Bench, Injection, Seen};
use super::judgement::{judge, per_mille};
use super::observation::{End, Observation};
use super::scenario::Scenario;
use crate::dimensions::{CycleRecord, Progress};
use crate::robot::Robot;
use crate::simulated_plant::{self, SimulatedPlant};
use crate::simulated_robot::emulate;

/// What came of one seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// What it was drawn from.
    pub seed: u64,
    /// The control law.
    pub controller: String,
    /// The kind of fault.
    pub fault: String,
    /// The fault in words.
    pub detail: String,
    /// The joint of the drive that it happened to, counted from 1.
    pub joint: usize,
    /// Task time at which it happened, s.
    pub at_s: f64,
    /// `completed`, `interrupted`, or the code of the fault that ended the run.
    pub end: String,
    /// From the fault to brakes that are all closed, ms; nothing if the run went on to its end.
    pub reaction_ms: Option<f64>,
    /// What was not as it must be.
    pub violations: Vec<String>,
}

/// How finely the plants are integrated, as in the comparison of many drawn robots.
const INTEGRATION_STEP: IntegrationStep = IntegrationStep::COARSE;
/// How long after a run the drives are watched: their watchdogs have acted by then.
const AFTER_THE_RUN: Duration = Duration::from_millis(200);

impl Trial {
    /// Draws the scenario of `seed` and runs it on `robot`.
    ///
    /// # Errors
    /// If the run cannot be begun.
    pub fn run(robot: &Robot, seed: u64) -> anyhow::Result<Self> {
        let scenario = Scenario::draw(robot, seed)?;
        let observation = observe(robot, &scenario)?;
        let expectation = Expectation::of(scenario.fault, robot);
        let violations = judge(robot, &scenario, &expectation, &observation);
        let reaction = observation.reaction().map(|reaction| reaction.as_secs_f64() * 1e3);
        Ok(Self {
            seed,
            controller: scenario.law.name().to_owned(),
            fault: scenario.fault.kind().to_owned(),
            detail: scenario.fault.to_string(),
            joint: scenario.joint.index() + 1,
            at_s: robot.description.period.seconds(scenario.cycle),
            end: observation.end.to_string(),
            reaction_ms: reaction,
            violations: violations.iter().map(ToString::to_string).collect(),
        })
    }

    /// Was everything as it must be?
    pub const fn is_good(&self) -> bool {
        self.violations.is_empty()
    }
}

/// Runs `scenario` on `robot`, under the paper's disturbance.
///
/// # Errors
/// If the run cannot be begun.
pub fn observe(robot: &Robot, scenario: &Scenario) -> anyhow::Result<Observation> {
    let mut clock = VirtualClock::new();
    let plant = SimulatedPlant::uarm(robot, scenario.plant, Disturbance::Paper)?
        .starting_at(simulated_plant::start(robot) + scenario.start_offset)
        .with_integration_step(INTEGRATION_STEP);
    let link = InProcessLink::new(emulate(robot, plant, Pacing::WallClock)?, clock.clone());
    let torque_limit =
        robot.description.joints.each_ref().map(|joint| per_mille(&joint.torque_scale, joint.torque_limit));
    let seen = Seen { torque_limit, ..Seen::default() };
    let bench = Rc::new(RefCell::new(Bench { link, seen }));
    let stop = StopRequest::default();
    let description = &robot.description;
    let injection = Injection::new(
        Rc::clone(&bench),
        clock.clone(),
        (scenario.fault, scenario.joint, scenario.cycle),
        description.joints.each_ref().map(|joint| joint.node),
        &stop,
    );
    let settings = Settings { guard: AdaptationGuard::Bounded, ..Settings::paper(scenario.law) };
    let mut controller = robot.controller(settings.law, settings.guard)?;
    let drives = DriveNetwork::new(injection, description.network_configuration()?);
    let observer = Observer { progress: &Progress::default(), stop: &stop };
    let records: Vec<CycleRecord> = Vec::new();
    let finished = run(description, &settings, controller.as_mut(), drives, &mut clock, records, observer)?;
    let end = match &finished.end {
        Ok(LoopEnd::Completed) => End::Completed,
        Ok(LoopEnd::Interrupted) => End::Interrupted,
        Err(error) => End::Fault(error.code()),
    };
    let bench = &mut *bench.borrow_mut();
    bench.settle(&clock, AFTER_THE_RUN);
    Ok(Observation {
        end,
        seen: bench.seen,
        brakes: bench.link.robot().brakes(),
        recorded: u64::try_from(finished.recorder.len()).unwrap_or(u64::MAX),
    })
}
