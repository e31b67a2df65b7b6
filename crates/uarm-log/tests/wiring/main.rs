//! How logs and replays are connected to the runs that they tell of: every expected number is worked out by hand.

mod bus_cycles;
mod exact;
mod log_file;
mod log_parts;
mod support;
mod what_if;
mod windows;
