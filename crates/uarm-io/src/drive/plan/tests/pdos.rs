//! PDOs: those of the cycle, and all others.

use super::*;

#[test]
fn fixed_mappings_that_match_are_accepted() {
    let fixed = |first: i64, second: i64| {
        drive()
            .ro(0x1600, 0, 2)
            .ro(0x1600, 1, first)
            .ro(0x1600, 2, second)
            .ro(0x1A00, 0, 2)
            .ro(0x1A00, 1, 0x6041_0010)
            .ro(0x1A00, 2, 0x6064_0020)
    };
    let plan = planned(fixed(0x6040_0010, 0x6071_0010), &wishes());
    assert_eq!(plan.verdict(), Verdict::Works);
    assert_eq!(of_index(&written(&plan), &["1600", "1A00"]), Vec::<&str>::new());
    assert_eq!(of_index(&written(&plan), &["1800"]), ["1800:1 = 80000182", "1800:2 = 1", "1800:1 = 182"]);
    let refused = *planned(fixed(0x6040_0010, 0x607A_0020), &wishes()).refusal().unwrap();
    assert_eq!((refused.question, refused.verdict), (Question::Command, Verdict::Cannot));
    // Another RPDO that carries it is named.
    let third = fixed(0x6040_0010, 0x607A_0020).pdo(0x1402, 0x8000_0402, 255, &[0x6040_0010, 0x6071_0010]);
    let number = PdoNumber::new(3).unwrap();
    let helped = *planned(third.clone(), &wishes()).refusal().unwrap();
    assert_eq!(helped.remedy, Remedy::PdoNumber(PdoKind::Receive, number));
    let mut wish = wishes();
    wish.pdos.command.number = number;
    let plan = planned(third, &wish);
    assert_eq!(plan.verdict(), Verdict::Works);
    assert_eq!(of_index(&written(&plan), &["140"]), ["1400:1 = 80000202", "1402:1 = 202"], "RPDO1 is off then");
}

/// Here TPDO22 and the last that there can be are on, behind gaps.
#[test]
fn pdos_of_any_number_are_switched_off() {
    let mut dictionary = drive();
    for number in (2..=512_u16).step_by(5) {
        let is_on = [22, 512].contains(&number);
        let identifier = if is_on { 0x4000_0381 } else { 0xC000_0000 };
        dictionary = dictionary.pdo(0x1800 + number - 1, identifier, 255, &[]);
    }
    let plan = planned(dictionary, &wishes());
    assert_eq!(of_index(&written(&plan), &["1815", "19FF"]), ["1815:1 = C0000381", "19FF:1 = C0000381"]);
    assert_eq!(written(&plan).iter().filter(|text| text.ends_with("= C0000381")).count(), 2, "and no other");
}

#[test]
fn more_pdos_that_are_on_than_can_be_looked_at_refuse_a_start() {
    let mut dictionary = drive();
    for number in 2..=34_u16 {
        dictionary = dictionary.pdo(0x1400 + number - 1, 0x301, 255, &[]);
    }
    let plan = planned(dictionary, &wishes());
    let refusal = *plan.refusal().unwrap();
    assert_eq!((refusal.question, refusal.object), (Question::OtherPdos, Address::new(0x1420, 1)));
}

#[test]
fn other_pdos_are_switched_off() {
    let dictionary = drive()
        .pdo(0x1801, 0x282, 255, &[0x6041_0010, 0x6061_0008])
        .pdo(0x1802, 0x4000_0382, 1, &[0x6041_0010])
        .pdo(0x1803, 0xC000_0482, 255, &[0x6041_0010])
        .pdo(0x1401, 0x302, 255, &[0x6040_0010])
        // Behind a gap.
        .pdo(0x1406, 0x502, 255, &[0x6040_0010]);
    let plan = planned(dictionary.clone(), &wishes());
    assert_eq!(plan.verdict(), Verdict::Works);
    assert_eq!(
        of_index(&written(&plan), &["1801", "1802", "1803", "1401", "1406"]),
        ["1801:1 = 80000282", "1802:1 = C0000382", "1401:1 = 80000302", "1406:1 = 80000502"]
    );
    let mut kept = wishes();
    kept.pdos.kept.push((PdoKind::Transmit, PdoNumber::SECOND)).unwrap();
    let plan = planned(dictionary.clone(), &kept);
    assert_eq!(of_index(&written(&plan), &["1801"]), Vec::<&str>::new());
    // One that cannot be switched off has to be named.
    let stuck = *planned(dictionary.ro(0x1801, 1, 0x282), &wishes()).refusal().unwrap();
    assert_eq!(stuck.remedy, Remedy::KeepPdo(PdoKind::Transmit, PdoNumber::SECOND));
}

#[test]
fn identifiers_keep_what_a_drive_has_in_bit_30() {
    let dictionary = drive().pdo(0x1800, 0x4000_0182, 1, &[0x6041_0010, 0x6064_0020]).pdo(
        0x1400,
        0x8000_0202,
        255,
        &[0x6040_0010, 0x6071_0010],
    );
    let plan = planned(dictionary, &wishes());
    // TPDO1 is as wanted; RPDO1 is only switched on.
    assert_eq!(of_index(&written(&plan), &["14", "18"]), ["1400:1 = 202"]);
    let elsewhere = planned(drive().rw(0x1800, 1, 0x4000_0190), &wishes());
    let written = written(&elsewhere);
    let identifiers = of_index(&written, &["1800:1"]);
    assert_eq!(identifiers, ["1800:1 = C0000190", "1800:1 = 40000182"], "off as it is, then on as wanted");
}

#[test]
fn a_long_mapping_is_replaced() {
    let entries: Vec<i64> = (0..12).map(|entry| 0x2000_0008 + (entry << 16)).collect();
    let plan = planned(drive().pdo(0x1800, 0x182, 1, &entries), &wishes());
    assert_eq!(
        of_index(&written(&plan), &["1A00"]),
        ["1A00:0 = 0", "1A00:1 = 60410010", "1A00:2 = 60640020", "1A00:0 = 2"]
    );
}

#[test]
fn torque_feedback_gets_the_second_tpdo() {
    let mut wish = wishes();
    wish.pdos.torque_feedback = Some(crate::drive::wishes::PdoChannel {
        number: PdoNumber::SECOND,
        identifier: embedded_can::StandardId::new(0x282).unwrap(),
    });
    let dictionary = drive().pdo(0x1801, 0x8000_0282, 255, &[0x6041_0010, 0x6061_0008]);
    let plan = planned(dictionary.clone(), &wish);
    assert_eq!(plan.verdict(), Verdict::Works);
    assert_eq!(
        of_index(&written(&plan), &["1801", "1A01"]),
        ["1A01:0 = 0", "1A01:1 = 60770010", "1A01:0 = 1", "1801:2 = 1", "1801:1 = 282"]
    );
    let without = *planned(dictionary.without(0x6077, 0), &wish).refusal().unwrap();
    assert_eq!(without.question, Question::TorqueFeedback);
}

#[test]
fn a_torque_that_acts_at_the_sync_has_type_1() {
    let wish = DriveConfiguration { torque_applies: crate::drive::wishes::TorqueApplies::AtSync, ..wishes() };
    assert_eq!(of_index(&written(&planned(drive(), &wish)), &["1400:2"]), ["1400:2 = 1"]);
}

/// RPDO1 has a fixed type: the robot file says when the torque acts.
#[test]
fn a_command_whose_transmission_type_is_fixed_names_when_its_torque_acts() {
    let remedy = |transmission| {
        let refused = *planned(drive().ro(0x1400, 2, transmission), &wishes()).refusal().unwrap();
        assert_eq!((refused.question, refused.object), (Question::Command, Address::new(0x1400, 2)));
        refused.remedy.to_string()
    };
    assert_eq!(remedy(1), "drive.torque_applies = \"at-sync\"");
    assert_eq!(remedy(0), "drive.torque_applies = \"at-sync\" and drive.pdo.rpdo_transmission = 0");
    assert_eq!(remedy(254), "drive.torque_applies = \"on-reception\" and drive.pdo.rpdo_transmission = 254");
    assert_eq!(remedy(7), "another drive, or another number in drive.pdo.rpdo", "at each seventh SYNC");
    let at_sync = DriveConfiguration { torque_applies: crate::drive::wishes::TorqueApplies::AtSync, ..wishes() };
    assert_eq!(planned(drive().ro(0x1400, 2, 1), &at_sync).verdict(), Verdict::Works);
}

/// TPDO1 cannot be made to answer each SYNC; another can, if nothing else uses it.
#[test]
fn another_tpdo_is_named_where_the_transmission_type_of_the_first_is_fixed() {
    let fixed = drive().ro(0x1800, 2, 255);
    let refused = *planned(fixed.clone(), &wishes()).refusal().unwrap();
    assert_eq!((refused.object, refused.verdict), (Address::new(0x1800, 2), Verdict::Cannot));
    let second = fixed.pdo(0x1801, 0x8000_0282, 255, &[0x6041_0010]);
    let helped = *planned(second.clone(), &wishes()).refusal().unwrap();
    assert_eq!(helped.remedy, Remedy::PdoNumber(PdoKind::Transmit, PdoNumber::SECOND));
    let mut wish = wishes();
    wish.pdos.feedback.number = PdoNumber::SECOND;
    assert!(planned(second.clone(), &wish).refusal().is_none());
    let mut kept = wishes();
    kept.pdos.kept.push((PdoKind::Transmit, PdoNumber::SECOND)).unwrap();
    for (dictionary, wish) in [
        (second.clone(), &kept),
        (second.clone().ro(0x1801, 2, 255), &wishes()),
        (second.clone().ro(0x1801, 1, 0x8000_0282), &wishes()),
        (second.ro(0x1A01, 0, 1), &wishes()),
    ] {
        assert_eq!(finding(&planned(dictionary, wish), Question::Feedback).verdict, Verdict::Cannot);
    }
}

/// Over SDO a drive is asked until eight numbers are absent, so that a PDO behind them is known from a dictionary file only: the
/// start would leave it on, unless `drive.writes` switches it off.
#[test]
fn a_pdo_behind_a_gap_needs_an_entry_of_its_own() {
    let dictionary = drive().pdo(0x1813, 0x4000_0482, 255, &[0x6041_0010]);
    let of_drive = planned(dictionary.clone(), &wishes());
    assert_eq!(of_index(&written(&of_drive), &["1813"]), [""; 0]);
    let of_file = |wishes: &DriveConfiguration| planned_from_file(dictionary.clone(), wishes);
    let plan = of_file(&wishes());
    let off = Setting::new(Address::new(0x1813, 1), Value::Unsigned32(0xC000_0482));
    assert_eq!(finding(&plan, Question::OtherPdos).remedy, Remedy::Write(off));
    assert!(plan.refusal().is_some());
    let mut helped = wishes();
    helped.settings.push(off).unwrap();
    let plan = of_file(&helped);
    assert!(plan.refusal().is_none(), "{:?}", plan.refusal());
    assert_eq!(of_index(&written(&plan), &["1813"]).len(), 1);
}

/// The robot file says where it is: a drive is asked there too, wherever its other PDOs are.
#[test]
fn a_pdo_that_the_robot_file_names_is_found_behind_a_gap() {
    let far = PdoNumber::new(21).unwrap();
    let mut wish = wishes();
    wish.pdos.feedback.number = far;
    let dictionary = drive().pdo(0x1814, 0x8000_0182, 1, &[0x6041_0010, 0x6064_0020]);
    let plan = planned(dictionary.clone(), &wish);
    assert!(plan.refusal().is_none(), "{:?}", plan.refusal());
    assert_eq!(of_index(&written(&plan), &["1814"]), ["1814:1 = 182"]);
    assert_eq!(of_index(&written(&plan), &["1800"]), ["1800:1 = 80000182"], "the first is off");
    // The same for commands, and for one that stays on; the one between is not looked for.
    let mut wish = wishes();
    wish.pdos.command.number = far;
    wish.pdos.kept.push((PdoKind::Transmit, far)).unwrap();
    let dictionary = dictionary.pdo(0x1414, 0x202, 255, &[0x6040_0010, 0x6071_0010]).pdo(0x1410, 0x302, 255, &[0]);
    let plan = planned(dictionary, &wish);
    assert!(plan.refusal().is_none(), "{:?}", plan.refusal());
    assert_eq!(of_index(&written(&plan), &["1400", "1410", "1414"]), ["1400:1 = 80000202"]);
    assert!(of_index(&written(&plan), &["1814"]).is_empty());
}
