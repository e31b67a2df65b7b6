//! Robot files: read, checked, and turned into types that cannot be wrong.
//!
//! | module | subject |
//! |---|---|
//! | [`mod@file`] | the file as written |
//! | [`error`] | what is wrong with it |
//! | [`fuzzy_sets`] | files of trained fuzzy sets |
//! | [`overrides`] | what a command line changes of it |
//! | `reading` | TOML into a type, and the fields that it does not know |
//! | [`arm`] | what the loop and its checks ask of an arm |
//! | [`model`] | what the controllers believe the arm to be |
//! | `names` | what robot and joints are called |
//! | [`on_bus`] | a robot's joints and their bus, whatever its arm is |
//! | [`shape`] | how many joints there are |
//! | `text` | the text of a file, or the built-in one |
//! | `task` | the motion |
//! | [`demand`] | what the motion asks of the joints, and whether they have it |
//! | `acceleration` | how fast the joints can change their velocities |
//! | `joint` | encoders, gears, torque scales and limits |
//! | [`imperfections`] | what is not ideal in the simulated robot |
//! | [`homing`] | how a drive finds its home position by itself |
//! | `drive` | what the master wants of a drive |
//! | `supervision` | how counts and torques are held against the model |
//! | `bus` | the bus and its time budget |
//! | `known_fields` | which fields a table may have |
//! | `protocol` | what the drives speak |
//! | [`profile`] | what is known of a maker's drives |
//! | [`control`] | period, estimator, and the controllers' weights |

mod acceleration;
pub mod arm;
mod bus;
pub mod control;
pub mod demand;
mod drive;
pub mod error;
pub mod file;
pub mod fuzzy_sets;
pub mod homing;
pub mod imperfections;
mod joint;
mod known_fields;
pub mod model;
mod names;
pub mod on_bus;
pub mod overrides;
pub mod profile;
mod protocol;
mod reading;
mod readings;
pub mod shape;
mod supervision;
mod task;
mod text;
mod via_csv;

use std::path::Path;
use std::sync::Arc;

use hinf_control::{AdaptationGuard, BuildError, Controller, ControllerSettings, FuzzySets, Law, QuinticReference};
use uarm_io::time::Duration;

use uarm_log::description::{JointDescription, LinkDescription, RobotDescription};
use uarm_loop::period::Period;

use crate::dimensions::LoopRobot;
use arm::{Arm, LawChoice};
use error::{Checker, RobotError};
use file::RobotFile;
use imperfections::Imperfections;
use model::{CheckedModel, Mechanics};
use overrides::Overrides;
use profile::UsedProfile;
use reading::read;
use shape::Shape;
pub use text::{BUILT_IN, BUILT_IN_NAME, RobotText};

/// What there is to say of a robot whose file leaves the supervision out.
pub const UNSUPERVISED: &str =
    "supervision is OFF: no encoder that stands still, no torque of the wrong sign is noticed but by the limits";

/// The version of the format that this program reads.
const SCHEMA: u32 = 1;

/// A robot of `J` joints with drives, `N` of them active, checked. The default is the paper's.
#[derive(Clone, Debug)]
pub struct Robot<const J: usize = 3, const N: usize = 2> {
    /// The text that it was read from.
    pub source: String,
    /// The file as written, with what the command line changed.
    pub file: RobotFile<N>,
    /// The drive profiles that completed the file.
    pub profiles: Vec<UsedProfile>,
    /// What the loop must know of it.
    pub description: LoopRobot<J, N>,
    /// The model that the controllers work with.
    pub arm: Arc<dyn Arm<J, N>>,
    /// What plants are made of.
    pub mechanics: Mechanics<N>,
    /// Links of its URDF whose inertia no body can have.
    pub impossible_inertias: Vec<String>,
    /// The settings of every law.
    pub controllers: ControllerSettings<N>,
    /// Trained premise sets of the fuzzy laws; without them they run with the untrained grid.
    pub fuzzy_sets: Option<FuzzySets<f64>>,
    /// What is not ideal in the simulated robot.
    pub plant: Imperfections<N>,
}

impl Robot {
    /// The paper's robot, or the one in `file`, which has as many joints.
    ///
    /// # Errors
    /// [`RobotError`] names file, field, value and expectation.
    pub fn load(file: Option<&Path>) -> Result<Self, RobotError> {
        Self::load_with(file, &Overrides::default())
    }

    /// The same, with what the command line changes.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn load_with(file: Option<&Path>, overrides: &Overrides) -> Result<Self, RobotError> {
        let RobotText { name, text } = RobotText::read(file)?;
        Self::parse(&name, &text, overrides)
    }

    /// A robot from the text of a robot file; `name` is what messages call the file.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn parse(name: &Path, text: &str, overrides: &Overrides) -> Result<Self, RobotError> {
        // What is no robot at all is told by the whole file's check.
        if let Ok(found) = Shape::of(name, text)
            && found != Shape::PAPER
        {
            let expected = "a passive base and 2 active joints: what was asked for is for the paper's arm alone";
            return Err(Checker::new(name).refuse("joints", found, expected));
        }
        Self::of_text(name, text, overrides)
    }
}

impl<const J: usize, const N: usize> Robot<J, N> {
    /// Is it the paper's UARM with the paper's task? What the paper measured says something of this robot alone.
    pub fn is_the_papers(&self) -> bool {
        let is_model = read::<RobotFile>(Path::new(BUILT_IN_NAME), BUILT_IN)
            .is_ok_and(|(paper, _)| paper.model == self.file.model);
        let task = self.description.task.reference.as_quintic();
        let task = task.and_then(|task| arm::same::<_, QuinticReference<f64, 2>>(*task));
        is_model && task == Some(QuinticReference::paper())
    }

    /// A robot of so many joints from the text of a robot file; `name` is what messages call the file.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn of_text(name: &Path, text: &str, overrides: &Overrides) -> Result<Self, RobotError> {
        let check = Checker::new(name);
        // What is no robot at all is told by the whole file's check.
        if let Ok(found) = Shape::of(name, text)
            && found != Shape::of_joints::<J, N>()
        {
            let expected = format!("{}, as the robot has whose place it takes", Shape::of_joints::<J, N>());
            return Err(check.refuse("joints", found, expected));
        }
        let (mut file, unknown): (RobotFile<N>, _) = read(name, text)?;
        if let Some(field) = unknown.first() {
            return Err(check.refuse(with_brackets(field), "unknown field", known_fields::beside(field)));
        }
        if let Some((field, found, expected)) = misread(text, &file) {
            return Err(check.refuse(field, found, expected));
        }
        names::check(&file.name, &file.joints, &check)?;
        overrides.apply(&mut file.control, &mut file.task, &check)?;
        model::resolve_urdf::<J, N>(name, &mut file, &check)?;
        via_csv::resolve(name, &mut file, &check)?;
        let profiles = profile::apply(name, &mut file.joints, &check)?;
        let checked = Self::check_with(name, text, file, overrides);
        let checked = checked.map_err(|error| profile::told_where_written(error, &profiles))?;
        let robot = Self { profiles, ..checked };
        let task = &robot.description.task.reference;
        demand::check(&robot.description, robot.arm.as_ref(), task, &check)?;
        Ok(robot)
    }

    /// Checks a robot file as written; `name` and `text` say where it came from.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn check(name: &Path, text: &str, file: RobotFile<N>) -> Result<Self, RobotError> {
        Self::check_with(name, text, file, &Overrides::default())
    }

    /// The same, with what a command line changes of the laws.
    fn check_with(name: &Path, text: &str, mut file: RobotFile<N>, overrides: &Overrides) -> Result<Self, RobotError> {
        let check = Checker::new(name);
        if file.schema != SCHEMA {
            return Err(check.refuse("schema", file.schema, format!("{SCHEMA}")));
        }
        let period = Period::new(Duration::from_micros(file.control.period_us.into())).ok_or_else(|| {
            let expected = format!("{} to {}", Period::SHORTEST.as_micros(), Period::LONGEST.as_micros());
            check.refuse("control.period_us", file.control.period_us, expected)
        })?;
        let joints = joint::check::<J, N>(&file, &check)?;
        let CheckedModel { arm, mechanics, impossible_inertias } = model::check::<J, N>(&file, &check)?;
        let task = task::check(&file.task, &file.joints, period, &check)?;
        let mut controllers = match file.controllers {
            Some(controllers) => controllers,
            None => control::derived(arm.as_ref(), task.reference.start(), &check)?,
        };
        overrides.apply_to_laws(&mut controllers)?;
        if let Some((law, mode)) = overrides.base_acceleration {
            control::check_override(&controllers, arm.as_ref(), law, mode)?;
        }
        file.controllers = Some(controllers);
        control::check(&controllers, arm.as_ref(), &check)?;
        let protocol = protocol::check(&file.bus, &file.joints, &check)?;
        let bus = bus::check(&file.bus, &joints, protocol, period, &check)?;
        let supervision = supervision::check::<J, N>(&file.supervision, arm.momentum_model(), &joints, period, &check)?;
        let plant = imperfections::check::<J, N>(file.plant.as_ref(), &mechanics, &check)?;
        let acceleration_bounds = arm.acceleration_bounds(&joints.each_ref().map(|joint| joint.torque_limit));
        Ok(Self {
            source: text.to_owned(),
            profiles: Vec::new(),
            description: LoopRobot {
                name: file.name.clone(),
                joints,
                task,
                acceleration_bounds,
                period,
                feedback_timeout: control::feedback_timeout(&file.control, &bus, period, &check)?,
                tracking_error_limit: check
                    .within("control.tracking_error_limit_deg", file.control.tracking_error_limit_deg, 0.1, 360.0)?
                    .to_radians(),
                overruns_in_a_row: control::overruns_in_a_row(&file.control, &check)?,
                saturation_limit: control::saturation_limit(&file.control, &check)?,
                rest_velocity: control::rest_velocity(&file.control, &check)?,
                supervision,
                stop_ramp: control::stop_ramp(&file.control, &check)?,
                bus,
            },
            arm,
            controllers,
            fuzzy_sets: None,
            plant,
            mechanics,
            impossible_inertias,
            file,
        })
    }

    /// The robot of a log, with what the log says of its fuzzy sets; `name` is what messages call the log.
    ///
    /// # Errors
    /// As [`Robot::load`]; fields that this version does not know are left out.
    pub fn from_log(name: &Path, logged: &RobotDescription) -> Result<Self, RobotError> {
        let (file, _) = read(name, &logged.toml)?;
        let mut robot = Self::check(name, &logged.toml, file)?;
        robot.fuzzy_sets = logged.fuzzy_sets;
        Ok(robot)
    }

    /// What a log holds of the robot.
    ///
    /// # Errors
    /// If the robot file cannot be written as TOML; a checked one can.
    pub fn for_log(&self) -> Result<RobotDescription, toml::ser::Error> {
        Ok(RobotDescription {
            name: self.description.name.clone(),
            toml: toml::to_string(&self.file)?,
            fuzzy_sets: self.fuzzy_sets,
        })
    }

    /// The joints as a log shows them, the passive base first.
    pub fn joint_descriptions(&self) -> [JointDescription; J] {
        let links = self.mechanics.links();
        let skipped = links.len().saturating_sub(J);
        let mut links = links.into_iter().skip(skipped);
        self.description.joints.each_ref().map(|joint| JointDescription {
            name: joint.name.clone(),
            node: joint.node.raw(),
            link: links.next().unwrap_or(LinkDescription::along_x(0.0, 0.0)),
        })
    }

    /// The control law with the robot file's weights and choices, in its initial state.
    ///
    /// # Errors
    /// If they allow no design; a checked robot file has only such that do.
    pub fn controller(&self, law: Law, guard: AdaptationGuard) -> Result<Box<dyn Controller<f64, N>>, BuildError> {
        let fuzzy_sets = self.fuzzy_sets.unwrap_or_else(FuzzySets::untrained);
        self.arm.controller(&self.controllers, &LawChoice { law, guard, fuzzy_sets })
    }
}

/// The first value in `text` that was not taken as it is written, since `serde` takes the first values of a longer list, and a list for a
/// table: its field, what was found, and what was expected.
fn misread<const N: usize>(text: &str, file: &RobotFile<N>) -> Option<(String, String, String)> {
    let (written, taken) = (text.parse::<toml::Table>().ok()?, toml::Table::try_from(file).ok()?);
    misread_in("", &toml::Value::Table(written), &toml::Value::Table(taken))
}

fn misread_in(path: &str, written: &toml::Value, taken: &toml::Value) -> Option<(String, String, String)> {
    match (written, taken) {
        (toml::Value::Table(written), toml::Value::Table(taken)) => written.iter().find_map(|(name, value)| {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            misread_in(&path, value, taken.get(name)?)
        }),
        (toml::Value::Array(written), toml::Value::Array(taken)) if written.len() > taken.len() => {
            Some((path.to_owned(), format!("{} values", written.len()), format!("{} values", taken.len())))
        }
        (toml::Value::Array(written), toml::Value::Array(taken)) => {
            let mut pairs = written.iter().zip(taken).enumerate();
            pairs.find_map(|(index, (written, taken))| misread_in(&format!("{path}[{index}]"), written, taken))
        }
        (toml::Value::Array(_), toml::Value::Table(taken)) => {
            let fields = taken.keys().cloned().collect::<Vec<_>>().join(", ");
            Some((path.to_owned(), "a list".to_owned(), format!("a table with {fields}")))
        }
        _ => None,
    }
}

/// A path with its indices in brackets, as other messages have them: `joints[1].limits.torque`.
fn with_brackets(path: &str) -> String {
    let mut text = String::new();
    for name in path.split('.') {
        match name.parse::<usize>() {
            Ok(index) => text.push_str(&format!("[{index}]")),
            Err(_) if text.is_empty() => text.push_str(name),
            Err(_) => text.push_str(&format!(".{name}")),
        }
    }
    text
}
