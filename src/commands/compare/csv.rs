//! Studies for other programs: one row an experiment, numbers that read back as the same bits.

use std::io::{self, Write};

use super::comparison::{Comparison, Failure};
use super::draws::{DrawnPlant, Draws};
use super::monte_carlo::MonteCarlo;

/// Writes the experiments of a comparison; of one that did not come to its end, why.
///
/// # Errors
/// If the output cannot be written.
pub fn write_comparison(comparison: &Comparison, output: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let all = 1..=comparison.joints;
    let active = comparison.active_numbers();
    write!(output, "controller,origin,experiment")?;
    all.clone().try_for_each(|joint| write!(output, ",start_offset_{joint}_deg"))?;
    write!(output, ",l2,e_nms")?;
    active.clone().try_for_each(|joint| write!(output, ",peak_torque_{joint}_nm"))?;
    active.clone().try_for_each(|joint| write!(output, ",final_error_{joint}_deg"))?;
    writeln!(output, ",base_drift_deg,failure")?;
    for row in &comparison.controllers {
        for experiment in &row.experiments {
            write!(output, "{},{},{}", row.controller, row.origin.label(), experiment.experiment)?;
            write_numbers(output, &experiment.start_offset_deg)?;
            write_numbers(output, &[experiment.l2, experiment.e])?;
            write_numbers(output, &experiment.peak_torque_nm)?;
            write_numbers(output, &experiment.final_error_deg)?;
            match experiment.base_drift_deg {
                Some(drift) => writeln!(output, ",{drift},")?,
                None => writeln!(output, ",,")?,
            }
        }
    }
    for Failure { controller, origin, experiment, reason } in &comparison.failures {
        // Offsets, L2 and E, torques and errors, the base's drift.
        let empty = ",".repeat(all.clone().count() + 2 + 2 * active.clone().count() + 1);
        writeln!(output, "{controller},{},{experiment}{empty},{}", origin.label(), quoted(reason))?;
    }
    Ok(())
}

/// A text as a field, with its commas and quotation marks.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// Writes the draws of a Monte Carlo study, one row for each controller: the plant, where it started, L2 and E. These two
/// are empty where the experiment did not come to its end; the last column says why.
///
/// # Errors
/// If the output cannot be written.
pub fn write_monte_carlo(study: &MonteCarlo, draws: &Draws, output: &mut (impl Write + ?Sized)) -> io::Result<()> {
    writeln!(
        output,
        "draw,controller,origin,l2,e_nms,viscous_friction_1_nm_s,viscous_friction_2_nm_s,viscous_friction_3_nm_s,\
         coulomb_friction_1_nm,coulomb_friction_2_nm,coulomb_friction_3_nm,base_inertia_scale,link_scale,torque_gain,\
         tilt_x_m_per_s2,tilt_y_m_per_s2,start_offset_1_deg,start_offset_2_deg,start_offset_3_deg,failure"
    )?;
    for draw in &draws.results {
        let DrawnPlant { viscous_friction, coulomb_friction, base_inertia_scale, link_inertia_scale, gain, tilt } =
            draw.plant;
        for (row, indices) in study.controllers.iter().zip(&draw.indices) {
            write!(output, "{},{},{}", draw.draw, row.controller, row.origin.label())?;
            match indices {
                Ok(indices) => write_numbers(output, &[indices.l2, indices.e])?,
                Err(_) => write!(output, ",,")?,
            }
            write_numbers(output, &viscous_friction)?;
            write_numbers(output, &coulomb_friction)?;
            write_numbers(output, &[base_inertia_scale, link_inertia_scale, gain])?;
            write_numbers(output, &tilt)?;
            write_numbers(output, &draw.start_offset.map(f64::to_degrees))?;
            writeln!(output, ",{}", indices.as_ref().err().map_or_else(String::new, |reason| quoted(reason)))?;
        }
    }
    Ok(())
}

fn write_numbers(output: &mut (impl Write + ?Sized), numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|number| write!(output, ",{number}"))
}
