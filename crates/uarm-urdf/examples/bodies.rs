//! Lists the bodies and joints of a URDF.

use std::error::Error;
use uarm_urdf::{Arm, Selection};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("usage: bodies FILE.urdf")?;
    let arm = Arm::parse(&std::fs::read_to_string(file)?, &Selection::default())?;
    println!("{}: {:.3} kg", arm.spacecraft.name, arm.spacecraft.body.mass);
    for (joint, link) in arm.joints.iter().zip(&arm.links) {
        println!("  {} ({:?}) -> {}: {:.3} kg", joint.name, joint.motion, link.name, link.body.mass);
    }
    Ok(())
}
