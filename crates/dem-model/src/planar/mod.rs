//! Space manipulators in the plane and the map to their dynamically equivalent manipulators, for any number of links.

mod dem;
mod jacobian;
mod space;

pub use dem::PlanarDem;
pub use space::{PlanarSpaceManipulator, SpaceLink, SpacecraftBody};
