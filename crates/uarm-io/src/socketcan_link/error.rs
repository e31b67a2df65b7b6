//! What can go wrong on a CAN interface, with what to do about it.

use super::interface::InterfaceName;
use crate::link::ControllerProblem;
use crate::link::{LinkError, LinkErrorKind};
use std::io;

/// Why a link to an interface could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The kernel has no raw CAN sockets.
    #[error(
        "cannot open `{interface}`: this kernel has no raw CAN sockets (AF_CAN). Load them with `modprobe can-raw`, or use a kernel built with CONFIG_CAN_RAW"
    )]
    NoCanInKernel {
        /// The interface asked for.
        interface: InterfaceName,
    },
    /// There is no such interface.
    #[error(
        "there is no network interface `{interface}`. `ip link show type can` lists CAN hardware; \
         a virtual bus is made with `ip link add {interface} type vcan && ip link set {interface} up`"
    )]
    NoSuchInterface {
        /// The interface asked for.
        interface: InterfaceName,
    },
    /// The interface exists but is not CAN.
    #[error(
        "`{interface}` is a network interface but no CAN interface. `ip -details link show {interface}` shows its kind"
    )]
    NotCan {
        /// The interface asked for.
        interface: InterfaceName,
    },
    /// The interface is down.
    #[error(
        "`{interface}` is down. Bring it up with `ip link set {interface} up` \
         (CAN hardware: `ip link set {interface} up type can bitrate RATE restart-ms 100`, RATE that of the bus: another disturbs it)"
    )]
    Down {
        /// The interface asked for.
        interface: InterfaceName,
    },
    /// The process may not open CAN sockets.
    #[error(
        "not allowed to open a CAN socket on `{interface}`: a container or security policy forbids AF_CAN; allow it there or run outside"
    )]
    NotPermitted {
        /// The interface asked for.
        interface: InterfaceName,
    },
    /// More identifiers than one socket can filter.
    #[error("{found} identifiers to receive on `{interface}`, expected at most {most}")]
    TooManyIdentifiers {
        /// The interface asked for.
        interface: InterfaceName,
        /// How many were asked for.
        found: usize,
        /// How many the kernel takes.
        most: usize,
    },
    /// Another answer of the system.
    #[error("cannot open `{interface}`: {action} failed: {source}")]
    System {
        /// The interface asked for.
        interface: InterfaceName,
        /// What was being done.
        action: &'static str,
        /// The system's answer.
        source: io::Error,
    },
}

/// What went wrong on an open link. Building one does not allocate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SocketCanError {
    /// The interface is down. The link works again as soon as the interface is up.
    #[error("CAN interface `{interface}` is down. `ip link set {interface} up` brings it back")]
    Down {
        /// The interface.
        interface: InterfaceName,
    },
    /// The interface was removed. Only [`reopen`](super::SocketCanLink::reopen) helps, once it is there again.
    #[error("CAN interface `{interface}` was removed: adapter unplugged, or deleted with `ip link delete`")]
    Gone {
        /// The interface.
        interface: InterfaceName,
    },
    /// The interface's transmit queue is full; the frame was not taken.
    #[error(
        "the transmit queue of CAN interface `{interface}` is full: nobody acknowledges, or the bus is overloaded. \
         Check cable and termination; `ip link set {interface} txqueuelen 64` gives more room"
    )]
    QueueFull {
        /// The interface.
        interface: InterfaceName,
    },
    /// The controller counted too many errors and left the bus.
    #[error(
        "the controller of CAN interface `{interface}` is bus-off: check cable, termination and bit rate. \
         `ip link set {interface} type can restart-ms 100` lets it come back by itself, `ip link set {interface} type can restart` once"
    )]
    BusOff {
        /// The interface.
        interface: InterfaceName,
    },
    /// The controller reports trouble short of bus-off. The link still works.
    #[error("the controller of CAN interface `{interface}` reports: {problem}")]
    Controller {
        /// The interface.
        interface: InterfaceName,
        /// The trouble.
        problem: ControllerProblem,
    },
    /// Another answer of the system.
    #[error("CAN interface `{interface}`: {source}")]
    System {
        /// The interface.
        interface: InterfaceName,
        /// The system's answer.
        source: io::Error,
    },
}

impl LinkError for SocketCanError {
    fn kind(&self) -> LinkErrorKind {
        match self {
            Self::Down { .. } => LinkErrorKind::Down,
            Self::Gone { .. } => LinkErrorKind::Gone,
            Self::QueueFull { .. } => LinkErrorKind::QueueFull,
            Self::BusOff { .. } => LinkErrorKind::BusOff,
            Self::Controller { .. } => LinkErrorKind::Controller,
            Self::System { .. } => LinkErrorKind::Other,
        }
    }
}

impl SocketCanError {
    /// What the system's answer to a read or write means.
    pub(super) fn from_system(interface: InterfaceName, source: io::Error) -> Self {
        match source.raw_os_error() {
            Some(libc::ENETDOWN) => Self::Down { interface },
            // The kernel unbinds the socket (ENODEV, once); from then on a send has no interface to go to (ENXIO).
            Some(libc::ENODEV | libc::ENXIO) => Self::Gone { interface },
            // ENOBUFS: the interface's queue is full. EAGAIN: the socket's own share of it is.
            Some(libc::ENOBUFS | libc::EAGAIN) => Self::QueueFull { interface },
            _ => Self::System { interface, source },
        }
    }
}

impl OpenError {
    /// What the system's answer to one step of opening means.
    pub(super) fn from_system(interface: InterfaceName, action: &'static str, source: io::Error) -> Self {
        match source.raw_os_error() {
            Some(libc::EAFNOSUPPORT | libc::EPROTONOSUPPORT | libc::ESOCKTNOSUPPORT) => {
                Self::NoCanInKernel { interface }
            }
            Some(libc::EPERM | libc::EACCES) => Self::NotPermitted { interface },
            Some(libc::ENETDOWN) => Self::Down { interface },
            _ => Self::System { interface, action, source },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn system_answers_become_kinds() {
        let interface: InterfaceName = "can7".parse().unwrap();
        for (errno, kind) in [
            (libc::ENETDOWN, LinkErrorKind::Down),
            (libc::ENODEV, LinkErrorKind::Gone),
            (libc::ENXIO, LinkErrorKind::Gone),
            (libc::ENOBUFS, LinkErrorKind::QueueFull),
            (libc::EAGAIN, LinkErrorKind::QueueFull),
            (libc::EIO, LinkErrorKind::Other),
        ] {
            let error = SocketCanError::from_system(interface, io::Error::from_raw_os_error(errno));
            assert_eq!(error.kind(), kind);
            assert!(error.to_string().contains("`can7`"), "{error}");
        }
    }
}
