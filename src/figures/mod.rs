//! What figures of several commands have in common.
//!
//! | module | subject |
//! |---|---|
//! | [`style`] | how the curves of each signal and law look |
//! | [`sets`] | the fuzzy sets and how they were learned |
//! | [`output`] | which files are written |

pub mod output;
pub mod sets;
pub mod style;
