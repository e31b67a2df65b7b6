//! Serial arms of N joints with any axes on a base of B degrees of freedom.
//!
//! Velocities are quasi-velocities v = [v_b; q̇_m]: the base's in *base axes*, which turn with the base, and the joints'.
//! Neither the base's attitude nor its place enters the equations. All vectors below are in base axes, about the base's
//! origin.

mod articulated;
mod base;
mod composite;
mod euler;
mod frame;
mod joint;
mod manipulator;
mod matrices;
mod recursive;
mod reduced;
mod regressor;
mod tool;
mod twist;
mod walk;

pub use base::{BaseFreedom, BaseMotion};
pub use euler::{EulerAngles, EulerSequence};
pub use joint::{Joint, JointMotion};
pub use manipulator::{FreeFloatingManipulator, PlanarBaseManipulator, SerialManipulator, SphericalBaseManipulator};
pub use matrices::{SerialDynamics, SerialState};
pub use recursive::SerialAcceleration;
pub use reduced::SerialReduced;
pub use regressor::{LINK_PARAMETERS, SerialRegressor};
pub use tool::{GeneralisedJacobian, ToolPose};
