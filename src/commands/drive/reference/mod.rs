//! `uarm drive reference`: tells the joints with incremental encoders where they are.

mod arguments;
mod homing;
mod joint_reference;
mod pose;
mod procedure;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

pub use arguments::Arguments;

use crate::console;
use crate::reference::store::References;
use crate::robot::on_bus::JointsOnBus;

/// Stores where the joints are.
///
/// # Errors
/// If the robot file, the drives or the operator do not allow it.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let robot = JointsOnBus::load(&arguments.robot)?;
    let references = match arguments.node {
        Some(node) => homing::home(arguments, &robot, node)?,
        None => pose::confirmed(arguments, &robot)?,
    };
    let path = references.write_beside(&arguments.robot)?;
    print(&references, &path, arguments.json)?;
    Ok(ExitCode::SUCCESS)
}

fn print(references: &References, path: &Path, json: bool) -> anyhow::Result<()> {
    let mut output = console::output();
    if json {
        let report = serde_json::json!({ "file": path.to_string_lossy(), "references": references });
        console::print_json(&report)?;
        return Ok(());
    }
    for joint in &references.joints {
        let serial = joint.serial.map_or_else(|| "no serial number".to_owned(), |serial| format!("serial {serial}"));
        writeln!(
            output,
            "{}: {} deg at {} counts{}, node {}, {serial}",
            joint.name,
            joint.angle_deg,
            joint.position_counts,
            joint.how(),
            joint.node
        )?;
    }
    writeln!(output, "stored in {}", path.display())?;
    Ok(())
}
