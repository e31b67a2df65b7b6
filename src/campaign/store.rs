//! The file of a campaign's trials.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::trial::Trial;
use crate::study::collection::{Collection, Header, Numbered};

/// What trials are of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CampaignHeader {
    /// The version of the program, with its commit.
    pub uarm: String,
    /// The robot's name.
    pub robot: String,
    /// CRC-32 of the robot file.
    pub robot_crc32: u32,
    /// The first seed.
    pub first_seed: u64,
    /// The number of seeds.
    pub seeds: u64,
}

/// Trials of a campaign, or of a part of it, by seed.
pub type Trials = Collection<CampaignHeader, Trial>;

impl Header for CampaignHeader {
    fn numbers(&self) -> RangeInclusive<u64> {
        self.first_seed..=self.first_seed.saturating_add(self.seeds.saturating_sub(1))
    }
}

impl Numbered<CampaignHeader> for Trial {
    fn number(&self) -> u64 {
        self.seed
    }
}
