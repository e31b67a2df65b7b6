//! What a link has seen of its wire.

use core::fmt;

/// What a link has seen since it was opened; all zero for a link without a wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkHealth {
    /// Frames that the interface took.
    pub frames_sent: u64,
    /// Data frames received.
    pub frames_received: u64,
    /// Remote frames and frames with 29-bit identifiers that were refused.
    pub refused: u64,
    /// Frames that the interface did not take because its queue was full.
    pub queue_full: u64,
    /// Error frames of any class.
    pub error_frames: u64,
    /// Error frames that report trouble short of bus-off.
    pub controller_problems: u64,
    /// The last of them.
    pub last_problem: Option<ControllerProblem>,
    /// How often the controller went bus-off.
    pub bus_offs: u64,
    /// How often the controller was restarted after bus-off.
    pub restarts: u64,
    /// The controller's error counters as last reported; `None` if it never did.
    pub error_counters: Option<ErrorCounters>,
    /// Frames that the kernel dropped because the link was not read in time; `None` if the kernel does not say.
    pub dropped: Option<u32>,
}

/// Trouble that a CAN controller reports short of bus-off, the gravest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum ControllerProblem {
    /// Error counter above 127: the controller may no longer signal errors actively; bus-off is near.
    ErrorPassive,
    /// The controller's receive buffer overflowed: frames were lost.
    ReceiveOverflow,
    /// The controller's transmit buffer overflowed: frames were lost.
    TransmitOverflow,
    /// The driver gave up on a frame.
    TransmitTimeout,
    /// Nobody acknowledged a frame: no other node is on, or the cable is open.
    NoAcknowledge,
    /// Error counter above 95: the bus is disturbed.
    ErrorWarning,
    /// Transceiver fault: a short circuit or an open wire.
    Transceiver,
    /// A violation of the protocol on the bus: disturbance, wrong bit rate, termination.
    BusError,
}

impl ControllerProblem {
    /// Whether the controller deals with it alone, by repeating the frame: worth counting, no reason to stop a robot.
    pub const fn is_dealt_with(self) -> bool {
        matches!(self, Self::ErrorWarning | Self::BusError)
    }
}

impl fmt::Display for ControllerProblem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::ErrorPassive => {
                "error passive (an error counter above 127); bus-off is near, check cable, termination and bit rate"
            }
            Self::ReceiveOverflow => {
                "receive buffer overflow; frames were lost, the computer served the controller too late"
            }
            Self::TransmitOverflow => "transmit buffer overflow; frames were lost",
            Self::TransmitTimeout => "transmit time-out; the driver gave up on a frame",
            Self::NoAcknowledge => "no acknowledge; no other node is on the bus, or the cable is open",
            Self::ErrorWarning => "error warning (an error counter above 95); the bus is disturbed",
            Self::Transceiver => "transceiver fault; look for a short circuit or an open wire",
            Self::BusError => "a protocol violation on the bus; check cable, termination and bit rate",
        })
    }
}

/// Transmit and receive error counters of a CAN controller, 0 to 255.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ErrorCounters {
    /// The transmit error counter.
    pub transmit: u8,
    /// The receive error counter.
    pub receive: u8,
}
