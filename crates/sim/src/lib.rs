//! Deterministic plants and the emulated drives that carry them: the other end of any link.
//!
//! # The contract: the same calls give the same bits
//!
//! - **Time is passed in.** Nothing here reads a clock but [`InProcessLink`], through the [`Clock`](uarm_io::time::Clock) that
//!   it was given. Plant time is whole nanoseconds.
//! - **One grid.** Plants integrate by RK4 on whole multiples of one [`IntegrationStep`] (100 µs) from plant time zero. How the
//!   caller cuts time into calls does not show, as long as it cuts on the grid; the instant at which the [`Disturbance`](hinf_control::Disturbance)
//!   starts is stepped onto exactly, wherever it lies.
//! - **Lockstep.** With [`Pacing::Lockstep`] the plant moves by one period at each SYNC: what happens does not depend on when
//!   it happens. A run in virtual time, in real time and over a bus gives the same positions, bit for bit.
//! - **The same functions everywhere.** sin, cos, tanh and exp come from `libm`; there is no fused multiply-add, no hash map,
//!   no random number but the seeded one of [`FaultyLink`].
//! - **No allocation after construction**, no lock, no panic: the in-process robot runs on the real-time thread.
//!
//! # Example
//!
//! Three drives on the ideal plant, over a link without a wire, in time that passes when it is told to:
//!
//! ```
//! use uarm_sim::{
//!     DemPlant, DriveDescription, DriveParameters, EmulatedRobot, EncoderDescription, InProcessLink, Pacing,
//!     VirtualClock,
//! };
//! use std::time::Duration;
//! use uarm_io::drive::wire::plain_sync_frame;
//! use uarm_io::encoder::Direction;
//! use uarm_io::link::Link;
//! use uarm_io::time::Clock;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let drive = |node| {
//!     DriveParameters::new(DriveDescription {
//!         node,
//!         rated_torque: 200, // mN·m
//!         rated_current: 1_500, // mA
//!         maximum_torque: 1_000, // per mille
//!         direction: Direction::Positive,
//!         encoder: EncoderDescription {
//!             counts_per_revolution: 33_739,
//!             counter_bits: 32,
//!             zero_offset: 0,
//!         },
//!     })
//! };
//! let plant = DemPlant::new(dem_model::ThreeLinkDem::table_2());
//! let pacing = Pacing::Lockstep { period: Duration::from_millis(3) };
//! let robot = EmulatedRobot::new(plant, [drive(1)?, drive(2)?, drive(3)?], pacing)?;
//!
//! let mut clock = VirtualClock::new();
//! let mut link = InProcessLink::new(robot, clock.clone());
//! let boot_ups = std::iter::from_fn(|| link.receive(clock.now()).transpose()).count();
//! assert_eq!(boot_ups, 3);
//!
//! link.send(&plain_sync_frame())?;
//! clock.sleep_until(clock.now() + Duration::from_millis(3));
//! assert!(link.receive(clock.now())?.is_none(), "before NMT start a drive does not answer SYNC");
//! # Ok(())
//! # }
//! ```
//!
//! The master that boots, configures and runs these drives is `uarm_io::drive::DriveNetwork`; see `tests/network.rs`.
//!
//! # Map
//!
//! | module | subject |
//! |---|---|
//! | [`plant`] | [`Plant`]; [`DemPlant`] (ideal), [`UarmPlant`] (imperfect), [`FreeFloatingPlant`] (space manipulator, without the DEM); [`SerialPlant`] (N joints, in space and in the plane); integrator, disturbance, brakes |
//! | [`drive`] | the CiA 402 drive: object dictionary, SDO rules, NMT, heartbeats, power state machine, encoder, faults |
//! | [`EmulatedRobot`] | drives on the joints of a plant, sans-I/O: frames and instants in, frames out |
//! | [`odrive`] | the same with ODrive axes instead of CiA 402 drives |
//! | [`link`] | [`InProcessLink`] to a [`RobotOnBus`]; [`FaultyLink`] around any link |
//! | [`VirtualClock`] | time that jumps |
//!
//! # Not in it
//!
//! Bit timing, arbitration and error frames of a CAN bus (a frame sent in process arrives at once); flexible links, backlash,
//! the motors' electrical side; SDO block transfer, LSS and node guarding; more than four RPDOs and TPDOs per drive.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod clock;
pub mod drive;
/// Links to the emulated robot, and wrappers around any link.
pub mod link {
    mod faulty;
    mod in_process;

    pub use faulty::{FaultCounts, FaultRateError, FaultRates, FaultyLink};
    pub use in_process::{InProcessError, InProcessLink};
}
mod joint;
mod motors;
pub mod odrive;
mod outbox;
pub mod plant;
mod robot;
mod robot_on_bus;

pub use clock::VirtualClock;
pub use drive::{
    DriveDescription, DriveDictionary, DriveFault, DriveObject, DriveParameters, EmulatedDrive, EncoderDescription,
    PowerUp,
};
pub use joint::Joint;
pub use link::{FaultRates, FaultyLink, InProcessError, InProcessLink};
pub use outbox::{OUTBOX_CAPACITY, Outbox};
pub use plant::{
    Brake, DemPlant, FreeFloatingPlant, InitialState, IntegrationStep, JointImperfections, MechanicalPlant, Mechanism,
    ParameterScale, PlanarBasePlant, Plant, SerialBrakes, SerialImperfections, SerialMotion, SerialPlant,
    SerialSpacePlant, SphericalBasePlant, UarmImperfections, UarmParameterError, UarmPlant, UarmPlantParameters,
};
pub use robot::{EmulatedRobot, Pacing, RobotError};
pub use robot_on_bus::RobotOnBus;

pub use dem_model;
pub use nalgebra;
pub use uarm_io;

/// The README's example, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
