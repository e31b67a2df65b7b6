//! Many experiments on drawn robots: what several subcommands need for them.
//!
//! | module | subject |
//! |---|---|
//! | [`random`] | random streams: one for each seed, subject and index |
//! | [`spread`], [`start`] | plants around a plant; where an experiment starts |
//! | [`parallel`], [`progress`] | work on all cores; its progress bar |

pub mod parallel;
pub mod progress;
pub mod random;
pub mod spread;
pub mod start;
