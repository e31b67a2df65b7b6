//! A master starts three emulated drives on a simulated robot, runs them for a second of virtual time and stops them.

use std::time::Duration;
use uarm_io::drive::DriveNetwork;
use uarm_io::drive::network::{DriveConfiguration, NetworkConfiguration};
use uarm_io::encoder::Direction;
use uarm_io::time::Clock;
use uarm_io::torque::RatedTorque;
use uarm_sim::dem_model::ThreeLinkDem;
use uarm_sim::{
    DemPlant, DriveDescription, DriveParameters, EmulatedRobot, EncoderDescription, InProcessLink, Pacing, Plant,
    VirtualClock,
};

const COUNTS_PER_REVOLUTION: u32 = 33_739;
/// mN·m.
const RATED_TORQUE: u32 = 200;
const PERIOD: Duration = Duration::from_millis(3);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let drive = |node| {
        DriveParameters::new(DriveDescription {
            node,
            rated_torque: RATED_TORQUE,
            rated_current: 1_500,
            maximum_torque: 1_000,
            direction: Direction::Positive,
            encoder: EncoderDescription {
                counts_per_revolution: COUNTS_PER_REVOLUTION,
                counter_bits: 32,
                zero_offset: 0,
            },
        })
    };
    let drives = [drive(1)?, drive(2)?, drive(3)?];
    let plant = DemPlant::new(ThreeLinkDem::table_2());
    let robot = EmulatedRobot::new(plant, drives, Pacing::Lockstep { period: PERIOD })?;

    let rated_torque = RatedTorque::from_millinewton_metres(RATED_TORQUE)?;
    let configuration = NetworkConfiguration::new(
        drives.map(|drive| DriveConfiguration::new(drive.node(), COUNTS_PER_REVOLUTION, rated_torque)),
        PERIOD,
    )?;
    let mut clock = VirtualClock::new();
    let mut network = DriveNetwork::new(InProcessLink::new(robot, clock.clone()), configuration);

    network.start(&clock)?;
    let start = clock.now();
    for cycle in 0..334 {
        let tick = start + PERIOD * cycle;
        clock.sleep_until(tick);
        network.sync()?;
        let feedback = network.collect(tick + PERIOD / 3)?;
        // 20 per mille of 200 mN·m on joint 2.
        network.send_torques([0, 20, 0])?;
        network.housekeeping(clock.now())?;
        if cycle % 111 == 0 {
            println!("{:.3} s: {:?} counts", clock.now().since(start).as_secs_f64(), feedback.positions);
        }
    }
    let end = network.link().robot().plant().position();
    assert!(network.stop(&clock).all_off(), "every drive confirms that its brake is closed");
    println!("joint angles at the end: {:.4} {:.4} {:.4} rad", end.x, end.y, end.z);
    Ok(())
}
