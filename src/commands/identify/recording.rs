//! Recorded runs as the search for a robot's numbers takes them.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use uarm_identify::Sample;
use uarm_io::drive::wishes::TorqueApplies;
use uarm_log::ordered::InOrder;
use uarm_loop::choice;
use uarm_loop::estimation::AngleSource;
use uarm_loop::robot::Joint;
use uarm_loop::torque::DisturbanceSite;

use crate::dimensions::{CycleRecord, JOINTS, OrderedLog};
use crate::robot::Robot;
use crate::robot::shape::Shape;
use crate::usage::UsageError;

/// Whose torques are taken for those of the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TorqueSource {
    /// Those that the drives were told.
    #[default]
    Sent,
    /// Those that the drives reported.
    Reported,
}

choice! {
    TorqueSource:
    Sent = "sent", "What the drives were told";
    Reported = "reported", "What the drives reported (CiA 402 object 6077h), where they do";
}

/// The most cycles: the search holds all of them, and simulates each some hundred times.
pub const MOST_CYCLES: usize = 400_000;

/// Recorded runs of one robot.
#[derive(Debug)]
pub struct Recordings {
    /// The robot, as the logs describe it.
    pub robot: Robot,
    /// What was recorded, in pieces without a gap.
    pub pieces: Vec<Vec<Sample<JOINTS>>>,
    /// Whether something acted on the joints that is known and not the motors'.
    pub is_disturbed: bool,
    /// Cycles that were read.
    pub cycles: usize,
    /// Cycles in which an angle was predicted, or that are missing; each ends a piece.
    pub gaps: usize,
}

/// Reads the logs `files`.
///
/// # Errors
/// If one cannot be read, is damaged, or is of another robot than the first.
pub fn read(files: &[PathBuf], source: TorqueSource) -> anyhow::Result<Recordings> {
    let mut all: Option<(String, Recordings)> = None;
    for file in files {
        let run = OrderedLog::<3, 2>::new(file).run()?;
        let shape = Shape::of(file, &run.robot.toml).context("the robot in the log")?;
        if shape != Shape::PAPER {
            let name = file.display();
            anyhow::bail!(
                "{name}: a robot with {shape}: expected the paper's arm, of which the imperfections have a model"
            );
        }
        let robot = Robot::from_log(file, &run.robot).context("the robot in the log")?;
        let (toml, recordings) = all.get_or_insert_with(|| (run.robot.toml.clone(), Recordings::none(robot)));
        if *toml != run.robot.toml {
            let name = file.display();
            anyhow::bail!("{name}: another robot file than the first run's: expected runs of one robot");
        }
        let settings = run.settings().with_context(|| file.display().to_string())?;
        if settings.approach.is_some()
            && settings.disturbance != Disturbance::None
            && settings.disturbance_site == DisturbanceSite::Plant
        {
            let name = file.display();
            anyhow::bail!(
                "{name}: an approach with a disturbance of the plant, which has a clock of its own: expected a run without one of the two"
            );
        }
        recordings.add(file, settings.disturbance_site, source)?;
    }
    let (_, recordings) = all.context("no run")?;
    Ok(recordings)
}

impl Recordings {
    const fn none(robot: Robot) -> Self {
        Self { robot, pieces: Vec::new(), is_disturbed: false, cycles: 0, gaps: 0 }
    }

    fn add(&mut self, file: &Path, site: DisturbanceSite, source: TorqueSource) -> anyhow::Result<()> {
        let left = MOST_CYCLES - self.cycles;
        let take = |cycles: &mut Vec<CycleRecord>, record: InOrder<'_, 3, 2>| {
            if let InOrder::Cycle(record) = record
                && cycles.len() <= left
            {
                cycles.push(*record);
            }
        };
        let (cycles, told) = OrderedLog::<3, 2>::new(file).pass(Vec::new, take)?;
        let name = file.display();
        if let Some(damage) = told.damage.first() {
            anyhow::bail!("{name}: {damage}: expected a whole log");
        }
        if cycles.len() > left {
            return Err(
                UsageError::new(format!("{name}: more than {MOST_CYCLES} cycles in all, expected no more")).into()
            );
        }
        self.cycles += cycles.len();
        let torques = torques(&self.robot, &cycles, source).with_context(|| name.to_string())?;
        let applies = applies(&self.robot)?;
        let mut piece: Vec<Sample<JOINTS>> = Vec::new();
        // What the drives were told in the last two cycles, the newest first; nothing where a cycle is missing.
        let mut history: [Option<[f64; JOINTS]>; 2] = [None; 2];
        for (cycle, told) in cycles.iter().zip(torques) {
            let is_first = cycle.tick == 0;
            if is_first {
                history = [Some([0.0; JOINTS]); 2];
            } else if cycle.elapsed_ticks != 1 {
                history = [None; 2];
            }
            let [last, last_but_one] = history;
            let (acts, before) = match applies {
                TorqueApplies::OnReception => (Some(told), last),
                TorqueApplies::AtSync => (last, last_but_one),
            };
            let is_measured = cycle.angle_sources.iter().all(|source| *source == AngleSource::Measured);
            if !is_measured || !is_first && cycle.elapsed_ticks != 1 {
                self.gaps += 1;
                self.pieces.push(std::mem::take(&mut piece));
            }
            if let (true, Some(torque), Some(torque_before)) = (is_measured, acts, before) {
                let sample = self.sample(cycle, torque, torque_before, site);
                self.is_disturbed |= sample.disturbance.iter().any(|torque| *torque != 0.0);
                piece.push(sample);
            }
            history = [Some(told), last];
        }
        self.pieces.push(piece);
        Ok(())
    }

    fn sample(
        &self,
        cycle: &CycleRecord,
        torque: [f64; JOINTS],
        torque_before: [f64; JOINTS],
        site: DisturbanceSite,
    ) -> Sample<JOINTS> {
        let [_, Joint { torque_delay, drive, .. }, _] = &self.robot.description.joints;
        let arrival = match drive.torque_applies {
            TorqueApplies::OnReception => cycle.instants.torque_out.since(cycle.instants.sync_sent),
            TorqueApplies::AtSync => Duration::ZERO,
        };
        let latency = arrival + *torque_delay;
        let [second, third] = match site {
            DisturbanceSite::Plant => cycle.disturbance,
            DisturbanceSite::Command => [0.0; 2],
        };
        Sample {
            at: cycle.time,
            position: cycle.measured_position,
            torque_before,
            torque,
            torque_at: cycle.time + latency.as_secs_f64(),
            disturbance: [0.0, second, third],
        }
    }
}

/// When the drives apply their torques.
///
/// # Errors
/// If they do not do so together.
fn applies(robot: &Robot) -> anyhow::Result<TorqueApplies> {
    let [_, second, third] = &robot.description.joints;
    anyhow::ensure!(
        second.drive.torque_applies == third.drive.torque_applies && second.torque_delay == third.torque_delay,
        "joints[1].drive, joints[2].drive: expected the same torque_applies and torque_delay_us"
    );
    Ok(second.drive.torque_applies)
}

/// The torque that the drives were told in each cycle, N·m at the joints.
fn torques(robot: &Robot, cycles: &[CycleRecord], source: TorqueSource) -> anyhow::Result<Vec<[f64; JOINTS]>> {
    let joints = &robot.description.joints;
    let told = |cycle: &CycleRecord| {
        let mut torque = [0.0; JOINTS];
        for ((torque, joint), sent) in torque.iter_mut().zip(joints).zip(cycle.torque_sent) {
            *torque = joint.torque_scale.to_joint(sent);
        }
        torque
    };
    match source {
        TorqueSource::Sent => Ok(cycles.iter().map(told).collect()),
        TorqueSource::Reported => {
            // A report belongs to the SYNC until which the torque of the cycle before acted.
            let next = cycles.iter().skip(1).chain(cycles.last());
            next.map(reported).collect()
        }
    }
}

fn reported(cycle: &CycleRecord) -> anyhow::Result<[f64; JOINTS]> {
    let mut torque = [0.0; JOINTS];
    for (joint, (torque, actual)) in torque.iter_mut().zip(cycle.torque_actual).enumerate().skip(1) {
        let expected = "expected reports of all active joints for --torque reported";
        let actual = actual
            .with_context(|| format!("cycle {}: joint {} reported no torque, {expected}", cycle.tick, joint + 1))?;
        *torque = actual.newton_metres;
    }
    Ok(torque)
}
