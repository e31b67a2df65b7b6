//! A live view of a running controller, made of the log that it writes anyway: `uarm monitor`.
//!
//! The view reads a file and nothing else. It has no connection to the loop, which does not know of it.
//!
//! | module | subject |
//! |---|---|
//! | [`source`] | the log to follow, and the wait for it |
//! | [`state`] | what the log has told so far |
//! | [`snapshot`] | the newest of it, as numbers with units |
//! | [`view`] | the same to look at |
//! | [`terminal`] | the screen and the keys |

pub mod snapshot;
pub mod source;
pub mod state;
pub mod terminal;
pub mod view;
