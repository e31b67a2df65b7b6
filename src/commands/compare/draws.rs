//! The file of a Monte Carlo study's draws.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use uarm_loop::outcome::Indices;
use uarm_sim::{UarmImperfections, UarmPlantParameters};

use crate::study::collection::{Collection, Header, Numbered};
use crate::study::start::StartVariation;

/// The draws of a study, or of a part of it.
pub type Draws = Collection<StudyHeader, Draw>;

/// What draws are of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyHeader {
    /// The version of the program, with its commit.
    pub uarm: String,
    /// The robot's name.
    pub robot: String,
    /// CRC-32 of the robot file.
    pub robot_crc32: u32,
    /// CRC-32 of the trained sets of the fuzzy laws; none where they are untrained.
    pub fuzzy_sets_crc32: Option<u32>,
    /// The number of plants drawn.
    pub draws: u32,
    /// How far each parameter is from the robot file's at most, as a share of it.
    pub spread: f64,
    /// How the starts differ.
    pub variation: StartVariation,
    /// What disturbs the joints.
    pub disturbance: String,
    /// What plants and starts are drawn from.
    pub seed: u64,
    /// The plants' integration step, µs.
    pub integration_step_us: u64,
    /// What must be said beside these numbers.
    pub caveat: Option<String>,
    /// The names of the controller variants.
    pub controllers: Vec<String>,
}

impl Header for StudyHeader {
    fn numbers(&self) -> RangeInclusive<u64> {
        1..=u64::from(self.draws)
    }
}

/// One plant, and how each controller did on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Draw {
    /// Its number, counted from 1.
    pub draw: u64,
    /// The plant that was drawn.
    pub plant: DrawnPlant,
    /// How far joints 1 to 3 were from the nominal start, rad.
    pub start_offset: [f64; 3],
    /// L2 and E of each controller, or why the experiment did not come to its end.
    pub indices: Vec<Result<Indices, String>>,
}

impl Numbered<StudyHeader> for Draw {
    fn number(&self) -> u64 {
        self.draw
    }

    fn misfit(&self, header: &StudyHeader) -> Option<String> {
        let (found, expected) = (self.indices.len(), header.controllers.len());
        (found != expected).then(|| format!("indices: of {found} controllers, expected {expected} as in line 1"))
    }
}

impl Draw {
    /// L2 and E of controller `number`, if it completed.
    pub fn completed(&self, number: usize) -> Option<Indices> {
        self.indices.get(number)?.as_ref().ok().copied()
    }

    /// L2 of controller `number`: beyond all others if it did not complete.
    pub fn l2(&self, number: usize) -> f64 {
        self.completed(number).map_or(f64::INFINITY, |indices| indices.l2)
    }

    /// The L2 that `pick` picks of all.
    pub fn extreme(&self, pick: fn(f64, f64) -> f64) -> f64 {
        (0..self.indices.len()).map(|number| self.l2(number)).reduce(pick).unwrap_or(f64::NAN)
    }
}

/// The imperfections of a plant that was drawn; units as in the robot file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrawnPlant {
    /// Viscous friction of joints 1 to 3, N·m·s.
    pub viscous_friction: [f64; 3],
    /// Coulomb friction of joints 1 to 3, N·m.
    pub coulomb_friction: [f64; 3],
    /// Factor of the base's inertia.
    pub base_inertia_scale: f64,
    /// Factor of the links' inertias.
    pub link_inertia_scale: f64,
    /// Factor of the torques.
    pub gain: f64,
    /// Gravity along x and y of a tilted table, m/s².
    pub tilt: [f64; 2],
}

impl From<&UarmPlantParameters> for DrawnPlant {
    fn from(plant: &UarmPlantParameters) -> Self {
        let UarmImperfections {
            viscous_friction,
            coulomb_friction,
            base_inertia_scale,
            link_inertia_scale,
            gain,
            tilt,
        } = plant.imperfections();
        Self { viscous_friction, coulomb_friction, base_inertia_scale, link_inertia_scale, gain, tilt }
    }
}
