//! Error frames: what the CAN controller tells about itself (`linux/can/error.h`).
//!
//! The kernel reports several classes at once in the identifier's bits, with details in the data bytes. They are decoded
//! here without allocating, since they come in bursts just when the loop has the least time to lose.

use crate::link::{ControllerProblem, ErrorCounters};
use libc::{
    CAN_ERR_ACK, CAN_ERR_BUSERROR, CAN_ERR_BUSOFF, CAN_ERR_CNT, CAN_ERR_CRTL, CAN_ERR_PROT, CAN_ERR_RESTARTED,
    CAN_ERR_TRX, CAN_ERR_TX_TIMEOUT,
};

/// Bits of the controller status byte (`CAN_ERR_CRTL_*`, data byte 1).
mod controller_status {
    pub const RECEIVE_OVERFLOW: u8 = 0x01;
    pub const TRANSMIT_OVERFLOW: u8 = 0x02;
    pub const RECEIVE_WARNING: u8 = 0x04;
    pub const TRANSMIT_WARNING: u8 = 0x08;
    pub const RECEIVE_PASSIVE: u8 = 0x10;
    pub const TRANSMIT_PASSIVE: u8 = 0x20;
}

/// What an error frame means for the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerEvent {
    /// The controller left the bus.
    BusOff,
    /// The controller came back after bus-off.
    Restarted,
    /// Trouble short of bus-off.
    Problem(ControllerProblem),
    /// Nothing to act on: lost arbitration, back to error-active, counters only.
    Notice,
}

/// Decodes an error frame: its class bits (the identifier without flags) and its data.
pub fn decode(classes: u32, data: [u8; 8]) -> (ControllerEvent, Option<ErrorCounters>) {
    let [_, controller, .., transmit, receive] = data;
    let counters = (classes & CAN_ERR_CNT != 0).then_some(ErrorCounters { transmit, receive });
    (event(classes, controller), counters)
}

fn event(classes: u32, controller: u8) -> ControllerEvent {
    let has = |class: u32| classes & class != 0;
    if has(CAN_ERR_BUSOFF) {
        return ControllerEvent::BusOff;
    }
    // A restart clears the state that the other classes of the same frame would describe.
    if has(CAN_ERR_RESTARTED) {
        return ControllerEvent::Restarted;
    }
    let candidates = [
        if has(CAN_ERR_CRTL) { controller_problem(controller) } else { None },
        has(CAN_ERR_TX_TIMEOUT).then_some(ControllerProblem::TransmitTimeout),
        has(CAN_ERR_ACK).then_some(ControllerProblem::NoAcknowledge),
        has(CAN_ERR_TRX).then_some(ControllerProblem::Transceiver),
        (has(CAN_ERR_PROT) || has(CAN_ERR_BUSERROR)).then_some(ControllerProblem::BusError),
    ];
    candidates.into_iter().flatten().min().map_or(ControllerEvent::Notice, ControllerEvent::Problem)
}

fn controller_problem(status: u8) -> Option<ControllerProblem> {
    use controller_status::*;
    let has = |bits: u8| status & bits != 0;
    if has(RECEIVE_PASSIVE | TRANSMIT_PASSIVE) {
        Some(ControllerProblem::ErrorPassive)
    } else if has(RECEIVE_OVERFLOW) {
        Some(ControllerProblem::ReceiveOverflow)
    } else if has(TRANSMIT_OVERFLOW) {
        Some(ControllerProblem::TransmitOverflow)
    } else if has(RECEIVE_WARNING | TRANSMIT_WARNING) {
        Some(ControllerProblem::ErrorWarning)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(classes: u32, controller: u8) -> ControllerEvent {
        decode(classes, [0, controller, 0, 0, 0, 0, 0, 0]).0
    }

    #[test]
    fn bus_off_outweighs_all_else() {
        assert_eq!(decoded(CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_RESTARTED, 0x20), ControllerEvent::BusOff);
    }

    #[test]
    fn the_gravest_problem_is_reported() {
        use ControllerProblem::*;
        for (classes, status, problem) in [
            (CAN_ERR_CRTL, 0x0C, ErrorWarning),
            (CAN_ERR_CRTL, 0x3C, ErrorPassive),
            (CAN_ERR_CRTL, 0x05, ReceiveOverflow),
            (CAN_ERR_CRTL | CAN_ERR_ACK, 0x08, NoAcknowledge),
            (CAN_ERR_CRTL | CAN_ERR_ACK, 0x20, ErrorPassive),
            (CAN_ERR_PROT | CAN_ERR_BUSERROR, 0, BusError),
            (CAN_ERR_TX_TIMEOUT, 0, TransmitTimeout),
            (CAN_ERR_TRX, 0, Transceiver),
        ] {
            assert_eq!(decoded(classes, status), ControllerEvent::Problem(problem), "{classes:#x} {status:#x}");
        }
    }

    #[test]
    fn what_frames_survive_is_dealt_with() {
        assert!(ControllerProblem::ErrorWarning.is_dealt_with() && ControllerProblem::BusError.is_dealt_with());
        assert!(
            !ControllerProblem::ErrorPassive.is_dealt_with() && !ControllerProblem::ReceiveOverflow.is_dealt_with()
        );
    }

    #[test]
    fn what_needs_no_action_is_a_notice() {
        const BACK_TO_ACTIVE: u8 = 0x40;
        assert_eq!(decoded(CAN_ERR_CRTL, BACK_TO_ACTIVE), ControllerEvent::Notice);
        assert_eq!(decoded(libc::CAN_ERR_LOSTARB, 0), ControllerEvent::Notice);
        assert_eq!(decoded(CAN_ERR_CNT, 0), ControllerEvent::Notice);
        assert_eq!(decoded(CAN_ERR_RESTARTED, 0), ControllerEvent::Restarted);
    }

    #[test]
    fn counters_are_read_only_where_the_frame_carries_them() {
        let data = [0, 0, 0, 0, 0, 0, 130, 7];
        assert_eq!(decode(CAN_ERR_CNT, data).1, Some(ErrorCounters { transmit: 130, receive: 7 }));
        assert_eq!(decode(CAN_ERR_CRTL, data).1, None);
    }
}
