//! What runs every 3 ms: the hard control loop of a CANopen manipulator, from encoder counts to torques, with its limits
//! and records. It sees [`RobotDrives`](uarm_io::drive::RobotDrives) and a [`Clock`](uarm_io::time::Clock), so that real drives in real
//! time and a simulated robot in virtual time run the same code.
//!
//! Generic over `J` joints with drives, of which `N` are active ([`dimensions`]). The crate knows no command line, no file
//! format and no simulator.
//!
//! # One cycle
//!
//! Wait for the tick → SYNC → counts in → angle, velocity → reference → torque → limits → torque out → record:
//! [`ControlLoop::run`](control_loop::ControlLoop::run). Nothing in it allocates, locks, logs text, reads a file or panics.
//!
//! ```
//! use uarm_loop::period::Period;
//! use uarm_loop::schedule::{OverrunPolicy, Schedule};
//! use uarm_io::time::{Clock, Duration, Instant};
//!
//! /// A clock on which sleeping takes no time.
//! struct Simulated(Instant);
//!
//! impl Clock for Simulated {
//!     fn now(&self) -> Instant {
//!         self.0
//!     }
//!     fn sleep_until(&mut self, deadline: Instant) {
//!         self.0 = self.0.max(deadline);
//!     }
//! }
//!
//! let period = Period::new(Duration::from_millis(3)).expect("within 100 us to 100 ms");
//! let mut clock = Simulated(Instant::default());
//! let mut schedule = Schedule::new(Instant::default(), period, OverrunPolicy::Stop);
//! assert_eq!(schedule.wait(&mut clock)?.elapsed, 0);
//! assert_eq!(schedule.wait(&mut clock)?.elapsed, 1);
//! assert_eq!(clock.now(), Instant::from_nanoseconds(3_000_000));
//! # Ok::<(), uarm_loop::schedule::Overrun>(())
//! ```
//!
//! # Map
//!
//! | module | subject |
//! |---|---|
//! | [`mod@run`] | a whole run: start the drives, loop, stop and brake |
//! | [`supervisor`] | whether torque may flow: the states of a run, and the one table of what leads where |
//! | [`control_loop`] | the loop itself |
//! | [`signal_path`] | from counts to torques without I/O: what a replay runs again |
//! | [`estimation`], [`mod@motion`], [`guard`], [`torque`] | its stages: encoders, desired motion, limits of the robot, drives' torques |
//! | [`barrier`] | the limits of motion, early enough to stop before them |
//! | [`finite`], [`saturation`] | stops on NaN or infinity; on torques that are limited for too long |
//! | [`rest`] | do the joints stand still when brakes open? |
//! | [`fade`] | the ramp of a stop that somebody asked for |
//! | [`plausibility`] | can a joint be where its counts say? |
//! | [`supervision`] | faults that only the model sees: a momentum observer, and what its residual says |
//! | [`period`], [`schedule`], [`task_clock`] | the period; ticks and late ones; what time and period the laws are told |
//! | [`record`], [`keyframe`] | what a cycle leaves behind; the whole inner state, frozen |
//! | [`recording`] | from the loop to files: lock-free queues and a writer thread |
//! | [`timing`], [`statistics`], [`outcome`] | latencies and their verdict; peaks; what came of a run |
//! | [`fault_code`] | names of what ends a run, the same in reports, logs and documents |
//! | [`stability`] | is the loop stable with its period, estimators and delay? |
//! | [`robot`], [`network`], [`odrive`] | the robot as types; what the CANopen or ODrive master must know of it |
//! | [`settings`], [`mod@choice`], [`dimensions`] | what a run does; choices by name; how joints are counted |
//! | [`progress`], [`stop_request`] | how others look at a running loop, and end it |
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

pub use hinf_control;
pub use nalgebra;
pub use uarm_io;

pub mod barrier;
pub mod choice;
pub mod control_loop;
pub mod dimensions;
pub mod estimation;
pub mod fade;
pub mod fault_code;
pub mod finite;
pub mod guard;
pub mod keyframe;
pub mod motion;
pub mod network;
pub mod odrive;
pub mod outcome;
pub mod period;
pub mod plausibility;
pub mod progress;
pub mod record;
pub mod recording;
pub mod reference;
pub mod rest;
pub mod robot;
pub mod run;
pub mod saturation;
pub mod schedule;
pub mod settings;
pub mod signal_path;
pub mod stability;
pub mod statistics;
pub mod stop_request;
pub mod supervision;
pub mod supervisor;
pub mod task_clock;
pub mod timing;
pub mod torque;

/// The README's example, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
