//! How the parts of the loop are connected: every expected number is worked out by hand.

mod control_loop;
mod estimation;
mod fake_bus;
mod fake_path;
mod fault_code;
mod finite;
mod guard;
mod indices;
mod keyframe;
mod recording;
mod records;
mod schedule;
mod signal_path;
mod supervisor;
mod task_clock;
mod timing;
mod torque;
