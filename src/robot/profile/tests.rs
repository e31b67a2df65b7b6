use super::*;
use crate::robot::overrides::Overrides;
use crate::robot::{BUILT_IN, Robot};
use uarm_io::drive::wishes::{Resolution, Setting};
use uarm_io::drive::{Address, Value as Raw};

const DRIVE: &str =
    "drive = { rated_torque_nm = 0.2, writes = [{ index = 0x6007, subindex = 0, type = \"i16\", value = 1 }] }";

/// The built-in robot, its base with another drive and encoder.
fn robot(drive: &str, encoder: &str) -> Result<Robot, String> {
    let text = BUILT_IN.replacen(DRIVE, &format!("drive = {{ rated_torque_nm = 0.2, {drive} }}"), 1).replacen(
        "zero_counts = 0 }",
        &format!("zero_counts = 0{encoder} }}"),
        1,
    );
    Robot::parse(Path::new("robots/test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
}

fn settings(robot: &Robot) -> Vec<Setting> {
    robot.description.joints[0].drive.settings.iter().copied().collect()
}

fn setting(index: u16, subindex: u8, value: Raw) -> Setting {
    Setting::new(Address::new(index, subindex), value)
}

#[test]
fn a_profile_says_what_the_robot_file_does_not() {
    let robot = robot("profile = \"elmo-gold\"", "").unwrap();
    let expected = [
        setting(0x6007, 0, Raw::Integer16(1)),
        // 0.2 N m, and 33739 counts, as the robot file has them.
        setting(0x6076, 0, Raw::Unsigned32(200)),
        setting(0x608F, 1, Raw::Unsigned32(33_739)),
        setting(0x608F, 2, Raw::Unsigned32(1)),
    ];
    assert_eq!(settings(&robot), expected);
    let [used] = robot.profiles.as_slice() else { panic!("{:?}", robot.profiles) };
    assert_eq!(
        used.to_string(),
        "base: profile elmo-gold (Elmo Gold, CANopen): from its dictionary, not tried on hardware"
    );
    assert!(!robot.for_log().unwrap().toml.is_empty());
}

#[test]
fn what_the_robot_file_says_itself_wins() {
    let own = "profile = \"elmo-gold\", writes = [{ index = 0x6007, subindex = 0, type = \"i16\", value = 3 }]";
    let found = settings(&robot(own, "").unwrap());
    let of_6007: Vec<_> = found.iter().filter(|setting| setting.address.index == 0x6007).collect();
    assert_eq!(of_6007, [&setting(0x6007, 0, Raw::Integer16(3))]);
    // Said to be compared: not written.
    let compared = "profile = \"elmo-gold\", target_torque_of = \"rated-torque\"";
    let found = settings(&robot(compared, ", resolution_object = \"608F\"").unwrap());
    assert!(
        found
            .iter()
            .all(|setting| !matches!((setting.address.index, setting.address.subindex), (0x6076, _) | (0x608F, 1)))
    );
    let epos = robot("profile = \"maxon-epos4\", rated_torque_unit = \"uNm\"", "").unwrap();
    assert_eq!(epos.description.joints[0].drive.resolution, Resolution::Stated);
    assert!(settings(&epos).contains(&setting(0x6076, 0, Raw::Unsigned32(200_000))));
    let object = ", resolution_object = { index = 0x3010, subindex = 1, equals = 8192 }";
    let epos = robot("profile = \"maxon-epos4\"", object).unwrap();
    let expected = Resolution::Object { address: Address::new(0x3010, 1), equals: 8192 };
    assert_eq!(epos.description.joints[0].drive.resolution, expected);
}

/// A log holds the completed file: it is read without the profile, which may be another by then.
#[test]
fn a_log_needs_no_profile() {
    let robot = robot("profile = \"elmo-gold\"", "").unwrap();
    let again = Robot::from_log(Path::new("a.mcap"), &robot.for_log().unwrap()).unwrap();
    assert_eq!(settings(&again), settings(&robot));
}

#[test]
fn an_unknown_profile_names_those_that_exist() {
    let message = robot("profile = \"elmo-silver\"", "").unwrap_err();
    assert!(message.contains("joints[0].drive.profile = \"elmo-silver\""), "{message}");
    assert!(message.contains("elmo-gold, maxon-epos4") && message.contains("./my-drive.toml"), "{message}");
}

#[test]
fn a_profile_of_ones_own_is_beside_the_robot_file() {
    // As the robot file is robots/test.toml.
    let own = robot("profile = \"profiles/elmo-gold.toml\"", "").unwrap();
    assert_eq!(settings(&own), settings(&robot("profile = \"elmo-gold\"", "").unwrap()));
    let message = robot("profile = \"./nowhere.toml\"", "").unwrap_err();
    for part in [
        "robots/test.toml: joints[0].drive.profile = \"./nowhere.toml\"",
        "elmo-gold, maxon-epos4",
        "robots/./nowhere.toml: No such file",
    ] {
        assert!(message.contains(part), "{message}: expected {part}");
    }
    let message = robot("profile = \"/dev/zero\"", "").unwrap_err();
    assert!(message.contains("/dev/zero: is a device, expected a file"), "{message}");
}

/// What a profile gave and cannot be is told as the profile's; what the robot file says, under the number that it has there.
#[test]
fn what_is_wrong_is_told_where_it_was_written() {
    let folder = std::env::temp_dir().join(format!("uarm-profile-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("own.toml");
    let head = "schema = 1\ndrives = \"mine\"\nevidence = \"tried\"\n";
    let named = format!("profile = {:?}", path.display().to_string());
    let write = |index: u16, value: i64| format!("{{ index = {index}, subindex = 0, type = \"u8\", value = {value} }}");
    let told = |profile: &str, own: &str| {
        std::fs::write(&path, format!("{head}{profile}")).unwrap();
        robot(&format!("{named}{own}"), "").unwrap_err()
    };
    let place = format!("profile {}: ", path.display());
    let message = told("[drive]\nwatchdog = \"rpdo-timeout\"\nrpdo_timeout_ms = 8\n", "");
    assert!(message.starts_with(&format!("{place}drive.rpdo_timeout_ms = 8: expected at least 9")), "{message}");
    assert!(message.contains("joints[0].drive.profile in robots/test.toml"), "{message}");
    let message = told("[drive]\npdo = { rpdo = 600 }\n", "");
    assert!(message.starts_with(&format!("{place}drive.pdo.rpdo = 600: expected 1 to 512")), "{message}");
    // Its first entry is the robot file's own, so that the second is the only one that it gives.
    let own = format!(", writes = [{}, {}]", write(0x2000, 1), write(0x2002, 2));
    let message = told(&format!("[drive]\nwrites = [{}, {}]\n", write(0x2000, 1), write(0x2001, 300)), &own);
    assert!(message.starts_with(&format!("{place}drive.writes[1].value = 300")), "{message}");
    let own = format!(", writes = [{}, {}]", write(0x2003, 1), write(0x2002, 301));
    let message = told(&format!("[drive]\nwrites = [{}]\n", write(0x2001, 3)), &own);
    assert!(message.starts_with("robots/test.toml: joints[0].drive.writes[1].value = 301"), "{message}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn shipped_profiles_pin_their_maker() {
    for (name, vendor) in [("elmo-gold", 0x9A), ("maxon-epos4", 0xFB)] {
        let found = robot(&format!("profile = \"{name}\""), "").unwrap();
        assert_eq!(found.description.joints[0].drive.identity.vendor, Some(vendor), "{name}");
    }
    let own = robot("profile = \"elmo-gold\", identity = { vendor = 7 }", "").unwrap();
    assert_eq!(own.description.joints[0].drive.identity.vendor, Some(7));
}

#[test]
fn what_is_wrong_in_a_profile_is_named() {
    let refused = |text: &str| Profile::parse(Path::new("own.toml"), text).unwrap_err().to_string();
    let head = "schema = 1\ndrives = \"mine\"\nevidence = \"tried\"\n";
    assert!(Profile::parse(Path::new("own.toml"), head).is_ok());
    assert!(refused(&head.replace('1', "2")).contains("own.toml: schema = 2: expected 1"));
    let message = refused(&format!("{head}[drive]\nrated_torque_nm = 1.0\n"));
    assert!(message.contains("own.toml: drive.rated_torque_nm"), "{message}");
    let write = "[drive]\nwrites = [{ index = 1, subindex = 0, type = \"u8\", value = \"torque\" }]\n";
    let message = refused(&format!("{head}{write}"));
    assert!(message.contains("\"rated-torque\" or \"counts-per-revolution\""), "{message}");
}
