//! CiA 402 drives on CANopen: what both ends of the wire agree on, and the master that runs them.
//!
//! | module | subject |
//! |---|---|
//! | [`objects`] | the object dictionary entries that are read, written or mapped |
//! | [`cia402`] | statusword, controlword and the power state machine between them |
//! | [`wire`] | identifiers and payloads of every frame |
//! | [`words`] | abort and emergency codes in words |
//! | [`network`] | the master: start, cycle, supervision, stop |

pub mod cia402;
pub mod network;
pub mod objects;
pub mod wire;
pub mod words;

pub use network::DriveNetwork;

pub use canopen_rs::{Address, DataType, NmtCommand, NmtState, NodeId, Value};
