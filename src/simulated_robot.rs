//! The simulated robot: a plant behind emulated drives, in this process or on a CAN interface.

use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use nalgebra::Vector3;
use uarm_sim::drive::{DriveDescription, DriveParameters, EncoderDescription};
use uarm_sim::{
    Brake, DemPlant, EmulatedRobot, FreeFloatingPlant, InitialState, IntegrationStep, Pacing, Plant, UarmPlant,
    UarmPlantParameters,
};

use uarm_loop::robot::Joint;

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
                Self::Space(FreeFloatingPlant::new(&robot.space_manipulator).with_disturbance(disturbance))
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

/// Puts emulated drives, as the robot file describes them, on a plant.
///
/// # Errors
/// If the robot file describes drives that cannot be emulated.
pub fn emulate<P: Plant + Clone>(robot: &Robot, plant: P, pacing: Pacing) -> anyhow::Result<EmulatedRobot<P>> {
    let [first, second, third] = &robot.description.joints;
    Ok(EmulatedRobot::new(plant, [drive(first)?, drive(second)?, drive(third)?], pacing)?)
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
        encoder: EncoderDescription {
            counts_per_revolution: joint
                .encoder
                .counts_per_revolution
                .of_motor(joint.torque_scale.transmission.ratio())
                .context("counts per revolution of the motor")?,
            counter_bits: joint.encoder.counter_width.get(),
            zero_offset: joint.encoder.zero,
        },
    })
    .with_context(|| joint.name.clone())
    .map(|drive| {
        let unit = joint.torque_scale.rated_torque.unit();
        drive.with_rated_torque_unit(unit).behind(joint.torque_scale.transmission)
    })
}
