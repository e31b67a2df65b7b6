use super::configuration::LISTEN;
use super::*;
use crate::drive::cia402::PowerState;
use crate::drive::wire::{Channel, DriveCommand, DriveFeedback};
use crate::frame::Frame;
use crate::time::{Clock, Instant};
use canopen_rs::NmtState;
use std::format;
use std::vec::Vec;

/// What another master may send, what it is taken for, and how that is told.
fn foreign_frames() -> Vec<(u16, Vec<u8>, ForeignFrame, &'static str)> {
    std::vec![
        (0x000, std::vec![1, 99], ForeignFrame::NmtCommand, "an NMT command (000h)"),
        (0x080, std::vec![], ForeignFrame::Sync, "a SYNC (080h)"),
        (0x080, std::vec![7], ForeignFrame::Sync, "a SYNC (080h)"),
        (0x77F, std::vec![5], ForeignFrame::MasterHeartbeat, "a heartbeat of node 127, this master's own (77Fh)"),
        (0x202, std::vec![0; 4], ForeignFrame::Rpdo { node: 2, identifier: 0x202 }, "an RPDO to node 2 (202h)"),
        (0x303, std::vec![0; 8], ForeignFrame::Rpdo { node: 3, identifier: 0x303 }, "an RPDO to node 3 (303h)"),
        (0x401, std::vec![0], ForeignFrame::Rpdo { node: 1, identifier: 0x401 }, "an RPDO to node 1 (401h)"),
        (0x501, std::vec![], ForeignFrame::Rpdo { node: 1, identifier: 0x501 }, "an RPDO to node 1 (501h)"),
        (
            0x603,
            std::vec![0x40, 0, 0x10, 0, 0, 0, 0, 0],
            ForeignFrame::SdoRequest { node: 3 },
            "an SDO request to node 3 (603h)"
        ),
    ]
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(embedded_can::StandardId::new(id).unwrap(), data).unwrap()
}

fn started() -> DriveNetwork<FakeBus, 3> {
    let mut network = network();
    start(&mut network).unwrap();
    network
}

/// SYNC and feedback, as the loop waits for it.
fn collect(network: &mut DriveNetwork<FakeBus, 3>) -> Result<Feedback<3>, CycleError<bus::Down>> {
    let deadline = network.link().clock.now() + Duration::from_millis(2);
    network.sync()?;
    network.collect(deadline)
}

fn after_listening(milliseconds: u64) -> Instant {
    Instant::default() + LISTEN + Duration::from_millis(milliseconds)
}

#[test]
fn another_master_that_is_heard_before_the_start_keeps_this_one_silent() {
    for (id, data, heard, words) in foreign_frames() {
        for millisecond in [0, 199] {
            let mut network = network();
            let at = Instant::from_nanoseconds(millisecond * 1_000_000);
            network.link_mut().inject(at, frame(id, &data));
            let error = start(&mut network).unwrap_err();
            assert_eq!(error, StartError::Disturbed(Disturbance::AnotherMaster(heard)));
            assert_eq!(format!("{error}"), format!("another master is on this bus: it sent {words}"));
            let report = stop(&mut network);
            assert!(!report.all_off());
            assert!(report.drives.iter().all(|drive| drive.power_off == Confirmation::Withheld));
            assert_eq!(network.link().sent, [], "{words}");
        }
    }
}

#[test]
fn a_refused_start_does_not_refuse_the_next() {
    let mut network = network();
    network.link_mut().inject(Instant::default(), frame(0x080, &[]));
    start(&mut network).unwrap_err();
    stop(&mut network);
    start(&mut network).unwrap();
    assert!(stop(&mut network).all_off());
}

#[test]
fn nothing_is_sent_while_listening() {
    let mut network = network();
    start(&mut network).unwrap();
    // The drives boot 10, 20 and 30 ms after their reset: what takes longer is the listening.
    assert!(network.link().clock.now() >= after_listening(30));
    let mut network = self::network();
    network.link_mut().down_until = Some(after_listening(0));
    start(&mut network).unwrap();
}

#[test]
fn another_master_that_is_heard_during_the_start_fails_it() {
    for (id, data, heard, words) in foreign_frames() {
        let mut network = network();
        network.link_mut().inject(after_listening(25), frame(id, &data));
        let error = start(&mut network).unwrap_err();
        assert_eq!(error, StartError::Disturbed(Disturbance::AnotherMaster(heard)), "{words}");
        assert!(stop(&mut network).all_off(), "the drives are this master's by then");
    }
}

#[test]
fn another_master_ends_a_run_in_the_cycle_in_which_it_is_heard() {
    for (id, data, heard, words) in foreign_frames() {
        let mut network = started();
        collect(&mut network).unwrap();
        network.send_torques([0; 3]).unwrap();
        let expected = CycleError::Disturbed(Disturbance::AnotherMaster(heard));

        // Between two cycles: no SYNC follows.
        let now = network.link().clock.now();
        let syncs = network.health().syncs;
        network.link_mut().inject(now, frame(id, &data));
        assert_eq!(collect(&mut network), Err(expected), "{words}");
        assert_eq!(network.health().syncs, syncs);

        // With the feedback: no torque follows.
        let mut network = started();
        network.link_mut().drives[2].script.feedback_delay = Duration::from_millis(1);
        network.sync().unwrap();
        let now = network.link().clock.now();
        network.link_mut().inject(now, frame(id, &data));
        assert_eq!(network.collect(now + Duration::from_millis(2)), Err(expected), "{words}");

        // After the torques.
        let mut network = started();
        collect(&mut network).unwrap();
        let now = network.link().clock.now();
        network.link_mut().inject(now, frame(id, &data));
        assert_eq!(network.housekeeping(now), Err(expected), "{words}");
        assert!(stop(&mut network).all_off());
    }
}

/// A drive that does not answer is not waited for when another master was heard.
#[test]
fn another_master_ends_the_wait_for_feedback() {
    let mut network = started();
    network.link_mut().drives[0].script.ignores_syncs = std::vec![1];
    network.sync().unwrap();
    let now = network.link().clock.now();
    network.link_mut().inject(now, frame(0x080, &[]));
    network.collect(now + Duration::from_millis(2)).unwrap_err();
    assert_eq!(network.link().clock.now(), now);
}

#[test]
fn the_first_disturbance_is_the_one_that_is_told() {
    let mut network = started();
    let now = network.link().clock.now();
    network.link_mut().inject(now, frame(0x000, &[0x81, 2]));
    network.link_mut().inject(now, frame(0x702, &[0]));
    let expected = CycleError::Disturbed(Disturbance::AnotherMaster(ForeignFrame::NmtCommand));
    assert_eq!(collect(&mut network), Err(expected));
}

#[test]
fn two_answers_to_one_sync_are_two_drives() {
    let mut network = started();
    collect(&mut network).unwrap();
    network.link_mut().drives[1].script.answers_twice = true;
    let error = collect(&mut network).unwrap_err();
    assert_eq!(error, CycleError::Disturbed(Disturbance::Twins { node: 2 }));
    assert!(format!("{error}").contains("are there two drives with node id 2?"), "{error}");
    assert!(stop(&mut network).all_off());
}

#[test]
fn a_second_answer_that_comes_after_the_torques_is_found_too() {
    let mut network = started();
    collect(&mut network).unwrap();
    let now = network.link().clock.now();
    let answer = DriveFeedback::default().frame(network.link().drives[2].node);
    network.link_mut().inject(now, answer);
    assert_eq!(network.housekeeping(now), Err(CycleError::Disturbed(Disturbance::Twins { node: 3 })));
}

/// All answers of a slow drive come, each in the cycle after the next: one for each SYNC, and so it is one drive.
#[test]
fn late_answers_are_not_two_drives() {
    let mut network = started();
    network.link_mut().drives[0].script.feedback_delay = Duration::from_micros(6_500);
    for _ in 0..20 {
        let begin = network.link().clock.now();
        network.sync().unwrap();
        assert!(!matches!(network.collect(begin + Duration::from_millis(2)), Err(CycleError::Disturbed(_))));
        network.send_torques([0; 3]).unwrap();
        network.housekeeping(begin).unwrap();
        network.link().clock.clone().sleep_until(begin + PERIOD);
    }
}

/// A drive that missed SYNCs lends no answers to a second drive for long.
#[test]
fn two_drives_are_found_after_missed_syncs_too() {
    let mut network = started();
    network.link_mut().drives[1].script.ignores_syncs = (1..=20).collect();
    for _ in 0..20 {
        assert_eq!(collect(&mut network).unwrap().positions[1], None);
    }
    network.link_mut().drives[1].script.answers_twice = true;
    let found = (0..3).find_map(|_| collect(&mut network).err());
    assert_eq!(found, Some(CycleError::Disturbed(Disturbance::Twins { node: 2 })));
}

/// Before the first SYNC of a run feedback belongs to nobody; the last run's SYNCs do not count.
#[test]
fn feedback_before_the_first_sync_is_not_two_drives() {
    let mut network = started();
    collect(&mut network).unwrap();
    stop(&mut network);
    let now = network.link().clock.now();
    for node in [1, 1, 2] {
        let answer = DriveFeedback::default().frame(canopen_rs::NodeId::new(node).unwrap());
        network.link_mut().inject(now + LISTEN / 2, answer);
    }
    start(&mut network).unwrap();
    collect(&mut network).unwrap();
}

#[test]
fn drives_that_are_found_enabled_lose_their_power_with_the_first_frames() {
    let mut network = network();
    for drive in &mut network.link_mut().drives {
        (drive.power, drive.nmt) = (PowerState::OperationEnabled, NmtState::Operational);
    }
    start(&mut network).unwrap();
    let off = |node| DriveCommand::default().frame(canopen_rs::NodeId::new(node).unwrap());
    assert_eq!(network.link().sent[..3], [off(1), off(2), off(3)]);
    assert_eq!(off(1).data(), [0; 4]);
}

/// A drive that keeps its power through a reset of the communication, and had other PDOs or none before it.
#[test]
fn drives_that_are_still_enabled_after_the_reset_lose_their_power_before_their_settings() {
    for powered in [PowerState::OperationEnabled, PowerState::QuickStopActive] {
        let mut network = network();
        network.link_mut().drives[2].power = powered;
        start(&mut network).unwrap();
        let writes: Vec<&Frame> = network.link().sent.iter().filter(|frame| is_write(frame)).collect();
        assert_eq!((writes[0].id().as_raw(), writes[0].data()), (0x603, &[0x2B, 0x40, 0x60, 0, 0, 0, 0, 0][..]));
        assert!(writes[1..].iter().all(|frame| frame.data()[1..3] != [0x40, 0x60]), "once");
        assert_eq!(network.link().drives[2].power, PowerState::OperationEnabled);
    }
}

#[test]
fn a_drive_that_cannot_be_switched_off_is_not_started() {
    let mut network = network();
    network.link_mut().drives[0].power = PowerState::OperationEnabled;
    network.link_mut().drives[0].script.stuck_in = Some(PowerState::OperationEnabled);
    let error = start(&mut network).unwrap_err();
    assert!(matches!(error, StartError::NotReached { node: 1, expected: PowerState::SwitchOnDisabled, .. }), "{error}");
}

/// An expedited or segmented SDO download (CiA 301).
fn is_write(frame: &Frame) -> bool {
    matches!(Channel::of(frame.id()), Some(Channel::SdoRequest(_))) && frame.data()[0] & 0xE0 == 0x20
}

fn heartbeats(frames: &[Frame]) -> usize {
    frames.iter().filter(|frame| frame.id().as_raw() == 0x77F).count()
}

/// The heartbeats of a master that cannot stop a drive would keep that drive's watchdog from stopping it.
#[test]
fn after_a_stop_that_is_not_confirmed_in_time_the_master_is_silent() {
    let mut network = started();
    network.link_mut().drives[1].script.stuck_in = Some(PowerState::OperationEnabled);
    let before = network.link().sent.len();
    stop(&mut network);
    let sent = &network.link().sent[before..];
    let power_off = sent.iter().rposition(|frame| frame.id().as_raw() == 0x203).expect("disable voltage");
    // One every 20 ms for half a second.
    assert!((25..=26).contains(&heartbeats(&sent[..power_off])), "{}", heartbeats(&sent[..power_off]));
    assert_eq!(heartbeats(&sent[power_off..]), 0);
}

/// A drive that is silent holds the first step up beyond its time; heartbeats end with that time.
#[test]
fn silent_drives_do_not_prolong_the_heartbeats() {
    let mut network = started();
    let now = network.link().clock.now();
    for drive in &mut network.link_mut().drives {
        drive.script.dies_at = Some(now);
    }
    let before = network.link().sent.len();
    stop(&mut network);
    assert!(network.link().clock.now().since(now) > Duration::from_secs(1));
    assert!((25..=26).contains(&heartbeats(&network.link().sent[before..])));
}

#[test]
fn a_stop_that_is_confirmed_keeps_its_voice_to_the_end() {
    let mut network = started();
    let clock = network.link().clock.clone();
    let mut blocking = blocking::Blocking::new(&mut network, &clock);
    assert!(blocking.stop().all_off());
    assert!(matches!(blocking.voice, blocking::Voice::HeartbeatsUntil(end) if end > clock.now()));
}

/// The drives of two joints were exchanged, or one was replaced: nothing is written to it.
#[test]
fn another_drive_than_the_pinned_one_is_not_written_to() {
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[1].identity.vendor = Some(0x56);
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    let error = start(&mut network).unwrap_err();
    assert!(matches!(error, StartError::Refused { node: 2, .. }), "{error}");
    let message = format!("{error}");
    for words in ["node 2", "vendor", "55h", "56h"] {
        assert!(message.contains(words), "{words} in {message}");
    }
    assert!(!network.link().sent.iter().any(|frame| is_write(frame) && frame.id().as_raw() == 0x602));
}

/// Each answers whatever is asked of node 2. That they send the same at the same instant is no rescue on a real bus either: their
/// serial numbers differ.
#[test]
fn two_drives_with_one_node_id_are_told_at_the_start() {
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3, 2]), configuration());
    let error = start(&mut network).unwrap_err();
    assert_eq!(error, StartError::Disturbed(Disturbance::SdoTwins { node: 2 }));
    let words = "two answers to one SDO request from node 2: are there two drives with node id 2?";
    assert_eq!(format!("{error}"), words);
    assert!(network.link().drives.iter().all(|drive| drive.power != PowerState::OperationEnabled));
}

/// The confirmation of a write comes twice, and the read that follows takes the second for its answer.
#[test]
fn a_second_confirmation_is_told_as_that_of_a_second_drive() {
    let mut network = network();
    network.link_mut().echo = Some(0x60);
    let error = start(&mut network).unwrap_err();
    assert_eq!(error, StartError::Disturbed(Disturbance::SdoTwins { node: 1 }));
}

/// A server that gives a transfer up says so once more than it was asked.
#[test]
fn an_abort_that_nobody_asked_for_is_not_a_second_drive() {
    let mut network = network();
    network.link_mut().echo = Some(0x80);
    network.link_mut().drives[1].lacks.push(crate::drive::objects::SERIAL_NUMBER.address());
    start(&mut network).unwrap();
}
