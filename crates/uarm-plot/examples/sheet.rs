//! Writes a figure with two panels to a new directory below that for temporary files, and prints the file's path.

use uarm_plot::output::{FileFormat, write};
use uarm_plot::sheet::{Axis, Panel, Sheet, legend};
use uarm_plot::style::{BLUE, Dash, Stroke, VERMILION};

/// An oscillator of one radian a second and a damping of 0.2, released at 1: its position and velocity at `time`.
fn oscillator(time: f64) -> [f64; 2] {
    let (damping, frequency) = (0.2_f64, (1.0 - 0.2_f64 * 0.2).sqrt());
    let decay = (-damping * time).exp();
    let (sine, cosine) = (frequency * time).sin_cos();
    [decay * (cosine + damping / frequency * sine), -decay * sine / frequency]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (position_line, velocity_line) = (Stroke::solid(BLUE), Stroke::solid(VERMILION).dashed(Dash::Dashed));
    let times = || (0..=2000).map(|k| 0.01 * f64::from(k));
    let position = Panel::new("Position", Axis::new("Time (s)", 0.0..20.0, 5.0, 0), Axis::new("m", -1.0..1.0, 0.5, 1))
        .with(position_line, times().map(|time| [time, oscillator(time)[0]]));
    let velocity = times().map(|time| [time, oscillator(time)[1]]);
    let velocity_axis = Axis::covering("m/s", velocity.clone().map(|[_, value]| value), 6);
    let velocity =
        Panel::new("Velocity", Axis::new("Time (s)", 0.0..20.0, 5.0, 0), velocity_axis).with(velocity_line, velocity);
    let sheet = Sheet {
        name: "oscillator".into(),
        title: "A damped oscillator".into(),
        note: "damping ratio 0.2".into(),
        size: [1000, 430],
        columns: 2,
        legend: legend(&[("position", position_line), ("velocity", velocity_line)]),
        panels: vec![position, velocity],
    };
    let directory = std::env::temp_dir().join(format!("uarm-plot-{}", std::process::id()));
    std::fs::create_dir_all(&directory)?;
    for file in write(&sheet, &directory, &[FileFormat::Svg])? {
        println!("{}", file.display());
    }
    Ok(())
}
