//! SYNC, period, watchdogs.

use super::*;

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

/// A dictionary that says that 1019h cannot be written.
#[test]
fn a_counter_that_cannot_be_written_is_not_chosen() {
    let network = NetworkConfiguration::new([wishes()], protocol().period).unwrap();
    let of = |dictionary| network.plan(&survey(dictionary, &wishes()), &wishes());
    let fixed = of(drive().ro(0x1019, 0, 0));
    assert_eq!(finding(&fixed, Question::Sync).verdict, Verdict::Works);
    assert_eq!(finding(&of(drive().ro(0x1019, 0, 240)), Question::Sync).wanted, Wanted::Number(240));
    assert_eq!(finding(&of(drive().ro(0x1019, 0, 10)), Question::Sync).verdict, Verdict::Cannot);
}

#[test]
fn the_sync_counter_is_chosen_by_what_all_drives_have() {
    use SyncCounterChoice::{Auto, Off, On};
    let chosen = [(Auto, true), (Auto, false), (On, false), (Off, true)].map(|(choice, all)| choice.payload(all));
    assert_eq!(chosen, [SyncPayload::Counter, SyncPayload::Empty, SyncPayload::Counter, SyncPayload::Empty]);
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

/// A drive does not say that its exponent is fixed until it is written to.
#[test]
fn the_period_is_told_in_the_exponent_that_the_drive_has() {
    let told = |dictionary| of_index(&written(&planned(dictionary, &wishes())), &["60C2"]).join(", ");
    let with = |exponent| drive().rw(0x60C2, 1, 1).rw(0x60C2, 2, exponent);
    assert_eq!(told(with(-4)), "60C2:1 = 1E", "30 of 0.1 ms");
    assert_eq!(told(drive().rw(0x60C2, 1, 1).ro(0x60C2, 2, -4)), "60C2:1 = 1E", "as a dictionary says it");
    for cannot_hold_it in [-2, -6] {
        assert_eq!(told(with(cannot_hold_it)), "60C2:1 = 3, 60C2:2 = FFFFFFFFFFFFFFFD", "{cannot_hold_it}");
    }
}

#[test]
fn a_period_that_is_fixed_and_equal_is_accepted() {
    let fixed = |value| planned(drive().ro(0x60C2, 1, value).ro(0x60C2, 2, -3), &wishes());
    assert_eq!(fixed(3).verdict(), Verdict::Works);
    assert_eq!(of_index(&written(&fixed(3)), &["60C2"]), Vec::<&str>::new());
    let other = finding(&fixed(1), Question::Period);
    assert_eq!((other.verdict, other.remedy), (Verdict::WorksWith, Remedy::Period(1000)));
    assert_eq!(other.remedy.to_string(), "[control] period_us = 1000");
    assert_eq!(finding(&fixed(0), Question::Period).verdict, Verdict::Cannot);
    let absent = planned(drive().without(0x60C2, 1).without(0x60C2, 2), &wishes());
    assert_eq!(finding(&absent, Question::Period).verdict, Verdict::WorksWith);
    assert!(absent.refusal().is_none());
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
    let undone = Setting::of(&objects::ABORT_CONNECTION_OPTION, Value::Integer16(0));
    set.later_settings.push(undone).unwrap();
    for dictionary in [drive().rw(0x6007, 0, 0), drive().rw(0x6007, 0, 1)] {
        let refused = *planned(dictionary, &set).refusal().unwrap();
        assert_eq!(
            (refused.question, refused.found),
            (Question::LossReaction, Answer::Number(0)),
            "what is written last"
        );
    }
}

/// What the robot file would write is not what the drive says.
#[test]
fn a_drive_that_does_nothing_without_its_master_and_cannot_be_told_to_is_refused_in_words() {
    let fault = Setting::of(&objects::ABORT_CONNECTION_OPTION, Value::Integer16(1));
    let mut writes = wishes();
    writes.settings.push(fault).unwrap();
    let mut writes_later = wishes();
    writes_later.later_settings.push(fault).unwrap();
    for wish in [wishes(), writes, writes_later] {
        let fixed = finding(&planned(drive().ro(0x6007, 0, 0), &wish), Question::LossReaction);
        assert_eq!((fixed.verdict, fixed.found), (Verdict::Cannot, Answer::Number(0)));
        assert!(matches!(fixed.remedy, Remedy::RobotFile(words) if words.contains("drive.without_6007h")));
        let absent = finding(&planned(drive().without(0x6007, 0), &wish), Question::LossReaction);
        assert_eq!((absent.found, absent.remedy), (Answer::Absent, Remedy::ExplainAbortOption));
        let other = finding(&planned(drive().ro(0x6007, 0, 2), &wish), Question::LossReaction);
        assert_eq!((other.verdict, other.found), (Verdict::Works, Answer::Number(2)));
    }
}

/// The file's last word must not be that nobody watches.
#[test]
fn a_watchdog_that_the_robot_file_would_switch_off_is_refused() {
    let off = Setting::of(&objects::CONSUMER_HEARTBEAT_TIME, Value::Unsigned32(0));
    let mut undone = wishes();
    undone.later_settings.push(off).unwrap();
    let refused = *planned(drive(), &undone).refusal().unwrap();
    assert_eq!((refused.question, refused.verdict), (Question::Watchdog, Verdict::Cannot));
    let mut overruled = wishes();
    overruled.settings.push(off).unwrap();
    let plan = planned(drive(), &overruled);
    assert!(plan.refusal().is_none());
    assert_eq!(of_index(&written(&plan), &["1016"]), ["1016:1 = 7F0064"], "the protocol comes later");

    let watchdog = Watchdog::RpdoTimeout { milliseconds: 20, test: WatchdogTest::AtStart };
    let mut timed = DriveConfiguration { watchdog, ..wishes() };
    let timer = PdoKind::Receive.event_timer(timed.pdos.command.number);
    timed.later_settings.push(Setting::of(&timer, Value::Unsigned16(0))).unwrap();
    let refused = *planned(drive().rw(0x1400, 5, 0), &timed).refusal().unwrap();
    assert_eq!((refused.question, refused.found), (Question::Watchdog, Answer::Number(0)));
}
