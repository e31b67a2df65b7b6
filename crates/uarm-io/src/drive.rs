//! The robot's drives: CiA 402 on CANopen, what both ends of the wire agree on and the master that runs them.
//!
//! | module | subject |
//! |---|---|
//! | [`objects`] | the object dictionary entries that are read, written or mapped |
//! | [`cia402`] | statusword, controlword and the power state machine between them |
//! | [`wire`] | identifiers and payloads of every frame |
//! | [`sdo`] | reading and writing single objects, as a master or as a bystander |
//! | [`words`] | abort and emergency codes in words |
//! | [`pdo_objects`] | where the parameters of PDOs stand |
//! | [`wishes`] | what a robot wants of a drive |
//! | [`survey`] | what a drive, or its dictionary file, says of itself |
//! | [`plan`](mod@plan) | from both: what is written, and what is found |
//! | [`power_marker`] | which object can tell of a loss of power |
//! | [`network`] | the master: start, cycle, supervision, stop |
//! | [`odrive`] | ODrive axes, another protocol: messages and master |
//! | [`robot_drives`] | what the control loop needs of drives, whatever protocol they speak |

pub mod cia402;
mod identity;
pub mod network;
pub mod objects;
pub mod odrive;
pub mod pdo_objects;
pub mod plan;
pub mod power_marker;
pub mod readings;
pub mod robot_drives;
pub mod sdo;
pub mod survey;
pub mod wire;
pub mod wishes;
pub mod words;

pub use identity::DriveIdentity;
pub use network::DriveNetwork;
pub use odrive::OdriveNetwork;
pub use robot_drives::RobotDrives;

pub use canopen_rs::{Address, DataType, NmtCommand, NmtState, NodeId, Value};
