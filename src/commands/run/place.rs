//! Where experiments take place.

use uarm_log::description::ClockKind;

use crate::simulated_plant::PlantChoice;

/// Where experiments take place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Drives on a CAN interface.
    Interface(String),
    /// The simulated robot on the wall clock.
    SimulatedRealTime(PlantChoice),
    /// The simulated robot in virtual time.
    SimulatedVirtualTime(PlantChoice),
}

impl Place {
    /// The clock that the loop runs on there.
    pub const fn clock(&self) -> ClockKind {
        match self {
            Self::SimulatedVirtualTime(_) => ClockKind::Virtual,
            Self::SimulatedRealTime(_) | Self::Interface(_) => ClockKind::Monotonic,
        }
    }

    /// What it is called in reports and logs.
    pub fn name(&self) -> String {
        match self {
            Self::Interface(interface) => interface.clone(),
            Self::SimulatedRealTime(plant) => format!("simulated {}", plant.label()),
            Self::SimulatedVirtualTime(plant) => format!("simulated {}, virtual time", plant.label()),
        }
    }

    /// What is about to happen there.
    pub fn announcement(&self) -> String {
        match self {
            Self::Interface(interface) => format!("on real drives on {interface}: MOTORS WILL MOVE"),
            Self::SimulatedRealTime(plant) => format!("on the simulated robot ({}), in real time", plant.label()),
            Self::SimulatedVirtualTime(plant) => format!("on the simulated robot ({}), in virtual time", plant.label()),
        }
    }
}
