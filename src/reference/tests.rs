use super::*;
use crate::robot::BUILT_IN;
use crate::robot::file::ObjectType;
use crate::robot::overrides::Overrides;
use store::JointReference;
use uarm_io::drive::Value;
use uarm_io::drive::cia402::{PowerState, Statusword};
use uarm_io::encoder::Direction;

/// The paper's robot, joint 2 with an incremental encoder. 33 739 counts per revolution; limits of -170 to 170 degrees.
fn robot(keys: &str) -> Robot {
    let joint_2 = "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0";
    assert!(BUILT_IN.contains(joint_2));
    let text = BUILT_IN.replace(joint_2, &format!("{joint_2}, reference = \"incremental\", {keys}"));
    Robot::parse(Path::new("robot.toml"), &text, &Overrides::default()).unwrap()
}

const MARKED: &str = "power_marker = { index = 0x6081, subindex = 0, type = \"u32\", value = 77 }";

/// Joint 2 at 20 degrees, where its counter showed 2000: zero is at 2000 - 1874 counts (33 739 / 18 = 1874.4).
fn reference(robot: &Robot) -> References {
    References::new(vec![JointReference {
        name: "joint 2".to_owned(),
        node: 2,
        date: "2026-01-01T00:00:00Z".to_owned(),
        angle_deg: 20.0,
        position_counts: 2_000,
        homing_method: None,
        zero_counts: 126,
        counts_per_revolution: 33_739,
        gear_ratio: None,
        direction: Direction::Positive,
        window_deg: [-170.0, 170.0],
        vendor: Some(1),
        product: Some(2),
        serial: Some(3),
        power_marker: robot.file.joints[1].encoder.power_marker.clone(),
    }])
}

fn shown() -> Shown {
    Shown {
        vendor: Some(1),
        product: Some(2),
        serial: Some(3),
        statusword: Statusword::of(PowerState::SwitchOnDisabled),
        position: 2_000,
        marker: Some(Value::Unsigned32(77)),
    }
}

fn refusal(robot: Robot, reference: &References, shown: Shown) -> String {
    format!("{:#}", referenced(robot, Path::new("robot.toml"), reference, &[(1, shown)]).unwrap_err())
}

#[test]
fn a_reference_that_holds_becomes_the_zero_of_its_joint_alone() {
    let robot = robot(MARKED);
    let reference = reference(&robot);
    let (robot, lines) = referenced(robot, Path::new("robot.toml"), &reference, &[(1, shown())]).unwrap();
    assert_eq!(robot.description.joints.each_ref().map(|joint| joint.encoder.zero), [0, 126, 0]);
    // The log's robot file says so too: a replay reads its counts with it.
    assert!(robot.for_log().unwrap().toml.contains("zero_counts = 126"));
    assert!(
        lines[0].contains("joint 2: reference of 2026-01-01") && lines[0].contains("now at 20.00 deg"),
        "{lines:?}"
    );
}

#[test]
fn a_drive_that_lost_its_power_is_refused() {
    let robot = robot(MARKED);
    let lost = Shown { marker: Some(Value::Unsigned32(1_000)), ..shown() };
    let message = refusal(robot.clone(), &reference(&robot), lost);
    assert!(message.contains("joint 2 (node 2)") && message.contains("has lost its power"), "{message}");
}

#[test]
fn a_drive_whose_own_bit_says_unreferenced_is_refused() {
    let robot = robot("referenced_bit = 15");
    let bit = |position: i32| Shown { position, marker: None, ..shown() };
    let message = refusal(robot.clone(), &reference(&robot), bit(2_000));
    assert!(message.contains("says that it is not referenced: bit 15"), "{message}");
    let set = Shown { statusword: Statusword::of(PowerState::SwitchOnDisabled).with(1 << 15), ..bit(2_000) };
    assert!(referenced(robot.clone(), Path::new("robot.toml"), &reference(&robot), &[(1, set)]).is_ok());
}

#[test]
fn another_drive_another_scale_or_an_impossible_angle_is_refused() {
    let robot = robot(MARKED);
    let reference = reference(&robot);
    let message = refusal(robot.clone(), &reference, Shown { serial: Some(4), ..shown() });
    assert!(message.contains("was referenced as 1, 2, 3, and is 1, 2, 4"), "{message}");
    // 180 degrees are 16 869.5 counts.
    let message = refusal(robot.clone(), &reference, Shown { position: 126 + 16_870, ..shown() });
    assert!(message.contains("outside of -170 to 170 deg"), "{message}");
    let mut changed = robot;
    let mut geared = changed.clone();
    geared.file.joints[1].gear_ratio = Some([50, 1]);
    let message = refusal(geared, &reference, shown());
    assert!(message.contains("gear_ratio was none when it was referenced, and is [50, 1]"), "{message}");
    changed.file.joints[1].encoder.counts_per_revolution = 8_000;
    let message = refusal(changed, &reference, shown());
    assert!(message.contains("counts_per_revolution was 33739 when it was referenced, and is 8000"), "{message}");
}

#[test]
fn a_counter_that_wraps_keeps_its_angle() {
    let robot = robot(MARKED);
    let mut reference = reference(&robot);
    // The counter is about to wrap at the top; 100 counts further it has.
    reference.joints[0].zero_counts = i32::MAX - 50;
    let wrapped = Shown { position: i32::MIN + 49, ..shown() };
    let (_, lines) = referenced(robot, Path::new("robot.toml"), &reference, &[(1, wrapped)]).unwrap();
    // 100 counts of 33 739 are 1.07 degrees.
    assert!(lines[0].contains("now at 1.07 deg"), "{lines:?}");
}

#[test]
fn a_joint_without_a_reference_is_named() {
    let robot = robot(MARKED);
    let message = refusal(robot, &References::new(Vec::new()), shown());
    assert!(message.contains("joint 2 (node 2) is not referenced in robot.reference.toml"), "{message}");
}

#[test]
fn the_file_is_read_as_it_was_written_and_stands_beside_the_robot_file() {
    let folder = std::env::temp_dir().join(format!("uarm-reference-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("my-robot.toml");
    assert_eq!(References::read_beside(&file).unwrap(), None);
    let references = reference(&robot(MARKED));
    assert_eq!(references.write_beside(&file).unwrap(), folder.join("my-robot.reference.toml"));
    assert_eq!(References::read_beside(&file).unwrap(), Some(references));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "nothing is left beside it");
    std::fs::write(References::path(&file), "schema = 2\njoints = []\n").unwrap();
    assert!(format!("{:#}", References::read_beside(&file).unwrap_err()).contains("expected 1"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn markers_have_the_types_of_the_object_dictionary() {
    let marker = robot(MARKED).file.joints[1].encoder.power_marker.clone().unwrap();
    assert_eq!((marker.kind, marker.as_value()), (ObjectType::U32, Some(Value::Unsigned32(77))));
    assert_eq!(marker.kind.data_type(), Value::Unsigned32(77).data_type());
}
