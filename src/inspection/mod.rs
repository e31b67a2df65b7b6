//! What a log tells: `uarm show`.
//!
//! | module | subject |
//! |---|---|
//! | [`outcome`] | indices, peaks and timing, recomputed from the cycles |
//! | [`summary`] | all that is told of a run |
//! | [`health`] | bus and drives in words |
//! | [`mod@print`] | the summary for people |
//! | [`panels`] | what is plotted |
//! | [`chart`] | a panel in a terminal |

pub mod chart;
pub mod health;
pub mod outcome;
pub mod panels;
pub mod print;
pub mod summary;
