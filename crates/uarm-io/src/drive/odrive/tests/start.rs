//! How axes are started.

use super::*;

#[test]
fn the_start_ends_armed_with_torque_zero_after_every_watchdog_has_proved_itself() {
    let (mut network, clock) = network(|axes| axes[1].error = 0x2000);
    let positions = network.start(&clock).unwrap();
    assert_eq!(positions, [8_192, 16_384, 24_576], "1, 2 and 3 turns of 8192 counts");
    for axis in &network.link().axes {
        assert_eq!(
            (axis.state, axis.error, axis.mode),
            (AxisState::CLOSED_LOOP_CONTROL, 0, Some(ControllerMode::TORQUE))
        );
        assert!(axis.torques.iter().all(|torque| *torque == 0.0));
    }
    let health = network.health();
    assert!(health.nodes.iter().all(|node| node.last_emergency.is_none()), "what was provoked is no emergency");
    assert_eq!(health.nodes.map(|node| node.emergencies), [0, 1, 0], "the error of before the start is one");
    let proved = network.stop(&clock).drives.map(|drive| drive.last_defence);
    assert_eq!(proved, [LastDefence::RpdoTimeout; 3], "each watchdog was seen to act");
}

#[test]
fn an_axis_that_is_not_heard_fails_the_start() {
    let (mut network, clock) = network(|axes| axes[2].mute_since = Some(Instant::default()));
    let axis = AxisNode::new(3).unwrap();
    assert_eq!(network.start(&clock), Err(OdriveStartError::NotHeard { axis, waited: Duration::from_secs(3) }));
}

#[test]
fn an_axis_without_a_watchdog_fails_the_start() {
    let (mut network, clock) = network(|axes| axes[1].has_watchdog = false);
    let error = network.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::NoWatchdog { axis, .. } if axis.raw() == 2), "{error}");
    assert!(network.stop(&clock).all_off());
}

#[test]
fn an_axis_that_does_not_arm_or_keeps_its_error_fails_the_start() {
    let (mut arms_not, clock) = network(|axes| axes[1].never_arms = true);
    let error = arms_not.start(&clock).unwrap_err();
    assert!(
        matches!(error, OdriveStartError::NotReached { axis, found, .. } if axis.raw() == 2 && found.state == AxisState::IDLE),
        "{error}"
    );
    let (mut hot, clock) = network(|axes| (axes[0].error, axes[0].lasting_error) = (0x2000, 0x2000));
    let error = hot.start(&clock).unwrap_err();
    let text = std::string::ToString::to_string(&error);
    assert!(text.contains("axis 1 is in IDLE with axis error 00002000h MOTOR_OVER_TEMP"), "{text}");
}

#[test]
fn an_axis_without_answers_or_with_positions_of_its_own_fails_the_start() {
    let (mut mute, clock) = network(|axes| axes[2].answers = false);
    let error = mute.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::NoPosition { axis, .. } if axis.raw() == 3), "{error}");
    let (mut talks, clock) = network(|axes| axes[0].sends_every = Some(Duration::from_millis(10)));
    let error = talks.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::Unrequested { axis } if axis.raw() == 1), "{error}");
    let (mut far, clock) = network(|axes| axes[1].turns = 3_000.0);
    let error = far.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::Position { axis, .. } if axis.raw() == 2), "{error}");
}
