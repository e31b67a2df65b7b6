//! From traces of runs to trained fuzzy sets.
//!
//! | module | subject |
//! |---|---|
//! | [`trace_file`] | reading what `uarm run --trace` writes |
//! | [`samples`] | which signals are inputs and target, and why |
//! | [`learn`] | ANFIS on them |

pub mod learn;
pub mod samples;
pub mod trace_file;
