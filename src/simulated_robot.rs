//! The simulated robot: a plant behind emulated drives, in this process or on a CAN interface.

use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use nalgebra::Vector3;
use uarm_io::drive::odrive::Positions;
use uarm_io::frame::Frame;
use uarm_io::time::Instant;
use uarm_sim::drive::{DriveDescription, DriveParameters, EncoderDescription};
use uarm_sim::odrive::{AxisDescription, AxisParameters, EmulatedOdrives};
use uarm_sim::{
    Brake, DemPlant, DriveDictionary, EmulatedDrive, EmulatedRobot, FreeFloatingPlant, InitialState, IntegrationStep,
    Outbox, Pacing, Plant, RobotOnBus, UarmPlant, UarmPlantParameters,
};

use uarm_loop::robot::{Bus, Joint, Protocol};

use crate::bought::{Bought, BoughtDrive};
use crate::dimensions::JOINTS;
use crate::eds::{maker_dictionary, with_good_readings};
use crate::robot::Robot;

/// Which plant a simulated robot is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlantChoice {
    /// The UARM with its documented imperfections.
    #[default]
    Uarm,
    /// The dynamically equivalent manipulator as the controllers believe it to be.
    Ideal,
    /// The free-floating space manipulator itself, simulated without the DEM.
    Space,
}

uarm_loop::choice! {
    PlantChoice:
    Uarm = "uarm", "The UARM with its documented imperfections";
    Ideal = "ideal", "The dynamically equivalent manipulator as the controllers believe it to be";
    Space = "space", "The free-floating space manipulator itself, simulated without the DEM";
}

impl PlantChoice {
    /// What reports and logs call the plant.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Uarm => "imperfect UARM",
            Self::Ideal => "ideal DEM",
            Self::Space => "free-floating space manipulator",
        }
    }
}

/// Any of the simulated plants.
#[derive(Clone, Debug)]
pub enum SimulatedPlant {
    /// With the documented imperfections.
    Uarm(UarmPlant),
    /// As the controllers believe it to be.
    Ideal(DemPlant),
    /// The space manipulator itself.
    Space(FreeFloatingPlant),
}

impl SimulatedPlant {
    /// The plant that `choice` names, at the start of the robot file's task and at rest.
    ///
    /// # Errors
    /// If the imperfections make no plant of the model.
    pub fn new(robot: &Robot, choice: PlantChoice, disturbance: Disturbance) -> anyhow::Result<Self> {
        let plant = match choice {
            PlantChoice::Uarm => return Self::uarm(robot, robot.plant, disturbance),
            PlantChoice::Ideal => Self::Ideal(DemPlant::new(robot.model).with_disturbance(disturbance)),
            PlantChoice::Space => {
                let name = &robot.description.name;
                let manipulator = robot.space_manipulator.as_ref().with_context(|| {
                    format!("{name}: the robot file has no [space_manipulator], which the plant \"space\" is made of")
                })?;
                Self::Space(FreeFloatingPlant::new(manipulator).with_disturbance(disturbance))
            }
        };
        Ok(plant.starting_at(start(robot)))
    }

    /// The robot with other imperfections than its file's, at the start of the file's task and at rest.
    ///
    /// # Errors
    /// If the imperfections make no plant of the model.
    pub fn uarm(robot: &Robot, imperfections: UarmPlantParameters, disturbance: Disturbance) -> anyhow::Result<Self> {
        let plant = UarmPlant::new(&robot.model, imperfections).context("plant")?;
        Ok(Self::Uarm(plant.with_disturbance(disturbance)).starting_at(start(robot)))
    }

    /// The same plant, starting at rest with its joints at `position`, rad.
    #[must_use]
    pub fn starting_at(self, position: Vector3<f64>) -> Self {
        let initial = InitialState { position, velocity: Vector3::zeros() };
        match self {
            Self::Uarm(plant) => Self::Uarm(plant.with_initial_state(initial)),
            Self::Ideal(plant) => Self::Ideal(plant.with_initial_state(initial)),
            Self::Space(plant) => Self::Space(plant.with_initial_state(initial)),
        }
    }

    /// The same plant, integrated on another grid.
    #[must_use]
    pub fn with_integration_step(self, step: IntegrationStep) -> Self {
        match self {
            Self::Uarm(plant) => Self::Uarm(plant.with_integration_step(step)),
            Self::Ideal(plant) => Self::Ideal(plant.with_integration_step(step)),
            Self::Space(plant) => Self::Space(plant.with_integration_step(step)),
        }
    }
}

/// Where the robot file's task starts: joints 1 to 3, rad, the base at zero.
pub fn start(robot: &Robot) -> Vector3<f64> {
    let start = robot.description.task.reference.start();
    Vector3::new(0.0, start.x, start.y)
}

impl Plant for SimulatedPlant {
    fn time(&self) -> Duration {
        match self {
            Self::Uarm(plant) => plant.time(),
            Self::Ideal(plant) => plant.time(),
            Self::Space(plant) => plant.time(),
        }
    }

    fn position(&self) -> Vector3<f64> {
        match self {
            Self::Uarm(plant) => plant.position(),
            Self::Ideal(plant) => plant.position(),
            Self::Space(plant) => plant.position(),
        }
    }

    fn velocity(&self) -> Vector3<f64> {
        match self {
            Self::Uarm(plant) => plant.velocity(),
            Self::Ideal(plant) => plant.velocity(),
            Self::Space(plant) => plant.velocity(),
        }
    }

    fn advance(&mut self, until: Duration, torque: &Vector3<f64>, brakes: [Brake; 3]) {
        match self {
            Self::Uarm(plant) => plant.advance(until, torque, brakes),
            Self::Ideal(plant) => plant.advance(until, torque, brakes),
            Self::Space(plant) => plant.advance(until, torque, brakes),
        }
    }
}

/// A simulated robot with the drives that its file names.
#[derive(Debug)]
pub enum SimulatedRobot<P> {
    /// CiA 402 drives on CANopen.
    Canopen(Box<EmulatedRobot<P>>),
    /// CiA 402 drives on CANopen, some with their makers' dictionaries or with a past.
    Bought(Box<EmulatedRobot<P, MAKERS_OBJECTS>>),
    /// ODrive axes.
    Odrive(Box<EmulatedOdrives<P>>),
}

/// Puts emulated drives, as the robot file describes them and of the protocol that it names, on a plant.
///
/// # Errors
/// If the robot file describes drives that cannot be emulated.
pub fn simulated<P: Plant + Clone>(robot: &Robot, plant: P, pacing: Pacing) -> anyhow::Result<SimulatedRobot<P>> {
    Ok(match robot.description.bus.protocol {
        Protocol::Canopen => SimulatedRobot::Canopen(Box::new(emulate(robot, plant, pacing)?)),
        Protocol::Odrive(positions) => {
            let [first, second, third] = &robot.description.joints;
            let axis = |index, joint| axis(&robot.description.bus, positions, index, joint);
            let axes = [axis(0, first)?, axis(1, second)?, axis(2, third)?];
            SimulatedRobot::Odrive(Box::new(EmulatedOdrives::new(plant, axes, pacing)?))
        }
    })
}

impl<P: Plant + Clone> RobotOnBus for SimulatedRobot<P> {
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
const CLOCK_ERRORS_PPM: [i32; 3] = [20, -35, 50];
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
        encoder_phase: FIRST_POSITIONS[index],
        watchdog: bus.controller_timeout,
        clock_error_ppm: CLOCK_ERRORS_PPM[index],
    })
    .with_context(|| joint.name.clone())
    .map(|axis| axis.behind(scale.transmission))
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
pub fn simulated_with<P: Plant + Clone>(
    robot: &Robot,
    plant: P,
    pacing: Pacing,
    bought: &Bought,
) -> anyhow::Result<SimulatedRobot<P>> {
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
pub fn emulate<P: Plant + Clone>(robot: &Robot, plant: P, pacing: Pacing) -> anyhow::Result<EmulatedRobot<P>> {
    let joints = &robot.description.joints;
    let ([first, second, third], own) = (joints, BoughtDrive::default());
    let drives = [emulated_drive(first, &own)?, emulated_drive(second, &own)?, emulated_drive(third, &own)?];
    let emulated = EmulatedRobot::with_drives(plant, drives, pacing)?;
    Ok(emulated.with_torque_delays(joints.each_ref().map(|joint| joint.torque_delay))?)
}

/// Objects that an emulated drive with a maker's dictionary can hold: three times as many as the largest known has.
pub const MAKERS_OBJECTS: usize = 2048;

/// Puts emulated drives with makers' dictionaries on a plant; what the dictionaries do not say is as the robot file describes it.
///
/// # Errors
/// If the robot file or a dictionary describes a drive that cannot be emulated.
#[inline(never)] // its frame holds thousands of objects: a thread that needs none of them has no room for it
fn emulate_bought<P: Plant + Clone>(
    robot: &Robot,
    plant: P,
    pacing: Pacing,
    bought: &[BoughtDrive<'_>; JOINTS],
) -> anyhow::Result<Box<EmulatedRobot<P, MAKERS_OBJECTS>>> {
    let joints = &robot.description.joints;
    let ([first, second, third], [a, b, c]) = (joints, bought);
    let drives = [emulated_drive(first, a)?, emulated_drive(second, b)?, emulated_drive(third, c)?];
    let emulated = EmulatedRobot::with_drives(plant, drives, pacing)?;
    Ok(Box::new(emulated.with_torque_delays(joints.each_ref().map(|joint| joint.torque_delay))?))
}

fn emulated_drive<const N: usize>(joint: &Joint, bought: &BoughtDrive<'_>) -> anyhow::Result<EmulatedDrive<N>> {
    let parameters = drive(joint)?.with_power_up(bought.power_up);
    let objects = match bought.dictionary {
        Some(dictionary) => maker_dictionary(dictionary, &parameters),
        None => DriveDictionary::own(&parameters),
    };
    let dictionary = bought.dictionary.map(|dictionary| (dictionary, joint.node.raw()));
    let objects = with_good_readings(objects, dictionary, &joint.drive.readings);
    EmulatedDrive::with_dictionary(parameters, objects).with_context(|| joint.name.clone())
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
