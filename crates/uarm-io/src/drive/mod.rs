//! CiA 402 drives on CANopen: what both ends of the wire agree on, and the master that runs them.
//!
//! | module | subject |
//! |---|---|
//! | [`objects`] | the object dictionary entries that are read, written or mapped |
//! | [`cia402`] | statusword, controlword and the power state machine between them |
//! | [`wire`] | identifiers and payloads of every frame |

pub mod cia402;
pub mod objects;
pub mod wire;

pub use canopen_rs::{Address, DataType, NmtCommand, NmtState, NodeId, Value};
