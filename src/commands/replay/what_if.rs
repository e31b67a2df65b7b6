//! Another law on the measurements of a run.

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, ensure};
use uarm_log::replay::what_if::{Pair, TorqueSummary, WhatIfOutcome, WhatIfRun};
use uarm_loop::dimensions;
use uarm_loop::settings::Settings;

use super::arguments::Arguments;
use super::chart::Torques;
use super::recorded::Recorded;
use super::report::{Report, WhatIfReport, print_recording};
use crate::console;
use crate::exit::Exit;
use crate::output_files::OutputFiles;
use crate::robot::Robot;
use crate::robot::RobotText;

/// Gives the measurements to another law.
///
/// # Errors
/// If nothing can be replayed, an option is for another kind of replay, or an output cannot be written.
pub fn what_if<const J: usize, const N: usize>(
    arguments: &Arguments,
    recorded: &mut Recorded<J, N>,
    file: &str,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    ensure!(
        arguments.from.is_none(),
        "--from is for a replay of the run as it was: another law begins with its own state"
    );
    let law = arguments.controller.unwrap_or(recorded.settings.law);
    let mut robot = match &arguments.robot {
        Some(path) => {
            let RobotText { name, text } = RobotText::read(Some(path))?;
            Robot::<J, N>::of_text(&name, &text, &arguments.overrides(law))?
        }
        None => {
            let text = toml::to_string(&recorded.robot.file).context("the robot file of the log")?;
            Robot::of_text(Path::new(file), &text, &arguments.overrides(law))?
        }
    };
    robot.fuzzy_sets = recorded.robot.fuzzy_sets;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref(), std::iter::once(law))?;
    let settings =
        Settings { law, guard: arguments.adaptation.unwrap_or(recorded.settings.guard), ..recorded.settings };
    let mut controller = robot.controller(law, settings.guard)?;
    let mut run =
        WhatIfRun::new(&robot.description, &settings, controller.as_mut()).with_context(|| file.to_owned())?;
    let mut torques = Torques::<N>::new(dimensions::number_of_active::<J, N>(0));
    let mut go = |each: &mut dyn FnMut(&Pair<N>)| {
        let mut take = |pair| {
            each(&pair);
            torques.take(&pair);
        };
        recorded.each_window(&mut |source| run.window(source, &mut take))
    };
    match &arguments.csv {
        None => go(&mut |_| {}).with_context(|| file.to_owned())?,
        Some(path) => outputs.write(path, |output| write_csv::<J, N>(go, output)).context("--csv")?,
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

fn print_what_if<const J: usize, const N: usize>(
    what_if: &WhatIfOutcome<N>,
    recorded: &Recorded<J, N>,
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
    let numbers = (0..N).map(dimensions::number_of_active::<J, N>);
    let joints: Vec<_> = numbers.map(|joint| format!("{:>9}", format!("joint {joint}"))).collect();
    writeln!(output, "    torque (N m)       {}", joints.join(" "))?;
    let mut row = |name: &str, torques: [f64; N]| {
        let torques = torques.map(|torque| format!("{torque:>9.5}")).join(" ");
        writeln!(output, "    {name:<18} {torques}")
    };
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
fn write_csv<const J: usize, const N: usize>(
    go: impl FnOnce(&mut dyn FnMut(&Pair<N>)) -> anyhow::Result<()>,
    output: &mut dyn Write,
) -> io::Result<()> {
    let columns = ["recorded", "other"].into_iter().flat_map(|of| {
        (0..N).map(move |index| format!(",torque_{of}_{}_nm", dimensions::number_of_active::<J, N>(index)))
    });
    writeln!(output, "tick,time_s{}", columns.collect::<String>())?;
    let mut written = Ok(());
    let mut write = |pair: &Pair<N>| {
        let torques = pair.recorded.iter().chain(&pair.other).map(|torque| format!(",{torque}"));
        if written.is_ok() {
            written = writeln!(output, "{},{}{}", pair.tick, pair.time, torques.collect::<String>());
        }
    };
    go(&mut write).map_err(io::Error::other)?;
    written
}
