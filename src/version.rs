//! Which version this is.

/// Version and commit: what `uarm --version` prints behind the name, and files of trials name.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (commit ", env!("UARM_COMMIT"), ")");
