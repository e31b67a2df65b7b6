//! Who the axes are, and what is watched of them.

use super::*;
use crate::drive::DriveIdentity;
use crate::drive::readings::{Quantity, ReadingLimits};
use std::string::ToString;

/// Axis 2 is watched: 20 to 28 V, up to 80 degrees, and told above 26 V and 70 degrees.
fn watched() -> OdriveConfiguration<3> {
    let mut made = configuration(Positions::OnRequest);
    let supply = ReadingLimits::new([22.0, 26.0], [20.0, 28.0]);
    let temperature = ReadingLimits::new([f64::NEG_INFINITY, 70.0], [f64::NEG_INFINITY, 80.0]);
    made.axes[1].readings = [supply, temperature];
    made
}

fn asked(network: &OdriveNetwork<Bus, 3>, message: Message) -> Vec<u8> {
    let of = |frame: &Frame| Message::of(frame.id()).filter(|(found, _)| *found == message && frame.data().is_empty());
    network.link().sent.iter().filter_map(of).map(|(_, node)| node.raw()).collect()
}

#[test]
fn each_axis_tells_its_hardware_and_firmware() {
    let (mut network, clock) = network(|axes| axes[2].version = None);
    network.start(&clock).unwrap();
    assert_eq!(asked(&network, Message::Version), [1, 2, 3]);
    // 4, 4, 58 and 0, 6, 10, 0, a byte each.
    let told = DriveIdentity { product: Some(0x0004_043A), revision: Some(0x0006_0A00), ..DriveIdentity::default() };
    assert_eq!(network.identities(), [told, told, DriveIdentity::default()]);
    assert_eq!(told.to_string(), "product 0004043Ah, revision 00060A00h");
}

#[test]
fn another_hardware_than_is_pinned_fails_the_start_before_anything_is_commanded() {
    let start = |product, version: Option<Version>| {
        let mut made = configuration(Positions::OnRequest);
        made.axes[1].product = Some(product);
        let (mut network, clock) = network_of(made, |axes| axes[1].version = version);
        let outcome = network.start(&clock).map(drop).map_err(|error| error.to_string());
        let commands = network.link().sent.iter().filter_map(|frame| Message::of(frame.id()));
        let has_commanded = commands.into_iter().any(|(message, _)| message == Message::SetAxisState);
        (outcome, has_commanded)
    };
    assert_eq!(start(0x0004_043A, Some(VERSION)), (Ok(()), true));
    let (other, has_commanded) = start(0x0004_0434, Some(VERSION));
    let other = other.unwrap_err();
    assert!(other.contains("axis 2 says that it is product 0004043Ah (hardware 4.4.58, firmware 0.6.10)"), "{other}");
    assert!(other.contains("product 00040434h") && !has_commanded, "{other}");
    let (silent, _) = start(0x0004_043A, None);
    assert!(silent.unwrap_err().contains("nothing (Get_Version has no answer)"));
}

#[test]
fn what_is_watched_is_asked_for_at_the_start_and_in_the_cycle() {
    let (mut network, mut clock) = network_of(watched(), |_| {});
    network.start(&clock).unwrap();
    assert_eq!(asked(&network, Message::BusVoltageCurrent), [2]);
    assert_eq!(asked(&network, Message::Temperature), [2]);
    // The hotter one of inverter and motor.
    assert_eq!(network.health().nodes[1].readings, [Some(24.0), Some(40.0)]);
    assert_eq!(network.health().nodes[0].readings, [None; 2]);
    network.link_mut().axes[1].supply = Some(26.5);
    network.link_mut().axes[1].temperatures = Some([50.0, 60.0]);
    // 0.6 s: each in turn every 50 ms.
    for _ in 0..200 {
        cycle(&mut network, &mut clock, [0; 3]).unwrap();
    }
    assert_eq!(network.health().nodes[1].readings, [Some(26.5), Some(60.0)]);
    let (supply, temperature) = (asked(&network, Message::BusVoltageCurrent), asked(&network, Message::Temperature));
    assert!((5..=8).contains(&supply.len()) && (5..=8).contains(&temperature.len()), "{supply:?} {temperature:?}");
    assert!(network.health().nodes[1].reading_warnings >= 4, "{:?}", network.health().nodes[1]);
    let (unwatched, _) = started();
    assert!(asked(&unwatched, Message::BusVoltageCurrent).is_empty());
}

#[test]
fn a_value_beyond_its_limits_ends_start_and_run() {
    let low: fn(&mut Axis) = |axis| axis.supply = Some(19.5);
    let hot: fn(&mut Axis) = |axis| axis.temperatures = Some([81.0, f32::NAN]);
    let no_number: fn(&mut Axis) = |axis| axis.supply = Some(f32::NAN);
    for (change, words) in [
        (low, "axis 2: supply voltage 19.5 V, expected 20 to 28 V"),
        (hot, "axis 2: temperature 81.0 deg C, expected at most 80 deg C"),
        (no_number, "axis 2: supply voltage NaN V"),
    ] {
        let (mut network, clock) = network_of(watched(), |axes| change(&mut axes[1]));
        let error = network.start(&clock).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        let (mut network, mut clock) = network_of(watched(), |_| {});
        network.start(&clock).unwrap();
        change(&mut network.link_mut().axes[1]);
        let error = until_error(&mut network, &mut clock).to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn an_axis_that_does_not_tell_what_is_watched_ends_start_and_run() {
    let (mut mute, clock) = network_of(watched(), |axes| axes[1].temperatures = None);
    let error = mute.start(&clock).unwrap_err();
    let expected = Quantity::Temperature;
    assert!(
        matches!(error, OdriveStartError::NoReading { axis, quantity, .. } if axis.raw() == 2 && quantity == expected)
    );
    let (mut network, mut clock) = network_of(watched(), |_| {});
    network.start(&clock).unwrap();
    network.link_mut().axes[1].supply = None;
    let error = until_error(&mut network, &mut clock);
    let expected = Quantity::SupplyVoltage;
    assert!(matches!(error, OdriveCycleError::NoReading { axis, quantity } if axis.raw() == 2 && quantity == expected));
}
