//! What the drive is: identity, mode, objects that are written, homing.

use super::*;

#[test]
fn a_pinned_identity_must_be_the_drives() {
    let pinned = |identity| DriveConfiguration { identity, ..wishes() };
    let dictionary = drive().ro(0x1018, 2, 7).ro(0x1018, 4, 1001);
    let right = PinnedIdentity { vendor: Some(0x55), product: Some(7), serial: Some(1001) };
    assert_eq!(planned(dictionary.clone(), &pinned(right)).verdict(), Verdict::Works);
    for (identity, subindex, told) in [
        (PinnedIdentity { vendor: Some(0x56), ..right }, 1, "1018h:01 (vendor-ID) is 85 (55h), expected 86 (56h)"),
        (PinnedIdentity { product: Some(8), ..right }, 2, "1018h:02 (product code) is 7, expected 8"),
        (
            PinnedIdentity { serial: Some(1002), ..right },
            4,
            "1018h:04 (serial number) is 1001 (3E9h), expected 1002 (3EAh)",
        ),
    ] {
        let plan = planned(dictionary.clone(), &pinned(identity));
        let refused = *plan.refusal().unwrap();
        assert_eq!((refused.question, refused.object), (Question::Identity, Address::new(0x1018, subindex)));
        assert!(refused.to_string().starts_with(told), "{refused}");
    }
    // A drive without the number is another one; a dictionary file cannot know a serial number.
    let plan = planned(dictionary.clone().without(0x1018, 4), &pinned(right));
    assert_eq!(plan.refusal().map(|finding| finding.question), Some(Question::Identity));
    let plan = planned(dictionary.unstated(0x1018, 4, Access::ReadOnly), &pinned(right));
    assert_eq!((plan.refusal(), finding(&plan, Question::Identity).verdict), (None, Verdict::WorksWith));
}

/// A PDO carries them: in so many bits, and in one direction.
#[test]
fn objects_of_the_cycle_have_the_standards_width_and_direction() {
    use canopen_rs::DataType;
    let with = |index, access, data_type| {
        let mut dictionary = drive();
        let object = dictionary.0.get_mut(&(index, 0)).unwrap();
        (object.access, object.data_type) = (access, Some(data_type));
        finding(&planned(dictionary, &wishes()), Question::CyclicObjects)
    };
    for (index, access, data_type, expected) in [
        (0x6064, Access::ReadOnly, DataType::Integer32, Verdict::Works),
        (0x6064, Access::ReadOnly, DataType::Unsigned32, Verdict::Works),
        (0x6064, Access::ReadOnly, DataType::Integer16, Verdict::Cannot),
        (0x6064, Access::ReadOnly, DataType::Real32, Verdict::Cannot),
        (0x6064, Access::WriteOnly, DataType::Integer32, Verdict::Cannot),
        (0x6041, Access::WriteOnly, DataType::Unsigned16, Verdict::Cannot),
        (0x6071, Access::WriteOnly, DataType::Integer16, Verdict::Works),
        (0x6071, Access::ReadWrite, DataType::Integer32, Verdict::Cannot),
        (0x6071, Access::ReadOnly, DataType::Integer16, Verdict::Cannot),
        (0x6040, Access::ReadOnly, DataType::Unsigned16, Verdict::Cannot),
    ] {
        let row = with(index, access, data_type);
        assert_eq!(row.verdict, expected, "{index:04X} {access:?} {data_type:?}");
    }
    assert_eq!(
        with(0x6071, Access::ReadWrite, DataType::Integer32).to_string(),
        "6071h:00 (target torque) is of type i32, expected writable, of type i16: another drive"
    );
}

/// What the drive sends at its own period is awaited at that period.
#[test]
fn a_heartbeat_that_is_fixed_names_the_key() {
    let row = |dictionary| finding(&planned(dictionary, &wishes()), Question::DriveHeartbeat);
    let fixed = row(drive().ro(0x1017, 0, 100));
    assert_eq!((fixed.verdict, fixed.remedy), (Verdict::WorksWith, Remedy::DriveHeartbeat(100)));
    assert_eq!(fixed.remedy.to_string(), "[bus] drive_heartbeat_ms = 100");
    assert_eq!(row(drive().ro(0x1017, 0, 50)).verdict, Verdict::Works);
    assert_eq!(row(drive().ro(0x1017, 0, 0)).verdict, Verdict::Cannot, "it sends none");
}

#[test]
fn a_position_drive_is_refused_before_anything_else() {
    let dictionary = drive().ro(0x6502, 0, 0x3_01A5).without(0x6071, 0);
    let plan = planned(dictionary, &wishes());
    let refused = plan.refusal().unwrap();
    assert_eq!((refused.question, refused.verdict), (Question::Mode, Verdict::Cannot));
    assert_eq!(plan.verdict(), Verdict::Cannot);
}

#[test]
fn what_only_the_drive_knows_is_said_and_refuses_nothing() {
    let dictionary = drive()
        .unstated(0x1000, 0, Access::ReadOnly)
        .unstated(0x6502, 0, Access::ReadOnly)
        .unstated(0x6061, 0, Access::ReadOnly)
        .unstated(0x6060, 0, Access::ReadWrite)
        .unstated(0x6076, 0, Access::ReadOnly)
        .unstated(0x608F, 1, Access::ReadOnly);
    let plan = planned(dictionary, &wishes());
    assert!(plan.refusal().is_none());
    assert_eq!(plan.verdict(), Verdict::WorksWith);
    for question in [Question::DeviceType, Question::Mode, Question::RatedTorque, Question::Resolution] {
        assert_eq!(finding(&plan, question).verdict, Verdict::WorksWith, "{question:?}");
    }
    let without = planned(drive().without(0x6502, 0), &wishes());
    assert!(without.refusal().is_none());
    assert_eq!(finding(&without, Question::Mode).verdict, Verdict::WorksWith);
}

#[test]
fn texts_and_refusals_are_no_numbers() {
    let odd = |answer| planned(drive().with(0x608F, 1, answer, Access::Unknown), &wishes());
    for answer in [Answer::NotANumber, Answer::Refused(0x0800_0000)] {
        assert_eq!(finding(&odd(answer), Question::Resolution).verdict, Verdict::Cannot);
    }
    let text = planned(drive().with(0x6076, 0, Answer::NotANumber, Access::Unknown), &wishes());
    assert_eq!(finding(&text, Question::RatedTorque).remedy, Remedy::TorqueStated);
    let domain = planned(drive().with(0x6064, 0, Answer::NotANumber, Access::ReadOnly), &wishes());
    assert_eq!(finding(&domain, Question::CyclicObjects).verdict, Verdict::Works, "it is there; the PDO carries it");
}

#[test]
fn later_writes_come_last_and_absent_ones_are_refused() {
    let mut later = wishes();
    later.later_settings.push(Setting::new(Address::new(0x2010, 1), Value::Unsigned16(7))).unwrap();
    let plan = planned(drive().rw(0x2010, 1, 0), &later);
    assert_eq!(written(&plan).last().unwrap(), "2010:1 = 7");
    let refused = *planned(drive(), &later).refusal().unwrap();
    assert_eq!((refused.question, refused.object), (Question::Writes, Address::new(0x2010, 1)));
}

/// A drive that homes, by objects of its own.
fn homing_drive() -> Dictionary {
    let dictionary = drive().ro(0x6502, 0, 1 << 9 | 1 << 5).rw(0x6098, 0, 0).rw(0x607C, 0, 0);
    dictionary.rw(0x6099, 1, 0).rw(0x6099, 2, 0).rw(0x609A, 0, 0)
}

fn homing(offset: i32) -> DriveConfiguration {
    let homing = Homing { method: 17, switch_speed: 500, zero_speed: 20, acceleration: Some(900), offset };
    DriveConfiguration { operation: Operation::Homing(homing), ..wishes() }
}

#[test]
fn a_drive_that_shall_home_gets_mode_6_and_what_homing_needs() {
    let plan = planned(homing_drive(), &homing(-7));
    assert_eq!(plan.verdict(), Verdict::Works, "{:#?}", plan.notes().collect::<Vec<_>>());
    let expected =
        ["6060:0 = 6", "6098:0 = 11", "6099:1 = 1F4", "6099:2 = 14", "607C:0 = FFFFFFFFFFFFFFF9", "609A:0 = 384"];
    assert_eq!(of_index(&written(&plan), &["6060", "6098", "6099", "607C", "609A"]), expected);
    assert!(of_index(&written(&planned(homing_drive(), &wishes())), &["6098", "6099", "607C"]).is_empty());
}

#[test]
fn a_drive_that_cannot_home_is_refused_with_the_object() {
    let refused = |dictionary, wishes: &DriveConfiguration| {
        planned(dictionary, wishes).refusal().map(|finding| (finding.question, finding.object.index))
    };
    assert_eq!(refused(homing_drive().ro(0x6502, 0, 1 << 9), &homing(0)), Some((Question::Mode, 0x6502)));
    assert_eq!(refused(homing_drive().without(0x6099, 2), &homing(0)), Some((Question::Homing, 0x6099)));
    assert_eq!(refused(homing_drive().ro(0x6098, 0, 35), &homing(0)), Some((Question::Homing, 0x6098)));
    // A drive without offsets does where none is wanted.
    assert_eq!(refused(homing_drive().without(0x607C, 0), &homing(0)), None);
    assert_eq!(refused(homing_drive().without(0x607C, 0), &homing(9)), Some((Question::Homing, 0x607C)));
}

#[test]
fn whether_a_drive_could_home_is_told() {
    let told = |dictionary| finding(&planned(dictionary, &wishes()), Question::Homing).wanted.to_string();
    assert_eq!(told(homing_drive()), "anything; it can home by itself");
    for cannot in [drive(), homing_drive().ro(0x6502, 0, 1 << 9), homing_drive().ro(0x6098, 0, 35)] {
        assert!(told(cannot.clone()).contains("cannot home by itself"));
        assert_eq!(planned(cannot, &wishes()).verdict(), Verdict::Works);
    }
}
