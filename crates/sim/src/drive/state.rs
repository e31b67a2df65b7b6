//! What an emulated drive holds, and its access to objects and bus.

use super::dictionary::CAPACITY;
use super::faults::Faults;
use super::homing_state::{Homing, Sight};
use super::memory::{Download, Errors, PDOS, Sent};
use super::numbers::{number_of, value_of};
use super::objects::DriveDictionary;
use super::parameters::DriveParameters;
use super::timers::{Ticker, Watchdog};
use crate::outbox::Outbox;
use canopen_rs::{Address, Node, TxFrame};
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

/// What a counter has of the angle of its joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counter {
    /// It begins at zero at the next reading.
    Beginning,
    /// It shows so many counts less than the angle is.
    Since(i32),
}

/// A CiA 402 drive with motor, encoder and holding brake: the slave that `uarm_io`'s master runs.
///
/// The brake is open in *Operation enabled* and closed in every other state. Target torque acts in cyclic synchronous torque
/// mode only, and is zeroed when the drive leaves *Operation enabled*, so that no old value acts when it comes back.
///
/// `N` is how many objects it can hold. The default is for its own dictionary; a maker's needs more.
#[derive(Debug)]
pub struct EmulatedDrive<const N: usize = CAPACITY> {
    pub(super) parameters: DriveParameters,
    /// Its objects at power-on.
    pub(super) objects: DriveDictionary,
    pub(super) node: Node<N>,
    /// Identifiers of its RPDOs as 1400h to 1403h have them; `None` for one that is off.
    pub(super) rpdos: [Option<u16>; PDOS],
    pub(super) power: PowerState,
    /// The motor's torque at the joint, N·m, as objects and faults have it: they are looked up when they may have changed.
    pub(super) torque: f64,
    /// The previous controlword: a fault reset is an edge.
    pub(super) controlword: Controlword,
    pub(super) heartbeat: Ticker,
    pub(super) master: Watchdog,
    pub(super) commands: Watchdog,
    /// Synchronous RPDOs, which act with all that is in them at the next SYNC.
    pub(super) waiting: [Option<Frame>; PDOS],
    /// A write in segments, not yet whole.
    pub(super) download: Option<Download>,
    pub(super) errors: Errors,
    /// What the TPDOs last carried.
    pub(super) sent: [Sent; PDOS],
    /// The last SYNC had the wrong length: said once.
    pub(super) sync_is_wrong: bool,
    /// When it has booted.
    pub(super) boots_at: Option<Instant>,
    /// The fault with which it starts was reported.
    pub(super) had_first_fault: bool,
    pub(super) faults: Faults,
    /// What its counter does not count.
    pub(super) counter: Counter,
    /// An injected fault that is yet to be reported.
    pub(super) report_due: bool,
    /// An answer to SYNC that an injected fault delays, and when it is sent.
    pub(super) late: Option<(Frame, Instant)>,
    /// What index and switches show.
    pub(super) sight: Sight,
    pub(super) homing: Homing,
}

impl<const N: usize> EmulatedDrive<N> {
    /// The integer that an object holds; `None` if there is none, or it holds something else.
    pub(super) fn number(&self, address: Address) -> Option<i128> {
        self.node.od().entry(address).and_then(|entry| number_of(&entry.value))
    }

    /// Makes an object show a number. A maker's dictionary need not have it, nor give it room for the number.
    pub(super) fn set_number(&mut self, address: Address, number: i128) {
        let data_type = self.node.od().entry(address).map(|entry| entry.value.data_type());
        if let Some(value) = data_type.and_then(|data_type| value_of(data_type, number)) {
            let _ = self.node.od_mut().set(address, value);
        }
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
