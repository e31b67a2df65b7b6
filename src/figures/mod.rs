//! What figures of several commands have in common.
//!
//! | module | subject |
//! |---|---|
//! | [`style`] | how the curves of each signal and law look |
//! | [`output`] | which files are written |

pub mod output;
pub mod style;
