//! What a seed stands for.

use hinf_control::Law;
use nalgebra::Vector3;
use uarm_sim::{Joint, UarmParameterError, UarmPlantParameters};

use super::fault::Fault;
use crate::robot::Robot;
use crate::study::random::{Stream, Subject};
use crate::study::spread::Spread;
use crate::study::start::StartVariation;

/// How far each parameter of the drawn plants is from the robot file's at most, as a share of it.
pub const SPREAD: f64 = 0.2;

/// A trial before it is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scenario {
    /// What it was drawn from.
    pub seed: u64,
    /// The control law.
    pub law: Law,
    /// The robot's imperfections.
    pub plant: UarmPlantParameters,
    /// How far joints 1 to 3 are from the nominal start, rad.
    pub start_offset: Vector3<f64>,
    /// What happens.
    pub fault: Fault,
    /// To whose drive.
    pub joint: Joint,
    /// In which cycle, counted from 0: with its SYNC.
    pub cycle: u64,
}

impl Scenario {
    /// What `seed` stands for on `robot`.
    ///
    /// # Errors
    /// [`UarmParameterError`] if the drawn plant is none.
    pub fn draw(robot: &Robot, seed: u64) -> Result<Self, UarmParameterError> {
        let mut stream = Stream::new(seed, Subject::Fault, 0);
        let laws = Law::ALL;
        let description = &robot.description;
        let cycles = (description.task.motion().end() / description.period.seconds(1)).floor();
        let law = laws[stream.below(laws.len())];
        let joint = <Joint>::ALL[stream.below(<Joint>::ALL.len())];
        // The first cycle has its own rules, and with the last the run is over.
        let cycle = stream.uniform(1.0, (cycles - 1.0).max(1.0)) as u64;
        let fault = Fault::draw(&mut stream);
        let spread = Spread::new(SPREAD).unwrap_or_default();
        Ok(Self {
            seed,
            law,
            plant: spread.draw(&robot.plant.uarm, &mut Stream::new(seed, Subject::Plant, 0))?,
            start_offset: StartVariation::Full.offset(robot, seed, 0),
            fault,
            joint,
            cycle,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_seed_stands_for_one_scenario_and_seeds_for_all_kinds_on_all_joints_under_all_laws() {
        let robot = Robot::load(None).unwrap();
        let draw = |seed| Scenario::draw(&robot, seed).unwrap();
        assert_eq!(draw(7), draw(7));
        let drawn: Vec<_> = (0..2_000).map(draw).collect();
        let count = |of: fn(&Scenario) -> String| drawn.iter().map(of).collect::<BTreeSet<_>>().len();
        assert_eq!(count(|scenario| scenario.fault.kind().to_owned()), 26, "emergencies are of two kinds and one name");
        assert_eq!(count(|scenario| scenario.law.name().to_owned()), Law::ALL.len());
        assert_eq!(count(|scenario| format!("{:?}", scenario.joint)), 3);
        let cycles = || drawn.iter().map(|scenario| scenario.cycle);
        assert!(cycles().min().unwrap() < 10 && cycles().max().unwrap() > 1_150 && cycles().max().unwrap() < 1_167);
    }
}
