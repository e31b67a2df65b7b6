//! `uarm drive check --eds`: the right verdict for each trait of makers' dictionaries, and an entry for the robot file that works
//! as printed.

mod dictionaries;
mod support;

use dictionaries::Dictionary;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use support::{scratch, text, uarm};

const WORKS: i32 = 0;
const CANNOT: i32 = 1;
const WORKS_WITH: i32 = 3;

fn file(name: &str, contents: &str) -> PathBuf {
    let path = scratch(name);
    fs::write(&path, contents).unwrap();
    path
}

fn check(name: &str, dictionary: &Dictionary, arguments: &[&str]) -> Output {
    let eds = file(&format!("check-{name}.eds"), dictionary.text());
    let mut all = vec!["drive", "check", "--json", "--eds", eds.to_str().unwrap()];
    all.extend(arguments);
    uarm(&all)
}

/// Exit code and findings.
fn judged(name: &str, dictionary: &Dictionary) -> (i32, Value) {
    let output = check(name, dictionary, &[]);
    let findings = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output)));
    (output.status.code().unwrap(), findings)
}

/// The rows with a verdict.
fn rows<'a>(findings: &'a Value, verdict: &str) -> Vec<&'a Value> {
    findings["rows"].as_array().unwrap().iter().filter(|row| row["verdict"] == verdict).collect()
}

#[test]
fn the_emulated_drives_own_dictionary_works() {
    let (code, findings) = judged("own", &Dictionary::own());
    assert_eq!(code, WORKS, "{findings:#}");
    assert_eq!(findings["node"], 2);
    assert!(findings["joint"].as_str().unwrap().starts_with("[[joints]]\nname = \"joint 2\"\n"), "{findings:#}");
}

/// Each of these lacks something that no robot file can help.
#[test]
fn what_cannot_be_helped_is_named() {
    for (name, dictionary, object) in [
        ("csv-only", Dictionary::own().with("6502", "DefaultValue", "0x1A5"), "6502h"),
        ("mode-limit", Dictionary::own().with("6060", "HighLimit", "9"), "6060h"),
        ("no-target", Dictionary::own().without("6071"), "6071h"),
        ("no-display", Dictionary::own().without("6061"), "6061h"),
        ("io-module", Dictionary::own().with("1000", "DefaultValue", "0x191"), "1000h"),
        ("unwatched", Dictionary::own().without("1016").without("1400sub5"), "1016h"),
    ] {
        let (code, findings) = judged(name, &dictionary);
        assert_eq!(code, CANNOT, "{name}: {findings:#}");
        let refused = rows(&findings, "no");
        assert!(refused.iter().any(|row| row["object"].as_str().unwrap().starts_with(object)), "{name}: {refused:#?}");
        assert_eq!(findings["joint"], Value::Null, "{name}");
    }
}

#[test]
fn what_the_robot_file_can_help_is_in_the_entry() {
    for (name, dictionary, expected) in [
        ("servo", Dictionary::servo(), "{ index = 0x608F, subindex = 1, type = \"u32\", value = 33739 }"),
        ("unrated", Dictionary::servo(), "{ index = 0x6076, subindex = 0, type = \"u32\", value = 200 }"),
        ("no-608F", Dictionary::own().without("608F"), "resolution_object = \"absent\""),
        ("no-6076", Dictionary::own().without("6076"), "target_torque_of = \"stated-torque\""),
        ("no-1016", Dictionary::own().without("1016"), "watchdog = \"rpdo-timeout\""),
        ("no-6007", Dictionary::own().without("6007"), "without_6007h = "),
        (
            "fixed",
            Dictionary::own().with("1A00sub0", "AccessType", "const").with("1A00sub0", "DefaultValue", "1"),
            "tpdo = 2",
        ),
        (
            "at-sync",
            Dictionary::own().with("1400sub2", "AccessType", "const").with("1400sub2", "DefaultValue", "1"),
            "torque_applies = \"at-sync\"",
        ),
    ] {
        let (code, findings) = judged(name, &dictionary);
        assert_eq!(code, WORKS_WITH, "{name}: {findings:#}");
        let joint = findings["joint"].as_str().unwrap();
        assert!(joint.contains(expected), "{name}: {joint}");
        assert_works_as_printed(name, &dictionary, joint);
    }
}

/// What all drives of a bus share is printed beside the entry, and works with it.
#[test]
fn what_is_fixed_for_the_whole_bus_is_told_with_its_keys() {
    let fixed = |object: &str, value: &str| {
        Dictionary::own().with(object, "AccessType", "ro").with(object, "DefaultValue", value)
    };
    let heartbeat = |milliseconds: &str| fixed("1017", milliseconds);
    let period = |milliseconds: &str| {
        let exponent = Dictionary::own().with("60C2sub2", "AccessType", "ro").with("60C2sub2", "DefaultValue", "-3");
        exponent.with("60C2sub1", "AccessType", "ro").with("60C2sub1", "DefaultValue", milliseconds)
    };
    for (name, dictionary, keys) in [
        ("heartbeat-100", heartbeat("100"), "[bus]\ndrive_heartbeat_ms = 100\ndrive_timeout_ms = 200\n"),
        (
            "heartbeat-500",
            heartbeat("500"),
            "[bus]\ndrive_heartbeat_ms = 500\ndrive_timeout_ms = 1000\nnmt_timeout_ms = 1000\n",
        ),
        ("period-5", period("5"), "[control]\nperiod_us = 5000\n"),
    ] {
        let (code, findings) = judged(name, &dictionary);
        assert_eq!(code, WORKS_WITH, "{name}: {findings:#}");
        assert_eq!(findings["shared"], serde_json::json!([keys]), "{name}");
        let original = fs::read_to_string("robots/uarm.toml").unwrap();
        let changed = |key: &str| keys.lines().find(|line| line.starts_with(&format!("{key} ="))).map(str::to_owned);
        let lines = original.lines().map(|line| {
            let key = line.split(' ').next().unwrap_or_default();
            changed(key).filter(|_| line.contains(" = ")).unwrap_or_else(|| line.to_owned())
        });
        let lines = lines.collect::<Vec<_>>().join("\n");
        // A key that the file has not stands in no line of it.
        let added = keys.lines().find(|line| line.starts_with("nmt_timeout_ms")).unwrap_or_default();
        let robot = file(&format!("check-{name}.toml"), &lines.replacen("[bus]\n", &format!("[bus]\n{added}\n"), 1));
        let again = check(&format!("{name}-again"), &dictionary, &["--node", "2", "--robot", robot.to_str().unwrap()]);
        assert_eq!(again.status.code(), Some(WORKS), "{name}: {}", text(&again));
    }
    // No robot has a period of 200 ms, and nobody waits for a heartbeat that is not sent.
    for (name, dictionary, remedy) in [
        ("heartbeat-0", heartbeat("0"), "[bus] drive_heartbeat_ms that the drive takes"),
        ("period-200", period("200"), "[control] period_us = 200000"),
    ] {
        let (code, findings) = judged(name, &dictionary);
        assert_eq!(code, CANNOT, "{name}: {findings:#}");
        let refused = rows(&findings, "no");
        assert!(refused.iter().any(|row| row["remedies"] == serde_json::json!([remedy])), "{name}: {refused:#?}");
    }
}

/// In the place of the robot file's entry for node 2, the entry needs nothing more.
fn assert_works_as_printed(name: &str, dictionary: &Dictionary, joint: &str) {
    let robot = file(&format!("check-{name}.toml"), &with_joint_2(joint));
    let output = check(&format!("{name}-again"), dictionary, &["--node", "2", "--robot", robot.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(WORKS), "{name}: {}", text(&output));
}

/// `robots/uarm.toml` with another entry for joint 2.
fn with_joint_2(entry: &str) -> String {
    let original = fs::read_to_string("robots/uarm.toml").unwrap();
    let (before, rest) = original.split_once("[[joints]]\nname = \"joint 2\"").unwrap();
    let (_, after) = rest.split_once("[[joints]]").unwrap();
    format!("{before}{entry}\n[[joints]]{after}")
}

#[test]
fn a_dcf_names_its_node_and_its_values_come_first() {
    let dcf = format!(
        "{}\n[DeviceComissioning]\nNodeID=3\n",
        Dictionary::own().with("6076", "DefaultValue", "1").with("6076", "ParameterValue", "200").text()
    );
    let path = file("check.dcf", &dcf);
    let output = uarm(&["drive", "check", "--eds", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(WORKS), "{}", text(&output));
    assert!(text(&output).contains("as node 3"), "{}", text(&output));
    assert!(text(&output).contains("name = \"joint 3\""), "the entry is that of joint 3: {}", text(&output));
}

/// A joint that names a profile and its rated torque, and says nothing else of its drive.
fn with_profile(name: &str) -> String {
    let entry = format!(
        "[[joints]]\nname = \"joint 2\"\nrole = \"active\"\nnode = 2\n\
         encoder = {{ counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0 }}\n\
         drive = {{ rated_torque_nm = 0.2, profile = \"{name}\" }}\n\
         limits = {{ torque_nm = 0.2, torque_rate_nm_per_s = 100.0, velocity_deg_per_s = 360.0, minimum_deg = -170.0, maximum_deg = 170.0 }}\n"
    );
    with_joint_2(&entry)
}

#[test]
fn a_profile_is_all_that_its_makers_drive_needs() {
    for (name, _) in uarm::robot::profile::SHIPPED {
        let dictionary = Dictionary::of_profile(name);
        assert_eq!(judged(&format!("{name}-without"), &dictionary).0, WORKS_WITH, "{name} without its profile");
        let robot = file(&format!("check-{name}.toml"), &with_profile(name));
        let arguments = ["--node", "2", "--robot", robot.to_str().unwrap()];
        let output = check(&format!("{name}-with"), &dictionary, &arguments);
        assert_eq!(output.status.code(), Some(WORKS), "{name}: {}", text(&output));
        let findings: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(findings["profile"].as_str().unwrap().contains("not tried on hardware"), "{findings:#}");
        assert!(findings["joint"].as_str().unwrap().contains(&format!("profile = \"{name}\"")), "{findings:#}");
    }
}

/// Each with its own maker's number: as what its 1018h:01 says, or its `[DeviceInfo]`.
#[test]
fn a_drive_of_another_maker_is_refused_under_a_profile() {
    for (profile, dictionary, found, wanted) in [
        ("elmo-gold", Dictionary::epos4(), "251 (FBh)", "154 (9Ah)"),
        ("maxon-epos4", Dictionary::gold(), "154 (9Ah)", "251 (FBh)"),
    ] {
        let robot = file(&format!("check-other-{profile}.toml"), &with_profile(profile));
        let arguments = ["--node", "2", "--robot", robot.to_str().unwrap()];
        let output = check(&format!("other-{profile}"), &dictionary, &arguments);
        assert_eq!(output.status.code(), Some(CANNOT), "{profile}: {}", text(&output));
        let findings: Value = serde_json::from_slice(&output.stdout).unwrap();
        let refused = rows(&findings, "no");
        let row = refused.iter().find(|row| row["question"] == "Which drive is it?").unwrap();
        assert!(row["object"].as_str().unwrap().starts_with("1018h:01"), "{row:#}");
        assert_eq!((&row["found"], &row["wanted"]), (&found.into(), &wanted.into()));
        assert!(row["remedies"][0].as_str().unwrap().contains("profile"), "{row:#}");
    }
}

/// TPDO 20 is on, and nothing stands between it and TPDO 4: a start would not ask for it, so the entry switches it off.
#[test]
fn a_pdo_behind_a_gap_is_switched_off_by_the_entry() {
    let section = "\n[1813sub1]\nParameterName=COB-ID\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\n\
                   DefaultValue=$NODEID+0x40000480\nPDOMapping=0\n";
    let dictionary = Dictionary::own().and(section);
    let (code, findings) = judged("behind-gap", &dictionary);
    assert_eq!(code, WORKS_WITH, "{findings:#}");
    // Node 2: 40000482h with bit 31 set.
    let expected = "{ index = 0x1813, subindex = 1, type = \"u32\", value = 3221226626 }";
    let joint = findings["joint"].as_str().unwrap();
    assert!(joint.contains(expected), "{joint}");
    assert_works_as_printed("behind-gap", &dictionary, joint);
    let off = Dictionary::own().and(&section.replace("0x40000480", "0x80000480"));
    assert_eq!(judged("behind-gap-off", &off).0, WORKS);
}

/// Opening a pipe waits for its writer, and a device has no end.
#[test]
fn what_is_no_file_is_refused_at_once() {
    let pipe = scratch("check-pipe.eds");
    let _ = fs::remove_file(&pipe);
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let pipe = pipe.to_str().unwrap();
    let own = file("check-no-file.eds", Dictionary::own().text());
    for (path, found) in [("/dev/zero", "is a device"), (pipe, "is a pipe")] {
        let profile =
            file("check-pipe.toml", &with_profile("elmo-gold").replace("\"elmo-gold\"", &format!("{path:?}")));
        for arguments in [
            vec!["drive", "check", "--eds", path],
            vec!["drive", "check", "--eds", own.to_str().unwrap(), "--robot", path],
            vec!["check", "--robot", path],
            vec!["check", "--robot", profile.to_str().unwrap()],
        ] {
            let output = uarm(&arguments);
            assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", text(&output));
            let told = text(&output);
            assert!(told.contains(path) && told.contains(found), "{arguments:?}: {told}");
        }
    }
}

#[test]
fn the_profiles_are_listed_and_printed() {
    let listed = uarm(&["drive", "profiles", "--json"]);
    let listed: Value = serde_json::from_slice(&listed.stdout).unwrap();
    let names: Vec<&str> = listed.as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["elmo-gold", "maxon-epos4"]);
    assert_eq!(listed[0]["evidence"], "from its dictionary, not tried on hardware");
    let printed = uarm(&["drive", "profiles", "elmo-gold"]);
    assert_eq!(printed.stdout, fs::read("robots/profiles/elmo-gold.toml").unwrap());
    let unknown = uarm(&["drive", "profiles", "elmo"]);
    assert_eq!(unknown.status.code(), Some(2), "a usage error");
    assert!(text(&unknown).contains("[possible values: elmo-gold, maxon-epos4]"), "{}", text(&unknown));
}

#[test]
fn bad_input_is_named() {
    let missing = uarm(&["drive", "check", "--eds", "nowhere.eds"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(text(&missing).contains("nowhere.eds"), "{}", text(&missing));
    let robot = uarm(&["drive", "check", "--eds", file("robot-as.eds", "[bus]\nperiod = 3\n").to_str().unwrap()]);
    assert_eq!(robot.status.code(), Some(1));
    assert!(text(&robot).contains("expected an EDS or DCF file"), "{}", text(&robot));
    let uarm_toml = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml");
    let other = check("other-node", &Dictionary::own(), &["--node", "9", "--robot", uarm_toml]);
    let usage = uarm(&["drive", "check"]);
    assert_eq!(usage.status.code(), Some(2), "a dictionary or an interface is needed");
    assert_eq!(other.status.code(), Some(2), "no joint has the node");
    assert!(text(&other).contains("--node 9: expected one of the robot's nodes, [1, 2, 3]"), "{}", text(&other));
    let damaged = Dictionary::own().with("6076", "DefaultValue", "about 200");
    let output = check("damaged", &damaged, &[]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("[6076] defaultvalue: found \"about 200\", expected a number"), "{message}");
}

/// 2011h: the temperature of one maker's drives.
fn temperature(data_type: &str, access: &str) -> Dictionary {
    Dictionary::own().and(&format!(
        "\n[2011]\nParameterName=Temperature\nObjectType=0x7\nDataType={data_type}\nAccessType={access}\nPDOMapping=0\n"
    ))
}

#[test]
fn what_a_run_watches_and_the_mark_of_an_incremental_encoder_are_judged() {
    let original = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml")).unwrap();
    let watched = "drive = { temperature_c = { object = { index = 0x2011, subindex = 0, type = \"i16\", unit = 0.1 }, \
                   stop_above = 80.0 }, rated_torque_nm";
    let marked = "zero_counts = 0, reference = \"incremental\", \
                  power_marker = { index = 0x6081, subindex = 0, type = \"u32\", value = 77 }";
    let robot = file(
        "check-watched.toml",
        &original.replace("drive = { rated_torque_nm", watched).replace("zero_counts = 0", marked),
    );
    let robot = ["--robot", robot.to_str().unwrap()];
    let judged = |name: &str, dictionary: &Dictionary| {
        let output = check(name, dictionary, &robot);
        let findings: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output)));
        (output.status.code().unwrap(), findings)
    };
    let (code, findings) = judged("watched", &temperature("0x0003", "ro"));
    assert_eq!(code, WORKS, "{findings:#}");
    for (name, dictionary, object, found, remedy) in [
        ("unwatched", Dictionary::own(), "2011h:00", "absent", "temperature_c"),
        ("other-type", temperature("0x0007", "ro"), "2011h:00", "of type u32", "temperature_c"),
        ("write-only", temperature("0x0003", "wo"), "2011h:00", "", "temperature_c"),
        ("no-mark", temperature("0x0003", "ro").with("6081", "AccessType", "ro"), "6081h:00", "0", "power_marker"),
    ] {
        let (code, findings) = judged(name, &dictionary);
        assert_eq!(code, CANNOT, "{name}: {findings:#}");
        let [row] = rows(&findings, "no").try_into().unwrap();
        assert!(row["object"].as_str().unwrap().starts_with(object), "{name}: {row:#}");
        assert!(row["found"].as_str().unwrap().starts_with(found), "{name}: {row:#}");
        assert!(row["remedies"][0].as_str().unwrap().contains(remedy), "{name}: {row:#}");
    }
}

/// The paper's robot file with keys more in each joint's drive and in joint 2's encoder.
fn robot_with(name: &str, drive: &str, encoder: &str) -> PathBuf {
    let original = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml")).unwrap();
    let joint_2 = "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0";
    assert!(original.contains(joint_2));
    let text = original
        .replace("drive = { rated_torque_nm", &format!("drive = {{ {drive}rated_torque_nm"))
        .replace(joint_2, &format!("{joint_2}{encoder}"));
    file(name, &text)
}

/// `uarm check` and `uarm drive check` of a robot file and a dictionary, and what both print.
fn both_checks(robot: &Path, eds: &Path) -> [(Option<i32>, String); 2] {
    let (robot, eds) = (robot.to_str().unwrap(), eds.to_str().unwrap());
    let arguments = ["--robot", robot, "--eds", eds, "--node", "2"];
    [&["check"][..], &["drive", "check"]].map(|command| {
        let output = uarm(&[command, &arguments].concat());
        (output.status.code(), text(&output))
    })
}

fn marker(index: u16, value: u32) -> String {
    format!(
        ", reference = \"incremental\", power_marker = {{ index = {index}, subindex = 0, type = \"u32\", value = {value} }}"
    )
}

#[test]
fn a_mark_is_judged_alike_by_both_checks() {
    let eds = file("check-mark.eds", Dictionary::own().with("6081", "DefaultValue", "77").text());
    for (name, index, value, code, words) in [
        ("mark-good", 0x6081, 78, WORKS, "completed"),
        ("mark-at-power-up", 0x6081, 77, CANNOT, "another value at power-up than the mark"),
        ("mark-of-the-master", 0x6071, 77, CANNOT, "the master writes it in each cycle"),
        ("mark-that-stores", 0x1010, 77, CANNOT, "stores the drive's parameters"),
        ("mark-that-is-absent", 0x2A00, 77, CANNOT, "2A00h:00"),
    ] {
        let robot = robot_with(&format!("{name}.toml"), "", &marker(index, value));
        let [whole, drive] = both_checks(&robot, &eds);
        assert_eq!((whole.0, drive.0), (Some(code), Some(code)), "{name}: {} {}", whole.1, drive.1);
        assert!(whole.1.contains(words), "{name}: {}", whole.1);
        assert!(code == WORKS || drive.1.contains(words), "{name}: {}", drive.1);
    }
}

/// 2206h: the supply voltage of one maker's drives, in tenths of a volt, which only the drive knows.
#[test]
fn a_supply_voltage_without_a_value_in_the_dictionary_is_not_judged() {
    let object = |default: &str| {
        format!(
            "\n[2206]\nParameterName=Supply voltage\nObjectType=0x7\nDataType=0x0006\nAccessType=ro\n{default}PDOMapping=0\n"
        )
    };
    let watched = "supply_voltage_v = { object = { index = 0x2206, subindex = 0, type = \"u16\", unit = 0.1 }, stop_below = 40.0 }, ";
    let original = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml")).unwrap();
    let joint_2 = original.find("node = 2").unwrap();
    let (before, after) = original.split_at(joint_2);
    let text = format!("{before}{}", after.replacen("drive = { ", &format!("drive = {{ {watched}"), 1));
    let robot = file("check-supply.toml", &text);
    let not_judged = "joint 2: supply voltage of node 2 is not judged: its dictionary has no value for 2206h:00";
    for (name, default, code, is_judged) in [
        ("supply-unstated", "", WORKS, false),
        ("supply-zero", "DefaultValue=0\n", WORKS, false),
        ("supply-good", "DefaultValue=480\n", WORKS, true),
        ("supply-low", "DefaultValue=240\n", CANNOT, true),
    ] {
        let eds = file(&format!("{name}.eds"), Dictionary::own().and(&object(default)).text());
        let [(found, printed), _] = both_checks(&robot, &eds);
        assert_eq!(found, Some(code), "{name}: {printed}");
        assert_eq!(printed.contains(not_judged), !is_judged, "{name}: {printed}");
        assert_eq!(printed.contains("supply voltage 24.0 V"), code == CANNOT, "{name}: {printed}");
    }
}

/// The emulated drive's 24 V say nothing of a robot with another supply.
#[test]
fn the_simulated_supply_is_a_good_one_of_the_robots() {
    let robot = robot_with("check-48-volts.toml", "supply_voltage_v = { stop_below = 40.0, stop_above = 56.0 }, ", "");
    let output = uarm(&["check", "--robot", robot.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(WORKS), "{}", text(&output));
}
