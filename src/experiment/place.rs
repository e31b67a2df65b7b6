//! Where experiments take place.

use super::report::ClockKind;
use crate::commands::run::PlantChoice;

/// Where experiments take place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Drives on a CAN interface.
    Interface(String),
    /// The embedded robot on the wall clock.
    EmbeddedReal(PlantChoice),
    /// The embedded robot in virtual time.
    EmbeddedVirtual(PlantChoice),
}

impl Place {
    /// The clock that the loop runs on there.
    pub const fn clock(&self) -> ClockKind {
        match self {
            Self::EmbeddedVirtual(_) => ClockKind::Virtual,
            Self::EmbeddedReal(_) | Self::Interface(_) => ClockKind::Monotonic,
        }
    }

    /// What it is called in reports and logs.
    pub fn name(&self) -> String {
        match self {
            Self::Interface(interface) => interface.clone(),
            Self::EmbeddedReal(plant) => format!("embedded {}", plant_name(*plant)),
            Self::EmbeddedVirtual(plant) => format!("embedded {}, virtual time", plant_name(*plant)),
        }
    }

    /// What is about to happen there.
    pub fn announcement(&self) -> String {
        match self {
            Self::Interface(interface) => format!("on real drives on {interface}: MOTORS WILL MOVE"),
            Self::EmbeddedReal(plant) => format!("on the embedded robot ({}), in real time", plant_name(*plant)),
            Self::EmbeddedVirtual(plant) => format!("on the embedded robot ({}), in virtual time", plant_name(*plant)),
        }
    }
}

/// What a plant is called.
pub const fn plant_name(plant: PlantChoice) -> &'static str {
    match plant {
        PlantChoice::Uarm => "imperfect UARM",
        PlantChoice::Ideal => "ideal DEM",
        PlantChoice::Space => "free-floating space manipulator",
    }
}
