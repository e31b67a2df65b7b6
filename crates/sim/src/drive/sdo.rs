//! The drive's SDO server. Reading, and the bytes of short writes, are the protocol stack's; what is refused, and writes in
//! segments, which must be judged when they are whole, are the drive's.

use super::memory::Download;
use super::sdo_rules::{Refusal, Rules};
use super::state::EmulatedDrive;
use crate::outbox::Outbox;
use canopen_rs::{Address, Value};
use heapless::Vec;
use uarm_io::drive::NmtState;
use uarm_io::drive::wire::{self, Channel};
use uarm_io::time::Instant;

/// Client command specifiers, in the upper three bits of the first byte (CiA 301, 7.2.4.3).
const COMMAND_MASK: u8 = 0xE0;
const DOWNLOAD_SEGMENT: u8 = 0x00;
const DOWNLOAD: u8 = 0x20;
const UPLOAD: u8 = 0x40;
const ABORT: u8 = 0x80;
/// Bits of a download's first byte.
const EXPEDITED: u8 = 0x02;
const SIZE_INDICATED: u8 = 0x01;
/// Bits of a segment's first byte.
const TOGGLE: u8 = 0x10;
const LAST: u8 = 0x01;
/// Server command specifiers.
const DOWNLOAD_RESPONSE: u8 = 0x60;
const SEGMENT_RESPONSE: u8 = 0x20;

impl<const N: usize> EmulatedDrive<N> {
    pub(super) fn on_sdo(&mut self, data: &[u8], now: Instant, outbox: &mut Outbox) {
        let Ok(request) = wire::decode_sdo(data) else { return };
        let listens = matches!(self.node.state(), NmtState::PreOperational | NmtState::Operational);
        if !listens || self.faults.sdo_silent {
            return;
        }
        let [command, low, high, subindex, ..] = request;
        let address = Address::new(u16::from_le_bytes([low, high]), subindex);
        let outcome = match command & COMMAND_MASK {
            DOWNLOAD => self.on_download(address, &request).map(Some),
            DOWNLOAD_SEGMENT if self.download.is_some() => self.on_segment(&request, now, outbox).map(Some),
            UPLOAD => self.may_upload(address).map(|()| None),
            ABORT => {
                self.download = None;
                Ok(None)
            }
            _ => Ok(None),
        };
        match outcome {
            Ok(Some(Reply::Here(answer))) => self.answer(&answer, now, outbox),
            Ok(Some(Reply::OfStack) | None) => self.ask_stack(&request, now, outbox),
            Err((address, refusal)) => {
                self.download = None;
                let [c0, c1, c2, c3] = refusal.code().to_le_bytes();
                let [low, high] = address.index.to_le_bytes();
                self.answer(&[ABORT, low, high, address.subindex, c0, c1, c2, c3], now, outbox);
            }
        }
    }

    fn rules(&self) -> Rules<'_, N> {
        Rules { values: self.node.od(), objects: &self.objects, power: self.power }
    }

    fn answer(&self, answer: &[u8; 8], now: Instant, outbox: &mut Outbox) {
        self.push(wire::sdo_response_frame(self.parameters.node(), answer), now, outbox);
    }

    fn ask_stack(&mut self, request: &[u8; 8], now: Instant, outbox: &mut Outbox) {
        let identifier = Channel::SdoRequest(self.parameters.node()).identifier().as_raw();
        if let Some(response) = self.node.on_frame(identifier, request) {
            self.send(&response, now, outbox);
        }
        if let Some(written) = self.node.take_written_object() {
            self.on_written(written, now, outbox);
        }
    }

    fn may_upload(&self, address: Address) -> Result<(), (Address, Refusal)> {
        self.rules().exists(address).map_err(|refusal| (address, refusal))?;
        // An empty text or domain: the stack has no frame for it.
        let is_empty = self.node.od().entry(address).is_some_and(|entry| entry.value.size() == 0);
        if is_empty { Err((address, Refusal::NoData)) } else { Ok(()) }
    }

    fn on_download(&mut self, address: Address, request: &[u8; 8]) -> Result<Reply, (Address, Refusal)> {
        let [command, low, high, subindex, d0, d1, d2, d3] = *request;
        let rules = self.rules();
        let refused = |refusal| (address, refusal);
        rules.exists(address).map_err(refused)?;
        let Some(entry) = rules.values.entry(address).filter(|entry| entry.access.is_writable()) else {
            return Err(refused(Refusal::ReadOnly));
        };
        let (data_type, expedited) = (entry.value.data_type(), command & EXPEDITED != 0);
        let data = [d0, d1, d2, d3];
        let size = match (expedited, command & SIZE_INDICATED != 0) {
            (true, true) => Some(4 - usize::from((command >> 2) & 0x03)),
            (true, false) => None,
            (false, true) => usize::try_from(u32::from_le_bytes(data)).ok(),
            (false, false) => None,
        };
        let expected = data_type.fixed_size();
        if let (Some(size), Some(expected)) = (size, expected) {
            fits(size, expected).map_err(refused)?;
        }
        if expedited {
            let size = size.or(expected).unwrap_or_default();
            let data = data.get(..size).ok_or(refused(Refusal::TooFewBytes))?;
            let value = Value::decode_le(data_type, data).map_err(|_| refused(Refusal::ValueRange))?;
            rules.check(address, value).map_err(refused)?;
            return Ok(Reply::OfStack);
        }
        self.download = Some(Download { address, data: Vec::new(), toggle: 0 });
        Ok(Reply::Here([DOWNLOAD_RESPONSE, low, high, subindex, 0, 0, 0, 0]))
    }

    fn on_segment(
        &mut self,
        request: &[u8; 8],
        now: Instant,
        outbox: &mut Outbox,
    ) -> Result<Reply, (Address, Refusal)> {
        let Some(mut download) = self.download.take() else { return Ok(Reply::OfStack) };
        let address = download.address;
        let refused = |refusal| (address, refusal);
        let [command, data @ ..] = request;
        if command & TOGGLE != download.toggle {
            return Err(refused(Refusal::Toggle));
        }
        let data = data.get(..7 - usize::from((command >> 1) & 0x07)).unwrap_or_default();
        download.data.extend_from_slice(data).map_err(|_| refused(Refusal::TooManyBytes))?;
        let answer = Reply::Here([SEGMENT_RESPONSE | download.toggle, 0, 0, 0, 0, 0, 0, 0]);
        if command & LAST == 0 {
            self.download = Some(Download { toggle: download.toggle ^ TOGGLE, ..download });
            return Ok(answer);
        }
        let Some(data_type) = self.node.od().entry(address).map(|entry| entry.value.data_type()) else {
            return Err(refused(Refusal::NoObject));
        };
        if let Some(expected) = data_type.fixed_size() {
            fits(download.data.len(), expected).map_err(refused)?;
        }
        let value = Value::decode_le(data_type, &download.data).map_err(|_| refused(Refusal::ValueRange))?;
        self.rules().check(address, value).map_err(refused)?;
        self.node.od_mut().write(address, value).map_err(|_| refused(Refusal::ReadOnly))?;
        self.on_written(address, now, outbox);
        Ok(answer)
    }
}

/// Who answers a request that is not refused.
enum Reply {
    /// The drive, with this.
    Here([u8; 8]),
    /// The protocol stack.
    OfStack,
}

const fn fits(size: usize, expected: usize) -> Result<(), Refusal> {
    if size > expected {
        Err(Refusal::TooManyBytes)
    } else if size < expected {
        Err(Refusal::TooFewBytes)
    } else {
        Ok(())
    }
}
