use super::*;
use crate::emulated_bus::bus;
use uarm_io::drive::wire::Channel;
use uarm_io::frame::Frame;
use uarm_io::link::{FrameDirection, ObservedLink};

/// What a scan finds there, and what it sent.
fn scan(asking: Asking) -> (Scan, Vec<Frame>) {
    let (link, clock) = bus();
    let mut sent = Vec::new();
    let mut observed = ObservedLink::new(link, |direction, frame: &Frame, _| {
        if direction == FrameDirection::Sent {
            sent.push(*frame);
        }
    });
    let listening = Duration::from_millis(500);
    let scan = Scan::make(&mut observed, &clock, listening, asking, &StopRequest::default()).unwrap();
    (scan, sent)
}

#[test]
fn each_drive_is_found_and_tells_who_it_is() {
    let (scan, sent) = scan(Asking::UnlessDisturbing);
    assert_eq!(scan.nodes().into_iter().collect::<Vec<_>>(), [1, 2, 3]);
    assert_eq!(scan.listened_s, 0.5);
    let identity = &scan.identities[&2];
    // docs/wire.md, section 11: vendor 0, product 5541_524Dh.
    assert_eq!((identity.vendor, identity.product), (Some(0), Some(0x5541_524D)));
    assert!(identity.is_drive());
    assert_eq!(identity.power_state.as_deref(), Some("Switch on disabled"));
    assert!(identity.name.as_deref().is_some_and(|name| name.contains("UARM")), "{identity:?}");
    // SDO uploads only: command specifier 2 (initiate) or 3 (segment) in the upper three bits, CiA 301, 7.2.4.3.
    for frame in &sent {
        assert!(matches!(Channel::of(frame.id()), Some(Channel::SdoRequest(_))), "{frame:?}");
        assert!(matches!(frame.data()[0] >> 5, 2 | 3), "{frame:?}");
    }
    assert_eq!(sent.iter().map(|frame| frame.id().as_raw() - 0x600).collect::<BTreeSet<_>>(), (1..=126).collect());
}

#[test]
fn who_only_listens_sends_nothing() {
    let (scan, sent) = scan(Asking::Never);
    assert_eq!(sent, []);
    // The drives' boot-up messages are heard; the emulated drive has no heartbeat before it is told so.
    assert_eq!(scan.nodes().into_iter().collect::<Vec<_>>(), [1, 2, 3]);
    assert!(scan.identities.is_empty() && scan.not_asked.is_some());
}

#[test]
fn a_request_to_stop_ends_the_listening_and_nobody_is_asked() {
    let stop = StopRequest::default();
    stop.make();
    let (mut link, clock) = bus();
    let scan = Scan::make(&mut link, &clock, Duration::from_secs(60), Asking::Always, &stop).unwrap();
    assert_eq!((scan.listened_s, scan.not_asked.as_deref()), (0.0, Some("interrupted")));
}

#[test]
fn a_master_or_errors_keep_a_scan_from_asking() {
    let quiet = Scan::default();
    let mastered = Scan { master: vec!["SYNC".to_owned()], ..Scan::default() };
    let disturbed = Scan { error_frames: 1, ..Scan::default() };
    assert_eq!(quiet.reason_not_to_ask(Asking::UnlessDisturbing, false), None);
    for scan in [&mastered, &disturbed] {
        assert!(scan.reason_not_to_ask(Asking::UnlessDisturbing, false).is_some());
        assert_eq!(scan.reason_not_to_ask(Asking::Always, false), None);
    }
}
