//! What was found, for people, programs and robot files.

use std::io::{self, Write};

use serde::Serialize;
use uarm_identify::{Identified, SearchEnd, Told, Uarm, UarmParameter};

use super::recording::Recordings;
use crate::robot::file;
use crate::words::in_words;

/// A number of the robot.
#[derive(Debug, Serialize)]
struct Row {
    /// Its name in `[plant]`.
    parameter: String,
    unit: &'static str,
    value: f64,
    /// Nothing where the recording says nothing.
    standard_error: Option<f64>,
    /// `well`, `not-told` or `at-least`.
    told: &'static str,
}

/// Two numbers that the recording hardly tells apart.
#[derive(Debug, Serialize)]
struct Pair {
    parameters: [String; 2],
    correlation: f64,
}

/// What a recording says of a robot.
#[derive(Debug, Serialize)]
pub struct Report {
    robot: String,
    runs: usize,
    cycles: usize,
    gaps: usize,
    windows: usize,
    steps: usize,
    /// The gain that was taken as known; nothing if it was sought.
    known_gain: Option<f64>,
    /// Left over, in units of an encoder's rounding error.
    residual: f64,
    correlation: f64,
    explains: bool,
    /// Whether the search found its end.
    converged: bool,
    parameters: Vec<Row>,
    confounded: Vec<Pair>,
    /// `[plant]` of a robot file.
    plant: file::Plant,
}

impl Report {
    /// What `found` says of the robot of `recordings` in so many `runs`.
    pub fn new(
        recordings: &Recordings,
        runs: usize,
        model: &Uarm,
        known_gain: Option<f64>,
        found: &Identified,
    ) -> Self {
        let row = |estimate: &uarm_identify::Estimate| Row {
            parameter: estimate.name.clone(),
            unit: estimate.unit,
            value: estimate.value,
            standard_error: Some(estimate.standard_error).filter(|error| error.is_finite()),
            told: match estimate.told {
                Told::Well => "well",
                Told::NotTold => "not-told",
                Told::AtLeast => "at-least",
            },
        };
        let name = |index: usize| found.estimates.get(index).map(|estimate| estimate.name.clone()).unwrap_or_default();
        let pair = |&(first, second, correlation): &(usize, usize, f64)| Pair {
            parameters: [name(first), name(second)],
            correlation,
        };
        Self {
            robot: recordings.robot.description.name.clone(),
            runs,
            cycles: recordings.cycles,
            gaps: recordings.gaps,
            windows: found.windows,
            steps: found.steps,
            known_gain,
            residual: found.residual,
            correlation: found.correlation,
            explains: found.explains(),
            converged: found.end == SearchEnd::Converged,
            parameters: found.estimates.iter().map(row).collect(),
            confounded: found.confounded.iter().map(pair).collect(),
            plant: plant(recordings, model, found),
        }
    }

    /// Does what was found explain the motion?
    pub const fn explains(&self) -> bool {
        self.explains
    }

    /// `[plant]` of a robot file.
    pub const fn plant(&self) -> &file::Plant {
        &self.plant
    }

    /// Did the recording tell every number, and does the model explain it?
    pub fn is_whole(&self) -> bool {
        self.explains && self.parameters.iter().all(|row| row.told != "not-told")
    }

    /// Prints it for people.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn print(&self, output: &mut impl Write) -> io::Result<()> {
        let Self { robot, runs, cycles, gaps, windows, steps, residual, .. } = self;
        let (of_runs, of_gaps) = (counted(*runs, "run"), counted(*gaps, "gap"));
        writeln!(
            output,
            "{robot}: {cycles} cycles of {of_runs}, {of_gaps}, {windows} windows, {steps} steps of the search\n"
        )?;
        writeln!(output, "  {:<26} {:>10} {:>15}", "[plant]", "value", "standard error")?;
        for Row { parameter, unit, value, standard_error, told } in &self.parameters {
            let error = standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.5}"));
            let note = match *told {
                "not-told" => "  NOT TOLD",
                "at-least" => "  the least that it can be",
                _ => "",
            };
            writeln!(output, "  {parameter:<26} {value:>10.5} {error:>15} {unit}{note}")?;
        }
        if let Some(gain) = self.known_gain {
            writeln!(
                output,
                "  {:<26} {gain:>10.5} {:>15} taken as known: all others are in proportion to it",
                "torque_gain", "-"
            )?;
        }
        let verdict = if self.explains {
            "the model explains the motion"
        } else if !self.converged {
            "the search did NOT come to an end: these numbers say nothing"
        } else {
            "the model does NOT explain the motion: standard errors say nothing"
        };
        writeln!(
            output,
            "\nleft over: {residual:.2} times an encoder's rounding, correlation {:.2}: {verdict}",
            self.correlation
        )?;
        let open: Vec<_> =
            self.parameters.iter().filter(|row| row.told == "not-told").map(|row| &row.parameter).collect();
        if !open.is_empty() {
            let open = in_words(open.into_iter());
            writeln!(
                output,
                "not told by these runs: {open}: a motion that excites them more is wanted, in both directions and at more velocities"
            )?;
        }
        for Pair { parameters: [first, second], correlation } in &self.confounded {
            writeln!(output, "hardly told apart: {first} and {second} (correlation {correlation:.2})")?;
        }
        Ok(())
    }
}

fn counted(number: usize, name: &str) -> String {
    if number == 1 { format!("1 {name}") } else { format!("{number} {name}s") }
}

/// `[plant]` with what was told; of the rest, what the robot file had, or none.
fn plant(recordings: &Recordings, model: &Uarm, found: &Identified) -> file::Plant {
    let before = recordings.robot.plant.uarm.imperfections();
    let told =
        |parameter: UarmParameter| found.estimate(parameter).is_some_and(|estimate| estimate.told != Told::NotTold);
    let new = model.imperfections(&found.values());
    let pick = |parameter, new, before| if told(parameter) { new } else { before };
    let each = |of: fn(usize) -> UarmParameter, new: [f64; 3], before: [f64; 3]| {
        (0..3).map(|joint| pick(of(joint), new[joint], before[joint])).collect()
    };
    file::Plant {
        base_inertia_scale: pick(UarmParameter::BaseInertia, new.base_inertia_scale, before.base_inertia_scale),
        link_scale: pick(UarmParameter::Links, new.link_inertia_scale, before.link_inertia_scale),
        viscous_friction_nm_s: each(UarmParameter::Viscous, new.viscous_friction, before.viscous_friction),
        coulomb_friction_nm: each(UarmParameter::Coulomb, new.coulomb_friction, before.coulomb_friction),
        torque_gain: pick(UarmParameter::Gain, new.gain, before.gain),
        tilt_m_per_s2: std::array::from_fn(|axis| pick(UarmParameter::Tilt(axis), new.tilt[axis], before.tilt[axis])),
    }
}
