//! What happens on the loop's thread: the place is set up, the thread becomes a real-time one, the experiment runs.

use hinf_control::Disturbance;

use sim::VirtualClock;
use uarm_io::link::{Link, ObservedLink};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::time::Clock;

use super::place::Place;
use super::session::Session;
use super::tape::LoopSide;
use super::{Finished, embedded, hardware};
use crate::control_loop::progress::Progress;
use crate::control_loop::record::NoRecorder;
use crate::control_loop::torque::DisturbanceSite;
use crate::recording::Notebook;
use crate::robot::Robot;
use crate::signals::StopRequest;

/// All that an experiment needs.
pub struct Start<'a> {
    /// What was asked for.
    pub session: &'a Session,
    /// The robot.
    pub robot: &'a Robot,
    /// What it is recorded in.
    pub loop_side: Option<&'a mut LoopSide>,
    /// What is told in words.
    pub notebook: Option<Notebook>,
    /// What others look at.
    pub progress: &'a Progress,
    /// Asks for the end.
    pub stop: &'a StopRequest,
}

impl Start<'_> {
    /// Runs the experiment; call it on the loop's thread.
    ///
    /// # Errors
    /// If it cannot be begun.
    pub fn run(self) -> anyhow::Result<Finished> {
        let Self { session, robot, .. } = self;
        let disturbance = match session.settings.disturbance_site {
            DisturbanceSite::Plant => session.settings.disturbance,
            DisturbanceSite::Command => Disturbance::None,
        };
        match &session.place {
            Place::EmbeddedVirtual(plant) => {
                let clock = VirtualClock::default();
                let link = embedded::link(robot, *plant, disturbance, clock.clone())?;
                self.on(link, clock)
            }
            Place::EmbeddedReal(plant) => {
                let link = embedded::link(robot, *plant, disturbance, MonotonicClock)?;
                let _thread = session.realtime.enter(self.notebook.as_ref())?;
                self.on(link, MonotonicClock)
            }
            Place::Interface(interface) => {
                let link = hardware::link(robot, interface)?;
                let _thread = session.realtime.enter(self.notebook.as_ref())?;
                self.on(link, MonotonicClock)
            }
        }
    }

    fn on<L: Link, C: Clock>(self, link: L, mut clock: C) -> anyhow::Result<Finished>
    where
        L::Error: Send + Sync + 'static,
    {
        let Self { session, robot, loop_side, progress, stop, .. } = self;
        let settings = &session.settings;
        let finished = match loop_side {
            Some(LoopSide { cycles, frames }) => {
                let link = ObservedLink::new(link, |direction, frame: &_, at| frames.record(direction, frame, at));
                super::run(robot, settings, link, &mut clock, cycles, progress, stop)?.0
            }
            None => super::run(robot, settings, link, &mut clock, NoRecorder, progress, stop)?.0,
        };
        Ok(finished)
    }
}
