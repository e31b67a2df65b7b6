//! Another law on the measurements of a run.

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, ensure};
use uarm_log::replay::what_if::{TorqueSummary, WhatIfRun};
use uarm_loop::settings::Settings;

use super::arguments::Arguments;
use super::chart::Torques;
use super::recorded::Recorded;
use super::report::{Report, WhatIfReport, print_recording};
use crate::console;
use crate::dimensions::ACTIVE;
use crate::exit::Exit;
use crate::output_files::OutputFiles;
use crate::robot::Robot;

type WhatIf = uarm_log::replay::what_if::WhatIfOutcome<ACTIVE>;
type Pair = uarm_log::replay::what_if::Pair<ACTIVE>;

/// Gives the measurements to another law.
///
/// # Errors
/// If nothing can be replayed, an option is for another kind of replay, or an output cannot be written.
pub fn what_if(
    arguments: &Arguments,
    recorded: &mut Recorded,
    file: &str,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    ensure!(
        arguments.from.is_none(),
        "--from is for a replay of the run as it was: another law begins with its own state"
    );
    let law = arguments.controller.unwrap_or(recorded.settings.law);
    let mut robot = match &arguments.robot {
        Some(path) => Robot::load_with(Some(path), &arguments.overrides(law))?,
        None => {
            let text = toml::to_string(&recorded.robot.file).context("the robot file of the log")?;
            Robot::parse(Path::new(file), &text, &arguments.overrides(law))?
        }
    };
    robot.fuzzy_sets = recorded.robot.fuzzy_sets;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref(), std::iter::once(law))?;
    let settings =
        Settings { law, guard: arguments.adaptation.unwrap_or(recorded.settings.guard), ..recorded.settings };
    let mut controller = robot.controller(law, settings.guard)?;
    let mut run = WhatIfRun::new(&robot.description, &settings, &mut controller).with_context(|| file.to_owned())?;
    let mut torques = Torques::default();
    let mut go = |each: &mut dyn FnMut(&Pair)| {
        let mut take = |pair| {
            each(&pair);
            torques.take(&pair);
        };
        recorded.each_window(&mut |source| run.window(source, &mut take))
    };
    match &arguments.csv {
        None => go(&mut |_| {}).with_context(|| file.to_owned())?,
        Some(path) => outputs.write(path, |output| write_csv(go, output)).context("--csv")?,
    }
    let what_if = run.finish().with_context(|| file.to_owned())?;
    let other_name = match arguments.robot {
        Some(_) => format!("{} of {}", law.name(), robot.description.name),
        None => law.name().to_owned(),
    };
    if let Some(figure) = &arguments.plot {
        let bytes = figure.render(&torques.chart(&recorded.name, &other_name, file)).context("--plot")?;
        outputs.write(figure.path(), |output| output.write_all(&bytes)).context("--plot")?;
    }
    if arguments.json {
        let report = Report {
            file,
            controller: &other_name,
            exact: None,
            what_if: Some(WhatIfReport::new(&what_if)),
            part: &recorded.part,
            damage: &recorded.damage,
            clock_steps: &recorded.clock_steps,
        };
        console::print_json(&report)?;
    } else {
        print_what_if(&what_if, recorded, &other_name, file, &mut console::output())?;
    }
    let whole = recorded.damage.is_empty() && what_if.lost_cycles == 0;
    let exit = match (what_if.cycles == 0, whole) {
        (true, _) => Exit::Failure,
        (false, true) => Exit::Ok,
        (false, false) => Exit::Loss,
    };
    Ok(exit.into())
}

fn print_what_if(
    what_if: &WhatIf,
    recorded: &Recorded,
    other: &str,
    file: &str,
    output: &mut impl Write,
) -> io::Result<()> {
    writeln!(
        output,
        "what {other} would have asked for on the measurements of {file}, where {} was in control",
        recorded.name
    )?;
    let TorqueSummary { rms_difference, largest_difference, rms_recorded, rms_other } = what_if.summary;
    let of_all = match what_if.lost_cycles {
        0 => String::new(),
        lost => format!(" of {}", what_if.cycles + lost),
    };
    writeln!(output, "  {}{of_all} cycles, open loop: the robot did not hear it", what_if.cycles)?;
    writeln!(output, "    torque (N m)         joint 2   joint 3")?;
    let mut row =
        |name: &str, [joint_2, joint_3]: [f64; 2]| writeln!(output, "    {name:<18} {joint_2:>9.5} {joint_3:>9.5}");
    row("recorded, RMS", rms_recorded)?;
    row("other, RMS", rms_other)?;
    row("difference, RMS", rms_difference)?;
    row("difference, most", largest_difference)?;
    if what_if.lost_cycles > 0 {
        writeln!(output, "  LOST               {} cycles that cannot be replayed", what_if.lost_cycles)?;
    }
    print_recording(recorded, output)
}

/// Writes what `go` gives: both torques of each cycle.
fn write_csv(go: impl FnOnce(&mut dyn FnMut(&Pair)) -> anyhow::Result<()>, output: &mut dyn Write) -> io::Result<()> {
    writeln!(output, "tick,time_s,torque_recorded_2_nm,torque_recorded_3_nm,torque_other_2_nm,torque_other_3_nm")?;
    let mut written = Ok(());
    let mut write = |pair: &Pair| {
        let ([recorded_2, recorded_3], [other_2, other_3]) = (pair.recorded, pair.other);
        if written.is_ok() {
            written = writeln!(output, "{},{},{recorded_2},{recorded_3},{other_2},{other_3}", pair.tick, pair.time);
        }
    };
    go(&mut write).map_err(io::Error::other)?;
    written
}
