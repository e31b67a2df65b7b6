//! The planar three-link DEM in closed form (appendix of the paper).

mod dem;
mod dynamics;
mod inertial;
mod kinematics;
mod partition;
mod reduced;
mod regressor;

pub use dem::ThreeLinkDem;
pub use inertial::InertialParameters;
pub use kinematics::Pose;
pub use partition::{EliminatedBase, Partition};
pub use reduced::ReducedDynamics;
pub use regressor::{REGRESSOR_PARAMETERS, regressor};
