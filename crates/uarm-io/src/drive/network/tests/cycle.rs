use super::*;
use crate::drive::cia402::{Command, Controlword, PowerState, Statusword};
use crate::drive::wire::{DriveCommand, DriveFeedback};
use crate::frame::Frame;
use crate::link::Received;
use crate::time::Clock;
use canopen_rs::NmtState;
use proptest::prelude::*;
use std::format;

fn started() -> DriveNetwork<FakeBus, 3> {
    let mut network = network();
    start(&mut network).unwrap();
    network
}

/// One whole cycle: SYNC, feedback within 2 ms, torques, housekeeping, sleep to the end of the period.
fn cycle(network: &mut DriveNetwork<FakeBus, 3>, torques: [i16; 3]) -> Result<Feedback<3>, CycleError<bus::Down>> {
    let mut clock = network.link().clock.clone();
    let begin = clock.now();
    network.sync()?;
    let feedback = network.collect(begin + Duration::from_millis(2));
    let sent = network.send_torques(torques);
    let kept = network.housekeeping(clock.now());
    clock.sleep_until(begin + PERIOD);
    let feedback = feedback?;
    sent?;
    kept?;
    Ok(feedback)
}

#[test]
fn a_thousand_cycles_count_up() {
    let mut network = started();
    for count in 0..1000_i32 {
        for (joint, drive) in network.link_mut().drives.iter_mut().enumerate() {
            drive.position = count * 10 + joint as i32;
        }
        let feedback = cycle(&mut network, [0, 5, -5]).unwrap();
        assert_eq!(feedback.positions, [count * 10, count * 10 + 1, count * 10 + 2].map(Some));
    }
    let health = network.health();
    assert_eq!(health.syncs, 1000);
    assert_eq!(health.unexpected_frames, 0);
    for node in health.nodes {
        assert_eq!(
            (node.feedbacks, node.missed_feedbacks, node.stale_feedbacks, node.surplus_feedbacks),
            (1000, 0, 0, 0)
        );
        assert_eq!(node.longest_feedback_gap, PERIOD);
        // The drives send every 50 ms; the bus moves in steps of up to 3 ms here.
        assert!(node.longest_heartbeat_gap <= Duration::from_millis(56), "{node:?}");
    }
    let last = network.link().drives[2].commands.last().unwrap();
    assert_eq!((last.target_torque, last.controlword), (-5, bus::enabling()));
}

#[test]
fn the_sync_counter_runs_from_1_to_240() {
    let mut network = started();
    for _ in 0..241 {
        cycle(&mut network, [0; 3]).unwrap();
    }
    let counters: std::vec::Vec<u8> =
        network.link().sent.iter().filter(|frame| frame.id().as_raw() == 0x080).map(|frame| frame.data()[0]).collect();
    assert_eq!(counters[0], 1);
    assert_eq!(counters[239], 240);
    assert_eq!(counters[240], 1);
}

#[test]
fn a_missing_answer_is_told_and_the_next_cycle_goes_on() {
    let mut network = started();
    network.link_mut().drives[1].script.ignores_syncs = std::vec![2];
    cycle(&mut network, [0; 3]).unwrap();
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions, [Some(0), None, Some(0)]);
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions, [Some(0); 3]);
    assert_eq!(network.health().nodes[1].missed_feedbacks, 1);
    assert_eq!(network.health().nodes[1].longest_feedback_gap, 2 * PERIOD);
}

#[test]
fn an_answer_that_comes_after_its_deadline_is_not_taken_for_the_next() {
    let mut network = started();
    network.link_mut().drives[0].script.feedback_delay = Duration::from_micros(2_500);
    network.link_mut().drives[0].position = 1;
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[0], None);
    network.link_mut().drives[0].script.feedback_delay = Duration::from_micros(500);
    network.link_mut().drives[0].position = 2;
    let feedback = cycle(&mut network, [0; 3]).unwrap();
    assert_eq!(feedback.positions[0], Some(2));
    assert_eq!(feedback.latency, Duration::from_micros(500));
}

/// A link without time stamps of its own: only taking in what is left before the SYNC can tell late answers.
#[test]
fn late_answers_are_told_without_stamps_too() {
    let mut network = started();
    network.link_mut().stamps_on_reading = true;
    network.link_mut().drives[0].script.feedback_delay = Duration::from_micros(2_500);
    network.link_mut().drives[0].position = 1;
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[0], None);
    network.link_mut().drives[0].script.feedback_delay = Duration::ZERO;
    network.link_mut().drives[0].position = 2;
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[0], Some(2));
    let health = network.health().nodes[0];
    assert_eq!(
        (health.feedbacks, health.missed_feedbacks, health.stale_feedbacks, health.surplus_feedbacks),
        (1, 1, 1, 0)
    );
}

#[test]
/// Late by more than a period: two answers come to one SYNC, and the second is its own.
fn an_answer_that_is_late_by_a_period_is_not_taken_for_the_next() {
    let mut network = started();
    network.link_mut().drives[0].script.feedback_delay = PERIOD + Duration::from_micros(500);
    network.link_mut().drives[0].position = 1;
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[0], None);
    network.link_mut().drives[0].script.feedback_delay = Duration::from_micros(1_000);
    network.link_mut().drives[0].position = 2;
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[0], Some(2));
    let health = network.health().nodes[0];
    assert_eq!((health.missed_feedbacks, health.stale_feedbacks, health.surplus_feedbacks), (1, 1, 0));
}

/// It was read in time for the cycle, but it came after the deadline.
#[test]
fn an_answer_with_a_stamp_after_the_deadline_is_lost() {
    let mut network = started();
    network.sync().unwrap();
    let deadline = network.link().clock.now() + Duration::from_millis(2);
    network.link_mut().drives[0].script.feedback_delay = Duration::from_micros(500);
    let late = Received {
        frame: DriveFeedback { statusword: Statusword::of(PowerState::OperationEnabled), position: 9 }
            .frame(NodeId::new(1).unwrap()),
        at: deadline + Duration::from_micros(1),
    };
    network.deadline = deadline;
    network.absorb(&late);
    assert!(network.nodes[0].fresh.is_none());
    assert_eq!(network.health().nodes[0].stale_feedbacks, 1);
}

#[test]
fn an_answer_that_is_too_early_for_its_sync_is_stale() {
    let mut configuration = configuration();
    configuration.earliest_feedback = Duration::from_micros(144);
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    start(&mut network).unwrap();
    for drive in &mut network.link_mut().drives {
        drive.script.feedback_delay = Duration::from_micros(200);
    }
    // Late by a whole period: it arrives just after the next SYNC, sooner than any answer to that can be here.
    network.link_mut().drives[2].script.feedback_delay = Duration::from_micros(3_050);
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[2], None);
    network.link_mut().drives[2].script.feedback_delay = Duration::from_micros(200);
    network.link_mut().drives[2].position = 7;
    let feedback = cycle(&mut network, [0; 3]).unwrap();
    assert_eq!(feedback.positions[2], Some(7));
    assert_eq!(network.health().nodes[2].stale_feedbacks, 1);
}

#[test]
fn every_state_but_operation_enabled_is_an_error() {
    for state in PowerState::ALL.into_iter().filter(|state| *state != PowerState::OperationEnabled) {
        let mut network = started();
        cycle(&mut network, [0; 3]).unwrap();
        network.link_mut().drives[2].power = state;
        let error = cycle(&mut network, [0; 3]).unwrap_err();
        assert_eq!(error, CycleError::NotEnabled { node: 3, found: Statusword::of(state), emergency: None });
    }
}

#[test]
fn a_drive_that_stops_following_its_target_is_an_error_and_one_that_never_said_so_is_none() {
    let told = |reaction| {
        let mut configuration = configuration();
        configuration.ignored_target_reaction = reaction;
        let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
        start(&mut network).unwrap();
        // It does not set the bit from the first answer on.
        cycle(&mut network, [0; 3]).unwrap();
        network.link_mut().drives[1].script.status_bits = Statusword::FOLLOWS_TARGET;
        cycle(&mut network, [0; 3]).unwrap();
        network.link_mut().drives[1].script.status_bits = 0;
        let outcome = cycle(&mut network, [0; 3]);
        (network, outcome)
    };
    let (mut network, outcome) = told(IgnoredTargetReaction::Stop);
    let error = outcome.unwrap_err();
    assert_eq!(error, CycleError::TargetIgnored { node: 2, found: Statusword::of(PowerState::OperationEnabled) });
    assert!(format!("{error}").starts_with("node 2 ignores its target torque: bit 12 is 0 in Operation enabled"));
    // The next run knows nothing of it.
    stop(&mut network);
    start(&mut network).unwrap();
    cycle(&mut network, [0; 3]).unwrap();
    assert!(told(IgnoredTargetReaction::Record).1.is_ok());
}

#[test]
fn a_silent_drive_is_lost_after_its_time() {
    let mut network = started();
    for _ in 0..100 {
        cycle(&mut network, [0; 3]).unwrap();
    }
    let now = network.link().clock.now();
    network.link_mut().drives[0].script.dies_at = Some(now);
    // 180 ms of silence are borne, as far as heartbeats go; the answers to SYNC are missed at once.
    for _ in 0..60 {
        assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions[0], None);
    }
    let now = network.link().clock.now();
    assert_eq!(network.housekeeping(now - Duration::from_millis(40)), Ok(()));
    for _ in 0..20 {
        let _ = cycle(&mut network, [0; 3]);
    }
    let now = network.link().clock.now();
    let error = network.housekeeping(now).unwrap_err();
    assert!(matches!(error, CycleError::Lost { node: 1, limit, .. } if limit == Duration::from_millis(200)), "{error}");
}

#[test]
fn a_drive_that_boots_anew_is_noticed() {
    let mut network = started();
    cycle(&mut network, [0; 3]).unwrap();
    let now = network.link().clock.now();
    let boot_up = wire::heartbeat_frame(NodeId::new(2).unwrap(), NmtState::Initialising);
    network.link_mut().inject(now, boot_up);
    let error = cycle(&mut network, [0; 3]).unwrap_err();
    assert_eq!(error, CycleError::Disturbed(Disturbance::Rebooted { node: 2 }));
    assert!(format!("{error}").starts_with("node 2 booted anew: its settings and its watchdog are lost"), "{error}");
    // Whatever else the drive reports later: no SYNC is sent any more.
    let syncs = network.health().syncs;
    assert_eq!(network.sync(), Err(CycleError::Disturbed(Disturbance::Rebooted { node: 2 })));
    assert_eq!(network.health().syncs, syncs);
    stop(&mut network);
    start(&mut network).unwrap();
    cycle(&mut network, [0; 3]).unwrap();
}

#[test]
fn emergencies_stop_or_are_recorded_as_configured() {
    let mut network = started();
    network.link_mut().inject_emergency(1, 0x8130);
    let error = cycle(&mut network, [0; 3]).unwrap_err();
    assert!(matches!(error, CycleError::Emergency { node: 1, .. }));
    assert!(format!("{error}").contains("life guard or heartbeat error (8130h"), "{error}");
    // An error reset is no alarm.
    network.link_mut().inject_emergency(1, 0);
    cycle(&mut network, [0; 3]).unwrap();

    // Nor does one excuse the error before it: the drive was enabled when it came.
    network.link_mut().inject_emergency(3, 0x2310);
    network.link_mut().inject_emergency(3, 0);
    assert!(matches!(cycle(&mut network, [0; 3]), Err(CycleError::Emergency { node: 3, .. })));

    let mut configuration = configuration();
    configuration.emergency_reaction = EmergencyReaction::Record;
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    start(&mut network).unwrap();
    network.link_mut().inject_emergency(1, 0x8130);
    cycle(&mut network, [0; 3]).unwrap();
    assert_eq!(network.health().nodes[0].last_emergency.unwrap().error_code, 0x8130);
}

/// Drives that leave out the maker's bytes, or more.
#[test]
fn an_emergency_of_any_length_stops() {
    for length in 0..8 {
        let mut network = started();
        let now = network.link().clock.now();
        let data = [0x10, 0x42, 0x09, 1, 2, 3, 4];
        let id = wire::Channel::Emergency(NodeId::new(2).unwrap()).identifier();
        network.link_mut().inject(now, Frame::new(id, &data[..length]).unwrap());
        let error = cycle(&mut network, [0; 3]).unwrap_err();
        assert!(matches!(error, CycleError::Emergency { node: 2, .. }), "{length} bytes: {error}");
    }
}

#[test]
fn an_emergency_between_start_and_the_first_sync_stops() {
    let mut network = started();
    network.link_mut().inject_emergency(2, 0x2310);
    let error = cycle(&mut network, [0; 3]).unwrap_err();
    assert!(matches!(error, CycleError::Emergency { node: 2, .. }), "{error}");
}

/// An answer of joint 1 that is stamped so long after the SYNC of a started network, whose deadline is 2 ms.
fn answer_after(network: &mut DriveNetwork<FakeBus, 3>, latency: Duration) {
    network.deadline = network.sync_at + Duration::from_millis(2);
    let at = network.sync_at + latency;
    let feedback = DriveFeedback { statusword: Statusword::of(PowerState::OperationEnabled), position: 9 };
    network.absorb(&Received { frame: feedback.frame(NodeId::new(1).unwrap()), at });
}

#[test]
fn an_answer_counts_from_the_earliest_instant_to_its_deadline() {
    for (microseconds, stale) in [(143, 1), (144, 0), (2_000, 0), (2_001, 1)] {
        let mut configuration = configuration();
        configuration.earliest_feedback = Duration::from_micros(144);
        let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
        start(&mut network).unwrap();
        network.sync().unwrap();
        answer_after(&mut network, Duration::from_micros(microseconds));
        let health = network.health().nodes[0];
        assert_eq!((health.feedbacks, health.stale_feedbacks), (1 - stale, stale), "{microseconds} us");
    }
}

/// The loop went on without it.
#[test]
fn an_answer_behind_a_cycle_that_missed_it_is_stale() {
    let mut network = started();
    network.sync().unwrap();
    network.nodes[0].missed = true;
    answer_after(&mut network, Duration::from_millis(1));
    assert_eq!((network.health().nodes[0].feedbacks, network.health().nodes[0].stale_feedbacks), (0, 1));
}

#[test]
fn every_frame_of_a_drive_is_counted_as_what_it_was() {
    let mut network = started();
    network.sync().unwrap();
    let before = network.health();
    for _ in 0..3 {
        answer_after(&mut network, Duration::from_millis(1));
    }
    let at = network.link().clock.now();
    let heartbeat = embedded_can::StandardId::new(0x701).unwrap();
    for data in [&[0x05_u8][..], &[0x05], &[0x05, 0x05, 0x05]] {
        network.absorb(&Received { frame: Frame::new(heartbeat, data).unwrap(), at });
    }
    let (now, node, earlier) = (network.health(), network.health().nodes[0], before.nodes[0]);
    assert_eq!(now.frames_received - before.frames_received, 6);
    assert_eq!((node.feedbacks, node.surplus_feedbacks), (1, 2));
    assert_eq!((node.heartbeats - earlier.heartbeats, node.malformed), (2, 1));
}

#[test]
fn answers_that_come_with_the_deadline_are_waited_for() {
    let mut network = started();
    for drive in &mut network.link_mut().drives {
        drive.script.feedback_delay = Duration::from_millis(2);
    }
    assert_eq!(cycle(&mut network, [0; 3]).unwrap().positions, [Some(0); 3]);
}

/// A link without time stamps of its own, which the loop comes to a millisecond too late.
#[test]
fn a_full_bus_does_not_hold_the_loop_beyond_its_deadline() {
    let mut network = started();
    network.link_mut().stamps_on_reading = true;
    for drive in &mut network.link_mut().drives {
        drive.script.feedback_delay = Duration::from_millis(20);
    }
    network.sync().unwrap();
    let mut clock = network.link().clock.clone();
    let deadline = clock.now() + Duration::from_millis(2);
    clock.sleep_until(deadline + Duration::from_millis(1));
    let now = clock.now();
    for _ in 0..8 {
        network.link_mut().inject(now, Frame::new(embedded_can::StandardId::new(0x7FF).unwrap(), &[]).unwrap());
    }
    let before = network.health().unexpected_frames;
    assert_eq!(network.collect(deadline).unwrap().positions, [None; 3]);
    assert_eq!(network.health().unexpected_frames - before, 1, "the first one told the time");
}

#[test]
fn a_drive_may_be_silent_for_its_time_and_no_longer() {
    let mut network = started();
    let now = network.link().clock.now();
    network.housekeeping(now).unwrap();
    let heard = network.health().nodes.map(|node| node.last_heartbeat_at.unwrap()).into_iter().min().unwrap();
    assert_eq!(network.housekeeping(heard + Duration::from_millis(200)), Ok(()));
    let error = network.housekeeping(heard + Duration::from_micros(200_001)).unwrap_err();
    assert!(matches!(error, CycleError::Lost { silence, .. } if silence == Duration::from_micros(200_001)), "{error}");
}

#[test]
fn controlwords_go_out_without_torque() {
    let mut network = started();
    cycle(&mut network, [0, 5, -5]).unwrap();
    let words = [bus::enabling(), Controlword::of(Command::QuickStop), bus::enabling()];
    let sent_at = network.send_controlwords(words).unwrap();
    assert_eq!(sent_at, network.link().clock.now());
    for (drive, controlword) in network.link().drives.iter().zip(words) {
        assert_eq!(drive.commands.last(), Some(&DriveCommand { controlword, target_torque: 0 }));
    }
}

#[test]
fn frames_of_others_are_counted_and_nothing_else() {
    let mut network = started();
    let before = network.health().unexpected_frames;
    let now = network.link().clock.now();
    for stranger in [0x184, 0x085, 0x7FF, 0x204, 0x604, 0x77E] {
        let id = embedded_can::StandardId::new(stranger).unwrap();
        network.link_mut().inject(now, Frame::new(id, &[1, 2, 3, 4, 5, 6]).unwrap());
    }
    cycle(&mut network, [0; 3]).unwrap();
    assert_eq!(network.health().unexpected_frames, before + 6);
}

#[test]
fn stopping_is_confirmed_by_every_drive() {
    let mut network = started();
    cycle(&mut network, [3; 3]).unwrap();
    let report = stop(&mut network);
    assert!(report.all_off());
    for (stopped, drive) in report.drives.iter().zip(&network.link().drives) {
        let [quick_stop, power_off, nmt_stop] = [stopped.quick_stop, stopped.power_off, stopped.nmt_stop];
        assert_eq!([quick_stop, power_off, nmt_stop], [Confirmation::Confirmed; 3]);
        assert_eq!(stopped.node, drive.node.raw());
        assert_eq!((drive.power, drive.nmt), (PowerState::SwitchOnDisabled, NmtState::Stopped));
        // A quick stop, then power off, both without torque.
        let [.., before, last] = &drive.commands[..] else { panic!("two commands") };
        assert_eq!([before, last].map(|command| command.controlword.bits()), [0x02, 0x00]);
        assert_eq!([before, last].map(|command| command.target_torque), [0, 0]);
    }
}

#[test]
fn stopping_reports_what_was_not_confirmed() {
    let mut network = started();
    let now = network.link().clock.now();
    network.link_mut().drives[1].script.dies_at = Some(now);
    let report = stop(&mut network);
    assert!(!report.all_off());
    assert_eq!(report.drives[0].power_off, Confirmation::Confirmed);
    let DriveStop { quick_stop, power_off, nmt_stop, .. } = report.drives[1];
    assert_eq!([quick_stop, power_off, nmt_stop], [Confirmation::Unconfirmed; 3]);
    assert_eq!(report.drives[2].power_off, Confirmation::Confirmed);
    // The dead drive costs two SDO timeouts and one of NMT, 0.9 s, and not more.
    assert!(network.link().clock.now().since(now) < Duration::from_millis(950));

    let mut network = started();
    network.link_mut().down = true;
    let report = stop(&mut network);
    for DriveStop { quick_stop, power_off, nmt_stop, .. } in report.drives {
        assert_eq!([quick_stop, power_off, nmt_stop], [Confirmation::NotSent; 3]);
    }
}

#[test]
fn a_drive_that_stays_enabled_is_not_reported_as_stopped() {
    let mut network = started();
    network.link_mut().drives[1].script.stuck_in = Some(PowerState::OperationEnabled);
    let before = network.link().clock.now();
    let report = stop(&mut network);
    assert!(!report.all_off());
    let DriveStop { quick_stop, power_off, nmt_stop, .. } = report.drives[1];
    let expected = [Confirmation::Unconfirmed, Confirmation::Unconfirmed, Confirmation::Confirmed];
    assert_eq!([quick_stop, power_off, nmt_stop], expected);
    // It was asked for the time of a step, twice.
    let stop = Timeouts::default().stop;
    let time = network.link().clock.now().since(before);
    assert!(time >= 2 * stop && time < 3 * stop, "{time:?}");
}

#[test]
fn stopping_a_network_that_never_started_enables_nothing() {
    let mut network = network();
    for drive in &mut network.link_mut().drives {
        drive.nmt = NmtState::Operational;
        drive.power = PowerState::SwitchedOn;
    }
    assert!(stop(&mut network).all_off());
    let commands = network.link().drives.iter().flat_map(|drive| &drive.commands);
    assert!(commands.into_iter().all(|command| command.controlword != bus::enabling()));
}

#[test]
fn a_stopped_network_starts_again() {
    let mut network = started();
    cycle(&mut network, [0; 3]).unwrap();
    stop(&mut network);
    start(&mut network).unwrap();
    cycle(&mut network, [0; 3]).unwrap();
    let syncs = network.link().sent.iter().filter(|frame| frame.id().as_raw() == 0x080);
    assert!(syncs.into_iter().all(|frame| frame.data() == [1]));
}

#[test]
fn a_failing_link_is_told_by_every_step() {
    let mut network = started();
    network.link_mut().down = true;
    let now = network.link().clock.now();
    assert_eq!(network.sync(), Err(CycleError::Link(bus::Down)));
    assert_eq!(network.collect(now), Err(CycleError::Link(bus::Down)));
    assert_eq!(network.send_torques([0; 3]), Err(CycleError::Link(bus::Down)));
    assert_eq!(network.housekeeping(now), Err(CycleError::Link(bus::Down)));
}

proptest! {
    /// Whatever is on the bus, a cycle ends with the true positions, with none, or with an error.
    #[test]
    fn noise_makes_errors_or_nothing(
        noise in proptest::collection::vec((0_u16..=0x7FF, proptest::collection::vec(any::<u8>(), 0..=8)), 0..60),
    ) {
        let mut network = started();
        let now = network.link().clock.now();
        for (id, data) in noise {
            let frame = Frame::new(embedded_can::StandardId::new(id).unwrap(), &data).unwrap();
            // Frames that are valid feedback of our drives cannot be told from the drives' own.
            if (0x181..=0x183).contains(&id) && data.len() == DriveFeedback::LENGTH {
                continue;
            }
            network.link_mut().inject(now, frame);
        }
        for drive in &mut network.link_mut().drives {
            drive.position = 42;
        }
        if let Ok(feedback) = cycle(&mut network, [0; 3]) {
            prop_assert!(feedback.positions.iter().all(|position| position.is_none_or(|position| position == 42)));
        }
    }
}
