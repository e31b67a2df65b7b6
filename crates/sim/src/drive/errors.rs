//! Error register, error history and emergencies (CiA 301, 7.2.7 and 7.5.2.4).

use super::memory::{ERROR_HISTORY, Errors};
use super::state::EmulatedDrive;
use crate::outbox::Outbox;
use canopen_rs::{Address, EmergencyMessage, ErrorRegister};
use embedded_can::StandardId;
use uarm_io::drive::objects as od;
use uarm_io::drive::wire;
use uarm_io::drive::{NmtState, NodeId};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

const HISTORY: u16 = 0x1003;
/// Bit 31 of 1014h: the drive sends no emergencies.
const NO_EMERGENCIES: u32 = 1 << 31;

impl<const N: usize> EmulatedDrive<N> {
    /// Reports an error that leaves the power stage alone.
    pub(super) fn warn(&mut self, code: u16, register: u8, now: Instant, outbox: &mut Outbox) {
        self.errors.add(code, register);
        self.show_errors();
        self.send_emergency(code, now, outbox);
    }

    /// All errors are gone.
    pub(super) fn clear_errors(&mut self, now: Instant, outbox: &mut Outbox) {
        self.errors = Errors::default();
        self.show_errors();
        self.send_emergency(0, now, outbox);
    }

    /// Forgets what was, not what is: 0 was written to 1003h:00.
    pub(super) fn clear_error_history(&mut self) {
        self.errors.history.clear();
        self.show_errors();
    }

    fn show_errors(&mut self) {
        self.set_number(od::ERROR_REGISTER.address(), self.errors.register.into());
        let entries = self.errors.history.clone();
        self.set_number(Address::new(HISTORY, 0), i128::try_from(entries.len()).unwrap_or_default());
        for subindex in 1..=ERROR_HISTORY {
            let code = entries.get(usize::from(subindex) - 1).copied().unwrap_or_default();
            self.set_number(Address::new(HISTORY, subindex), code.into());
        }
    }

    /// Emergencies are sent in *Pre-operational* and *Operational*, with the identifier of 1014h.
    fn send_emergency(&self, code: u16, now: Instant, outbox: &mut Outbox) {
        if !matches!(self.node.state(), NmtState::PreOperational | NmtState::Operational) {
            return;
        }
        let node: NodeId = self.parameters.node();
        let message = EmergencyMessage::new(code, ErrorRegister(self.errors.register), [0; 5]);
        let frame = wire::emergency_frame(node, &message);
        let frame = match self.number(od::EMERGENCY_IDENTIFIER.address()).and_then(|id| u32::try_from(id).ok()) {
            Some(identifier) if identifier & NO_EMERGENCIES != 0 => return,
            Some(identifier) => {
                let identifier = u16::try_from(identifier & 0x7FF).ok().and_then(StandardId::new);
                identifier.and_then(|identifier| Frame::new(identifier, frame.data()))
            }
            None => Some(frame),
        };
        if let Some(frame) = frame {
            self.push(frame, now, outbox);
        }
    }
}
