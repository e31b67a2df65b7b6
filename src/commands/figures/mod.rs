//! `uarm figures`: the paper's figures from simulated experiments.

pub mod experiments;
pub mod overview;
pub mod paper;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use hinf_control::{Disturbance, FuzzySets, Law};
use uarm_plot::sheet::{Panel, Sheet};
use uarm_sim::UarmPlantParameters;

use crate::console;
use crate::figures::output::{Format, write};
use crate::figures::sets;
use crate::options::choice;
use crate::output_files::{Force, OutputFiles};
use crate::robot::fuzzy_sets::TrainedSets;
use crate::robot::overrides::Overrides;
use crate::robot::shape::{Shape, for_shape};
use crate::robot::{Robot, RobotText};
use crate::simulated_plant::{PlantChoice, usual_disturbance};
use experiments::{Experiment, simulate_paper, simulated};
use overview::{Published, Shared};

/// Arguments of `uarm figures`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Runs each of the six controllers once in virtual time and draws what the paper shows of them:
  fig04 ... fig16   positions, velocities and torques (4-11, 13-16), fuzzy sets (12), with the paper's axes
  overview          all six together: errors, base, torques, and L2 beside the paper's Table 4
Of a robot with other joints than the paper's, the overview alone.
The same command writes the same bytes, on any machine: the font is built in.
The curves are a simulation. The plant \"uarm\" is a fit to the paper's Table 4, no measurement.

Example:
  uarm figures --out figures --format svg")]
pub struct Arguments {
    /// Where the files go; made if it is not there
    #[arg(long, default_value = "figures", value_name = "DIR")]
    out: PathBuf,
    /// Which files
    #[arg(long, value_enum, default_value_t, value_name = "FORMAT")]
    format: Format,
    /// The robot file; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// What the simulated robot is; by default it has the imperfections of the robot file's [plant], and is "ideal" without
    #[arg(long, value_parser = choice::<PlantChoice>(), value_name = "PLANT")]
    plant: Option<PlantChoice>,
    /// Let the fuzzy laws run with the sets in this file, as uarm train writes it; without it with the untrained grid
    #[arg(long, value_name = "FILE.toml")]
    fuzzy_sets: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Draws the figures and prints the paths of the files.
///
/// # Errors
/// If the robot file is wrong, a run fails, or a file cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let inputs = [&arguments.robot, &arguments.fuzzy_sets];
    let outputs = OutputFiles::new(arguments.force, inputs.into_iter().flatten().map(PathBuf::as_path));
    let file = RobotText::read(arguments.robot.as_deref())?;
    let sheets = match file.shape()? {
        Shape::PAPER => sheets_of_the_paper(arguments, &file)?,
        shape => for_shape!(shape, overview_alone(arguments, &file))?,
    };
    let files = write(&sheets, &arguments.out, arguments.format, &outputs).context("--out")?;
    let mut output = console::output();
    for file in files {
        writeln!(output, "{}", file.display())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The robot of `file` with the sets that it is to have.
fn robot<const J: usize, const N: usize>(arguments: &Arguments, file: &RobotText) -> anyhow::Result<Robot<J, N>> {
    let mut robot = Robot::of_text(&file.name, &file.text, &Overrides::default())?;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref(), Law::ALL.into_iter())?;
    Ok(robot)
}

fn sheets_of_the_paper(arguments: &Arguments, file: &RobotText) -> anyhow::Result<Vec<Sheet>> {
    let robot = robot(arguments, file)?;
    sheets(&robot, PlantChoice::asked(arguments.plant, &robot)?)
}

fn overview_alone<const J: usize, const N: usize>(
    arguments: &Arguments,
    file: &RobotText,
) -> anyhow::Result<Vec<Sheet>> {
    let robot = robot::<J, N>(arguments, file)?;
    let plant = PlantChoice::asked(arguments.plant, &robot)?;
    let disturbance = usual_disturbance(&robot);
    let experiment = |law| simulated(&robot, plant, disturbance, law);
    let experiments = Law::PAPER.into_iter().map(experiment).collect::<anyhow::Result<Vec<_>>>()?;
    Ok(vec![overview::overview(&experiments, &shared(&robot, plant, disturbance))])
}

/// All figures of the paper and the overview.
///
/// # Errors
/// If a run fails.
pub fn sheets(robot: &Robot, plant: PlantChoice) -> anyhow::Result<Vec<Sheet>> {
    let experiments: Vec<Experiment> =
        Law::PAPER.into_iter().map(|law| simulate_paper(robot, plant, law)).collect::<anyhow::Result<_>>()?;
    let mut sheets = Vec::new();
    for experiment in &experiments {
        let Some(figures) = paper::figures_of(experiment.law) else { continue };
        let note = note(robot, plant, experiment);
        for mut sheet in [paper::motion(experiment, &figures, &note), paper::torque(experiment, &figures, &note)] {
            if sheet.panels.iter().any(Panel::cuts_a_curve) {
                sheet.note.push_str("; a curve leaves the paper's axis");
            }
            sheets.push(sheet);
        }
    }
    sheets.push(fuzzy_sets(robot)?);
    sheets.push(overview::overview(&experiments, &shared(robot, plant, Disturbance::Paper)));
    Ok(sheets)
}

fn shared<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    plant: PlantChoice,
    disturbance: Disturbance,
) -> Shared<N> {
    Shared {
        task: robot.description.task.clone(),
        disturbance,
        published: if robot.is_the_papers() { Published::Shown } else { Published::Hidden },
        note: format!(
            "Simulation: {}, a cycle every {:?}",
            plant_note(robot, plant),
            robot.description.period.duration()
        ),
    }
}

/// Fig. 12: the sets in use if they are trained ones, otherwise those shipped.
fn fuzzy_sets(robot: &Robot) -> anyhow::Result<Sheet> {
    let trained = match robot.fuzzy_sets {
        Some(sets) => sets,
        None => TrainedSets::built_in()?.sets,
    };
    let note = "Trained on the simulated UARM (uarm train); the paper's own trained sets are lost";
    Ok(sets::fuzzy_sets("fig12-fuzzy-sets", &FuzzySets::untrained(), &trained, note))
}

fn note(robot: &Robot, plant: PlantChoice, experiment: &Experiment) -> String {
    let indices = experiment.indices;
    format!("Simulation: {}; L2 {:.4}, E {:.4} N\u{b7}m\u{b7}s", plant_note(robot, plant), indices.l2, indices.e)
}

fn plant_note<const J: usize, const N: usize>(robot: &Robot<J, N>, plant: PlantChoice) -> String {
    match plant {
        PlantChoice::Uarm if robot.is_the_papers() && robot.plant.uarm == UarmPlantParameters::fitted() => {
            format!("{} with imperfections fitted to the paper's Table 4", robot.description.name)
        }
        PlantChoice::Uarm | PlantChoice::Imperfect => {
            format!("{} with the imperfections in its robot file", robot.description.name)
        }
        PlantChoice::Ideal => format!("{} as the controllers believe it to be", robot.description.name),
        PlantChoice::Space => "the free-floating space manipulator".to_owned(),
    }
}
