//! The boundary between protocol and wire.

mod health;
mod observed;
mod transport;

pub use health::{ControllerProblem, ErrorCounters, LinkHealth};
pub use observed::{FrameDirection, ObservedLink};
pub use transport::{Link, LinkError, LinkErrorKind, Received};
