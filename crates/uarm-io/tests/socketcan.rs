//! `SocketCanLink` on real vcan interfaces, which each test makes and removes.
//!
//! Compiled with the feature `vcan-tests` only. Needs a kernel with vcan and the right to make interfaces (root);
//! without, the tests fail.

use embedded_can::{ExtendedId, Frame as _, StandardId};
use socketcan::nl::{CanInterface, Mtu};
use socketcan::{
    CanAnyFrame, CanDataFrame, CanErrorFrame, CanFdFrame, CanFdSocket, CanFrame, CanRemoteFrame, CanSocket, Socket,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkError, LinkErrorKind};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{ControllerProblem, ErrorCounters, OpenError, Reception, SocketCanError, SocketCanLink};
use uarm_io::time::{Clock, Duration, Instant};

/// Long enough for any frame that is coming at all, on any machine; short enough to fail a test.
const PATIENCE: Duration = Duration::from_secs(20);

/// A virtual bus that lives as long as its test.
struct Bus {
    name: &'static str,
}

impl Bus {
    fn new(name: &'static str) -> Self {
        let interface = CanInterface::create_vcan(name, None).unwrap_or_else(|error| {
            panic!("cannot make the vcan interface {name} (needs root and the module vcan): {error}")
        });
        interface.bring_up().unwrap();
        Self { name }
    }

    fn interface(&self) -> CanInterface {
        CanInterface::open(self.name).unwrap()
    }

    fn link(&self, reception: Reception<'_>) -> SocketCanLink {
        SocketCanLink::open(self.name.parse().unwrap(), reception).unwrap()
    }

    fn socket(&self) -> CanSocket {
        CanSocket::open(self.name).unwrap()
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        if let Ok(interface) = CanInterface::open(self.name) {
            interface.delete().map_err(|(_, error)| error).unwrap();
        }
    }
}

fn id(raw: u16) -> StandardId {
    StandardId::new(raw).unwrap()
}

fn frame(raw: u16, data: &[u8]) -> Frame {
    Frame::new(id(raw), data).unwrap()
}

fn soon() -> Instant {
    MonotonicClock.now() + PATIENCE
}

/// A deadline that has passed: asks for what already waits.
fn already() -> Instant {
    Instant::default()
}

#[test]
fn frames_cross_both_ways_unchanged() {
    let bus = Bus::new("uarm_cross");
    let (mut one, mut other) = (bus.link(Reception::Everything), bus.link(Reception::Everything));
    for length in 0..=8 {
        let sent = frame(0x180 + length, &[0xA5, 1, 2, 3, 4, 5, 6, 7][..length.into()]);
        one.send(&sent).unwrap();
        assert_eq!(other.receive(soon()).unwrap().unwrap().frame, sent);
        other.send(&sent).unwrap();
        assert_eq!(one.receive(soon()).unwrap().unwrap().frame, sent);
    }
    assert_eq!((one.health().frames_sent, one.health().frames_received), (9, 9));
    // A link does not hear itself.
    assert_eq!(one.receive(already()).unwrap(), None);
}

#[test]
fn only_the_identifiers_asked_for_arrive() {
    let bus = Bus::new("uarm_filter");
    let mut link = bus.link(Reception::Exactly(&[id(0x181), id(0x701)]));
    let mut nothing = bus.link(Reception::Exactly(&[]));
    let mut everything = bus.link(Reception::Everything);
    let socket = bus.socket();
    let data = |raw| CanFrame::Data(CanDataFrame::new(id(raw), &[1]).unwrap());
    let noise = [
        data(0x180),
        data(0x182),
        data(0x581),
        CanFrame::Data(CanDataFrame::new(ExtendedId::new(0x181).unwrap(), &[1]).unwrap()),
        CanFrame::Remote(CanRemoteFrame::new_remote(id(0x181), 1).unwrap()),
    ];
    for frame in noise.iter().chain([&data(0x701), &data(0x181)]) {
        socket.write_frame(frame).unwrap();
    }
    for expected in [0x701, 0x181] {
        assert_eq!(link.receive(soon()).unwrap().unwrap().frame, frame(expected, &[1]));
    }
    assert_eq!(link.receive(already()).unwrap(), None);
    assert_eq!(link.health().refused, 2, "the remote frame and the one with 29 bits");
    assert_eq!(nothing.receive(already()).unwrap(), None);
    // With time left: a refused frame ends a look at the socket whose deadline is past.
    for expected in [0x180, 0x182, 0x581, 0x701, 0x181] {
        assert_eq!(everything.receive(soon()).unwrap().unwrap().frame.id().as_raw(), expected);
    }
    assert_eq!(everything.receive(already()).unwrap(), None);
}

/// The interface takes FD frames; the link is none of those who asked for them.
#[test]
fn fd_frames_never_arrive() {
    let bus = Bus::new("uarm_fd");
    let interface = bus.interface();
    interface.bring_down().unwrap();
    interface.set_mtu(Mtu::Fd).unwrap();
    interface.bring_up().unwrap();
    let mut link = bus.link(Reception::Exactly(&[id(0x181)]));
    let socket = CanFdSocket::open(bus.name).unwrap();
    let witness = CanFdSocket::open(bus.name).unwrap();
    socket.write_frame(&CanFdFrame::new(id(0x181), &[9; 12]).unwrap()).unwrap();
    assert!(matches!(witness.read_frame().unwrap(), CanAnyFrame::Fd(_)));
    socket.write_frame(&CanDataFrame::new(id(0x181), &[7]).unwrap()).unwrap();
    assert_eq!(link.receive(soon()).unwrap().unwrap().frame, frame(0x181, &[7]));
}

#[test]
fn reception_times_lie_between_sending_and_reading_and_never_go_back() {
    let bus = Bus::new("uarm_stamps");
    let (mut one, mut other) = (bus.link(Reception::Everything), bus.link(Reception::Everything));
    // The kernel's stamp is a time of day; its way to the monotonic clock costs up to the spread of three clock readings.
    let conversion = Duration::from_millis(1);
    let mut clock = MonotonicClock;
    let mut last = Instant::default();
    for count in 0..200_u8 {
        let before = clock.now();
        let handed_over = one.send(&frame(0x80, &[count])).unwrap();
        assert!(before <= handed_over && handed_over <= clock.now());
        // The frame waits in the queue: a stamp taken at reading instead of reception would be late by this.
        let pause = Duration::from_millis(5);
        clock.sleep_until(handed_over + pause);
        let at = other.receive(soon()).unwrap().unwrap().at;
        assert!(at + conversion >= before, "{at:?} against {before:?}");
        assert!(at <= handed_over + conversion, "{at:?} against {handed_over:?}");
        assert!(at >= last);
        last = at;
    }
}

#[test]
fn a_silent_bus_gives_nothing_and_not_before_the_deadline() {
    let bus = Bus::new("uarm_silent");
    let mut link = bus.link(Reception::Everything);
    let deadline = MonotonicClock.now() + Duration::from_millis(20);
    assert_eq!(link.receive(deadline).unwrap(), None);
    assert!(MonotonicClock.now() >= deadline);
}

#[test]
fn error_frames_become_errors_with_a_kind() {
    let bus = Bus::new("uarm_errors");
    let mut link = bus.link(Reception::Exactly(&[id(0x181)]));
    let socket = bus.socket();
    let inject = |classes: u32, data: [u8; 8]| {
        socket.write_frame(&CanFrame::Error(CanErrorFrame::new_error(classes, &data).unwrap())).unwrap();
    };
    let (warning, passive) = (0x08, 0x20);
    inject(libc::CAN_ERR_CRTL, [0, warning, 0, 0, 0, 0, 0, 0]);
    inject(libc::CAN_ERR_CRTL | libc::CAN_ERR_CNT, [0, passive, 0, 0, 0, 0, 136, 3]);
    inject(libc::CAN_ERR_BUSOFF, [0; 8]);
    inject(libc::CAN_ERR_LOSTARB, [0; 8]);
    inject(libc::CAN_ERR_RESTARTED, [0; 8]);
    socket.write_frame(&CanDataFrame::new(id(0x181), &[7]).unwrap()).unwrap();

    let error = link.receive(soon()).unwrap_err();
    assert_eq!(error.kind(), LinkErrorKind::Controller);
    assert!(matches!(error, SocketCanError::Controller { problem: ControllerProblem::ErrorPassive, .. }), "{error}");
    assert_eq!(link.receive(soon()).unwrap_err().kind(), LinkErrorKind::BusOff);
    assert_eq!(link.receive(soon()).unwrap().unwrap().frame, frame(0x181, &[7]));

    let health = link.health();
    assert_eq!((health.error_frames, health.controller_problems, health.bus_offs, health.restarts), (5, 2, 1, 1));
    assert_eq!(health.last_problem, Some(ControllerProblem::ErrorPassive));
    assert_eq!(health.error_counters, Some(ErrorCounters { transmit: 136, receive: 3 }));
}

#[test]
fn a_link_reports_down_once_and_works_again_after_up() {
    let bus = Bus::new("uarm_down");
    let (mut one, mut other) = (bus.link(Reception::Everything), bus.link(Reception::Everything));
    bus.interface().bring_down().unwrap();
    assert_eq!(one.receive(soon()).unwrap_err().kind(), LinkErrorKind::Down);
    assert_eq!(one.receive(already()).unwrap(), None);
    for _ in 0..2 {
        assert_eq!(one.send(&frame(0x80, &[])).unwrap_err().kind(), LinkErrorKind::Down);
    }
    assert!(matches!(SocketCanLink::open(one.interface(), Reception::Everything), Err(OpenError::Down { .. })));

    bus.interface().bring_up().unwrap();
    assert_eq!(other.receive(already()).unwrap_err().kind(), LinkErrorKind::Down);
    one.send(&frame(0x80, &[1])).unwrap();
    assert_eq!(other.receive(soon()).unwrap().unwrap().frame, frame(0x80, &[1]));
}

#[test]
fn going_down_ends_a_wait() {
    let bus = Bus::new("uarm_wait");
    let mut link = bus.link(Reception::Everything);
    let waiting = std::thread::spawn(move || link.receive(soon()));
    std::thread::sleep(Duration::from_millis(50));
    bus.interface().bring_down().unwrap();
    assert_eq!(waiting.join().unwrap().unwrap_err().kind(), LinkErrorKind::Down);
}

#[test]
fn a_removed_interface_stays_gone_until_reopened() {
    let bus = Bus::new("uarm_gone");
    let mut receiver = bus.link(Reception::Everything);
    let mut sender = bus.link(Reception::Everything);
    drop(bus);
    // Removal is a going down first; the kernel may report both or, if nobody reads in between, only the last.
    let mut error = receiver.receive(soon()).unwrap_err();
    if error.kind() == LinkErrorKind::Down {
        error = receiver.receive(soon()).unwrap_err();
    }
    assert_eq!(error.kind(), LinkErrorKind::Gone, "{error}");
    assert_eq!(receiver.receive(already()).unwrap_err().kind(), LinkErrorKind::Gone);
    for _ in 0..2 {
        assert_eq!(sender.send(&frame(0x80, &[])).unwrap_err().kind(), LinkErrorKind::Gone);
    }
    assert!(matches!(sender.reopen(), Err(OpenError::NoSuchInterface { .. })));
    assert_eq!(sender.send(&frame(0x80, &[])).unwrap_err().kind(), LinkErrorKind::Gone);

    let _bus = Bus::new("uarm_gone");
    receiver.reopen().unwrap();
    sender.reopen().unwrap();
    sender.send(&frame(0x80, &[2])).unwrap();
    assert_eq!(receiver.receive(soon()).unwrap().unwrap().frame, frame(0x80, &[2]));
}

#[test]
fn what_cannot_be_opened_is_named() {
    let open = |name: &str| SocketCanLink::open(name.parse().unwrap(), Reception::Everything).unwrap_err();
    assert!(matches!(open("uarm_never"), OpenError::NoSuchInterface { .. }));
    assert!(matches!(open("lo"), OpenError::NotCan { .. }));
}

#[test]
fn frames_lost_in_the_kernel_are_counted() {
    const FLOOD: u64 = 4_000;
    let bus = Bus::new("uarm_drops");
    let (mut one, mut other) = (bus.link(Reception::Everything), bus.link(Reception::Everything));
    for _ in 0..FLOOD {
        one.send(&frame(0x80, &[0; 8])).unwrap();
    }
    while other.receive(already()).unwrap().is_some() {}
    let health = other.health();
    let dropped = u64::from(health.dropped.unwrap());
    assert!(dropped > 0 && health.frames_received > 0, "{health:?}");
    assert_eq!(dropped + health.frames_received, FLOOD);
}

#[test]
fn nothing_allocates_per_frame() {
    let bus = Bus::new("uarm_alloc");
    let (mut one, mut other) = (bus.link(Reception::Everything), bus.link(Reception::Everything));
    let socket = bus.socket();
    let every_class = CanErrorFrame::new_error(libc::CAN_ERR_MASK & !libc::CAN_ERR_BUSOFF, &[0; 8]).unwrap();
    let before = ALLOCATIONS.get();
    assert!(
        {
            drop(std::hint::black_box(Box::new(1)));
            ALLOCATIONS.get() > before
        },
        "the counter counts nothing"
    );
    let before = ALLOCATIONS.get();
    for count in 0..100 {
        one.send(&frame(0x80, &[count])).unwrap();
        assert!(other.receive(soon()).unwrap().is_some());
        assert!(other.receive(already()).unwrap().is_none());
        socket.write_frame(&CanFrame::Error(every_class)).unwrap();
        let _ = other.receive(already());
        let _ = one.receive(already());
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
}

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counting per thread.
struct Counting;

// SAFETY: every call is passed on unchanged to the system's allocator, which fulfils the contract; the counter is a plain
// thread-local without destructor and does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise about `pointer` and `layout` is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;
