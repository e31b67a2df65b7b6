//! A [`Link`] over a Linux CAN interface.
//!
//! One raw socket per link. The kernel delivers exactly the identifiers asked for, so that other traffic costs the loop
//! nothing. Remote frames with one of them, and frames whose 29-bit identifier ends in one, are refused before they are decoded, and
//! counted ([`LinkHealth::refused`]); the kernel gives no CAN FD frame to a classic socket. Reception times are taken by the kernel as the frame enters the network stack and are given on the loop's
//! clock, `CLOCK_MONOTONIC`. Sending never waits. Nothing allocates after opening.
//!
//! # When the interface fails
//! | What happens | [`send`](Link::send) | [`receive`](Link::receive) | Recovery |
//! |---|---|---|---|
//! | set down | `Down`, each time | `Down` once, then nothing comes | by itself when set up again |
//! | removed, unplugged | `Gone`, each time | `Gone`, each time | [`SocketCanLink::reopen`] when it is back |
//! | bus-off | `QueueFull` once the queue is full | `BusOff` once | by the kernel, if `restart-ms` is set |
//! | error passive, no acknowledge, overflow … | works | `Controller`, once per report | by itself when the bus is sound again |
//! | error warning, single bus errors | works | works; counted in [`LinkHealth`] | none needed: the controller repeats frames |
//! | transmit queue full | `QueueFull`; the frame is not taken | works | by itself |

mod error;
pub mod error_frame;
mod interface;

pub use crate::link::{ControllerProblem, ErrorCounters, LinkHealth};
pub use error::{OpenError, SocketCanError};
pub use interface::{InterfaceName, InterfaceNameError};

use crate::frame::Frame;
use crate::link::{Link, Received};
use crate::monotonic::{MonotonicClock, RealtimeOffset, timeout};
use crate::time::{Clock, Instant};
use embedded_can::{Frame as _, Id, StandardId};
use error_frame::ControllerEvent;
use rustix::event::{PollFd, PollFlags};
use rustix::io::Errno;
use socketcan::timestamp::{SOF_TIMESTAMPING_RX_SOFTWARE, SOF_TIMESTAMPING_SOFTWARE};
use socketcan::{
    CanAddr, CanDataFrame, CanErrorFrame, CanFilter, CanFrame, CanSocket, CanTimestamps, Socket, SocketOptions,
};
use std::io;
use std::time::UNIX_EPOCH;

/// The most filters that the kernel takes per socket (`CAN_RAW_FILTER_MAX`).
const MOST_IDENTIFIERS: usize = 512;

/// `getsockopt` name of the socket's memory statistics (`SO_MEMINFO`), for architectures with the generic numbering.
const SOCKET_MEMORY_STATISTICS: i32 = 55;
/// Number of 32-bit values in them (`SK_MEMINFO_VARS`), and which is the count of frames dropped (`SK_MEMINFO_DROPS`).
const MEMORY_STATISTICS: usize = 9;
const MEMORY_STATISTICS_DROPS: usize = 8;

/// Which data frames a link receives. Remote frames and 29-bit identifiers are refused; error frames always arrive.
#[derive(Clone, Copy, Debug)]
pub enum Reception<'a> {
    /// These 11-bit identifiers and no others.
    Exactly(&'a [StandardId]),
    /// Every 11-bit identifier.
    Everything,
}

/// A CAN interface as a [`Link`].
///
/// ```no_run
/// use uarm_io::link::Link;
/// use uarm_io::monotonic::MonotonicClock;
/// use uarm_io::socketcan_link::{Reception, SocketCanLink};
/// use uarm_io::time::{Clock, Duration};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut link = SocketCanLink::open("vcan0".parse()?, Reception::Everything)?;
/// let deadline = MonotonicClock.now() + Duration::from_millis(3);
/// if let Some(received) = link.receive(deadline)? {
///     println!("{:?} at {:?}", received.frame, received.at);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct SocketCanLink {
    socket: CanSocket,
    interface: InterfaceName,
    filters: Vec<CanFilter>,
    health: LinkHealth,
    /// When the last frame came: a later one is never given an earlier instant.
    last_reception: Instant,
    presence: Presence,
}

/// Whether the socket still has its interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Presence {
    Bound,
    /// The kernel says so only once; from then on the socket would just stay silent.
    Lost,
}

impl SocketCanLink {
    /// Opens a link on an interface that is up.
    ///
    /// # Errors
    /// [`OpenError`] says which of the preconditions is missing, and how to get it.
    pub fn open(interface: InterfaceName, reception: Reception<'_>) -> Result<Self, OpenError> {
        let filters = filters(interface, reception)?;
        Ok(Self {
            socket: open_socket(interface, &filters)?,
            interface,
            filters,
            health: LinkHealth::default(),
            last_reception: Instant::default(),
            presence: Presence::Bound,
        })
    }

    /// Opens the same interface anew, after it was removed and has come back. Counters go on.
    ///
    /// # Errors
    /// As [`open`](Self::open); the link then stays as it is.
    pub fn reopen(&mut self) -> Result<(), OpenError> {
        self.socket = open_socket(self.interface, &self.filters)?;
        self.presence = Presence::Bound;
        Ok(())
    }

    /// The interface.
    pub const fn interface(&self) -> InterfaceName {
        self.interface
    }

    /// The frame of one read, if it is one for the caller.
    fn accept(&mut self, frame: CanFrame, timestamps: CanTimestamps) -> Result<Option<Received>, SocketCanError> {
        match frame {
            CanFrame::Error(frame) => self.note_error_frame(frame).map(|()| None),
            frame => match classic_data(&frame) {
                Some(frame) => {
                    self.health.frames_received += 1;
                    Ok(Some(Received { frame, at: self.reception_instant(timestamps) }))
                }
                None => {
                    self.health.refused += 1;
                    Ok(None)
                }
            },
        }
    }

    /// The kernel's time stamp (time of day) on the monotonic clock.
    ///
    /// The offset is measured at each frame (three clock readings, no system call on most PCs), so that a step of the time
    /// of day shifts no frame but those then in the queue; and the result is kept between the last frame's and now.
    fn reception_instant(&mut self, timestamps: CanTimestamps) -> Instant {
        let stamp = timestamps.sw.and_then(|stamp| stamp.duration_since(UNIX_EPOCH).ok());
        let stamp = stamp.and_then(|stamp| u64::try_from(stamp.as_nanos()).ok());
        let (offset, _) = RealtimeOffset::capture_once();
        let now = MonotonicClock.now();
        let at = stamp.map_or(now, |stamp| offset.instant(stamp));
        self.last_reception = at.min(now).max(self.last_reception);
        self.last_reception
    }

    fn note_error_frame(&mut self, frame: CanErrorFrame) -> Result<(), SocketCanError> {
        let interface = self.interface;
        let data = <[u8; 8]>::try_from(embedded_can::Frame::data(&frame)).unwrap_or_default();
        let (event, counters) = error_frame::decode(frame.error_bits(), data);
        self.health.error_frames += 1;
        self.health.error_counters = counters.or(self.health.error_counters);
        match event {
            ControllerEvent::BusOff => {
                self.health.bus_offs += 1;
                Err(SocketCanError::BusOff { interface })
            }
            ControllerEvent::Problem(problem) => {
                self.health.controller_problems += 1;
                self.health.last_problem = Some(problem);
                if problem.is_dealt_with() { Ok(()) } else { Err(SocketCanError::Controller { interface, problem }) }
            }
            ControllerEvent::Restarted => {
                self.health.restarts += 1;
                Ok(())
            }
            ControllerEvent::Notice => Ok(()),
        }
    }

    /// Waits until the socket has something to say; `false` if the deadline came first.
    fn wait(&self, deadline: Instant) -> Result<bool, SocketCanError> {
        loop {
            let left = deadline.since(MonotonicClock.now());
            if left.is_zero() {
                return Ok(false);
            }
            let mut sockets = [PollFd::new(&self.socket, PollFlags::IN)];
            match rustix::event::poll(&mut sockets, Some(&timeout(left))) {
                Ok(0) | Err(Errno::INTR) => {}
                Ok(_) => return Ok(true),
                Err(errno) => return Err(SocketCanError::System { interface: self.interface, source: errno.into() }),
            }
        }
    }

    fn fault(&mut self, source: io::Error) -> SocketCanError {
        let error = SocketCanError::from_system(self.interface, source);
        match error {
            SocketCanError::Gone { .. } => self.presence = Presence::Lost,
            SocketCanError::QueueFull { .. } => self.health.queue_full += 1,
            _ => {}
        }
        error
    }

    fn check_presence(&self) -> Result<(), SocketCanError> {
        match self.presence {
            Presence::Bound => Ok(()),
            Presence::Lost => Err(SocketCanError::Gone { interface: self.interface }),
        }
    }
}

impl Link for SocketCanLink {
    type Error = SocketCanError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, Self::Error> {
        self.check_presence()?;
        // A `Frame` always fits; were it not so, the system's word for it is the honest answer.
        let unfit = || SocketCanError::System { interface: self.interface, source: io::ErrorKind::InvalidInput.into() };
        let outgoing = CanDataFrame::new(frame.id(), frame.data()).ok_or_else(unfit)?;
        // Read before: on a virtual bus an answer may come in before the call returns, and must not seem older than its SYNC.
        let at = MonotonicClock.now();
        match self.socket.write_frame(&outgoing) {
            Ok(()) => {
                self.health.frames_sent += 1;
                Ok(at)
            }
            Err(source) => Err(self.fault(source)),
        }
    }

    /// Asks the kernel for the drops, which is a system call: not for each cycle.
    fn health(&self) -> LinkHealth {
        LinkHealth { dropped: dropped(&self.socket), ..self.health }
    }

    /// Frames that already wait are given even if the deadline has passed.
    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, Self::Error> {
        self.check_presence()?;
        loop {
            match self.socket.read_frame_with_timestamps() {
                Ok((frame, timestamps)) => {
                    if let Some(received) = self.accept(frame, timestamps)? {
                        return Ok(Some(received));
                    }
                    // A burst of frames without interest must not hold the loop beyond its deadline.
                    if MonotonicClock.now() >= deadline {
                        return Ok(None);
                    }
                }
                Err(source) if source.kind() == io::ErrorKind::WouldBlock => {
                    if !self.wait(deadline)? {
                        return Ok(None);
                    }
                }
                Err(source) if source.kind() == io::ErrorKind::Interrupted => {}
                Err(source) => return Err(self.fault(source)),
            }
        }
    }
}

/// Whether the kernel has raw CAN sockets at all.
///
/// # Errors
/// The system's answer, if it has not.
pub fn raw_can_sockets() -> io::Result<()> {
    const ANY_INTERFACE: u32 = 0;
    CanSocket::open_iface(ANY_INTERFACE).map(drop)
}

/// A data frame with an 11-bit identifier; nothing if it is a remote frame, or has 29 bits.
fn classic_data(frame: &CanFrame) -> Option<Frame> {
    match frame {
        CanFrame::Data(frame) => match frame.id() {
            Id::Standard(id) => Frame::new(id, embedded_can::Frame::data(frame)),
            Id::Extended(_) => None,
        },
        CanFrame::Remote(_) | CanFrame::Error(_) => None,
    }
}

fn filters(interface: InterfaceName, reception: Reception<'_>) -> Result<Vec<CanFilter>, OpenError> {
    match reception {
        Reception::Everything => Ok(vec![CanFilter::new(0, 0)]),
        Reception::Exactly(identifiers) if identifiers.len() > MOST_IDENTIFIERS => {
            Err(OpenError::TooManyIdentifiers { interface, found: identifiers.len(), most: MOST_IDENTIFIERS })
        }
        Reception::Exactly(identifiers) => {
            // Without the flags of remote frames and of 29 bits in the mask, so that those are counted.
            Ok(identifiers.iter().map(|id| CanFilter::new(id.as_raw().into(), libc::CAN_SFF_MASK)).collect())
        }
    }
}

fn open_socket(interface: InterfaceName, filters: &[CanFilter]) -> Result<CanSocket, OpenError> {
    let failed = |action| move |source| OpenError::from_system(interface, action, source);
    raw_can_sockets().map_err(failed("socket(AF_CAN, SOCK_RAW)"))?;
    let address = CanAddr::from_iface(interface.as_str()).map_err(|_| OpenError::NoSuchInterface { interface })?;
    let socket = CanSocket::open_addr(&address).map_err(|source| match source.raw_os_error() {
        // The interface was found a line above: no such device now means no such CAN device.
        Some(libc::ENODEV) => OpenError::NotCan { interface },
        _ => OpenError::from_system(interface, "bind", source),
    })?;
    // Binding to an interface that is down succeeds and leaves ENETDOWN as the socket's pending error.
    if let Some(source) = socket.as_raw_socket().take_error().map_err(failed("getsockopt(SO_ERROR)"))? {
        return Err(OpenError::from_system(interface, "bind", source));
    }
    socket.set_nonblocking(true).map_err(failed("fcntl(O_NONBLOCK)"))?;
    socket.set_error_filter_accept_all().map_err(failed("setsockopt(CAN_RAW_ERR_FILTER)"))?;
    socket
        .set_timestamping(SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE)
        .map_err(failed("setsockopt(SO_TIMESTAMPING)"))?;
    // Until here the socket took every frame: forget those by filtering last and emptying the queue.
    socket.set_filters(filters).map_err(failed("setsockopt(CAN_RAW_FILTER)"))?;
    while socket.read_raw_frame().is_ok() {}
    Ok(socket)
}

fn dropped(socket: &CanSocket) -> Option<u32> {
    const VALUE: usize = size_of::<u32>();
    let mut statistics = [0_u8; MEMORY_STATISTICS * VALUE];
    let length = socket.get_socket_option_bytes(libc::SOL_SOCKET, SOCKET_MEMORY_STATISTICS, &mut statistics).ok()?;
    let drops = statistics.get(..length)?.get(MEMORY_STATISTICS_DROPS * VALUE..)?.first_chunk::<VALUE>()?;
    Some(u32::from_ne_bytes(*drops))
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::ExtendedId;
    use socketcan::CanRemoteFrame;

    #[test]
    fn more_identifiers_than_the_kernel_takes_are_refused() {
        let interface: InterfaceName = "can0".parse().unwrap();
        let many = [StandardId::ZERO; MOST_IDENTIFIERS + 1];
        assert!(matches!(
            filters(interface, Reception::Exactly(&many)),
            Err(OpenError::TooManyIdentifiers { found: 513, most: 512, .. })
        ));
        assert_eq!(filters(interface, Reception::Exactly(&many[1..])).unwrap().len(), 512);
    }

    #[test]
    fn an_exact_filter_lets_frames_of_every_kind_through_to_be_counted() {
        let interface: InterfaceName = "can0".parse().unwrap();
        let id = StandardId::new(0x181).unwrap();
        let filter = filters(interface, Reception::Exactly(&[id])).unwrap()[0];
        let filter: &libc::can_filter = filter.as_ref();
        assert_eq!((filter.can_id, filter.can_mask), (0x181, 0x7FF));
    }

    #[test]
    fn only_data_frames_with_11_bits_are_taken() {
        let (standard, extended) = (StandardId::new(0x181).unwrap(), ExtendedId::new(0x181).unwrap());
        let data = |id: Id| CanFrame::Data(CanDataFrame::new(id, &[1, 2]).unwrap());
        assert_eq!(classic_data(&data(standard.into())), Frame::new(standard, &[1, 2]));
        assert_eq!(classic_data(&data(extended.into())), None);
        for id in [Id::from(standard), Id::from(extended)] {
            assert_eq!(classic_data(&CanFrame::Remote(CanRemoteFrame::new_remote(id, 2).unwrap())), None);
        }
    }

    #[test]
    fn opening_says_what_is_missing() {
        let error = SocketCanLink::open("nosuchcan9".parse().unwrap(), Reception::Everything).unwrap_err();
        match raw_can_sockets() {
            Ok(()) => assert!(matches!(error, OpenError::NoSuchInterface { .. }), "{error}"),
            Err(_) => {
                assert!(matches!(error, OpenError::NoCanInKernel { .. } | OpenError::NotPermitted { .. }), "{error}")
            }
        }
        assert!(error.to_string().contains("nosuchcan9"));
    }
}
