//! The simulated robot: a plant behind emulated drives, in this process or on a CAN interface.

use std::time::Duration;

use anyhow::Context;
use dem_model::{
    BaseFreedom, FreeFloatingManipulator, PlanarBaseManipulator, SerialManipulator, SphericalBaseManipulator,
};
use hinf_control::Disturbance;
use nalgebra::SVector;
use uarm_io::drive::odrive::Positions;
use uarm_io::drive::{Address, NodeId};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;
use uarm_sim::drive::{DriveDescription, DriveParameters, EncoderDescription, value_of};
use uarm_sim::odrive::{AxisDescription, AxisParameters, EmulatedOdrives};
use uarm_sim::plant::PosedBase;
use uarm_sim::{
    Brake, DemPlant, DriveDictionary, EmulatedDrive, EmulatedRobot, FreeFloatingPlant, InitialState, IntegrationStep,
    Outbox, Pacing, PlanarBasePlant, Plant, RobotOnBus, SerialBrakes, SerialImperfections, SerialMotion, SerialPlant,
    SerialSpacePlant, SphericalBasePlant, UarmPlant, UarmPlantParameters,
};

use uarm_loop::choice::Choice;
use uarm_loop::dimensions;
use uarm_loop::robot::{Bus, Joint, Protocol};

use crate::bought::{Bought, BoughtDrive, Past, StoredObject};
use crate::eds::{good_readings, maker_dictionary, with_good_readings};
use crate::robot::Robot;
use crate::robot::imperfections::Imperfections;
use crate::robot::model::Mechanics;
use crate::usage::UsageError;

/// Which plant a simulated robot is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlantChoice {
    /// The UARM with its documented imperfections.
    #[default]
    Uarm,
    /// Any other arm with the imperfections of its robot file.
    Imperfect,
    /// The dynamically equivalent manipulator as the controllers believe it to be.
    Ideal,
    /// The free-floating space manipulator itself, simulated without the DEM.
    Space,
}

uarm_loop::choice! {
    PlantChoice:
    Uarm = "uarm", "The UARM with its documented imperfections";
    Imperfect = "imperfect", "The robot with the imperfections of its file's [plant]; of the paper's arm that is \"uarm\"";
    Ideal = "ideal", "The dynamically equivalent manipulator as the controllers believe it to be";
    Space = "space", "The free-floating space manipulator itself, simulated without the DEM";
}

impl PlantChoice {
    /// What it comes to for `robot`: without imperfections in its file, the plant with imperfections is the ideal one.
    pub fn of<const J: usize, const N: usize>(self, robot: &Robot<J, N>) -> Self {
        match self {
            Self::Uarm | Self::Imperfect if robot.file.plant.is_none() => Self::Ideal,
            Self::Uarm | Self::Imperfect => match robot.mechanics {
                Mechanics::ThreeLinks { .. } => Self::Uarm,
                Mechanics::Planar { .. } | Mechanics::Spatial { .. } => Self::Imperfect,
            },
            Self::Ideal | Self::Space => self,
        }
    }

    /// The plant that `--plant` asks for, or what it is by default.
    ///
    /// # Errors
    /// If imperfections are asked for that the robot's file has not.
    pub fn asked<const J: usize, const N: usize>(asked: Option<Self>, robot: &Robot<J, N>) -> Result<Self, UsageError> {
        let choice = asked.unwrap_or_default().of(robot);
        let name = &robot.description.name;
        match (asked, choice) {
            (Some(asked @ (Self::Uarm | Self::Imperfect)), Self::Ideal) => Err(UsageError::new(format!(
                "--plant {}: expected ideal or space, since {name} has no [plant], no imperfections",
                asked.name()
            ))),
            (Some(Self::Uarm), Self::Imperfect) => Err(UsageError::new(format!(
                "--plant uarm: expected imperfect, ideal or space, since {name} is another arm than the UARM"
            ))),
            _ => Ok(choice),
        }
    }

    /// What reports and logs call the plant.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Uarm => "imperfect UARM",
            Self::Imperfect => "imperfect robot",
            Self::Ideal => "ideal DEM",
            Self::Space => "free-floating space manipulator",
        }
    }
}

/// What disturbs the simulated `robot` unless another disturbance is asked for: that of eq. 48 is one for motors of 0.2 N·m, and for
/// the paper's arm only.
pub const fn usual_disturbance<const J: usize, const N: usize>(robot: &Robot<J, N>) -> Disturbance {
    match robot.mechanics {
        Mechanics::ThreeLinks { .. } => Disturbance::Paper,
        Mechanics::Planar { .. } | Mechanics::Spatial { .. } => Disturbance::None,
    }
}

/// Any of the simulated plants, of a robot with `N` active joints.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // One of it for each robot.
pub enum SimulatedPlant<const N: usize = 2> {
    /// The paper's robot with its documented imperfections.
    Uarm(UarmPlant),
    /// The same as the controllers believe it to be.
    Ideal(DemPlant),
    /// Its space manipulator itself.
    Space(FreeFloatingPlant),
    /// An arm in the plane, as the controllers believe it to be.
    Planar(PlanarBasePlant<N>),
    /// An arm in space, as the controllers believe it to be.
    Spherical(SphericalBasePlant<N>),
    /// A space manipulator itself.
    Floating(SerialSpacePlant<N>),
}

impl<const N: usize> SimulatedPlant<N> {
    /// The plant that `choice` names, at the start of the robot file's task and at rest.
    ///
    /// # Errors
    /// If the imperfections make no plant of the model, or the robot file lacks what the plant is made of.
    pub fn new<const J: usize>(
        robot: &Robot<J, N>,
        choice: PlantChoice,
        disturbance: Disturbance,
    ) -> anyhow::Result<Self> {
        let no_space = || {
            let name = &robot.description.name;
            format!("{name}: the robot file has no [space_manipulator], which the plant \"space\" is made of")
        };
        let plant = match (choice, &robot.mechanics) {
            (PlantChoice::Uarm | PlantChoice::Imperfect, Mechanics::ThreeLinks { .. }) => {
                return Self::uarm(robot, robot.plant.uarm, disturbance);
            }
            (PlantChoice::Ideal, Mechanics::ThreeLinks { dem, .. }) => {
                Self::Ideal(DemPlant::new(*dem).with_disturbance(disturbance))
            }
            (PlantChoice::Space, Mechanics::ThreeLinks { space, .. }) => {
                let space = space.as_ref().with_context(no_space)?;
                Self::Space(FreeFloatingPlant::new(space).with_disturbance(disturbance))
            }
            (PlantChoice::Uarm | PlantChoice::Imperfect, Mechanics::Planar { dem, .. }) => {
                let Imperfections { scale, joints, .. } = robot.plant;
                let built = scale.dem(dem).context("plant")?;
                let plant = SerialPlant::new(PlanarBaseManipulator::planar(&built), joints);
                Self::Planar(plant.with_disturbance(disturbance))
            }
            (PlantChoice::Ideal, Mechanics::Planar { dem, .. }) => {
                Self::Planar(serial(PlanarBaseManipulator::planar(dem)).with_disturbance(disturbance))
            }
            (PlantChoice::Space, Mechanics::Planar { space, .. }) => {
                let space = space.as_ref().with_context(no_space)?.in_space();
                let space = FreeFloatingManipulator::free_floating(&space, [dem_model::Joint::about_z(); N]);
                Self::Floating(serial(space).with_disturbance(disturbance))
            }
            (PlantChoice::Uarm | PlantChoice::Imperfect, Mechanics::Spatial { space, joints: axes, .. }) => {
                let Imperfections { scale, joints, .. } = robot.plant;
                let weighed = scale.space_manipulator(space).context("plant")?;
                let arm = SphericalBaseManipulator::dynamically_equivalent(&weighed, *axes);
                Self::Spherical(SerialPlant::new(arm, joints).with_disturbance(disturbance))
            }
            (PlantChoice::Ideal, Mechanics::Spatial { dem, .. }) => {
                Self::Spherical(serial(*dem).with_disturbance(disturbance))
            }
            (PlantChoice::Space, Mechanics::Spatial { space, joints, .. }) => {
                let space = FreeFloatingManipulator::free_floating(space, *joints);
                Self::Floating(serial(space).with_disturbance(disturbance))
            }
        };
        Ok(plant.starting_at(start(robot)))
    }

    /// The paper's robot with other imperfections than its file's, at the start of the file's task and at rest.
    ///
    /// # Errors
    /// If the imperfections make no plant of the model, or the robot is another.
    pub fn uarm<const J: usize>(
        robot: &Robot<J, N>,
        imperfections: UarmPlantParameters,
        disturbance: Disturbance,
    ) -> anyhow::Result<Self> {
        let Mechanics::ThreeLinks { dem, .. } = &robot.mechanics else {
            anyhow::bail!("{}: imperfections are simulated of the paper's arm only", robot.description.name)
        };
        let plant = UarmPlant::new(dem, imperfections).context("plant")?;
        Ok(Self::Uarm(plant.with_disturbance(disturbance)).starting_at(start(robot)))
    }

    /// The same plant, starting at rest with its joints at `position`, rad.
    #[must_use]
    pub fn starting_at<const J: usize>(self, position: SVector<f64, J>) -> Self {
        let initial = InitialState { position: resized(&position), velocity: SVector::zeros() };
        let arm = SVector::from(<[f64; N]>::from(dimensions::active::<J, N>(&position.into())));
        match self {
            Self::Uarm(plant) => Self::Uarm(plant.with_initial_state(initial)),
            Self::Ideal(plant) => Self::Ideal(plant.with_initial_state(initial)),
            Self::Space(plant) => Self::Space(plant.with_initial_state(initial)),
            Self::Planar(plant) => {
                let turned = dimensions::base::<f64, J, N>(&position.into());
                let motion = SerialMotion { pose: turned, ..SerialMotion::at_rest(arm) };
                Self::Planar(plant.with_motion(motion))
            }
            Self::Spherical(plant) => Self::Spherical(plant.with_motion(SerialMotion::at_rest(arm))),
            Self::Floating(plant) => Self::Floating(plant.with_motion(SerialMotion::at_rest(arm))),
        }
    }

    /// The same plant, integrated on another grid.
    #[must_use]
    pub fn with_integration_step(self, step: IntegrationStep) -> Self {
        match self {
            Self::Uarm(plant) => Self::Uarm(plant.with_integration_step(step)),
            Self::Ideal(plant) => Self::Ideal(plant.with_integration_step(step)),
            Self::Space(plant) => Self::Space(plant.with_integration_step(step)),
            Self::Planar(plant) => Self::Planar(plant.with_integration_step(step)),
            Self::Spherical(plant) => Self::Spherical(plant.with_integration_step(step)),
            Self::Floating(plant) => Self::Floating(plant.with_integration_step(step)),
        }
    }
}

/// A plant as it is believed to be.
fn serial<const N: usize, const B: usize>(arm: SerialManipulator<f64, N, B>) -> SerialPlant<N, B>
where
    BaseFreedom<B>: PosedBase<B>,
{
    SerialPlant::new(arm, SerialImperfections::IDEAL)
}

/// The same values in a vector of another length: of three for a robot of `J` joints that is the paper's.
fn resized<const FROM: usize, const TO: usize>(values: &SVector<f64, FROM>) -> SVector<f64, TO> {
    SVector::from_fn(|row, _| values.get(row).copied().unwrap_or_default())
}

/// What the encoders of `J` joints see: an angle or velocity of the base about z, and those of the arm.
fn seen<const J: usize, const N: usize>(base: f64, arm: &SVector<f64, N>) -> SVector<f64, J> {
    let passive = dimensions::passive::<J, N>();
    SVector::from_iterator(std::iter::repeat_n(base, passive).chain(arm.iter().copied()))
}

/// Moves a plant whose joints are the arm's, or a base that turns about z and the arm's.
fn advance<const J: usize, const N: usize, const B: usize>(
    plant: &mut SerialPlant<N, B>,
    until: Duration,
    torque: &SVector<f64, J>,
    brakes: [Brake; J],
) where
    BaseFreedom<B>: PosedBase<B>,
{
    let (passive, torques) = (dimensions::passive::<J, N>(), (*torque).into());
    let base = dimensions::base::<f64, J, N>(&torques);
    let on_base = SVector::from_fn(|row, _| if row == 0 && B == 1 { base } else { 0.0 });
    let arm = dimensions::active::<J, N>(&torques);
    let mut joints = brakes.iter().skip(passive).copied();
    let brakes = SerialBrakes {
        // A spacecraft that floats has no brake.
        base: brakes.first().copied().filter(|_| passive == 1 && B == 1).unwrap_or(Brake::Released),
        joints: std::array::from_fn(|_| joints.next().unwrap_or(Brake::Released)),
    };
    plant.advance_under(until, &on_base, |_| arm, brakes);
}

/// Where the robot file's task starts, rad, a passive base at zero.
pub fn start<const J: usize, const N: usize>(robot: &Robot<J, N>) -> SVector<f64, J> {
    SVector::from(dimensions::of_all::<J, N>(robot.description.task.reference.start()))
}

impl<const J: usize, const N: usize> Plant<J> for SimulatedPlant<N> {
    fn time(&self) -> Duration {
        match self {
            Self::Uarm(plant) => plant.time(),
            Self::Ideal(plant) => plant.time(),
            Self::Space(plant) => plant.time(),
            Self::Planar(plant) => plant.time(),
            Self::Spherical(plant) => plant.time(),
            Self::Floating(plant) => plant.time(),
        }
    }

    fn position(&self) -> SVector<f64, J> {
        match self {
            Self::Uarm(plant) => resized(&plant.position()),
            Self::Ideal(plant) => resized(&plant.position()),
            Self::Space(plant) => resized(&plant.position()),
            Self::Planar(plant) => seen(plant.motion().pose, &plant.motion().state.position),
            Self::Spherical(plant) => seen(0.0, &plant.motion().state.position),
            Self::Floating(plant) => {
                let motion = plant.motion();
                seen(motion.pose.attitude.euler_angles().2, &motion.state.position)
            }
        }
    }

    fn velocity(&self) -> SVector<f64, J> {
        match self {
            Self::Uarm(plant) => resized(&plant.velocity()),
            Self::Ideal(plant) => resized(&plant.velocity()),
            Self::Space(plant) => resized(&plant.velocity()),
            Self::Planar(plant) => seen(plant.motion().state.base_velocity.x, &plant.motion().state.velocity),
            Self::Spherical(plant) => seen(0.0, &plant.motion().state.velocity),
            Self::Floating(plant) => seen(plant.motion().state.base_velocity.z, &plant.motion().state.velocity),
        }
    }

    fn advance(&mut self, until: Duration, torque: &SVector<f64, J>, brakes: [Brake; J]) {
        let three = || std::array::from_fn(|joint| brakes.get(joint).copied().unwrap_or(Brake::Released));
        match self {
            Self::Uarm(plant) => plant.advance(until, &resized(torque), three()),
            Self::Ideal(plant) => plant.advance(until, &resized(torque), three()),
            Self::Space(plant) => plant.advance(until, &resized(torque), three()),
            Self::Planar(plant) => advance(plant, until, torque, brakes),
            Self::Spherical(plant) => advance(plant, until, torque, brakes),
            Self::Floating(plant) => advance(plant, until, torque, brakes),
        }
    }
}

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
