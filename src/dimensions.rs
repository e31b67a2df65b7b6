//! The paper's robot: a passive base and two active joints. What is generic over both numbers has it as its default.

/// Joints with a drive, the passive base included.
pub const JOINTS: usize = 3;
/// Joints with a motor.
pub const ACTIVE: usize = 2;

/// The record of a cycle.
pub type CycleRecord<const J: usize = JOINTS, const N: usize = ACTIVE> = uarm_loop::record::CycleRecord<J, N>;
/// The log of a run.
pub type RunLog<const J: usize = JOINTS, const N: usize = ACTIVE> = uarm_log::reader::RunLog<J, N>;
/// The same, read in order in bounded memory.
pub type OrderedLog<const J: usize = JOINTS, const N: usize = ACTIVE> = uarm_log::ordered::OrderedLog<J, N>;
/// Something that a log tells.
pub type Item<const J: usize = JOINTS, const N: usize = ACTIVE> = uarm_log::decoder::Item<J, N>;
/// The latest numbers of a loop.
pub type Progress<const N: usize = ACTIVE> = uarm_loop::progress::Progress<N>;
/// What came of a run.
pub type Outcome<const N: usize = ACTIVE> = uarm_loop::outcome::Outcome<N>;
/// What the loop must know of a robot.
pub type LoopRobot<const J: usize = JOINTS, const N: usize = ACTIVE> = uarm_loop::robot::Robot<J, N>;
