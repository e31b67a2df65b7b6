//! How many joints the robot has: the paper's UARM has a passive base and two active joints. The crates below are generic
//! over both numbers; this program is not, and says so here alone.

/// Joints with a drive, the passive base included.
pub const JOINTS: usize = 3;
/// Joints with a motor.
pub const ACTIVE: usize = 2;

/// The record of a cycle of this robot.
pub type CycleRecord = uarm_loop::record::CycleRecord<JOINTS, ACTIVE>;
/// The log of a run of this robot.
pub type RunLog = uarm_log::reader::RunLog<JOINTS, ACTIVE>;
/// The same, read in order in bounded memory.
pub type OrderedLog = uarm_log::ordered::OrderedLog<JOINTS, ACTIVE>;
/// Something that a log of this robot tells.
pub type Item = uarm_log::decoder::Item<JOINTS, ACTIVE>;
/// The latest numbers of this robot's loop.
pub type Progress = uarm_loop::progress::Progress<ACTIVE>;
/// What came of a run of this robot.
pub type Outcome = uarm_loop::outcome::Outcome<ACTIVE>;
/// What the loop must know of this robot.
pub type LoopRobot = uarm_loop::robot::Robot<JOINTS, ACTIVE>;
