//! Cycles, and what ends them.

use super::*;

#[test]
fn a_cycle_takes_counts_and_gives_newton_metres() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[1].turns = -0.5;
    assert_eq!(cycle(&mut network, &mut clock, [0, 353, -1_000]).unwrap(), [Some(8_192), Some(-4_096), Some(24_576)]);
    let last = network.link().axes.clone().map(|axis| *axis.torques.last().unwrap());
    // 353 per mille of 0.2 N·m.
    assert_eq!(last, [0.0, 0.0706, -0.2]);
    let health = network.health();
    assert_eq!(health.nodes[1].statusword, Statusword::of(PowerState::OperationEnabled));
    assert_eq!((health.nodes[1].node, health.syncs, health.nodes[1].nmt_state), (2, 1, Some(NmtState::Operational)));
}

#[test]
fn a_position_that_does_not_come_is_missing_and_a_late_one_is_not_taken_for_the_next() {
    let (mut network, mut clock) = started();
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    network.link_mut().axes[2].delay = PERIOD + Duration::from_micros(500);
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], None);
    assert_eq!(network.health().nodes[2].missed_feedbacks, 1);
    network.link_mut().axes[2].delay = Duration::from_millis(1);
    network.link_mut().axes[2].turns = 7.0;
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], Some(7 * 8_192));
    assert_eq!(network.health().nodes[2].stale_feedbacks, 1);
}

/// After an answer that was lost for good, the next one is not taken for a late one.
#[test]
fn one_answer_that_is_lost_costs_one_cycle() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[2].delay = Duration::from_secs(1_000);
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], None);
    network.link_mut().axes[2].delay = Duration::from_millis(1);
    for _ in 0..3 {
        assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], Some(24_576));
    }
    assert_eq!(network.health().nodes[2].stale_feedbacks, 0);
}

#[test]
fn an_axis_that_disarms_ends_the_run_within_a_heartbeat() {
    let (mut network, mut clock) = started();
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    let before = clock.now();
    network.link_mut().axes[1].fail(0x2000);
    let error = until_error(&mut network, &mut clock);
    assert!(
        matches!(error, OdriveCycleError::NotArmed { axis, found } if axis.raw() == 2 && found.error == AxisError::MOTOR_OVER_TEMP),
        "{error}"
    );
    assert!(clock.now().since(before) <= HEARTBEAT + PERIOD);
    assert_eq!(network.health().nodes[1].statusword, Statusword::of(PowerState::Fault));
    let told = network.health().nodes[1].last_emergency.unwrap();
    assert_eq!((told.error_code, told.vendor_specific), (0xFF00, [0x00, 0x20, 0x00, 0x00, 1]));
    assert!(network.stop(&clock).all_off());
}

#[test]
fn a_lost_heartbeat_ends_the_run() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[0].mute_since = Some(clock.now());
    // Its positions still come, since they are asked for.
    let error = until_error(&mut network, &mut clock);
    let limit = Duration::from_millis(200);
    assert!(
        matches!(error, OdriveCycleError::Lost { axis, silence, limit: told } if axis.raw() == 1 && silence > limit && told == limit),
        "{error}"
    );
}

#[test]
fn frames_of_the_wrong_length_are_counted_and_not_read() {
    let (mut network, mut clock) = started();
    let at = clock.now();
    let id = Message::Heartbeat.identifier(AxisNode::new(2).unwrap());
    let estimates = Message::EncoderEstimates.identifier(AxisNode::new(2).unwrap());
    for frame in [Frame::with(id, [0, 0, 0, 0, 1, 0, 0]), Frame::with(estimates, [0; 7])] {
        network.link_mut().wire.insert(0, Received { frame, at });
    }
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    assert_eq!(network.health().nodes[1].malformed, 2);
}

#[test]
fn a_position_of_before_the_request_is_not_taken_for_the_answer() {
    let (mut network, mut clock) = started();
    let early = EncoderEstimates { position: 99.0, velocity: 0.0 }.frame(AxisNode::new(1).unwrap());
    let at = clock.now();
    network.link_mut().wire.insert(0, Received { frame: early, at });
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[0], Some(8_192));
}

#[test]
fn no_torque_is_asked_for_in_a_cycle_in_which_an_axis_is_seen_disarmed() {
    let (mut network, clock) = started();
    let error = AxisError::MOTOR_OVER_TEMP;
    let heartbeat = Heartbeat { error, state: AxisState::IDLE, ..Heartbeat::default() };
    let frame = heartbeat.frame(AxisNode::new(3).unwrap());
    let at = network.sync(clock.now()).unwrap();
    network.link_mut().wire.insert(0, Received { frame, at });
    let seen = network.collect(at + PERIOD).unwrap_err();
    assert!(
        matches!(seen, OdriveCycleError::NotArmed { axis, found } if axis.raw() == 3 && found.error == error),
        "{seen}"
    );
}

#[test]
fn a_position_that_is_no_number_ends_the_run() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[1].turns = f32::NAN;
    let error = cycle(&mut network, &mut clock, [0; 3]).unwrap_err();
    assert!(matches!(error, OdriveCycleError::Position { axis, .. } if axis.raw() == 2), "{error}");
}

#[test]
fn cyclic_positions_are_used_as_old_as_they_are_and_not_when_two_periods_old() {
    let every = Duration::from_millis(5);
    let (mut network, mut clock) = network_with(Positions::Cyclic { every }, |axes| {
        axes.iter_mut().for_each(|axis| axis.sends_every = Some(every))
    });
    network.start(&clock).unwrap();
    for _ in 0..50 {
        cycle(&mut network, &mut clock, [0; 3]).unwrap();
    }
    let asked = |frame: &&Frame| matches!(Message::of(frame.id()), Some((Message::EncoderEstimates, _)));
    assert_eq!(network.link().sent.iter().filter(asked).count(), 0, "nobody asks");
    let oldest = network.health().nodes[0].longest_latency;
    assert!(oldest > Duration::from_millis(3) && oldest <= every, "{oldest:?}");
    network.link_mut().axes[2].sends_every = None;
    let missing_from = (0..).find(|_| cycle(&mut network, &mut clock, [0; 3]).unwrap()[2].is_none()).unwrap();
    assert!(missing_from <= 4, "twice 5 ms are borne, not {missing_from} cycles of 3 ms");
}
