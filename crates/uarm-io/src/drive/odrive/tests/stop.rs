//! How axes are stopped.

use super::*;

#[test]
fn the_stop_ends_idle_and_an_axis_that_does_not_obey_gets_the_emergency_stop() {
    let (mut network, clock) = started();
    assert!(network.stop(&clock).all_off());
    assert!(network.link().axes.iter().all(|axis| axis.state == AxisState::IDLE && axis.torques.last() == Some(&0.0)));

    let (mut network, clock) = started();
    network.link_mut().axes[1].ignores_idle = true;
    // Without its watchdog, so that only the emergency stop can have done it.
    network.link_mut().axes[1].has_watchdog = false;
    network.send_torques([0; 3]).unwrap();
    assert!(network.stop(&clock).all_off());
    assert_eq!(network.link().axes[1].error, AxisError::ESTOP_REQUESTED.0);
    assert_eq!(network.link().axes[0].error, 0, "the others did obey");
}

#[test]
fn a_silent_axis_is_not_confirmed() {
    let (mut network, clock) = started();
    network.link_mut().axes[2].mute_since = Some(clock.now());
    let report = network.stop(&clock);
    let confirmed = report.drives.map(|drive| drive.power_off);
    assert_eq!(confirmed, [Confirmation::Confirmed, Confirmation::Confirmed, Confirmation::Unconfirmed]);
    assert!(
        report.drives.iter().all(|drive| drive.last_defence == LastDefence::RpdoTimeout),
        "seen to act at the start"
    );
}

#[test]
fn a_watchdog_is_told_of_only_after_it_was_seen_to_act() {
    let (mut network, clock) = network(|axes| axes[1].has_watchdog = false);
    assert_eq!(network.stop(&clock).drives.map(|drive| drive.last_defence), [LastDefence::None; 3], "never started");
    assert!(network.start(&clock).is_err());
    let seen = network.stop(&clock).drives.map(|drive| drive.last_defence);
    assert_eq!(seen, [LastDefence::RpdoTimeout, LastDefence::None, LastDefence::RpdoTimeout]);
}
