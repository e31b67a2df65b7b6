//! The deploy binary's library: robot files, the control loop, the subcommands.
#![forbid(unsafe_code)]

pub mod cli;
pub mod commands;
pub mod control_loop;
pub mod controllers;
pub mod experiment;
pub mod figures;
pub mod filter_study;
pub mod inspection;
pub mod monitor;
pub mod plain_text;
pub mod recording;
pub mod replay;
pub mod robot;
pub mod run_log;
pub mod signals;
pub mod study;
pub mod trace;
pub mod training;
