//! The run as it was, every signal compared bit for bit.

use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::{Context, ensure};
use uarm_log::replay::exact::{ExactReplay, ExactRun};

use super::arguments::Arguments;
use super::recorded::Recorded;
use super::report::{Report, print_recording};
use crate::console;
use crate::exit::Exit;

/// Replays the run as it was.
///
/// # Errors
/// If nothing can be replayed, or an option is for another kind of replay.
pub fn exact<const J: usize, const N: usize>(
    arguments: &Arguments,
    recorded: &mut Recorded<J, N>,
    file: &str,
) -> anyhow::Result<ExitCode> {
    ensure!(
        arguments.plot.is_none() && arguments.csv.is_none(),
        "--plot and --csv compare two controllers: name the other one with --controller (or --robot)"
    );
    let begin = recorded.begin(arguments.from).with_context(|| file.to_owned())?;
    let (robot, settings) = (recorded.robot.description.clone(), recorded.settings);
    let mut controller = recorded.robot.controller(settings.law, settings.guard)?;
    let mut run = ExactRun::new(&robot, &settings, controller.as_mut(), begin).with_context(|| file.to_owned())?;
    recorded.each_window(&mut |source| run.window(source)).with_context(|| file.to_owned())?;
    let replay = run.finish().with_context(|| file.to_owned())?;
    if arguments.json {
        console::print_json(&Report {
            file,
            controller: &recorded.name,
            exact: Some(&replay),
            what_if: None,
            part: &recorded.part,
            damage: &recorded.damage,
            clock_steps: &recorded.clock_steps,
        })?;
    } else {
        print_exact(&replay, recorded, file, &mut console::output())?;
    }
    let exit = if !replay.is_equal() || !replay.has_compared() {
        Exit::Failure
    } else if replay.has_loss() || !recorded.damage.is_empty() {
        Exit::Loss
    } else {
        Exit::Ok
    };
    Ok(exit.into())
}

fn print_exact<const J: usize, const N: usize>(
    replay: &ExactReplay,
    recorded: &Recorded<J, N>,
    file: &str,
    output: &mut impl Write,
) -> io::Result<()> {
    let ExactReplay { from, cycles, signals, keyframes, .. } = replay;
    writeln!(output, "replay of {file}: {}, controller {}", recorded.robot.description.name, recorded.name)?;
    if !recorded.part.is_all() {
        writeln!(output, "  {}", recorded.part)?;
    }
    let of_all = match replay.lost_cycles {
        0 => String::new(),
        lost => format!(" of {}", cycles + lost),
    };
    let compared =
        format!("{cycles}{of_all} cycles from {from:.3} s, {signals} signals and {keyframes} keyframes compared");
    if !replay.has_compared() || *cycles == 0 {
        writeln!(output, "  {compared}: NOTHING was compared")?;
    } else if replay.differing_cycles == 0 && replay.lost_cycles > 0 {
        writeln!(output, "  {compared}: these are equal, bit for bit")?;
    } else if replay.differing_cycles == 0 {
        writeln!(output, "  {compared}: all equal, bit for bit")?;
    } else {
        writeln!(output, "  {compared}: DIFFERENT in {} cycles; the first:", replay.differing_cycles)?;
    }
    for difference in &replay.differences {
        writeln!(output, "    {difference}")?;
    }
    if replay.differing_keyframes > 0 {
        write!(output, "  DIFFERENT: the inner state in {} keyframes", replay.differing_keyframes)?;
        match &recorded.other_build {
            Some(build) => writeln!(output, ": the log was written by {build}, whose inner state may be another")?,
            None => writeln!(output)?,
        }
    }
    if let Some(time) = replay.faded_from {
        writeln!(output, "  the end was asked for: torques faded from {time:.3} s on (control.stop_ramp_ms)")?;
    }
    match (&replay.fault, replay.fault_reproduced) {
        (Some(fault), Some(true)) => writeln!(output, "  the fault is the recorded one: {fault}")?,
        (Some(fault), None) => writeln!(output, "  the recording ends with the cycle of this fault: {fault}")?,
        (Some(fault), Some(false)) => {
            writeln!(output, "  DIFFERENT: the replay ends with a fault that was not recorded: {fault}")?
        }
        (None, _) => {}
    }
    let predicted = replay.predicted_cycles - replay.missing_positions;
    if predicted > 0 {
        writeln!(output, "  in {predicted} of these cycles an angle was predicted, as in the run")?;
    }
    if replay.missing_positions > 0 {
        writeln!(
            output,
            "  LOST               positions in {} of these cycles: they were predicted, and gave the torques that are in the file",
            replay.missing_positions
        )?;
    }
    if replay.lost_cycles > 0 {
        writeln!(
            output,
            "  LOST               {} cycles that cannot be compared, since something in them or before them is missing; \
             went on from a keyframe {} times",
            replay.lost_cycles, replay.resumed
        )?;
    }
    if replay.missing_torques > 0 {
        writeln!(output, "  LOST               {} torques that are not in the file", replay.missing_torques)?;
    }
    if replay.ends_within_a_cycle {
        writeln!(
            output,
            "  LOST               the end: the file ends within a cycle, and without a stop of the drives"
        )?;
    }
    print_recording(recorded, output)
}
