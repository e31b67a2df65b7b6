//! Dictionaries with the traits of makers, written by hand.

use super::*;
use crate::drive::objects::{self, Object};
use crate::drive::pdo_objects::{PdoKind, PdoNumber};
use crate::drive::survey::{Access, Answered, ObjectSource};
use crate::drive::wishes::{
    AbortOption, Heartbeats, Homing, Operation, PinnedIdentity, Resolution, Setting, SyncCounterChoice, SyncPayload,
    TorqueReference, Watchdog, WatchdogTest,
};
use crate::torque::{RatedTorque, TorqueUnit};
use canopen_rs::{Address, NodeId, Value};
use core::convert::Infallible;
use core::time::Duration;
use std::collections::BTreeMap;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// A dictionary as a file states it.
#[derive(Clone, Default)]
struct Dictionary(BTreeMap<(u16, u8), Answered>);

impl ObjectSource for Dictionary {
    type Error = Infallible;

    fn ask(&mut self, object: &Object) -> Result<Answered, Infallible> {
        Ok(self.0.get(&(object.index, object.subindex)).copied().unwrap_or_default())
    }
}

impl Dictionary {
    fn with(mut self, index: u16, subindex: u8, answer: Answer, access: Access) -> Self {
        self.0.insert((index, subindex), Answered { answer, access, least: None, most: None });
        self
    }

    fn rw(self, index: u16, subindex: u8, value: i64) -> Self {
        self.with(index, subindex, Answer::Number(value), Access::ReadWrite)
    }

    fn ro(self, index: u16, subindex: u8, value: i64) -> Self {
        self.with(index, subindex, Answer::Number(value), Access::ReadOnly)
    }

    fn unstated(self, index: u16, subindex: u8, access: Access) -> Self {
        self.with(index, subindex, Answer::Unstated, access)
    }

    fn without(mut self, index: u16, subindex: u8) -> Self {
        self.0.remove(&(index, subindex));
        self
    }

    fn limited(mut self, index: u16, subindex: u8, least: i64, most: i64) -> Self {
        let object = self.0.get_mut(&(index, subindex)).unwrap();
        (object.least, object.most) = (Some(least), Some(most));
        self
    }

    fn pdo(self, parameter: u16, identifier: i64, transmission: i64, mapping: &[i64]) -> Self {
        let mut dictionary = self.rw(parameter, 1, identifier).rw(parameter, 2, transmission);
        dictionary = dictionary.rw(parameter + 0x200, 0, mapping.len() as i64);
        for (subindex, entry) in (1..).zip(mapping) {
            dictionary = dictionary.rw(parameter + 0x200, subindex, *entry);
        }
        dictionary
    }
}

const NODE: u8 = 2;
const COUNTS: u32 = 33_739;

/// A drive of which everything is as the master wants it, but for what every start writes.
fn drive() -> Dictionary {
    Dictionary::default()
        .ro(0x1000, 0, 0x0002_0192)
        .ro(0x1018, 1, 0x55)
        .rw(0x1005, 0, 0x80)
        .ro(0x1014, 0, 0x82)
        .rw(0x1016, 1, 0)
        .rw(0x1017, 0, 0)
        .rw(0x1019, 0, 0)
        .rw(0x6007, 0, 1)
        .rw(0x6040, 0, 0)
        .ro(0x6041, 0, 0)
        .rw(0x605A, 0, 2)
        .rw(0x6060, 0, 0)
        .ro(0x6061, 0, 0)
        .ro(0x6064, 0, 0)
        .rw(0x6071, 0, 0)
        .rw(0x6072, 0, 1000)
        .rw(0x6075, 0, 3000)
        .rw(0x6076, 0, 200)
        .ro(0x6077, 0, 0)
        .ro(0x608F, 1, COUNTS.into())
        .ro(0x608F, 2, 1)
        .rw(0x60C2, 1, 1)
        .rw(0x60C2, 2, -3)
        .ro(0x6502, 0, 1 << 9)
        .pdo(0x1400, 0x202, 255, &[0x6040_0010])
        .pdo(0x1800, 0x182, 255, &[0x6041_0010])
}

fn wishes() -> DriveConfiguration {
    DriveConfiguration::new(NodeId::new(NODE).unwrap(), COUNTS, RatedTorque::from_millinewton_metres(200).unwrap())
}

fn protocol() -> Protocol {
    Protocol { period: Duration::from_millis(3), heartbeats: Heartbeats::default(), sync_payload: SyncPayload::Counter }
}

fn survey(mut dictionary: Dictionary, drive: &DriveConfiguration) -> Survey {
    let Ok(survey) = Survey::of(&mut dictionary, named_objects(drive));
    survey
}

fn planned(dictionary: Dictionary, drive: &DriveConfiguration) -> Plan {
    plan(&survey(dictionary, drive), drive, &protocol())
}

fn finding(plan: &Plan, question: Question) -> Finding {
    *plan.findings.iter().find(|finding| finding.question == question).unwrap()
}

/// What is written, as `index:subindex = number`.
fn written(plan: &Plan) -> Vec<String> {
    let shown = |setting: &Setting| {
        let Address { index, subindex } = setting.address;
        format!("{index:04X}:{subindex} = {:X}", Answer::of(setting.value).number().unwrap())
    };
    plan.settings.iter().map(shown).collect()
}

fn of_index<'a>(written: &'a [String], indices: &[&str]) -> Vec<&'a str> {
    written.iter().map(String::as_str).filter(|text| indices.iter().any(|index| text.starts_with(index))).collect()
}

#[test]
fn a_good_drive_is_configured_in_the_standards_order() {
    let plan = planned(drive(), &wishes());
    assert_eq!(plan.verdict(), Verdict::Works, "{:#?}", plan.notes().collect::<Vec<_>>());
    let expected = [
        "6060:0 = A",
        "1400:1 = 80000202",
        "1600:0 = 0",
        "1600:2 = 60710010",
        "1600:0 = 2",
        "1400:1 = 202",
        "1800:1 = 80000182",
        "1A00:0 = 0",
        "1A00:2 = 60640020",
        "1A00:0 = 2",
        "1800:2 = 1",
        "1800:1 = 182",
        "1019:0 = F0",
        "60C2:1 = 3",
        "1017:0 = 32",
        "1016:1 = 7F0064",
    ];
    assert_eq!(written(&plan), expected);
}

#[test]
fn every_question_is_answered_in_its_order() {
    let plan = planned(drive(), &wishes());
    let questions: Vec<Question> = plan.findings.iter().map(|finding| finding.question).collect();
    assert_eq!(questions, Question::ALL);
}

/// What a start has written is not written again.
#[test]
fn what_is_right_already_is_not_written() {
    let mut dictionary = drive();
    for setting in &planned(drive(), &wishes()).settings {
        let Address { index, subindex } = setting.address;
        dictionary = dictionary.rw(index, subindex, Answer::of(setting.value).number().unwrap());
    }
    assert_eq!(written(&planned(dictionary, &wishes())), Vec::<String>::new());
}

#[test]
fn without_1019h_the_sync_carries_no_counter_if_all_can_do_without() {
    let dictionary = drive().without(0x1019, 0);
    let empty = Protocol { sync_payload: SyncPayload::Empty, ..protocol() };
    let plan_with = |protocol: &Protocol| plan(&survey(dictionary.clone(), &wishes()), &wishes(), protocol);
    assert_eq!(plan_with(&empty).verdict(), Verdict::Works);
    let refused = *plan_with(&protocol()).refusal().unwrap();
    assert_eq!((refused.question, refused.remedy), (Question::Sync, Remedy::SyncWithoutCounter));
    // A drive that could count is told not to, where another cannot.
    let counts = drive().rw(0x1019, 0, 240);
    let plan = plan(&survey(counts, &wishes()), &wishes(), &empty);
    assert_eq!(of_index(&written(&plan), &["1019"]), ["1019:0 = 0"]);
}

#[test]
fn the_sync_counter_is_chosen_by_what_all_drives_have() {
    use SyncCounterChoice::{Auto, Off, On};
    let chosen = [(Auto, true), (Auto, false), (On, false), (Off, true)].map(|(choice, all)| choice.payload(all));
    assert_eq!(chosen, [SyncPayload::Counter, SyncPayload::Empty, SyncPayload::Counter, SyncPayload::Empty]);
}

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

#[test]
fn without_608fh_the_robot_file_has_to_say_so() {
    let dictionary = drive().without(0x608F, 1).without(0x608F, 2);
    let refused = *planned(dictionary.clone(), &wishes()).refusal().unwrap();
    assert_eq!(refused.remedy, Remedy::ResolutionStated);
    assert_eq!(
        refused.to_string(),
        "608Fh:01 (encoder increments) is absent, expected 33739 (83CBh): encoder.resolution_object = \"absent\""
    );
    let stated = DriveConfiguration { resolution: Resolution::Stated, ..wishes() };
    assert_eq!(planned(dictionary, &stated).verdict(), Verdict::Works);
}

#[test]
fn a_resolution_is_a_ratio() {
    let halved = drive().ro(0x608F, 1, 2 * i64::from(COUNTS)).ro(0x608F, 2, 2);
    assert_eq!(planned(halved, &wishes()).verdict(), Verdict::Works);
    let other = planned(drive().ro(0x608F, 1, 4096), &wishes());
    assert_eq!(finding(&other, Question::Resolution).remedy, Remedy::CountsPerRevolution(4096));
    // A default of a dictionary can be set.
    let default = planned(drive().rw(0x608F, 1, 1), &wishes());
    let setting = Setting::of(&objects::ENCODER_INCREMENTS, Value::Unsigned32(COUNTS));
    assert_eq!(finding(&default, Question::Resolution).remedy, Remedy::Write(setting));
    let mut told = wishes();
    told.settings.push(setting).unwrap();
    let plan = planned(drive().rw(0x608F, 1, 1), &told);
    assert_eq!(plan.verdict(), Verdict::Works);
    assert_eq!(written(&plan)[0], "608F:1 = 83CB", "the robot file's objects come first");
}

#[test]
fn a_makers_own_object_can_hold_the_resolution() {
    let address = Address::new(0x3010, 4);
    let wish = |equals| DriveConfiguration { resolution: Resolution::Object { address, equals }, ..wishes() };
    let dictionary = drive().without(0x608F, 1).ro(0x3010, 4, 8192);
    assert_eq!(planned(dictionary.clone(), &wish(8192)).verdict(), Verdict::Works);
    let refused = *planned(dictionary, &wish(4096)).refusal().unwrap();
    assert_eq!((refused.object, refused.found), (address, Answer::Number(8192)));
    let absent = planned(drive(), &wish(8192));
    assert_eq!(finding(&absent, Question::Resolution).verdict, Verdict::Cannot);
}

#[test]
fn the_period_is_told_in_whole_milliseconds() {
    let with_exponent = |exponent| planned(drive().rw(0x60C2, 1, 8).rw(0x60C2, 2, exponent), &wishes());
    assert_eq!(of_index(&written(&with_exponent(-3)), &["60C2"]), ["60C2:1 = 3"]);
    let ten = Protocol { period: Duration::from_millis(10), ..protocol() };
    let plan_of = |dictionary| plan(&survey(dictionary, &wishes()), &wishes(), &ten);
    assert_eq!(of_index(&written(&plan_of(drive())), &["60C2"]), ["60C2:1 = A"], "(10, -3), not (1, -2)");
    // The same time in another exponent is right already.
    let right = plan_of(drive().rw(0x60C2, 1, 1).rw(0x60C2, 2, -2));
    assert_eq!(of_index(&written(&right), &["60C2"]), Vec::<&str>::new());
    // Milliseconds cannot hold half of one.
    let half = Protocol { period: Duration::from_micros(500), ..protocol() };
    let planned = plan(&survey(drive(), &wishes()), &wishes(), &half);
    assert_eq!(of_index(&written(&planned), &["60C2"]), ["60C2:1 = 5", "60C2:2 = FFFFFFFFFFFFFFFC"]);
    let only_milliseconds = drive().limited(0x60C2, 2, -3, -3);
    let refused = *plan(&survey(only_milliseconds, &wishes()), &wishes(), &half).refusal().unwrap();
    assert_eq!((refused.question, refused.verdict), (Question::Period, Verdict::Cannot));
}

#[test]
fn a_period_that_is_fixed_and_equal_is_accepted() {
    let fixed = |value| planned(drive().ro(0x60C2, 1, value).ro(0x60C2, 2, -3), &wishes());
    assert_eq!(fixed(3).verdict(), Verdict::Works);
    assert_eq!(of_index(&written(&fixed(3)), &["60C2"]), Vec::<&str>::new());
    assert_eq!(finding(&fixed(1), Question::Period).verdict, Verdict::Cannot);
    let absent = planned(drive().without(0x60C2, 1).without(0x60C2, 2), &wishes());
    assert_eq!(finding(&absent, Question::Period).verdict, Verdict::WorksWith);
    assert!(absent.refusal().is_none());
}

#[test]
fn a_rated_torque_may_be_fixed_missing_or_in_another_unit() {
    assert_eq!(planned(drive().ro(0x6076, 0, 200), &wishes()).verdict(), Verdict::Works);
    let remedy = |dictionary| finding(&planned(dictionary, &wishes()), Question::RatedTorque).remedy;
    assert_eq!(remedy(drive().without(0x6076, 0)), Remedy::TorqueStated);
    assert_eq!(remedy(drive().ro(0x6076, 0, 200_000)), Remedy::MicronewtonMetres);
    assert_eq!(remedy(drive().ro(0x6076, 0, 150)), Remedy::RatedTorque(150));
    let setting = Setting::of(&objects::RATED_TORQUE, Value::Unsigned32(200));
    assert_eq!(remedy(drive().rw(0x6076, 0, 0)), Remedy::Write(setting));

    let micro = RatedTorque::new(200_000, TorqueUnit::MicronewtonMetre).unwrap();
    let in_micro = DriveConfiguration { rated_torque: micro, ..wishes() };
    assert_eq!(planned(drive().ro(0x6076, 0, 200_000), &in_micro).verdict(), Verdict::Works);
    let stated = DriveConfiguration { torque_reference: TorqueReference::StatedTorque, ..wishes() };
    assert_eq!(planned(drive().without(0x6076, 0), &stated).verdict(), Verdict::Works);
}

#[test]
fn target_torque_can_refer_to_the_rated_current() {
    let wish = |milliamperes| DriveConfiguration {
        torque_reference: TorqueReference::RatedCurrent { milliamperes },
        ..wishes()
    };
    let dictionary = drive().without(0x6076, 0);
    assert_eq!(planned(dictionary.clone(), &wish(3000)).verdict(), Verdict::Works);
    let refused = *planned(dictionary, &wish(2000)).refusal().unwrap();
    assert_eq!(refused.object, objects::RATED_CURRENT.address());
}

#[test]
fn without_a_heartbeat_consumer_another_watchdog_is_named() {
    let without = drive().without(0x1016, 1);
    let refused = *planned(without.clone(), &wishes()).refusal().unwrap();
    assert_eq!((refused.question, refused.verdict), (Question::Watchdog, Verdict::Cannot));
    let with_timer = without.rw(0x1400, 5, 0);
    let helped = *planned(with_timer.clone(), &wishes()).refusal().unwrap();
    assert_eq!(helped.remedy, Remedy::RpdoTimeout);
    let watched = DriveConfiguration {
        watchdog: Watchdog::RpdoTimeout { milliseconds: 20, test: WatchdogTest::AtStart },
        ..wishes()
    };
    let plan = planned(with_timer, &watched);
    assert!(plan.refusal().is_none());
    assert_eq!(of_index(&written(&plan), &["1400:5", "1016"]), ["1400:5 = 14"]);
    // Where the drive has both, both are armed.
    let both = planned(drive().rw(0x1400, 5, 0), &watched);
    assert_eq!(of_index(&written(&both), &["1400:5", "1016"]), ["1016:1 = 7F0064", "1400:5 = 14"]);
    assert_eq!(finding(&planned(drive(), &watched), Question::Watchdog).verdict, Verdict::Cannot, "no 1400h:05");
}

#[test]
fn a_drive_that_would_do_nothing_without_its_master_is_refused() {
    let nothing = *planned(drive().rw(0x6007, 0, 0), &wishes()).refusal().unwrap();
    let fault = Setting::of(&objects::ABORT_CONNECTION_OPTION, Value::Integer16(1));
    assert_eq!(nothing.remedy, Remedy::Write(fault));
    let absent = *planned(drive().without(0x6007, 0), &wishes()).refusal().unwrap();
    assert_eq!(absent.remedy, Remedy::ExplainAbortOption);
    let explained = DriveConfiguration { abort_option: AbortOption::Explained, ..wishes() };
    for dictionary in [drive().rw(0x6007, 0, 0), drive().without(0x6007, 0)] {
        let plan = planned(dictionary, &explained);
        assert!(plan.refusal().is_none());
        assert_eq!(finding(&plan, Question::LossReaction).verdict, Verdict::WorksWith, "it is told");
    }
    let mut set = wishes();
    set.settings.push(fault).unwrap();
    assert_eq!(planned(drive().rw(0x6007, 0, 0), &set).verdict(), Verdict::Works);
}

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
fn gears_and_units_of_the_drive_must_be_neutral() {
    let units = |dictionary| finding(&planned(dictionary, &wishes()), Question::PositionUnits);
    let neutral = drive().rw(0x6091, 1, 1).rw(0x6091, 2, 1).rw(0x6092, 1, 1).rw(0x6092, 2, 1);
    assert_eq!(units(neutral.clone()).verdict, Verdict::Works);
    let counts = neutral.clone().rw(0x6092, 1, COUNTS.into());
    assert_eq!(units(counts).verdict, Verdict::Works);
    let stated = DriveConfiguration { resolution: Resolution::Stated, ..wishes() };
    let counts = neutral.clone().without(0x608F, 1).rw(0x6092, 1, COUNTS.into());
    assert_eq!(finding(&planned(counts, &stated), Question::PositionUnits).verdict, Verdict::Works);
    let degrees = units(neutral.clone().rw(0x6092, 1, 360));
    assert_eq!(degrees.remedy, Remedy::Write(Setting::of(&objects::FEED, Value::Unsigned32(1))));
    let geared = units(neutral.rw(0x6091, 1, 100));
    assert_eq!(geared.remedy, Remedy::Write(Setting::of(&objects::GEAR_MOTOR_REVOLUTIONS, Value::Unsigned32(1))));
    let fixed = units(drive().ro(0x6091, 1, 100).ro(0x6091, 2, 1));
    assert_eq!(fixed.verdict, Verdict::Cannot);
}

#[test]
fn signs_of_the_drive_must_be_neutral() {
    let reversed = finding(&planned(drive().rw(0x607E, 0, 0x80), &wishes()), Question::Polarity);
    assert_eq!(reversed.remedy, Remedy::Write(Setting::of(&objects::POLARITY, Value::Unsigned8(0))));
    assert_eq!(finding(&planned(drive().rw(0x607E, 0, 0), &wishes()), Question::Polarity).verdict, Verdict::Works);
}

#[test]
fn a_drives_own_torque_limit_below_the_robots_is_told() {
    let low = planned(drive().rw(0x6072, 0, 500), &wishes());
    assert_eq!(finding(&low, Question::TorqueLimits).verdict, Verdict::WorksWith);
    assert!(low.refusal().is_none());
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

#[test]
fn an_entry_of_the_robot_file_reads_well() {
    let setting = Setting::of(&objects::ABORT_CONNECTION_OPTION, Value::Integer16(1));
    assert_eq!(
        Remedy::Write(setting).to_string(),
        "drive.writes: { index = 0x6007, subindex = 0, type = \"i16\", value = 1 }"
    );
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
