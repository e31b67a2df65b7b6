//! What is counted while a log is gone through, cycle by cycle.

use uarm_log::csv::Reporting;
use uarm_log::description::RunDescription;
use uarm_log::ordered::InOrder;
use uarm_log::proto;
use uarm_log::reader::ReadError;
use uarm_loop::outcome::OutcomeOfCycles;
use uarm_loop::supervisor::Authority;

use crate::dimensions::{CycleRecord, OrderedLog, RunLog};
use crate::robot::Robot;

/// What was counted.
#[derive(Debug)]
pub struct Tally<const J: usize, const N: usize> {
    /// The run's figures.
    pub outcome: OutcomeOfCycles<N>,
    /// The first cycle.
    pub first: Option<CycleRecord<J, N>>,
    /// The last cycle.
    pub last: Option<CycleRecord<J, N>>,
    /// The number of cycles.
    pub cycles: usize,
    /// The number of frames.
    pub frames: usize,
    /// The number of keyframes.
    pub keyframes: usize,
    /// Whether cycles are missing between others.
    pub has_gaps: bool,
    /// Task time of the first cycle of a stop on request, s, and how many there are.
    pub stopping: Option<(f64, usize)>,
    /// Whose drives reported torques.
    pub reporting: Reporting<J>,
    /// Cycles and frames in the flight recorder's window.
    pub in_window: [usize; 2],
}

impl<const J: usize, const N: usize> Tally<J, N> {
    /// Nothing so far, of a run of `robot`.
    fn new(robot: &Robot<J, N>) -> Self {
        let description = &robot.description;
        Self {
            outcome: OutcomeOfCycles::new(description.task.motion(), description.period),
            first: None,
            last: None,
            cycles: 0,
            frames: 0,
            keyframes: 0,
            has_gaps: false,
            stopping: None,
            reporting: Reporting::default(),
            in_window: [0; 2],
        }
    }

    /// Goes through a log.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn of(log: &mut OrderedLog<J, N>, robot: &Robot<J, N>) -> Result<(Self, RunLog<J, N>), ReadError> {
        let (mut tally, told) = log.pass(|| Self::new(robot), Self::take)?;
        if let Some(fault) = &told.fault {
            tally.in_window = in_window(log, &told.run, fault)?;
        }
        Ok((tally, told))
    }

    fn take(&mut self, record: InOrder<'_, J, N>) {
        match record {
            InOrder::Cycle(record) => self.cycle(record),
            InOrder::Frame(_) => self.frames += 1,
            InOrder::Keyframe(_) => self.keyframes += 1,
        }
    }

    fn cycle(&mut self, record: &CycleRecord<J, N>) {
        self.has_gaps |= self.last.as_ref().is_some_and(|last| uarm_log::reader::is_gap(last, record));
        self.outcome.record(record);
        self.reporting.look_at(record);
        if record.authority == Authority::Fading {
            self.stopping.get_or_insert((record.time, 0)).1 += 1;
        }
        self.first.get_or_insert(*record);
        self.last = Some(*record);
        self.cycles += 1;
    }
}

/// Cycles and frames in the flight recorder's window, which is only known at the end of a log.
fn in_window<const J: usize, const N: usize>(
    log: &mut OrderedLog<J, N>,
    run: &RunDescription,
    fault: &proto::Fault,
) -> Result<[usize; 2], ReadError> {
    let window = fault.window_start_ns..=fault.at_ns;
    let count = |[cycles, frames]: &mut [usize; 2], record: InOrder<'_, J, N>| match record {
        InOrder::Cycle(record) => *cycles += usize::from(window.contains(&run.axis.at(record.instants.done))),
        InOrder::Frame(frame) => *frames += usize::from(window.contains(&run.axis.at(frame.at))),
        InOrder::Keyframe(_) => {}
    };
    log.pass(|| [0; 2], count).map(|(counts, _)| counts)
}
