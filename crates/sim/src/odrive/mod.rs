//! Emulated ODrive axes: the other side of `uarm_io`'s ODrive master, on the same plants as the CiA 402 drives.
//!
//! | file | subject |
//! |---|---|
//! | `parameters` | what an axis is made of |
//! | `axis` | one axis, without I/O: state, errors, watchdog, cyclic messages |
//! | `robot` | [`EmulatedOdrives`]: the axes on a plant, and the rule by which plant time passes |
//!
//! Modelled after the maker's documentation of CANSimple for firmware 0.6. Not in it: calibration, input modes other than
//! torque passed through, limits other than that of the torque, the time that an axis takes to answer, messages other than
//! those of `uarm_io::drive::odrive::wire`.

mod axis;
mod parameters;
mod robot;

pub use axis::{AxisFault, EmulatedAxis};
pub use parameters::{AxisDescription, AxisDescriptionError, AxisParameters};
pub use robot::{EmulatedOdrives, OdriveRobotError};
