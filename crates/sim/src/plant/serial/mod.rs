//! Plants of N joints with any axes: the free-floating space manipulator simulated as it is, and its dynamically
//! equivalent manipulators on a spherical and on a planar base.

mod imperfections;
mod motion;
mod parameter_error;
mod plant;
mod pose;
mod robot;

pub use imperfections::{JointImperfections, SerialImperfections};
pub use motion::{SerialMotion, SerialRate};
pub use parameter_error::ParameterScale;
pub use plant::{PlanarBasePlant, SerialBrakes, SerialPlant, SerialSpacePlant, SphericalBasePlant};
pub use pose::{BasePose, FloatingPose, FloatingRate, PosedBase};
