//! Others on the bus.

use super::*;

/// A torque for axis 2 that this master did not send.
fn foreign_torque(at: Instant) -> Received {
    Received { frame: wire::torque_frame(AxisNode::new(2).unwrap(), 1.0), at }
}

#[test]
fn nothing_is_sent_on_a_bus_that_another_master_commands() {
    let (mut network, clock) = network(|_| {});
    network.link_mut().wire.push(foreign_torque(Instant::default() + Duration::from_millis(150)));
    let error = network.start(&clock).unwrap_err();
    let text = std::string::ToString::to_string(&error);
    // 2 × 32 + 14.
    assert!(
        text.starts_with("Set_Input_Torque to ODrive axis 2 (identifier 04Eh) is not from this controller"),
        "{text}"
    );
    let report = network.stop(&clock);
    assert!(report.drives.iter().all(|drive| drive.power_off == Confirmation::Withheld));
    assert_eq!(network.link().sent, [], "not even a stop");
}

#[test]
fn another_master_ends_a_start_and_a_run() {
    let (mut network, clock) = network(|_| {});
    // Behind 200 ms of listening, while the watchdogs are tried.
    network.link_mut().wire.push(foreign_torque(Instant::default() + Duration::from_millis(260)));
    let error = network.start(&clock).unwrap_err();
    assert!(
        matches!(error, OdriveStartError::AnotherMaster(foreign) if foreign.message == Message::SetInputTorque),
        "{error}"
    );
    let (mut network, mut clock) = started();
    assert!(cycle(&mut network, &mut clock, [0; 3]).is_ok());
    let request = Received { frame: wire::estimates_request(AxisNode::new(3).unwrap()), at: clock.now() };
    network.link_mut().wire.push(request);
    let error = cycle(&mut network, &mut clock, [0; 3]).unwrap_err();
    assert!(matches!(error, Error::AnotherMaster(foreign) if foreign.axis.raw() == 3), "{error}");
    assert!(network.stop(&clock).all_off(), "its own axes are stopped");
}

#[test]
fn two_axes_with_one_node_id_are_told_apart_from_one() {
    let (mut network, clock) = network(|axes| axes[1].has_twin = true);
    let error = network.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::TwoAxes { axis } if axis.raw() == 2), "{error}");
    assert!(std::string::ToString::to_string(&error).contains("two axes with node id 2?"), "{error}");
    let (mut network, mut clock) = started();
    network.link_mut().axes[2].has_twin = true;
    let error = until_error(&mut network, &mut clock);
    assert!(matches!(error, Error::TwoAxes { axis } if axis.raw() == 3), "{error}");
}
