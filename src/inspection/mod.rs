//! What a log tells, as `uarm show` and `uarm monitor` both show it.
//!
//! | module | subject |
//! |---|---|
//! | [`health`] | bus and drives in words |
//! | [`panels`] | what is plotted |
//! | [`chart`] | a panel in a terminal |
//! | [`plain_text`] | what terminal widgets draw, as plain text |

pub mod chart;
pub mod health;
pub mod panels;
pub mod plain_text;
