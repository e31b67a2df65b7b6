//! Many experiments on drawn robots: what several subcommands need for them.
//!
//! | module | subject |
//! |---|---|
//! | [`random`] | random streams: one for each seed, subject and index |
//! | [`spread`], [`start`] | plants around a plant; where an experiment starts |
//! | [`shard`], [`collection`] | a part of the experiments; the file of their results, and how parts become a whole |
//! | [`parallel`], [`progress`] | work on all cores; its progress bar |

pub mod collection;
pub mod parallel;
pub mod progress;
pub mod random;
pub mod shard;
pub mod spread;
pub mod start;
