//! A robot's task on its simulated self, for commands that want to know how it ends and keep no log: the loop of `uarm run`, in virtual
//! time.

use anyhow::Context;
use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::record::Recorder;
use uarm_loop::run::Observer;
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;

use super::loop_thread::LoopThread;
use super::place::Place;
use crate::bought::Bought;
use crate::dimensions::{Outcome, Progress};
use crate::robot::Robot;
use crate::simulated_plant::{PlantChoice, SimulatedPlant};

/// How a simulated run ended.
#[derive(Debug)]
pub enum SimulatedEnd<const N: usize = 2> {
    /// The motion was completed.
    Completed(Box<Outcome<N>>),
    /// A limit of the robot ended it.
    Failed(anyhow::Error),
}

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
    let plant = SimulatedPlant::new(robot, PlantChoice::Uarm.of(robot), disturbance)?;
    simulate(robot, bought, &settings, plant, None)
}

/// A run of `robot` on `plant`, which brings its disturbance along, with the drives `bought`; each cycle is given to `recorder`.
///
/// # Errors
/// If it cannot be begun.
pub fn simulate<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    bought: &Bought<J>,
    settings: &Settings,
    plant: SimulatedPlant<N>,
    recorder: Option<&mut dyn Recorder<J, N>>,
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
    let finished = run.on_plant(plant, recorder)?;
    Ok(match finished.end {
        Ok(LoopEnd::Completed) => SimulatedEnd::Completed(Box::new(finished.outcome)),
        Ok(LoopEnd::Interrupted) => SimulatedEnd::Failed(anyhow::anyhow!("interrupted")),
        Err(failure) => SimulatedEnd::Failed(failure.cause),
    })
}

impl<const N: usize> SimulatedEnd<N> {
    /// What came of a run that completed.
    ///
    /// # Errors
    /// Why it did not complete, with `name`.
    pub fn completed(self, name: &str) -> anyhow::Result<Outcome<N>> {
        match self {
            Self::Completed(outcome) => Ok(*outcome),
            Self::Failed(error) => Err(error).with_context(|| format!("the run of {name}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hinf_control::BaseAcceleration;

    use super::*;
    use crate::dimensions::CycleRecord;
    use crate::robot::BUILT_IN;
    use crate::robot::overrides::Overrides;

    /// The paper's experiment with controller 1 on the imperfect UARM, whose joints in `reversed` have their drives the other
    /// way round.
    fn run_with(reversed: [bool; 3]) -> (Outcome, Vec<CycleRecord>) {
        let mut pieces = BUILT_IN.split("direction = \"positive\"");
        let mut text = pieces.next().unwrap_or_default().to_owned();
        for (piece, reversed) in pieces.zip(reversed) {
            text += if reversed { "direction = \"negative\"" } else { "direction = \"positive\"" };
            text += piece;
        }
        assert_eq!(text.matches("direction = \"negative\"").count(), reversed.iter().filter(|one| **one).count());
        let robot = Robot::parse(Path::new("reversed.toml"), &text, &Overrides::default()).unwrap();
        let plant = SimulatedPlant::new(&robot, PlantChoice::Uarm, Disturbance::Paper).unwrap();
        let settings = Settings::paper(Law::Nonlinear);
        let mut records = Vec::new();
        let end = simulate(&robot, &Bought::default(), &settings, plant, Some(&mut records)).unwrap();
        (end.completed("reversed").unwrap(), records)
    }

    /// L2 of the reduced law on the ideal plant, undisturbed, from the paper's start to the stretched arm, where the loop is
    /// least stable; with `changes` to the built-in robot file.
    fn l2_to_the_stretched_arm(changes: &[(&str, &str)]) -> f64 {
        let stretched = ("end_deg = [80.0, 60.0]", "end_deg = [0.0, 0.0]");
        let text = changes.iter().chain([&stretched]).fold(BUILT_IN.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        let mode = Some((Law::Nonlinear, BaseAcceleration::Reduced));
        let overrides = Overrides { base_acceleration: mode, ..Overrides::default() };
        let robot = Robot::parse(Path::new("delayed.toml"), &text, &overrides).unwrap();
        let plant = SimulatedPlant::new(&robot, PlantChoice::Ideal, Disturbance::None).unwrap();
        let end = simulate(&robot, &Bought::default(), &Settings::paper(Law::Nonlinear), plant, None).unwrap();
        end.completed("delayed").unwrap().indices.l2
    }

    /// The frozen loop has a spectral radius of 0.991 without and of 1.012 with one cycle of delay; with the filter of the
    /// hardware's robot file it is stable with it.
    #[test]
    fn one_cycle_of_delay_makes_the_loop_with_the_papers_filter_swing_up() {
        const TORQUE: &str = "rated_torque_nm = 0.2,";
        let undelayed = l2_to_the_stretched_arm(&[]);
        assert!(undelayed < 0.01, "{undelayed}");
        let delayed = l2_to_the_stretched_arm(&[(TORQUE, "rated_torque_nm = 0.2, torque_delay_us = 2999,")]);
        assert!(delayed > 0.2, "{delayed}");
        let at_sync = l2_to_the_stretched_arm(&[(TORQUE, "rated_torque_nm = 0.2, torque_applies = \"at-sync\",")]);
        assert!(at_sync > 0.2, "{at_sync}");
        let hardware = l2_to_the_stretched_arm(&[
            (TORQUE, "rated_torque_nm = 0.2, torque_delay_us = 1999,"),
            ("period_us = 3000", "period_us = 2000"),
            ("cutoff_rad_per_s = 27.81882", "cutoff_rad_per_s = 150.0"),
        ]);
        assert!(hardware < 0.015, "{hardware}");
    }

    /// Which way a drive is mounted shows in its counts and in the torques that it is sent, and in nothing else.
    #[test]
    fn a_reversed_drive_moves_its_joint_the_same_way() {
        let (outcome, records) = run_with([false; 3]);
        assert!((outcome.indices.l2 - 0.0751).abs() <= 0.0005, "L2 is {}", outcome.indices.l2);
        assert!(records.iter().any(|record| record.counts[0] != 0 && record.torque_sent[1] != 0));
        for reversed in [[true, false, false], [false, true, false], [false, false, true], [true, true, true]] {
            let (reversed_outcome, reversed_records) = run_with(reversed);
            let indices = |outcome: &Outcome| (outcome.indices.l2.to_bits(), outcome.indices.e.to_bits());
            assert_eq!(indices(&reversed_outcome), indices(&outcome), "{reversed:?}");
            assert_eq!(reversed_records.len(), records.len());
            for (record, mut mirrored) in records.iter().zip(reversed_records) {
                for joint in (0..3).filter(|joint| reversed[*joint]) {
                    mirrored.counts[joint] = -mirrored.counts[joint];
                    mirrored.torque_sent[joint] = -mirrored.torque_sent[joint];
                }
                // As text, in which the two zeros differ.
                assert_eq!(format!("{mirrored:?}"), format!("{record:?}"), "{reversed:?}");
            }
        }
    }
}
