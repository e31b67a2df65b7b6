//! What numbers of the drive mean: resolution, torque, gears, signs.

use super::*;

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

/// 24576 counts in 3 revolutions are 8192 in one.
#[test]
fn a_resolution_of_several_revolutions_is_stated_for_one() {
    let remedy = |dictionary| finding(&planned(dictionary, &wishes()), Question::Resolution).remedy;
    let fixed = drive().ro(0x608F, 1, 24_576).ro(0x608F, 2, 3);
    assert_eq!(remedy(fixed.clone()), Remedy::CountsPerRevolution(8192));
    let stated = DriveConfiguration { counts_per_revolution: 8192, ..wishes() };
    assert_eq!(planned(fixed, &stated).verdict(), Verdict::Works);
    let one = Setting::of(&objects::ENCODER_REVOLUTIONS, Value::Unsigned32(1));
    assert_eq!(remedy(drive().rw(0x608F, 1, 24_576).rw(0x608F, 2, 3)), Remedy::Write(one));
    let no_whole_number = drive().ro(0x608F, 1, 24_577).ro(0x608F, 2, 3);
    assert_eq!(finding(&planned(no_whole_number, &wishes()), Question::Resolution).verdict, Verdict::Cannot);
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
    let refused = *planned(dictionary.clone(), &wish(2000)).refusal().unwrap();
    assert_eq!(refused.object, objects::RATED_CURRENT.address());
    // What a drive itself says is not overwritten; a dictionary's default may be.
    let fixed = *planned(dictionary.ro(0x6075, 0, 3000), &wish(2000)).refusal().unwrap();
    assert_eq!(fixed.remedy, Remedy::RatedCurrent(3000));
    assert!(fixed.to_string().contains("drive.rated_current_ma = 3000 if the drive is right"), "{fixed}");
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
