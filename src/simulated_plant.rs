//! The plant of a simulated robot: which one it is, and how it moves the robot's joints.

use std::time::Duration;

use anyhow::Context;
use dem_model::{
    BaseFreedom, FreeFloatingManipulator, PlanarBaseManipulator, SerialManipulator, SphericalBaseManipulator,
};
use hinf_control::Disturbance;
use nalgebra::SVector;
use uarm_loop::choice::Choice;
use uarm_loop::dimensions;
use uarm_sim::plant::PosedBase;
use uarm_sim::{
    Brake, DemPlant, FreeFloatingPlant, InitialState, IntegrationStep, PlanarBasePlant, Plant, SerialBrakes,
    SerialImperfections, SerialMotion, SerialPlant, SerialSpacePlant, SphericalBasePlant, UarmPlant,
    UarmPlantParameters,
};

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
