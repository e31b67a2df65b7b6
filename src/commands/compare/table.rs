//! Studies for people: tables on a terminal.

use std::io::{self, Write};

use super::comparison::{Comparison, ControllerRow, Failure, LeftOut};
use super::monte_carlo::{MonteCarlo, MonteCarloRow};
use super::statistics::{Quantiles, Summary};
use super::variant::Origin;
use crate::robot::fuzzy_sets::described;
use crate::study::start::StartVariation;
use uarm_loop::outcome::Indices;

/// Width of the controllers' names.
const NAME: usize = 26;

/// Prints a comparison.
///
/// # Errors
/// If the output cannot be written.
pub fn print_comparison(comparison: &Comparison, output: &mut impl Write) -> io::Result<()> {
    let Comparison { robot, plant, repetitions, seed, .. } = comparison;
    let variation = describe(comparison.variation);
    writeln!(
        output,
        "{robot} on {plant}: {} with each controller, seed {seed}, {variation}",
        experiments(*repetitions)
    )?;
    print_index(comparison, output, "L2 of the tracking error", |row| row.l2, |indices| indices.l2)?;
    print_index(comparison, output, "E, the summed torque (N m s)", |row| row.e, |indices| indices.e)?;
    print_motion(comparison, output)?;
    print_failures(comparison, output)?;
    print_left_out(&comparison.left_out, output)?;
    print_sets(comparison.fuzzy_sets_crc32, output)?;
    print_caveat(comparison.caveat, output)
}

fn describe(variation: StartVariation) -> &'static str {
    match variation {
        StartVariation::None => "all of them the same",
        StartVariation::EncoderPhase => "each with another encoder phase",
        StartVariation::Full => "each with another encoder phase and start",
    }
}

fn print_index(
    comparison: &Comparison,
    output: &mut impl Write,
    title: &str,
    summary: fn(&ControllerRow) -> Summary,
    index: fn(&Indices) -> f64,
) -> io::Result<()> {
    writeln!(output, "\n{title}")?;
    let is_the_papers = comparison.controllers.iter().any(|row| row.paper.is_some());
    let heads = ["mean", "std dev", "min", "max", "Table 4", "ratio"];
    let heads: String = heads.iter().take(if is_the_papers { 6 } else { 4 }).map(|head| format!("{head:>9}")).collect();
    writeln!(output, "  {:<NAME$}{heads}", "controller")?;
    for row in &comparison.controllers {
        let Summary { mean, deviation, minimum, maximum } = summary(row);
        let deviation = deviation.map_or_else(|| "-".to_owned(), |deviation| format!("{deviation:.5}"));
        let paper = match (&row.paper, &row.ratio) {
            (Some(paper), Some(ratio)) => format!("{:>9.4}{:>9.2}", index(paper), index(ratio)),
            _ if is_the_papers => format!("{:>9}{:>9}   {}", "-", "-", row.origin.label()),
            _ => format!("   {}", row.origin.label()),
        };
        writeln!(output, "  {:<NAME$}{mean:>9.4}{deviation:>9}{minimum:>9.4}{maximum:>9.4}{paper}", row.controller)?;
    }
    Ok(())
}

fn experiments(number: impl TryInto<u64>) -> String {
    match number.try_into() {
        Ok(1) => "1 experiment".to_owned(),
        Ok(number) => format!("{number} experiments"),
        Err(_) => "experiments".to_owned(),
    }
}

/// Failures that are listed; all are counted, and are in JSON and CSV.
const MOST_FAILURES: usize = 20;

fn print_failures(comparison: &Comparison, output: &mut impl Write) -> io::Result<()> {
    let failures = &comparison.failures;
    if failures.is_empty() {
        return Ok(());
    }
    writeln!(output, "\n{} did not come to the end, not in the numbers above", experiments(failures.len()))?;
    for Failure { controller, experiment, reason, .. } in failures.iter().take(MOST_FAILURES) {
        writeln!(output, "  {controller}, experiment {experiment}: {reason}")?;
    }
    let more = failures.len().saturating_sub(MOST_FAILURES);
    if more > 0 { writeln!(output, "  and {more} more") } else { Ok(()) }
}

fn print_left_out(left_out: &[LeftOut], output: &mut impl Write) -> io::Result<()> {
    let Some(LeftOut { reason, .. }) = left_out.first() else { return Ok(()) };
    let names: Vec<_> = left_out.iter().map(|each| each.controller).collect();
    writeln!(output, "\nLeft out: {}: {reason}", names.join(", "))
}

/// So many joints have columns of their own; of more the worst is printed, and all are in JSON and CSV.
const MOST_COLUMNS: usize = 3;

fn print_motion(comparison: &Comparison, output: &mut impl Write) -> io::Result<()> {
    let columns: Vec<String> = if comparison.active_joints <= MOST_COLUMNS {
        comparison.active_numbers().map(|joint| format!("joint {joint}")).collect()
    } else {
        vec!["largest".to_owned()]
    };
    let cells = |values: &[Summary]| -> Vec<f64> {
        let means = values.iter().map(|summary| summary.mean);
        if values.len() <= MOST_COLUMNS { means.collect() } else { vec![means.fold(f64::NAN, f64::max)] }
    };
    let heads = |width: usize| columns.iter().map(|head| format!("{head:>width$}")).collect::<String>();
    // A title over one column is wider than it.
    let (torque, error) = ((columns.len() * 9).max(18), (columns.len() * 10).max(20));
    writeln!(output, "\nMotion, means of the experiments")?;
    let base = if comparison.has_base() { format!("{:>13}", "base drift") } else { String::new() };
    writeln!(output, "  {:<NAME$}{:>torque$}{:>error$}{base}", "", "peak torque (N m)", "final error (deg)")?;
    let base = if comparison.has_base() { format!("{:>13}", "(deg)") } else { String::new() };
    writeln!(output, "  {:<NAME$}{:>torque$}{:>error$}{base}", "controller", heads(9), heads(10))?;
    for row in &comparison.controllers {
        let torques: String = cells(&row.peak_torque_nm).iter().map(|value| format!("{value:>9.4}")).collect();
        let errors: String = cells(&row.final_error_deg).iter().map(|value| format!("{value:>10.3}")).collect();
        let drift = row.base_drift_deg.map_or_else(String::new, |drift| format!("{:>13.2}", drift.mean));
        writeln!(output, "  {:<NAME$}{torques:>torque$}{errors:>error$}{drift}", row.controller)?;
    }
    Ok(())
}

/// Prints a Monte Carlo study.
///
/// # Errors
/// If the output cannot be written.
pub fn print_monte_carlo(study: &MonteCarlo, output: &mut impl Write) -> io::Result<()> {
    let MonteCarlo { robot, draws, drawn, spread, seed, integration_step_us, .. } = study;
    let part = if usize::try_from(*draws) == Ok(*drawn) { String::new() } else { format!("{drawn} of ") };
    let (percent, variation) = (spread * 100.0, describe(study.variation));
    writeln!(
        output,
        "{robot}, {part}{draws} times, each parameter of the plant within {percent} % of the robot file's, seed {seed},\n\
         {variation}; the same {draws} robots for each controller; integrated by {integration_step_us} us"
    )?;
    print_quantiles(study, output, "L2 of the tracking error", |row| row.l2)?;
    print_quantiles(study, output, "E, the summed torque (N m s)", |row| row.e)?;
    writeln!(output, "\nRank in L2, and experiments that the robot's limits ended")?;
    writeln!(output, "  {:<NAME$}{:>9}{:>9}{:>9}", "controller", "best", "worst", "ended")?;
    for row in &study.controllers {
        let MonteCarloRow { controller, best_l2, worst_l2, failed, .. } = row;
        writeln!(output, "  {controller:<NAME$}{best_l2:>9}{worst_l2:>9}{failed:>9}")?;
    }
    print_sets(study.fuzzy_sets_crc32, output)?;
    print_caveat(study.caveat.as_deref(), output)
}

fn print_quantiles(
    study: &MonteCarlo,
    output: &mut impl Write,
    title: &str,
    quantiles: fn(&MonteCarloRow) -> Option<Quantiles>,
) -> io::Result<()> {
    writeln!(output, "\n{title}")?;
    let heads = ["5 %", "25 %", "median", "75 %", "95 %"].map(|head| format!("{head:>9}")).concat();
    writeln!(output, "  {:<NAME$}{heads}", "controller")?;
    for row in &study.controllers {
        let cells = match quantiles(row) {
            Some(quantiles) => quantiles.as_array().map(|value| format!("{value:>9.4}")).concat(),
            None => format!("{:>9}", "-").repeat(5),
        };
        let origin = if row.origin == Origin::Paper { "" } else { row.origin.label() };
        writeln!(output, "{}", format!("  {:<NAME$}{cells}   {origin}", row.controller).trim_end())?;
    }
    Ok(())
}

fn print_sets(crc32: Option<u32>, output: &mut impl Write) -> io::Result<()> {
    crc32.map_or(Ok(()), |crc32| writeln!(output, "\n{}", described(crc32)))
}

fn print_caveat(caveat: Option<&str>, output: &mut impl Write) -> io::Result<()> {
    caveat.map_or(Ok(()), |caveat| writeln!(output, "\n{caveat}"))
}
