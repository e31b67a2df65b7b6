//! What an emulated drive holds, and its access to objects and bus.

use super::dictionary::CAPACITY;
use super::faults::Faults;
use super::parameters::DriveParameters;
use super::timers::{Ticker, Watchdog};
use crate::outbox::Outbox;
use canopen_rs::{Address, Node, TxFrame, Value};
use embedded_can::StandardId;
use uarm_io::drive::cia402::{Controlword, PowerState};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

/// The deadline of RPDO1, ms; `uarm_io` has no constant for it.
pub(super) const RPDO1_EVENT_TIMER: Address = Address::new(0x1400, 5);

/// What a frame did to the drive, as far as its surroundings care.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reaction {
    /// Nothing that concerns others.
    None,
    /// NMT reset it.
    Reset,
}

/// A CiA 402 drive with motor, encoder and holding brake: the slave that `uarm_io`'s master runs.
///
/// The brake is open in *Operation enabled* and closed in every other state. Target torque acts in cyclic synchronous torque
/// mode only, and is zeroed when the drive leaves *Operation enabled*, so that no old value acts when it comes back.
#[derive(Debug)]
pub struct EmulatedDrive {
    pub(super) parameters: DriveParameters,
    pub(super) node: Node<CAPACITY>,
    pub(super) power: PowerState,
    /// The previous controlword: a fault reset is an edge.
    pub(super) controlword: Controlword,
    pub(super) heartbeat: Ticker,
    pub(super) master: Watchdog,
    pub(super) commands: Watchdog,
    /// A synchronous RPDO waits for the next SYNC.
    pub(super) command_waits: bool,
    pub(super) faults: Faults,
    /// An injected fault that is yet to be reported.
    pub(super) report_due: bool,
}

impl EmulatedDrive {
    pub(super) fn unsigned(&self, address: Address) -> u32 {
        match self.node.od().read(address) {
            Ok(Value::Unsigned32(value)) => value,
            _ => 0,
        }
    }

    pub(super) fn unsigned16(&self, address: Address) -> u16 {
        match self.node.od().read(address) {
            Ok(Value::Unsigned16(value)) => value,
            _ => 0,
        }
    }

    /// Sets an object of the table; the table's test makes sure that it is there with this type.
    pub(super) fn set(&mut self, address: Address, value: Value) {
        let _ = self.node.od_mut().set(address, value);
    }

    pub(super) fn send(&self, frame: &TxFrame, now: Instant, outbox: &mut Outbox) {
        if let Some(frame) = StandardId::new(frame.cob_id).and_then(|id| Frame::new(id, frame.data())) {
            self.push(frame, now, outbox);
        }
    }

    pub(super) fn push(&self, frame: Frame, now: Instant, outbox: &mut Outbox) {
        if !self.faults.off_bus() {
            outbox.push(frame, now);
        }
    }
}
