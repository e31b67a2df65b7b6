//! The simulated robot: emulated drives on a plant, in this process or on a CAN interface.

use std::time::Duration;

use anyhow::Context;
use uarm_io::drive::odrive::Positions;
use uarm_io::drive::{Address, NodeId};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;
use uarm_loop::robot::{Bus, Joint, Protocol};
use uarm_sim::drive::{DriveDescription, DriveParameters, EncoderDescription, value_of};
use uarm_sim::odrive::{AxisDescription, AxisParameters, EmulatedOdrives};
use uarm_sim::{DriveDictionary, EmulatedDrive, EmulatedRobot, Outbox, Pacing, Plant, RobotOnBus};

use crate::bought::{Bought, BoughtDrive, Past, StoredObject};
use crate::eds::{good_readings, maker_dictionary, with_good_readings};
use crate::robot::Robot;
use crate::usage::UsageError;

/// A simulated robot with the drives that its file names.
#[derive(Debug)]
pub enum SimulatedRobot<P, const J: usize = 3> {
    /// CiA 402 drives on CANopen.
    Canopen(Box<EmulatedRobot<P, J>>),
    /// CiA 402 drives on CANopen, some with their makers' dictionaries or with a past.
    Bought(Box<EmulatedRobot<P, J, MAKERS_OBJECTS>>),
    /// ODrive axes.
    Odrive(Box<EmulatedOdrives<P, J>>),
}

/// Puts emulated drives, as the robot file describes them and of the protocol that it names, on a plant.
///
/// # Errors
/// If the robot file describes drives that cannot be emulated.
pub fn simulated<P: Plant<J> + Clone, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    plant: P,
    pacing: Pacing,
) -> anyhow::Result<SimulatedRobot<P, J>> {
    Ok(match robot.description.bus.protocol {
        Protocol::Canopen => SimulatedRobot::Canopen(Box::new(emulate(robot, plant, pacing)?)),
        Protocol::Odrive(positions) => {
            let axis = |(index, joint)| axis(&robot.description.bus, positions, index, joint);
            let axes = each(robot.description.joints.iter().enumerate().map(axis))?;
            SimulatedRobot::Odrive(Box::new(EmulatedOdrives::new(plant, axes, pacing)?))
        }
    })
}

/// An array of what is made of each joint.
fn each<T, const J: usize>(made: impl Iterator<Item = anyhow::Result<T>>) -> anyhow::Result<[T; J]> {
    let made: Vec<T> = made.collect::<anyhow::Result<_>>()?;
    made.try_into().map_err(|made: Vec<T>| anyhow::anyhow!("{} joints, expected {J}", made.len()))
}

impl<P: Plant<J> + Clone, const J: usize> RobotOnBus for SimulatedRobot<P, J> {
    fn power_on(&mut self, now: Instant, outbox: &mut Outbox) {
        match self {
            Self::Canopen(robot) => robot.power_on(now, outbox),
            Self::Bought(robot) => robot.power_on(now, outbox),
            Self::Odrive(robot) => robot.power_on(now, outbox),
        }
    }

    fn next_deadline(&self) -> Option<Instant> {
        match self {
            Self::Canopen(robot) => robot.next_deadline(),
            Self::Bought(robot) => robot.next_deadline(),
            Self::Odrive(robot) => robot.next_deadline(),
        }
    }

    fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        match self {
            Self::Canopen(robot) => robot.on_time(now, outbox),
            Self::Bought(robot) => robot.on_time(now, outbox),
            Self::Odrive(robot) => robot.on_time(now, outbox),
        }
    }

    fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        match self {
            Self::Canopen(robot) => robot.on_frame(frame, now, outbox),
            Self::Bought(robot) => robot.on_frame(frame, now, outbox),
            Self::Odrive(robot) => robot.on_frame(frame, now, outbox),
        }
    }
}

/// How far the clocks of the emulated ODrive axes are off, parts per million: what crystals are within. Chosen.
const CLOCK_ERRORS_PPM: [i32; 8] = [20, -35, 50, -10, 40, -45, 15, -25];
/// When each sends its first position by itself. Chosen, so that they are not together.
const FIRST_POSITIONS: [Duration; 3] =
    [Duration::from_micros(300), Duration::from_micros(1_100), Duration::from_micros(1_900)];

fn axis(bus: &Bus, positions: Positions, index: usize, joint: &Joint) -> anyhow::Result<AxisParameters> {
    let scale = &joint.torque_scale;
    AxisParameters::new(AxisDescription {
        node: joint.node.raw(),
        maximum_torque: f64::from(scale.ceiling.per_mille()) * scale.rated_torque.per_mille(),
        direction: joint.encoder.direction,
        encoder: encoder(joint)?,
        heartbeat: bus.drive_heartbeat,
        encoder_period: match positions {
            Positions::OnRequest => Duration::ZERO,
            Positions::Cyclic { every } => every,
        },
        encoder_phase: FIRST_POSITIONS[index % FIRST_POSITIONS.len()],
        watchdog: bus.controller_timeout,
        clock_error_ppm: CLOCK_ERRORS_PPM[index % CLOCK_ERRORS_PPM.len()],
    })
    .with_context(|| joint.name.clone())
    .map(|axis| {
        let axis = axis.behind(scale.transmission);
        let axis = joint.drive.identity.product.map_or(axis, |product| axis.with_product(product));
        let [supply, temperature] = good_readings(&joint.drive.readings);
        axis.with_readings(supply, temperature)
    })
}

fn encoder(joint: &Joint) -> anyhow::Result<EncoderDescription> {
    let motor = joint.encoder.counts_per_revolution.of_motor(joint.torque_scale.transmission.ratio());
    Ok(EncoderDescription {
        counts_per_revolution: motor.context("counts per revolution of the motor")?,
        counter_bits: joint.encoder.counter_width.get(),
        zero_offset: joint.encoder.zero,
    })
}

/// The same with drives of which something is known, `bought`, joint by joint.
///
/// # Errors
/// As [`simulated`], or if a dictionary describes a drive that cannot be emulated, or the robot file names another protocol.
pub fn simulated_with<P: Plant<J> + Clone, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    plant: P,
    pacing: Pacing,
    bought: &Bought<J>,
) -> anyhow::Result<SimulatedRobot<P, J>> {
    if bought.is_none() {
        return simulated(robot, plant, pacing);
    }
    anyhow::ensure!(
        matches!(robot.description.bus.protocol, Protocol::Canopen),
        "makers' dictionaries: only with bus.protocol = \"canopen\""
    );
    Ok(SimulatedRobot::Bought(emulate_bought(robot, plant, pacing, &bought.drives())?))
}

/// Puts emulated CiA 402 drives, as the robot file describes them, on a plant.
///
/// # Errors
/// If the robot file describes drives that cannot be emulated.
pub fn emulate<P: Plant<J> + Clone, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    plant: P,
    pacing: Pacing,
) -> anyhow::Result<EmulatedRobot<P, J>> {
    let joints = &robot.description.joints;
    let past = Past::default();
    let own = BoughtDrive { dictionary: None, past: &past };
    let emulated =
        EmulatedRobot::with_drives(plant, each(joints.iter().map(|joint| emulated_drive(joint, &own)))?, pacing)?;
    Ok(emulated.with_torque_delays(joints.each_ref().map(|joint| joint.torque_delay))?)
}

/// Objects that an emulated drive with a maker's dictionary can hold: three times as many as the largest known has.
pub const MAKERS_OBJECTS: usize = 2048;

/// Puts emulated drives with makers' dictionaries on a plant; what the dictionaries do not say is as the robot file describes it.
///
/// # Errors
/// If the robot file or a dictionary describes a drive that cannot be emulated.
#[inline(never)] // its frame holds thousands of objects: a thread that needs none of them has no room for it
fn emulate_bought<P: Plant<J> + Clone, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    plant: P,
    pacing: Pacing,
    bought: &[BoughtDrive<'_>; J],
) -> anyhow::Result<Box<EmulatedRobot<P, J, MAKERS_OBJECTS>>> {
    let joints = &robot.description.joints;
    let drives = each(joints.iter().zip(bought).map(|(joint, bought)| emulated_drive(joint, bought)))?;
    let emulated = EmulatedRobot::with_drives(plant, drives, pacing)?;
    Ok(Box::new(emulated.with_torque_delays(joints.each_ref().map(|joint| joint.torque_delay))?))
}

fn emulated_drive<const N: usize>(joint: &Joint, bought: &BoughtDrive<'_>) -> anyhow::Result<EmulatedDrive<N>> {
    let parameters = drive(joint)?.with_power_up(bought.past.power_up);
    let objects = match bought.dictionary {
        Some(dictionary) => maker_dictionary(dictionary, &parameters),
        None => DriveDictionary::own(&parameters),
    };
    let dictionary = bought.dictionary.map(|dictionary| (dictionary, joint.node.raw()));
    let objects = with_good_readings(objects, dictionary, &joint.drive.readings);
    let objects =
        bought.past.stored.iter().try_fold(objects, |objects, stored| storing(objects, stored, joint.node))?;
    EmulatedDrive::with_dictionary(parameters, objects).with_context(|| joint.name.clone())
}

/// The same objects, where one has been stored with another value.
fn storing(objects: DriveDictionary, stored: &StoredObject, node: NodeId) -> anyhow::Result<DriveDictionary> {
    let Address { index, subindex } = stored.address;
    let refused = |expected: String| {
        UsageError::new(format!("--start {}:{index:04X}.{subindex}={}: {expected}", node.raw(), stored.number))
    };
    let object = objects.object(stored.address).ok_or_else(|| refused("the drive has no such object".to_owned()))?;
    let data_type = object.data_type;
    let value = value_of(data_type, stored.number.into())
        .ok_or_else(|| refused(format!("expected a number of the object's type, {data_type:?}")))?;
    Ok(objects.storing(stored.address, value)?)
}

/// Shown by the emulated drives (6075h) and used nowhere: the paper prints no motor currents.
const RATED_CURRENT_MILLIAMPERES: u32 = 1000;

fn drive(joint: &Joint) -> anyhow::Result<DriveParameters> {
    DriveParameters::new(DriveDescription {
        node: joint.node.raw(),
        rated_torque: joint.torque_scale.rated_torque.object_value(),
        rated_current: RATED_CURRENT_MILLIAMPERES,
        maximum_torque: u16::try_from(joint.torque_scale.ceiling.per_mille())?,
        direction: joint.encoder.direction,
        encoder: encoder(joint)?,
    })
    .with_context(|| joint.name.clone())
    .map(|drive| {
        let unit = joint.torque_scale.rated_torque.unit();
        drive
            .with_rated_torque_unit(unit)
            .behind(joint.torque_scale.transmission)
            .with_limit_switches(joint.limits.position)
            .with_identity(joint.drive.identity)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_drive_has_stored_is_there_at_power_up() {
        let robot = Robot::<3, 2>::load(None).unwrap();
        let joint = &robot.description.joints[1];
        let own = DriveDictionary::own(&drive(joint).unwrap());
        let tpdo_2 = Address::new(0x1801, 1);
        let stored = |address, number| storing(own.clone(), &StoredObject { address, number }, joint.node);
        let objects = stored(tpdo_2, 0x282).unwrap();
        assert_eq!(objects.object(tpdo_2).unwrap().value, Some(uarm_io::drive::Value::Unsigned32(642)));
        let refused = |address, number| stored(address, number).unwrap_err().to_string();
        assert_eq!(refused(tpdo_2, -1), "--start 2:1801.1=-1: expected a number of the object's type, Unsigned32");
        assert_eq!(refused(Address::new(0x1899, 1), 5), "--start 2:1899.1=5: the drive has no such object");
    }
}
