mod boot;
mod bus;
mod cycle;
mod disturbance;
mod objects;
mod start;
mod watchdogs;

use super::*;
use crate::drive::wire;
use crate::time::Duration;
use crate::torque::RatedTorque;
use bus::FakeBus;
use canopen_rs::{Address, NodeId, Value};

const PERIOD: Duration = Duration::from_millis(3);

fn drive(node: u8) -> DriveConfiguration {
    let rated_torque = RatedTorque::from_millinewton_metres(200).unwrap();
    DriveConfiguration::new(NodeId::new(node).unwrap(), 8000, rated_torque)
}

fn configuration() -> NetworkConfiguration<3> {
    NetworkConfiguration::new([drive(1), drive(2), drive(3)], PERIOD).unwrap()
}

/// A network of three well-behaved drives.
fn network() -> DriveNetwork<FakeBus, 3> {
    DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration())
}

fn start(network: &mut DriveNetwork<FakeBus, 3>) -> Result<Started<3>, StartError<bus::Down>> {
    let clock = network.link().clock.clone();
    network.start(&clock)
}

fn stop(network: &mut DriveNetwork<FakeBus, 3>) -> StopReport<3> {
    let clock = network.link().clock.clone();
    network.stop(&clock)
}

fn value(network: &DriveNetwork<FakeBus, 3>, joint: usize, object: &crate::drive::objects::Object) -> Value {
    network.link().drives[joint].dictionary.read(object.address()).unwrap()
}

/// SDO downloads to the drive of `node`.
fn writes(network: &DriveNetwork<FakeBus, 3>, node: u16) -> std::vec::Vec<Address> {
    const DOWNLOAD: u8 = 0x20;
    let requests = network.link().sent.iter().filter(|frame| frame.id().as_raw() == 0x600 + node);
    requests
        .map(|frame| frame.data())
        .filter(|data| data[0] & 0xE0 == DOWNLOAD)
        .map(|data| Address::new(u16::from_le_bytes([data[1], data[2]]), data[3]))
        .collect()
}
