//! An observer on `vcan0`, written from CiA 301 alone, so that it checks the code under test and does not repeat it.

use socketcan::{CanDataFrame, CanFrame, CanSocket, EmbeddedFrame, Frame, Socket, SocketOptions, StandardId};
use std::io::ErrorKind;
use std::time::{Duration, Instant, SystemTime};

use super::{DRIVEN_NODE, INTERFACE, NODES};

/// NMT commands (CiA 301, 7.2.8.3.1).
pub const NMT: u16 = 0x000;
/// The NMT command *start remote node*.
pub const NMT_START: u8 = 0x01;
/// The NMT command *reset node*.
const NMT_RESET_NODE: u8 = 0x81;
/// The NMT command *stop remote node*.
pub const NMT_STOP: u8 = 0x02;
/// Emergency messages: base, plus node.
pub const EMERGENCY: u16 = 0x080;
/// Feedback of the drives in the cyclic exchange: base, plus node.
pub const TPDO1: u16 = 0x180;
/// Drive commands of the cyclic exchange: base, plus node.
pub const RPDO1: u16 = 0x200;
/// SDO answers: base, plus node.
const SDO_ANSWER: u16 = 0x580;
/// SDO requests: base, plus node.
pub const SDO_REQUEST: u16 = 0x600;
/// Heartbeats: base, plus node.
pub const HEARTBEAT: u16 = 0x700;
/// The heartbeat of a node that has just booted.
const BOOT_UP: u8 = 0;
/// The emergency error code for a missing heartbeat (CiA 301, table 26).
pub const HEARTBEAT_ERROR: u16 = 0x8130;
/// The emergency error code for a device that is too hot (CiA 301, table 26).
pub const DEVICE_TEMPERATURE: u16 = 0x4210;
/// The bit of the error register that is set with any error (CiA 301, 7.5.2.2).
const GENERIC_ERROR: u8 = 0x01;

/// Statusword (CiA 402).
pub const STATUSWORD: u16 = 0x6041;
/// Position in counts (CiA 402).
pub const POSITION: u16 = 0x6064;
/// How long an answer may take; generous, for a native run on a loaded machine.
const ANSWER: Duration = Duration::from_secs(10);
/// How long a controller may take from its own start to the first torque: stability, listening, some 300 SDO reads, power.
const START: Duration = Duration::from_secs(60);

/// A frame and when the kernel saw it.
#[derive(Clone, Debug)]
pub struct Seen {
    pub id: u16,
    pub data: Vec<u8>,
    pub at: SystemTime,
}

impl Seen {
    /// The 16-bit value at `offset`.
    pub fn u16(&self, offset: usize) -> u16 {
        u16::from_le_bytes([self.data[offset], self.data[offset + 1]])
    }
}

/// A socket that hears everything.
pub struct Bus(CanSocket);

impl Bus {
    pub fn open() -> Self {
        let socket = CanSocket::open(INTERFACE).unwrap_or_else(|error| {
            panic!("{INTERFACE}: {error}; run this test through `tools/can-guest run`, see docs/testing.md")
        });
        socket.set_recv_timestamp(true).unwrap();
        Self(socket)
    }

    /// The next data frame; `None` if none comes in time.
    pub fn next(&self, timeout: Duration) -> Option<Seen> {
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            self.0.set_read_timeout(left).unwrap();
            if let Some(seen) = self.read() {
                return Some(seen);
            }
        }
    }

    /// One read; `None` if there is no data frame.
    fn read(&self) -> Option<Seen> {
        loop {
            match self.0.read_frame_with_timestamp() {
                Ok((CanFrame::Data(frame), at)) => {
                    let id = u16::try_from(frame.raw_id()).expect("an 11-bit identifier");
                    return Some(Seen { id, data: frame.data().to_vec(), at });
                }
                Ok(_) => {}
                // Interrupted, timed out, or the interface went down under the test: the time limit decides.
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::NetworkDown
                    ) =>
                {
                    return None;
                }
                Err(error) => panic!("reading {INTERFACE}: {error}"),
            }
        }
    }

    /// The first frame that is `wanted`.
    pub fn wait_for(&self, what: &str, timeout: Duration, wanted: impl Fn(&Seen) -> bool) -> Seen {
        let end = Instant::now() + timeout;
        while let Some(seen) = self.next(end.saturating_duration_since(Instant::now())) {
            if wanted(&seen) {
                return seen;
            }
        }
        panic!("no {what} on {INTERFACE} within {timeout:?}");
    }

    /// Waits until the arm is in motion, without resting, as [`Bus::wait_for_boot_up`] does.
    pub fn wait_for_motion(&self) {
        let end = Instant::now() + START;
        // The passive joint is never given a torque.
        while !self.drain().iter().any(|seen| seen.id == RPDO1 + u16::from(DRIVEN_NODE) && seen.u16(2) != 0) {
            assert!(Instant::now() < end, "no torque for node {DRIVEN_NODE} on {INTERFACE} within {START:?}");
            std::thread::yield_now();
        }
    }

    /// Waits until each drive has said that it booted. It does so without resting: a guest in which everything rests leaps
    /// to its next timer, and would leap over any time limit while the robot's program is being read from the machine's
    /// files.
    pub fn wait_for_boot_up(&self) {
        let end = Instant::now() + ANSWER;
        let mut waiting = NODES.to_vec();
        while !waiting.is_empty() {
            for seen in self.drain() {
                waiting.retain(|node| seen.id != HEARTBEAT + u16::from(*node) || seen.data != [BOOT_UP]);
            }
            assert!(Instant::now() < end, "no boot-up of nodes {waiting:?} on {INTERFACE} within {ANSWER:?}");
            std::thread::yield_now();
        }
    }

    /// Everything that was received and not read yet. Does not wait: the kernel rounds a short time limit up to its tick,
    /// within which a bus in cyclic operation always has one more frame.
    pub fn drain(&self) -> Vec<Seen> {
        self.0.set_nonblocking(true).unwrap();
        let seen = std::iter::from_fn(|| self.read()).collect();
        self.0.set_nonblocking(false).unwrap();
        seen
    }

    /// Reads an object of up to four bytes by an expedited SDO upload (CiA 301, 7.2.4.3.3).
    pub fn read_object(&self, node: u8, index: u16) -> Vec<u8> {
        let [low, high] = index.to_le_bytes();
        self.drain();
        self.send(SDO_REQUEST + u16::from(node), &[0x40, low, high, 0, 0, 0, 0, 0]);
        let answer = self.wait_for("SDO answer", ANSWER, |seen| seen.id == SDO_ANSWER + u16::from(node));
        assert_eq!(answer.data[0] & 0xE3, 0x43, "node {node} refused {index:04X}h: {:02X?}", answer.data);
        let unused = usize::from((answer.data[0] >> 2) & 0x03);
        answer.data[4..8 - unused].to_vec()
    }

    /// True if the drive's next feedback says that it is enabled. Nothing is sent: a controller that is there would take
    /// an SDO request for another's.
    pub fn reports_enabled(&self, node: u8) -> bool {
        self.drain();
        let feedback = self.wait_for("feedback", ANSWER, |seen| seen.id == TPDO1 + u16::from(node));
        feedback.u16(0) & 0x6F == 0x27
    }

    /// True if the drive's power stage drives its motor and holds the brake open: *Operation enabled* (CiA 402).
    pub fn is_enabled(&self, node: u8) -> bool {
        let status = u16::from_le_bytes(self.read_object(node, STATUSWORD).try_into().unwrap());
        status & 0x6F == 0x27
    }

    /// The drive's encoder counts.
    pub fn position(&self, node: u8) -> i32 {
        i32::from_le_bytes(self.read_object(node, POSITION).try_into().unwrap())
    }

    /// Says in the name of a drive that something is wrong with it (CiA 301, 7.2.7).
    pub fn send_emergency(&self, node: u8, error_code: u16) {
        let [low, high] = error_code.to_le_bytes();
        self.send(EMERGENCY + u16::from(node), &[low, high, GENERIC_ERROR, 0, 0, 0, 0, 0]);
    }

    /// Resets a node, as another master would (CiA 301, 7.2.8.3.1.4).
    pub fn reset(&self, node: u8) {
        self.send(NMT, &[NMT_RESET_NODE, node]);
    }

    /// True if no drive holds its brake open, and no joint moves. Drives that a master has left in *Stopped* answer no SDO:
    /// they are brought back to *Operational* first, which leaves their power stages as they are.
    pub fn all_have_braked(&self) -> bool {
        self.send(NMT, &[NMT_START, 0]);
        let before = NODES.map(|node| self.position(node));
        std::thread::sleep(Duration::from_millis(50));
        NODES.iter().all(|node| !self.is_enabled(*node)) && before == NODES.map(|node| self.position(node))
    }

    /// Sends any frame.
    pub fn send(&self, id: u16, data: &[u8]) {
        let frame = CanDataFrame::new(StandardId::new(id).unwrap(), data).unwrap();
        self.0.write_frame(&frame).unwrap();
    }
}
