mod bus;
mod cycle;
mod disturbance;
mod start;

use super::*;
use crate::drive::wire;
use crate::time::Duration;
use crate::torque::RatedTorque;
use bus::FakeBus;
use canopen_rs::NodeId;

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
