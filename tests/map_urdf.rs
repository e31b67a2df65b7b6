//! `uarm map` of a URDF: what it prints, what it writes, what it refuses.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const URDF: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/urdf/three_joints.urdf");

fn map(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uarm")).arg("map").args(arguments).output().unwrap()
}

fn standard_output(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("map-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Masses 100, 10, 21 and 10 kg of 141: eq. 1 by hand, along z.
#[test]
fn a_urdf_becomes_its_equivalent() {
    let json: Value = serde_json::from_str(&standard_output(&map(&[URDF, "--tip", "tool", "--json"]))).unwrap();
    assert_eq!(json["total_mass_kg"], 141.0);
    assert_eq!(json["locked_joints"], serde_json::json!(["camera_pan"]));
    let space = json["space_manipulator"].as_array().unwrap();
    assert_eq!(space[0]["merged"], serde_json::json!(["mount"]));
    assert_eq!((space.len(), space[2]["mass_kg"].as_f64()), (4, Some(21.0)));
    let dem = json["dynamically_equivalent"].as_array().unwrap();
    assert_eq!(dem[0]["mass_kg"], Value::Null);
    let number = |row: usize, field: &str, index: usize| dem[row][field][index].as_f64().unwrap();
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    close(dem[1]["mass_kg"].as_f64().unwrap(), 141.0 * 141.0 * 10.0 / (100.0 * 110.0));
    // The spacecraft's centre of mass is 0.2 above the bus, its joint 0.8.
    close(number(0, "length_m", 2), 0.6 * 100.0 / 141.0);
    close(number(1, "centre_of_mass_m", 2), 0.1 * 100.0 / 141.0);
    close(number(1, "length_m", 2), (0.1 * 110.0 + 0.1 * 100.0) / 141.0);
    assert_eq!(json["joints"][1]["limits"]["lower"], -2.0);
    assert_eq!(json["joints"][2]["limits"], Value::Null);

    let text = standard_output(&map(&[URDF, "--tip", "tool"]));
    for expected in [
        "three joints: 3 joints, 141.000000 kg",
        "joint yaw: revolute, axis 0.000000 0.000000 1.000000, -3 to 3; 20 at most 0.5/s",
        "joint elbow: revolute, axis 1.000000 0.000000 0.000000, no limits in the file: they come from the robot file",
        "joint camera_pan: beside the arm, taken as fixed at zero",
        "bus with mount: mass free",
    ] {
        assert!(text.contains(expected), "no {expected:?} in\n{text}");
    }
}

#[test]
fn what_is_written_is_read_again() {
    let folder = folder("written");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (urdf, dem, mjcf) = (file("space.urdf"), file("dem.urdf"), file("dem.xml"));
    let write = [URDF, "--tip", "tool", "--json", "--urdf", &urdf, "--dem-urdf", &dem, "--dem-mjcf", &mjcf];
    let first: Value = serde_json::from_str(&standard_output(&map(&write))).unwrap();
    let again: Value = serde_json::from_str(&standard_output(&map(&[&urdf, "--json"]))).unwrap();
    let numbers = |json: &Value, table: &str| -> Vec<f64> {
        let rows = json[table].as_array().unwrap();
        let fields = ["inertia_kg_m2", "centre_of_mass_m", "length_m"];
        rows.iter()
            .flat_map(|row| fields.map(|field| row[field].clone()))
            .flat_map(|list| list.as_array().unwrap().clone())
            .map(|number| number.as_f64().unwrap())
            .collect()
    };
    for table in ["space_manipulator", "dynamically_equivalent"] {
        let (before, after) = (numbers(&first, table), numbers(&again, table));
        assert_eq!(before.len(), after.len());
        assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1e-12), "{table}: {before:?} {after:?}");
    }
    assert!(std::fs::read_to_string(&mjcf).unwrap().contains(r#"<joint name="base" type="ball"/>"#));
    let twice = map(&write);
    assert_eq!(twice.status.code(), Some(1), "files are not replaced");
    assert!(standard_output(&map(&[&write[..], &["--force"]].concat())).contains("three joints"));
}

/// The robots with published parameters: how many joints, and what they weigh by the numbers of their sources.
#[test]
fn the_published_robots_are_read() {
    let satellite = 2_552.0 + 3.0 + 35.01 + 22.45 + 21.89 + 16.54 + 26.0 + 18.49;
    let benchmark = 1_000.0 + 3.0 + 35.01 + 30.0 + 22.69 + 21.38 + 16.75 + 26.17 + 18.07;
    for (file, tip, joints, mass) in [
        ("ets-vii.urdf", "tool", 6, satellite),
        ("ets-vii.urdf", "forearm", 3, satellite),
        ("seven-joint.urdf", "tool", 7, benchmark),
        ("planar-four-link.urdf", "tool", 3, 64.859 + 2.913 + 2.646 + 1.699),
    ] {
        let path = format!("{}/robots/{file}", env!("CARGO_MANIFEST_DIR"));
        let json: Value = serde_json::from_str(&standard_output(&map(&[&path, "--tip", tip, "--json"]))).unwrap();
        assert_eq!(json["joints"].as_array().unwrap().len(), joints, "{file}");
        assert!((json["total_mass_kg"].as_f64().unwrap() - mass).abs() < 1e-9, "{file}");
    }
}

/// The paper's arm is written as one in the plane.
#[test]
fn a_robot_file_is_written_too() {
    let folder = folder("planar");
    let (space, dem) = (folder.join("space.xml"), folder.join("dem.xml"));
    standard_output(&map(&["--mjcf", space.to_str().unwrap(), "--dem-mjcf", dem.to_str().unwrap()]));
    let (space, dem) = (std::fs::read_to_string(space).unwrap(), std::fs::read_to_string(dem).unwrap());
    assert!(space.contains("<freejoint") && space.contains(r#"mass="4.816""#), "{space}");
    assert!(dem.contains(r#"<joint name="base" type="hinge" axis="0 0 1"/>"#), "{dem}");
}

#[test]
fn what_is_wrong_is_named_with_the_option_that_helps() {
    let cases: [(&[&str], i32, &str); 9] = [
        (&[URDF], 1, "the arm ends in \"camera\", \"tool\", expected one to be named as its tip (--tip LINK names it)"),
        (&[URDF, "--tip", "hand"], 1, "no link \"hand\""),
        (&[URDF, "--tip", "tool", "--base", "tool"], 1, "link \"tool\" is not outboard of link \"tool\""),
        (&[URDF, "--tip", "tool", "--base-mass", "5"], 2, "--base-inertia"),
        (&[URDF, "--tip", "tool", "--base-mass", "-5", "--base-inertia", "1,1,1"], 1, "expected a mass above 0"),
        (&[URDF, "--tip", "tool", "--base-mass", "5", "--base-inertia", "1,2"], 2, "three or six numbers"),
        (&["--tip", "tool"], 1, "--tip is for a URDF, and this is none"),
        (&[URDF, "--tip", "tool", "--urdf", URDF, "--force"], 1, "it is the input"),
        (&[URDF, "--tip", "tool", "--urdf", "-"], 1, "-: expected a file's name (/dev/stdout is standard output"),
    ];
    for (arguments, code, expected) in cases {
        let output = map(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(message.contains(expected), "{arguments:?}: {message}");
    }
    let folder = folder("wrong");
    let file = folder.join("arm.urdf");
    let text = std::fs::read_to_string(URDF).unwrap();
    std::fs::write(&file, text.replace(r#"<mass value="20"/>"#, r#"<mass value="heavy"/>"#)).unwrap();
    let output = map(&[file.to_str().unwrap(), "--tip", "tool"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message.contains("arm.urdf: line 17: upper_arm: mass value = \"heavy\", expected a number of at most 1e12"),
        "{message}"
    );
}

/// What of a file is strange but can be computed is said, and what a hint can mend gets one.
#[test]
fn what_is_strange_is_told() {
    let folder = folder("strange");
    let file = folder.join("arm.urdf");
    let run = |text: &str| {
        std::fs::write(&file, text).unwrap();
        map(&[file.to_str().unwrap(), "--tip", "tool"])
    };
    let text = std::fs::read_to_string(URDF).unwrap();
    let refused = |text: &str| String::from_utf8(run(text).stderr).unwrap();
    assert!(refused("").contains("arm.urdf: not XML: "), "an empty file");

    let joint = r#"<joint name="bus_to_mount" type="fixed">"#;
    assert!(text.contains(joint), "the base's joint in {URDF}");
    let floating = format!(
        r#"<link name="world"/><joint name="orbit" type="floating"><parent link="world"/><child link="bus"/></joint>{joint}"#
    );
    let message = refused(&text.replace(joint, &floating));
    assert!(message.contains("joint \"orbit\" is floating") && message.contains("(--base \"bus\" if"), "{message}");

    let strange = text.replacen("type=\"revolute\"", "type=\"prismatic\"", 1).replacen("ixx=\"0.1\"", "ixx=\"9\"", 1);
    let printed = standard_output(&run(&strange));
    for expected in ["no body has this inertia", "a prismatic joint moves the equivalent's link by a part"] {
        assert!(printed.contains(expected), "no {expected:?} in\n{printed}");
    }
    let named = text.replace("\"elbow\"", "\"elbow&#10;joint yaw: fake\"");
    assert!(
        standard_output(&run(&named)).contains("joint elbow\\njoint yaw: fake: revolute"),
        "a name with a line end"
    );
    let unlimited = text.replace(r#"lower="-3" upper="3""#, "");
    assert_ne!(unlimited, text);
    assert!(standard_output(&run(&unlimited)).contains("no range; 20 at most 0.5/s"), "limits without a range");
    let printed = standard_output(&run(&text));
    assert!(!printed.contains("no body has this inertia") && !printed.contains("prismatic"), "{printed}");
}

/// Table 1 in a URDF gives what Table 1 in the robot file does; the numbers of Table 2 alone are no space manipulator.
#[test]
fn a_robot_file_with_a_urdf_is_mapped_and_one_with_a_model_alone_is_not() {
    let folder = folder("robot-files");
    std::fs::write(folder.join("arm.urdf"), include_str!("urdf/table-1.urdf")).unwrap();
    let file = folder.join("robot.toml");
    std::fs::write(&file, "[model]\nurdf = \"arm.urdf\"\n").unwrap();
    assert_eq!(standard_output(&map(&[file.to_str().unwrap()])), standard_output(&map(&[])));
    std::fs::write(&file, "[model]\nlinks = []\n").unwrap();
    let output = map(&[file.to_str().unwrap()]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("robot.toml: no [space_manipulator], and no [model] with a urdf"), "{message}");
}
