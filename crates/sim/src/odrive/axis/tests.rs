//! One axis: its states, errors, watchdog and messages.

use super::super::parameters::tests::description;
use super::*;
use crate::odrive::AxisDescription;

fn at(milliseconds: u64) -> Instant {
    Instant::from_nanoseconds(milliseconds * 1_000_000)
}

fn axis(description: AxisDescription) -> EmulatedAxis {
    let mut axis = EmulatedAxis::new(AxisParameters::new(description).unwrap());
    axis.power_on(at(0));
    axis
}

fn tell(axis: &mut EmulatedAxis, frame: &uarm_io::frame::Frame, now: Instant) -> bool {
    let (message, node) = Message::of(frame.id()).unwrap();
    assert_eq!(node, axis.parameters().node());
    axis.on_message(message, frame.data(), now)
}

fn armed(description: AxisDescription) -> EmulatedAxis {
    let mut axis = axis(description);
    let node = axis.parameters().node();
    tell(&mut axis, &ControllerMode::TORQUE.frame(node), at(0));
    tell(&mut axis, &wire::state_frame(node, AxisState::CLOSED_LOOP_CONTROL), at(0));
    assert!(axis.is_armed());
    axis
}

#[test]
fn a_torque_acts_only_while_armed_in_torque_control_and_is_cut_at_the_limit() {
    let mut axis = axis(description(2));
    let node = axis.parameters().node();
    let torque = |newton_metres| wire::torque_frame(node, newton_metres);
    tell(&mut axis, &torque(0.125), at(0));
    assert_eq!((axis.torque(), axis.brake()), (0.0, Brake::Engaged), "idle");
    tell(&mut axis, &wire::state_frame(node, AxisState::CLOSED_LOOP_CONTROL), at(0));
    tell(&mut axis, &torque(0.125), at(0));
    assert_eq!((axis.torque(), axis.brake()), (0.0, Brake::Released), "no torque control yet");
    tell(&mut axis, &ControllerMode::TORQUE.frame(node), at(0));
    assert_eq!(axis.torque(), 0.125);
    tell(&mut axis, &torque(-5.0), at(0));
    assert_eq!(axis.torque(), -0.2, "cut");
    tell(&mut axis, &torque(f32::NAN), at(0));
    assert_eq!(axis.torque(), -0.2, "what is no number is not taken");
    tell(&mut axis, &wire::state_frame(node, AxisState::IDLE), at(0));
    assert_eq!((axis.torque(), axis.brake()), (0.0, Brake::Engaged));
    tell(&mut axis, &wire::state_frame(node, AxisState::CLOSED_LOOP_CONTROL), at(0));
    assert_eq!(axis.torque(), 0.0, "the torque of before is forgotten");
}

#[test]
fn the_watchdog_disarms_unless_a_torque_comes_in_time() {
    let (mut axis, mut outbox) = (armed(description(2)), Outbox::new());
    let node = axis.parameters().node();
    tell(&mut axis, &wire::torque_frame(node, 0.1), at(40));
    axis.on_time(at(89), &mut outbox);
    assert!(axis.is_armed());
    axis.on_time(at(90), &mut outbox);
    assert_eq!((axis.state(), axis.error()), (AxisState::IDLE, AxisError::WATCHDOG_TIMER_EXPIRED));
    assert_eq!((axis.torque(), axis.brake()), (0.0, Brake::Engaged));
    // With an error it does not arm; cleared, it does.
    tell(&mut axis, &wire::state_frame(node, AxisState::CLOSED_LOOP_CONTROL), at(91));
    assert!(!axis.is_armed());
    assert!(tell(&mut axis, &wire::clear_errors_frame(node), at(92)));
    tell(&mut axis, &wire::state_frame(node, AxisState::CLOSED_LOOP_CONTROL), at(93));
    assert!(axis.is_armed());
    let unwatched = AxisDescription { watchdog: Duration::ZERO, ..description(2) };
    let mut axis = armed(unwatched);
    axis.on_time(at(100_000), &mut outbox);
    assert!(axis.is_armed(), "without a watchdog nothing disarms it");
}

#[test]
fn an_error_or_an_emergency_stop_disarms_and_an_error_that_lasts_is_not_cleared() {
    let mut axis = armed(description(2));
    let node = axis.parameters().node();
    tell(&mut axis, &wire::estop_frame(node), at(1));
    assert_eq!((axis.state(), axis.error()), (AxisState::IDLE, AxisError::ESTOP_REQUESTED));
    let mut axis = armed(description(2));
    axis.inject(AxisFault::Error(AxisError::MOTOR_OVER_TEMP));
    assert!(!axis.is_armed());
    tell(&mut axis, &wire::clear_errors_frame(node), at(1));
    assert_eq!(axis.error(), AxisError::MOTOR_OVER_TEMP);
    axis.repair();
    tell(&mut axis, &wire::clear_errors_frame(node), at(1));
    assert!(axis.error().is_none());
}

#[test]
fn clearing_the_errors_of_an_armed_axis_is_no_new_experiment() {
    let mut axis = armed(description(2));
    let node = axis.parameters().node();
    assert!(!tell(&mut axis, &wire::clear_errors_frame(node), at(1)));
}

#[test]
fn heartbeats_and_positions_come_at_their_periods_on_the_axis_own_clock() {
    let mut axis = axis(AxisDescription {
        encoder_period: Duration::from_millis(10),
        encoder_phase: Duration::from_millis(3),
        clock_error_ppm: 1_000,
        ..description(5)
    });
    let mut outbox = Outbox::new();
    axis.measure(core::f64::consts::TAU / 4.0);
    while let Some(due) = axis.next_deadline().filter(|due| *due <= at(120)) {
        axis.on_time(due, &mut outbox);
    }
    let mut times = [std::vec::Vec::new(), std::vec::Vec::new()];
    while let Some(received) = outbox.pop() {
        match Message::of(received.frame.id()).unwrap().0 {
            Message::Heartbeat => times[0].push(received.at.nanoseconds() / 1_000),
            Message::EncoderEstimates => {
                assert_eq!(EncoderEstimates::decode(received.frame.data()).unwrap().position, 0.25);
                times[1].push(received.at.nanoseconds() / 1_000);
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(times[0], [0, 50_050, 100_100], "50 ms of a clock that is 1000 ppm slow");
    assert_eq!(times[1][..3], [3_003, 13_013, 23_023]);
}

#[test]
fn off_the_bus_it_hears_and_says_nothing_and_its_watchdog_disarms_it() {
    let (mut axis, mut outbox) = (armed(description(2)), Outbox::new());
    let node = axis.parameters().node();
    axis.inject(AxisFault::BusDisconnected);
    tell(&mut axis, &wire::torque_frame(node, 0.1), at(49));
    axis.on_time(at(60), &mut outbox);
    axis.answer(at(60), &mut outbox);
    assert!(outbox.is_empty());
    assert!(!axis.is_armed());
}
