//! The drive's PDOs: up to four each way, mapped as the dictionary says.

use super::memory::Sent;
use super::numbers::number_of;
use super::power::error;
use super::state::EmulatedDrive;
use crate::outbox::Outbox;
use canopen_rs::{Address, ErrorRegister, MappingEntry, pdo};
use embedded_can::StandardId;
use uarm_io::drive::NmtState;
use uarm_io::drive::objects as od;
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

/// The numbers of the PDOs each way, from 0.
const NUMBERS: core::ops::Range<u16> = 0..4;
const RPDO: u16 = 0x1400;
const RPDO_MAPPING: u16 = 0x1600;
const TPDO: u16 = 0x1800;
const TPDO_MAPPING: u16 = 0x1A00;
/// Sub-indices of a PDO's parameter.
const IDENTIFIER: u8 = 1;
const TRANSMISSION: u8 = 2;
/// The largest transmission type that waits for a SYNC.
const LAST_SYNCHRONOUS: i128 = 240;
/// From here on a TPDO is sent when what it carries has changed.
const FIRST_EVENT_DRIVEN: i128 = 254;

impl<const N: usize> EmulatedDrive<N> {
    /// Takes the PDOs over as the dictionary has them now.
    pub(super) fn configure_pdos(&mut self) {
        self.node.configure_pdos_from_od();
        for (number, rpdo) in NUMBERS.zip(&mut self.rpdos) {
            let entry = self.node.od().entry(Address::new(RPDO + number, IDENTIFIER));
            let identifier = entry.and_then(|entry| number_of(&entry.value)).and_then(|id| u32::try_from(id).ok());
            *rpdo = identifier.filter(|id| pdo::pdo_is_valid(*id)).map(pdo::pdo_can_id);
        }
    }

    /// The RPDO that a frame is, if it is one of this drive's.
    pub(super) fn rpdo_of(&self, frame: &Frame) -> Option<u16> {
        let identifier = Some(frame.id().as_raw());
        NUMBERS.zip(&self.rpdos).find(|(_, rpdo)| **rpdo == identifier).map(|(number, _)| number)
    }

    pub(super) fn on_pdo(&mut self, number: u16, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        if self.node.state() != NmtState::Operational {
            return;
        }
        if frame.data().len() < self.mapped_bytes(RPDO_MAPPING + number) {
            self.warn(error::PDO_LENGTH, ErrorRegister::COMMUNICATION, now, outbox);
            return;
        }
        if number == 0 {
            self.commands.feed(now);
        }
        let kind = self.number(Address::new(RPDO + number, TRANSMISSION));
        if kind.is_some_and(|kind| kind <= LAST_SYNCHRONOUS) {
            if let Some(waiting) = self.waiting.get_mut(usize::from(number)) {
                *waiting = Some(*frame);
            }
        } else {
            self.take_pdo(frame, now, outbox);
        }
    }

    /// Takes the objects of an RPDO over, and obeys the controlword.
    pub(super) fn take_pdo(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        self.node.on_frame(frame.id().as_raw(), frame.data());
        self.on_command(now, outbox);
    }

    /// Sends the TPDOs whose turn it is at a SYNC. What is sent on change is looked at now, too.
    pub(super) fn send_tpdos(&mut self, now: Instant, outbox: &mut Outbox) {
        self.send_those(now, outbox, |kind, syncs, changed| match kind {
            0 => changed,
            1..=LAST_SYNCHRONOUS => syncs >= kind,
            FIRST_EVENT_DRIVEN.. => changed,
            _ => false,
        });
    }

    /// Sends the event-driven TPDOs: their drive has become *Operational*.
    pub(super) fn send_first_events(&mut self, now: Instant, outbox: &mut Outbox) {
        self.sent = Default::default();
        self.send_those(now, outbox, |kind, _, _| kind >= FIRST_EVENT_DRIVEN);
        for sent in &mut self.sent {
            sent.syncs = 0;
        }
    }

    fn send_those(&mut self, now: Instant, outbox: &mut Outbox, is_due: impl Fn(i128, i128, bool) -> bool) {
        if self.node.state() != NmtState::Operational {
            return;
        }
        for number in NUMBERS {
            let Some(frame) = self.tpdo(number) else { continue };
            let kind = self.number(Address::new(TPDO + number, TRANSMISSION)).unwrap_or(FIRST_EVENT_DRIVEN);
            let Some(sent) = self.sent.get_mut(usize::from(number)) else { continue };
            sent.syncs += 1;
            if is_due(kind, sent.syncs, sent.last != Some(frame)) {
                let before = core::mem::replace(sent, Sent { syncs: 0, last: Some(frame) }).last;
                if number == 0 {
                    self.send_tpdo1(frame, before, now, outbox);
                } else {
                    self.push(frame, now, outbox);
                }
            }
        }
    }

    /// Sends TPDO1, as far as injected faults let it; `before` is the one before it.
    fn send_tpdo1(&mut self, frame: Frame, before: Option<Frame>, now: Instant, outbox: &mut Outbox) {
        if self.faults.feedback_lost > 0 {
            self.faults.feedback_lost -= 1;
            return;
        }
        if !self.faults.feedback_late.is_zero() {
            self.late = Some((frame, now + self.faults.feedback_late));
            return;
        }
        if let Some(before) = before.filter(|_| self.faults.feedback_replayed) {
            self.push(before, now, outbox);
        }
        self.push(frame, now, outbox);
    }

    /// A TPDO with what its objects hold; `None` if it is off, empty or maps what is not there.
    fn tpdo(&self, number: u16) -> Option<Frame> {
        let identifier = u32::try_from(self.number(Address::new(TPDO + number, IDENTIFIER))?).ok()?;
        let identifier = Some(identifier).filter(|id| pdo::pdo_is_valid(*id)).map(pdo::pdo_can_id)?;
        let mut data = heapless::Vec::<u8, 8>::new();
        for entry in self.mapping(TPDO_MAPPING + number) {
            let value = self.node.od().read(entry.address).ok()?;
            let mut bytes = [0; 8];
            let length = value.encode_le(bytes.get_mut(..value.size())?).ok()?;
            data.extend_from_slice(bytes.get(..length)?).ok()?;
        }
        if data.is_empty() { None } else { Frame::new(StandardId::new(identifier)?, &data) }
    }

    fn mapping(&self, index: u16) -> impl Iterator<Item = MappingEntry> {
        let count = self.number(Address::new(index, 0)).and_then(|count| u8::try_from(count).ok()).unwrap_or_default();
        let entry = move |subindex| match self.node.od().read(Address::new(index, subindex)) {
            Ok(value) => number_of(&value).and_then(|entry| u32::try_from(entry).ok()).map(MappingEntry::from_u32),
            Err(_) => None,
        };
        (1..=count).filter_map(entry)
    }

    fn mapped_bytes(&self, index: u16) -> usize {
        self.mapping(index).map(|entry| usize::from(entry.bit_length)).sum::<usize>() / 8
    }

    /// Whether the drive was told to expect a counter in the SYNC.
    pub(super) fn wants_counter(&self) -> bool {
        self.number(od::SYNC_COUNTER_OVERFLOW.address()).is_some_and(|overflow| overflow != 0)
    }
}
