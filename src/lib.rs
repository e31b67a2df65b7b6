//! The deploy binary's library: the command line, its subcommands, robot files and the simulated robot.
//!
//! | module | subject |
//! |---|---|
//! | [`cli`] | the command line: which subcommands there are |
//! | [`commands`] | a file or folder per subcommand |
//! | [`robot`] | robot files: read, checked, turned into types |
//! | [`drives`] | which master drives the robot: CANopen or ODrive |
//! | [`mod@reference`] | where the joints with incremental encoders are, and whether that still holds |
//! | [`simulated_plant`] | which plant, and how it moves the joints |
//! | [`simulated_robot`] | a plant behind emulated drives |
//! | [`campaign`] | faults drawn by the thousand |
//! | [`study`] | many experiments on drawn robots |
//! | [`stability`] | is the loop of a robot file stable with the delay of its drives? |
//! | [`report`], [`inspection`], [`figures`] | what runs and logs tell: for people, in terminals, as figures |
//! | [`log_files`], [`signals`], [`options`] | where logs go; signals that end a run; choices on command lines |
//! | [`console`], [`output_files`] | standard output and error; files that commands write |
//! | [`version`] | which version this is |
//! | [`text_file`] | text files that people write, read in bounded memory |
//! | [`exit`], [`usage`], [`error_text`] | exit codes; command lines that cannot be; errors in words |
//! | [`bus_observation`] | what is heard on a bus by somebody who sends nothing |
//! | [`realtime`] | how the thread of a loop is scheduled |
//! | [`sdo_access`] | SDO access to drives that a run has stopped |
//! | [`eds`] | what makers' dictionaries say |
//! | `words` | lists in sentences |
//! | [`dimensions`] | the one place that says how many joints the robot has |
//!
//! The control loop itself is the crate [`uarm_loop`]: see [`uarm_loop::control_loop`].
#![forbid(unsafe_code)]

pub mod bought;
pub mod bus_observation;
pub mod campaign;
pub mod cli;
pub mod commands;
pub mod console;
pub mod dimensions;
pub mod drives;
pub mod eds;
#[cfg(test)]
mod emulated_bus;
pub mod error_text;
pub mod exit;
pub mod figures;
pub mod inspection;
pub mod log_files;
pub mod options;
pub mod output_files;
pub mod realtime;
pub mod reference;
pub mod report;
pub mod robot;
pub mod sdo_access;
pub mod signals;
pub mod simulated_plant;
pub mod simulated_robot;
pub mod stability;
pub mod study;
pub mod text_file;
pub mod usage;
pub mod version;
mod words;
