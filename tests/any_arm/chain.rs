//! Robots of any number of joints: equal links in a row on a satellite.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What holds the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// Its attitude is measured; all axes are parallel.
    Encoder,
    /// Nothing is known of it; every second axis is across.
    NoSensor,
}

/// Writes the URDF and the robot file of `links` links into `folder`, and gives the robot file.
pub fn write(folder: &Path, links: usize, base: Base) -> PathBuf {
    let file = folder.join(format!("chain-{links}-{base:?}.toml"));
    std::fs::write(file.with_extension("urdf"), urdf(links, base)).unwrap();
    std::fs::write(&file, robot(&file.with_extension("urdf"), links, base)).unwrap();
    file
}

fn urdf(links: usize, base: Base) -> String {
    let mut text = "<robot name=\"chain\">\n<link name=\"link_0\"><inertial><mass value=\"100\"/>\
        <inertia ixx=\"10\" ixy=\"0\" ixz=\"0\" iyy=\"10\" iyz=\"0\" izz=\"10\"/></inertial></link>\n"
        .to_owned();
    for link in 1..=links {
        let axis = if base == Base::NoSensor && link % 2 == 0 { "0 1 0" } else { "0 0 1" };
        writeln!(
            text,
            "<link name=\"link_{link}\"><inertial><origin xyz=\"0.15 0 0\"/><mass value=\"2\"/>\
             <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.03\" iyz=\"0\" izz=\"0.03\"/></inertial></link>\n\
             <joint name=\"joint_{link}\" type=\"continuous\"><parent link=\"link_{}\"/><child link=\"link_{link}\"/>\
             <origin xyz=\"0.3 0 0\"/><axis xyz=\"{axis}\"/></joint>",
            link - 1
        )
        .unwrap();
    }
    text + "</robot>\n"
}

fn robot(urdf: &Path, links: usize, base: Base) -> String {
    let [start, end] = [10.0, 12.0].map(|angle| vec![angle; links]);
    let mut text = format!(
        "schema = 1\nname = \"chain\"\n[model]\nurdf = {urdf:?}\ntip = \"link_{links}\"\n\
         [task]\nstart_deg = {start:?}\nend_deg = {end:?}\nduration_s = 1.0\nhold_s = 0.1\nstart_tolerance_deg = 2.0\n\
         [control]\nperiod_us = 5000\ntracking_error_limit_deg = 10.0\n\
         [estimator]\nkind = \"low-pass\"\ncutoff_rad_per_s = 800.0\n[supervision]\nmode = \"on\"\n\
         [bus]\nbitrate_hz = 1000000\ncontroller_heartbeat_ms = 10\ncontroller_timeout_ms = 50\ndrive_heartbeat_ms = 100\n\
         drive_timeout_ms = 400\nsdo_timeout_ms = 500\n"
    );
    let first_active = usize::from(base == Base::Encoder);
    for joint in 0..links + first_active {
        let (role, torque) = if joint < first_active { ("passive", 0.0) } else { ("active", 5.0) };
        write!(
            text,
            "[[joints]]\nname = \"joint {node}\"\nrole = \"{role}\"\nnode = {node}\n\
             encoder = {{ counts_per_revolution = 1048576, counter_bits = 32, direction = \"positive\", zero_counts = 0 }}\n\
             drive = {{ rated_torque_nm = 5.0, writes = [{{ index = 0x6007, subindex = 0, type = \"i16\", value = 1 }}] }}\n\
             limits = {{ torque_nm = {torque:?}, torque_rate_nm_per_s = {:?}, velocity_deg_per_s = 360.0, minimum_deg = -170.0, \
             maximum_deg = 170.0, brake_ms = 0 }}\n",
            100.0 * torque,
            node = joint + 1,
        )
        .unwrap();
    }
    text
}
