//! Faults drawn by the thousand: fault × controller × phase of the motion × plant, each run in virtual time and held against
//! what must be true of any run.
//!
//! A trial depends on its seed and the robot alone. So seeds may be divided among machines, and the one that fails runs again
//! by itself.
//!
//! | module | subject |
//! |---|---|
//! | [`fault`] | what happens, and how it is drawn |
//! | [`scenario`] | a seed's controller, plant, fault and instant |
//! | [`injection`] | a link on which it happens, and which watches wire and joints |
//! | [`expectation`] | how a run with that fault may end, and how soon |
//! | [`observation`] | how a run ended, and what was seen of it |
//! | [`judgement`] | what must be true of any run |
//! | [`trial`] | one seed, run and judged |
//! | [`store`] | the file of trials |
//! | [`summary`] | what came of them, by fault |

pub mod expectation;
pub mod fault;
pub mod injection;
pub mod judgement;
pub mod observation;
pub mod scenario;
pub mod store;
pub mod summary;
pub mod trial;
