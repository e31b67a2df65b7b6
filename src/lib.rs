//! The deploy binary's library: robot files, the control loop, the subcommands.
#![forbid(unsafe_code)]
