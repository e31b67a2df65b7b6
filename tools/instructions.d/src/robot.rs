//! The other end of the bus: plants, and emulated drives.

use crate::case;
use dem_model::{PlanarSpaceManipulator, ThreeLinkDem};
use hinf_control::Disturbance;
use nalgebra::Vector3;
use std::error::Error;
use std::hint::black_box;
use std::time::Duration;
use uarm_io::drive::cia402::{Command, Controlword};
use uarm_io::drive::wire::{self, DriveCommand};
use uarm_io::drive::{NmtCommand, NodeId};
use uarm_io::encoder::Direction;
use uarm_io::frame::Frame;
use uarm_io::time::Instant;
use uarm_sim::{
    Brake, DemPlant, DriveDescription, DriveParameters, EmulatedRobot, EncoderDescription, FreeFloatingPlant, Outbox,
    Pacing, Plant, UarmPlant, UarmPlantParameters,
};

const PERIOD: Duration = Duration::from_millis(3);
const NODES: [u8; 3] = [1, 2, 3];

pub fn run() -> Result<(), Box<dyn Error>> {
    let nominal = ThreeLinkDem::table_2();
    let uarm = UarmPlant::new(&nominal, UarmPlantParameters::fitted())?;
    period("f64 plant ideal 3 ms", DemPlant::new(nominal).with_disturbance(Disturbance::Paper));
    period("f64 plant uarm 3 ms", uarm.with_disturbance(Disturbance::Paper));
    let space = FreeFloatingPlant::new(&PlanarSpaceManipulator::table_1());
    period("f64 plant space 3 ms", space.with_disturbance(Disturbance::Paper));
    drives(DemPlant::new(nominal))
}

/// One period from where the disturbance starts.
fn period(name: &str, mut plant: impl Plant) {
    plant.advance(Disturbance::PAPER_ONSET, &Vector3::new(0.0, 0.01, 0.005), [Brake::Released; 3]);
    let until = plant.time() + PERIOD;
    case(name, || plant.advance(until, black_box(&Vector3::new(0.0, 0.02, -0.01)), [Brake::Released; 3]));
}

/// What a cycle of the loop sends to three drives, the plant's part left out: on the wall clock at one instant it stands.
fn drives(plant: DemPlant) -> Result<(), Box<dyn Error>> {
    let parameters = [description(NODES[0]), description(NODES[1]), description(NODES[2])];
    let [first, second, third] = parameters.map(DriveParameters::new);
    let mut robot = EmulatedRobot::new(plant, [first?, second?, third?], Pacing::WallClock)?;
    let mut outbox = Outbox::new();
    let now = Instant::default();
    robot.power_on(now, &mut outbox);
    for node in NODES {
        // The mode, and that SYNC counts.
        for request in [[0x2F, 0x60, 0x60, 0, 10, 0, 0, 0], [0x2F, 0x19, 0x10, 0, 240, 0, 0, 0]] {
            robot.on_frame(&wire::sdo_request_frame(node_id(node)?, &request), now, &mut outbox);
        }
    }
    robot.on_frame(&wire::nmt_frame(NmtCommand::StartRemoteNode, NodeId::BROADCAST), now, &mut outbox);
    for word in [Command::Shutdown, Command::SwitchOn, Command::EnableOperation] {
        for node in NODES {
            robot.on_frame(&command(node, word, 0)?, now, &mut outbox);
        }
    }
    robot.on_frame(&wire::sync_frame(1), now, &mut outbox);
    let sync = wire::sync_frame(2);
    case("f64 drives SYNC, three answers", || robot.on_frame(black_box(&sync), now, &mut outbox));
    let frames = [
        command(1, Command::EnableOperation, 0)?,
        command(2, Command::EnableOperation, 100)?,
        command(3, Command::EnableOperation, -50)?,
    ];
    case("f64 drives three torques", || {
        for frame in black_box(&frames) {
            robot.on_frame(frame, now, &mut outbox);
        }
    });
    if robot.torque() == Vector3::zeros() {
        return Err("the drives follow no torque".into());
    }
    Ok(())
}

fn description(node: u8) -> DriveDescription {
    DriveDescription {
        node,
        rated_torque: 200,
        rated_current: 1_500,
        maximum_torque: 1_000,
        direction: Direction::Positive,
        encoder: EncoderDescription { counts_per_revolution: 33_739, counter_bits: 32, zero_offset: 0 },
    }
}

fn command(node: u8, command: Command, target_torque: i16) -> Result<Frame, Box<dyn Error>> {
    Ok(DriveCommand { controlword: Controlword::of(command), target_torque }.frame(node_id(node)?))
}

fn node_id(node: u8) -> Result<NodeId, String> {
    NodeId::new(node).map_err(|_| format!("there is no node {node}"))
}
