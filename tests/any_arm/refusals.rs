//! What is wrong with a robot file, or for a robot of other joints, is told by its field or its option.

use crate::robots::{changed, file, refused};
use crate::support::{scratch, uarm};

#[test]
fn what_the_sensors_do_not_allow_is_refused_by_law() {
    for (law, mode, expected) in [
        ("nonlinear", "measured", "expected omitted or reduced"),
        ("nonlinear", "reduced-momentum", "expected omitted or reduced"),
        ("adaptive", "eliminated", "expected omitted"),
    ] {
        let robot = file("seven-joint");
        let run = ["run", "--virtual-time", "--log", "none", "--robot", robot.to_str().unwrap(), "--controller", law];
        let output = uarm(&[run.as_slice(), &["--base-acceleration", mode]].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(&format!("--base-acceleration {mode} with --controller {law}")), "{message}");
        assert!(message.trim_end().ends_with(expected), "{message}");
    }
}

#[test]
fn lists_of_another_length_are_refused_by_field() {
    let message = refused("any_arm_task", &[("start_deg = [0.0, ", "start_deg = [")], &[]);
    assert!(message.contains("task.start_deg = 6 values: expected 7, one for each active joint"), "{message}");
    let message = refused("any_arm_role", &[("role = \"active\"", "role = \"passive\"")], &[]);
    assert!(message.contains("seven-joint.urdf: 7 joints between base and tip, expected 6"), "{message}");
    let message = refused(
        "any_arm_roles",
        &[("name = \"joint 2\"\nrole = \"active\"", "name = \"joint 2\"\nrole = \"passive\"")],
        &[],
    );
    assert!(
        message.contains("joints[1].role = passive: expected active: only the first joint may be passive"),
        "{message}"
    );
    for (from, to, expected) in [
        (
            "coulomb_friction_nm = [1.0, ",
            "coulomb_friction_nm = [",
            "plant.coulomb_friction_nm = 6 values: expected 7, one for each joint",
        ),
        (
            "viscous_friction_nm_s = [2.0, ",
            "viscous_friction_nm_s = [-2.0, ",
            "plant.viscous_friction_nm_s = -2: expected a finite value >= 0",
        ),
        ("link_scale = 1.05", "link_scale = 0.0", "plant.link_scale = 0: expected"),
        ("torque_gain = 0.98", "torque_gain = 0.0", "plant.torque_gain = 0: expected a finite value > 0"),
        (
            "torque_gain = 0.98",
            "torque_gain = 1.0\ntilt_m_per_s2 = [0.1, 0.0]",
            "plant.tilt_m_per_s2 = [0.1, 0.0]: expected [0, 0]",
        ),
    ] {
        let message = refused("any_arm_plant", &[(from, to)], &[]);
        assert!(message.contains(expected), "{message}");
    }
}

/// What a newcomer tried: each is refused or told in the terms of robots.
#[test]
fn what_no_body_or_drive_has_is_told() {
    let urdf = "tip = \"tool\"\n";
    let with = |inertia: &str| format!("{urdf}spacecraft = {{ mass_kg = 100.0, inertia_kg_m2 = {inertia} }}\n");
    for impossible in
        ["[1.0, 1.0, 3.0, 0.0, 0.0, 0.0]", "[1.0, 1.0, -1.0, 0.0, 0.0, 0.0]", "[1.0, 1.0, 1.0, 2.0, 0.0, 0.0]"]
    {
        let message = refused("any_arm_inertia", &[(urdf, &with(impossible))], &[]);
        assert!(message.contains("model.spacecraft = 100 kg") && message.contains("two others together"), "{message}");
    }
    let heavy = changed("any_arm_inertia", &[(urdf, &with("[10.0, 20.0, 29.0, 0.0, 0.0, 0.0]"))]);
    let checked = uarm(&["check", "--robot", heavy.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&checked.stdout).into_owned();
    // As published: docs/your-own-robot.md.
    assert!(checked.status.success() && text.matches("no body has this inertia").count() == 1, "{text}");

    // 16 bits of 1 048 576 counts per revolution are 22.5 degrees of 340.
    let message = refused("any_arm_counter", &[("counter_bits = 32", "counter_bits = 16")], &[]);
    assert!(message.contains("joints[0].encoder.counter_bits = 16") && message.contains("22.5 deg"), "{message}");

    // A per mille of 100 kN m is 100 N m.
    let coarse = [("rated_torque_nm = 100.0", "rated_torque_nm = 100000.0")];
    let checked = uarm(&["check", "--robot", changed("any_arm_coarse", &coarse).to_str().unwrap()]);
    let text = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(text.contains("less torque than one step of its drive, 100.0000 N m"), "{text}");
    assert_eq!(text.matches("one step of its drive").count(), 1, "{text}");
}

#[test]
fn a_robot_file_of_another_arm_is_mapped_and_refused_in_place_of_the_papers() {
    let of = |name: &str| uarm(&["map", name, "--json"]);
    let toml = of(file("seven-joint").to_str().unwrap());
    let urdf = file("seven-joint").with_extension("urdf");
    let urdf = uarm(&["map", urdf.to_str().unwrap(), "--tip", "tool", "--json"]);
    assert!(toml.status.success(), "{}", String::from_utf8_lossy(&toml.stderr));
    assert_eq!(toml.stdout, urdf.stdout);

    let log = scratch("any_arm_of_the_paper.mcap");
    let _ = std::fs::remove_file(&log);
    let log = log.to_str().unwrap();
    assert!(uarm(&["run", "--virtual-time", "--log", log]).status.success());
    let replayed = uarm(&["replay", log, "--robot", file("seven-joint").to_str().unwrap()]);
    let message = String::from_utf8_lossy(&replayed.stderr).into_owned();
    assert_eq!(replayed.status.code(), Some(1), "{message}");
    let expected =
        "joints = 7 active joints: expected a passive base and 2 active joints, as the robot has whose place it takes";
    assert!(message.contains(expected), "{message}");
}

/// A second arm, and a spacecraft that belongs to no URDF.
#[test]
fn an_arm_is_described_once() {
    let urdf = "urdf = \"seven-joint.urdf\"\ntip = \"tool\"\n";
    let numbers = "base = { inertia_kg_m2 = 1.0, length_m = 1.0 }\n";
    let spacecraft = "spacecraft = { mass_kg = 1.0, inertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0] }\n";
    let message = refused("any_arm_spacecraft", &[(urdf, &format!("{numbers}{spacecraft}"))], &[]);
    assert!(message.contains("model.spacecraft = a table: expected model.urdf beside it"), "{message}");
    let space = "[space_manipulator]\nspacecraft = { mass_kg = 1.0, inertia_kg_m2 = 1.0, centre_of_mass_to_joint_m = 1.0 }\nlinks = []\n";
    let message = refused("any_arm_twice", &[("[task]", &format!("{space}\n[task]"))], &[]);
    assert!(message.contains("model.urdf = a URDF: expected the arm once"), "{message}");
    let light = spacecraft.replace("mass_kg = 1.0", "mass_kg = -1.0");
    let message = refused("any_arm_light", &[(urdf, &format!("{urdf}{light}"))], &[]);
    assert!(message.contains("model.spacecraft = -1 kg"), "{message}");
}

#[test]
fn commands_for_the_papers_robot_alone_say_so() {
    let output = uarm(&["campaign", "--robot", file("seven-joint").to_str().unwrap()]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    let expected = "joints = 7 active joints: expected a passive base and 2 active joints: what was asked for is for the paper's arm alone";
    assert!(message.contains(expected), "{message}");
}
