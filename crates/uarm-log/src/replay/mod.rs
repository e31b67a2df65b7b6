//! Replay: the recorded frames and instants through the same estimators and controller, and every signal compared with the
//! recorded one, bit for bit.
//!
//! | module | subject |
//! |---|---|
//! | [`bus_cycles`] | frames, cut at each SYNC |
//! | [`one_clock`] | instants of a clock that was set, brought back to one |
//! | [`source`] | what is replayed |
//! | [`comparison`] | two records, bit for bit |
//! | [`exact`] | the run again, as it was |
//! | [`what_if`] | another law or robot on the same measurements |
//! | [`windows`] | a run in windows, in bounded memory |

pub mod bus_cycles;
pub mod comparison;
pub mod exact;
pub mod one_clock;
pub mod source;
pub mod what_if;
pub mod windows;
