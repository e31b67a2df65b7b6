//! What a replay compares, and what it does not.

use uarm_log::replay::bus_cycles::Continuity;
use uarm_log::replay::exact::{Begin, ExactReplay, ExactRun, Start};
use uarm_log::replay::source::{Behind, Source};
use uarm_log::signals::Value;

use crate::support::{FaintLaw, RampLaw, Run, bus_cycle, run};

fn replay(run: &Run, start: Start) -> ExactReplay {
    ExactReplay::run(&run.source(), &mut RampLaw::default(), start).unwrap()
}

fn from_beginning(run: &Run) -> ExactReplay {
    replay(run, Start::Beginning)
}

#[test]
fn a_run_is_equal_to_itself() {
    let outcome = from_beginning(&run(12));
    assert!(outcome.is_equal());
    assert_eq!((outcome.cycles, outcome.keyframes, outcome.lost_cycles, outcome.resumed), (12, 2, 0, 0));
    assert_eq!((outcome.from, outcome.differences, outcome.fault), (0.0, Vec::new(), None));
}

#[test]
fn where_only_the_bus_was_recorded_its_torques_are_compared() {
    let outcome = from_beginning(&run(12).bus_only());
    assert!(outcome.is_equal());
    assert_eq!((outcome.cycles, outcome.signals), (12, 36), "three torques a cycle");
}

/// 1.1 rad of joint 2 are 6303 counts: beyond the limit of 1 rad.
fn beyond_a_limit() -> Run {
    let mut run = run(4);
    run.bus.push(bus_cycle(4, [0, 6_303, 0]));
    run.bus[4].sent = [None; 3];
    run
}

#[test]
fn a_fault_is_reproduced_only_if_it_is_the_recorded_one() {
    let text = "joint 2 at 0.012 s: angle is 63.03 deg, expected -57.30 to 57.30 deg";
    let mut run = beyond_a_limit();
    run.fault = Some("the loop ended: joint 2 at 0.012 s: angle is 63.03 deg, expected -57.30 to 57.30 deg");
    let outcome = from_beginning(&run);
    assert_eq!((outcome.fault.as_deref(), outcome.fault_reproduced), (Some(text), Some(true)));
    assert!(outcome.is_equal());

    run.fault = Some("the CAN link failed");
    let outcome = from_beginning(&run);
    assert_eq!((outcome.fault.as_deref(), outcome.fault_reproduced), (Some(text), Some(false)));
    assert!(!outcome.is_equal());
}

#[test]
fn a_recording_of_the_bus_alone_may_end_with_a_fault_but_not_go_on_behind_it() {
    let outcome = from_beginning(&beyond_a_limit().bus_only());
    assert!(outcome.fault.is_some_and(|fault| fault.starts_with("joint 2 at 0.012 s: angle is 63.03 deg")));
    assert_eq!(outcome.fault_reproduced, None);

    let mut run = beyond_a_limit().bus_only();
    run.bus.push(bus_cycle(5, [-5, 15, 10]));
    let outcome = from_beginning(&run);
    assert_eq!((outcome.is_equal(), outcome.fault_reproduced), (false, Some(false)));
}

/// Where one state differs, all that follow do.
#[test]
fn keyframes_that_differ_are_counted_and_told_once() {
    let mut run = run(12);
    for (_, keyframe) in &mut run.keyframes[1..] {
        keyframe.torque_applied.x += 1e-9;
    }
    let outcome = from_beginning(&run);
    assert_eq!((outcome.keyframes, outcome.differing_keyframes), (2, 2));
    let told: Vec<_> = outcome.differences.iter().map(|difference| (difference.tick, &difference.signal)).collect();
    assert_eq!(told, [(4, &"inner state equals the keyframe".to_owned())]);
    assert!(!outcome.is_equal());
}

#[test]
fn a_killed_run_ends_with_its_last_record() {
    let mut run = run(6);
    run.records.pop();
    let outcome = from_beginning(&run);
    assert!(outcome.is_equal());
    assert_eq!((outcome.cycles, outcome.fault_reproduced), (5, None));
    // With a limit passed in the cycle that the process was killed in, too: nobody knows whether it saw it.
    let outcome = from_beginning(&beyond_a_limit());
    assert_eq!((outcome.is_equal(), outcome.cycles, outcome.fault), (true, 4, None));
}

#[test]
fn a_record_that_is_missing_in_the_middle_is_no_end() {
    let mut run = run(6);
    run.records.remove(2);
    let outcome = from_beginning(&run);
    assert_eq!((outcome.is_equal(), outcome.cycles), (true, 6), "its frames are compared");
}

#[test]
fn the_stop_after_the_last_sync_is_not_a_torque_of_the_law() {
    for sent in [[Some(0); 3], [None; 3], [Some(0), None, None]] {
        let mut run = run(6).bus_only();
        run.bus[5].sent = sent;
        let outcome = from_beginning(&run);
        assert_eq!((outcome.is_equal(), outcome.cycles), (true, 5), "{sent:?}");
    }
    // Zero in the middle of a run is a torque, and a wrong one.
    let mut run = run(6).bus_only();
    run.bus[3].sent = [Some(0); 3];
    let outcome = from_beginning(&run);
    assert_eq!((outcome.differing_cycles, outcome.cycles), (1, 6));
    let [first, second] = outcome.differences.as_slice() else { panic!("{:?}", outcome.differences) };
    assert_eq!((first.tick, first.signal.as_str()), (3, "torque in the frame to joint 2, per mille"));
    assert_eq!((first.recorded, first.replayed), (Value::Integer(0), Value::Integer(265)));
    assert_eq!(
        (second.signal.as_str(), second.replayed),
        ("torque in the frame to joint 3, per mille", Value::Integer(-200))
    );
    // And so is one of the last cycle that is not zero.
    run.bus[3] = bus_cycle(3, [-3, 9, 6]);
    run.bus[5].sent = [Some(0), Some(1), Some(0)];
    assert!(!from_beginning(&run).is_equal());
}

#[test]
fn all_differences_are_counted_and_the_first_ten_are_kept() {
    let mut run = run(20);
    for record in &mut run.records[3..18] {
        record.torque_applied[1] = 0.125;
    }
    let outcome = from_beginning(&run);
    assert_eq!((outcome.differing_cycles, outcome.differences.len()), (15, 10));
    let ticks: Vec<u64> = outcome.differences.iter().map(|difference| difference.tick).collect();
    assert_eq!(ticks, (3..13).collect::<Vec<_>>());
    assert!(!outcome.is_equal());
}

#[test]
fn a_cycle_that_differs_in_record_frame_and_state_is_one_cycle() {
    let mut run = run(6);
    run.records[4].torque_sent[1] = 1;
    run.bus[4].sent[1] = Some(1);
    run.keyframes[1].1.torque_applied.x = 0.125;
    let outcome = from_beginning(&run);
    let signals: Vec<&str> = outcome.differences.iter().map(|difference| difference.signal.as_str()).collect();
    let expected =
        ["torque_sent_2_per_mille", "torque in the frame to joint 2, per mille", "inner state equals the keyframe"];
    assert_eq!((signals.as_slice(), outcome.differing_cycles), (expected.as_slice(), 1));
}

#[test]
fn behind_a_gap_a_replay_goes_on_from_the_next_keyframe() {
    let mut run = run(12);
    run.bus[2].continuity = Continuity::Broken;
    let outcome = from_beginning(&run);
    // Ticks 2, 3 and 4 are lost; a keyframe follows tick 4.
    assert_eq!((outcome.cycles, outcome.lost_cycles, outcome.resumed), (9, 3, 1));
    assert!(outcome.is_equal());
    // A SYNC that is not there at all is a gap, too.
    let mut run = self::run(12);
    run.bus.remove(2);
    let outcome = from_beginning(&run);
    assert_eq!((outcome.cycles, outcome.lost_cycles, outcome.resumed), (9, 2, 1));
}

#[test]
fn a_replay_may_begin_at_a_keyframe() {
    // Keyframes follow ticks 4 (0.012 s) and 9 (0.027 s).
    for (before, from, cycles) in [(0.001, 0.0, 12), (0.02, 0.012, 7), (0.027, 0.012, 7), (1.0, 0.027, 2)] {
        let outcome = replay(&run(12), Start::KeyframeBefore(before));
        assert_eq!((outcome.from, outcome.cycles, outcome.is_equal()), (from, cycles, true), "before {before} s");
    }
    let mut run = run(12);
    run.keyframes.remove(0);
    let error = ExactReplay::run(&run.source(), &mut RampLaw::default(), Start::KeyframeBefore(0.01)).unwrap_err();
    assert_eq!(error.to_string(), "no keyframe before 0.01 s");
}

/// 7 per mille that fade over 50 ms, a period of 3 ms being 6 %: the first of them, 6.58, is sent as 7, as without a ramp.
const FADING: [i16; 17] = [7, 6, 6, 5, 5, 4, 4, 4, 3, 3, 2, 2, 2, 1, 1, 0, 0];

fn faint(torques: impl Iterator<Item = i16>) -> ExactReplay {
    let mut run = run(0).bus_only();
    run.bus = torques
        .zip(0..)
        .map(|(torque, tick)| (tick, torque))
        .map(|(tick, torque)| {
            let mut cycle = bus_cycle(tick, [0; 3]);
            cycle.sent = [Some(0), Some(torque), Some(0)];
            cycle
        })
        .collect();
    ExactReplay::run(&run.source(), &mut FaintLaw, Start::Beginning).unwrap()
}

#[test]
fn a_ramp_begins_where_all_that_follows_is_one() {
    let outcome = faint([7; 4].into_iter().chain(FADING).chain([0]));
    assert_eq!((outcome.is_equal(), outcome.faded_from), (true, Some(0.012)), "{:?}", outcome.differences);
    // No ramp: the torques stay, and then the motors are stopped.
    let outcome = faint([7; 21].into_iter().chain([0]));
    assert_eq!((outcome.is_equal(), outcome.faded_from), (true, None), "{:?}", outcome.differences);
    // Half a ramp is none.
    let outcome = faint([7; 4].into_iter().chain(FADING[..8].iter().copied()).chain([7; 9]));
    assert_eq!((outcome.is_equal(), outcome.faded_from, outcome.differing_cycles), (false, None, 7));
}

#[test]
fn a_replay_says_whether_it_compared_anything_and_all() {
    let none = ExactReplay::default();
    assert_eq!((none.has_compared(), none.has_loss()), (false, false));
    assert!(ExactReplay { signals: 1, ..none.clone() }.has_compared());
    assert!(ExactReplay { fault_reproduced: Some(true), ..none.clone() }.has_compared());
    assert!(ExactReplay { lost_cycles: 1, ..none.clone() }.has_loss());
    assert!(ExactReplay { missing_torques: 1, ..none.clone() }.has_loss());
    assert!(ExactReplay { missing_positions: 1, ..none }.has_loss());
}

#[test]
fn the_bus_alone_is_replayed_from_its_first_sync_only() {
    let mut run = run(4).bus_only();
    for first in [None, Some(0), Some(1)] {
        run.bus[0].counter = first;
        assert_eq!(from_beginning(&run).cycles, 4);
    }
    run.bus[0].counter = Some(2);
    let error = ExactReplay::run(&run.source(), &mut RampLaw::default(), Start::Beginning).unwrap_err();
    assert!(error.to_string().starts_with("its first SYNC has the number 2, expected 1"), "{error}");
}

/// Keyframes follow ticks 4 (0.012 s) and 9.
#[test]
fn a_log_that_lost_its_beginning_is_taken_up_at_its_first_keyframe() {
    let without = |lost: usize| {
        let mut run = run(12);
        run.keyframes.remove(0);
        run.bus.drain(..lost);
        run.records.drain(..lost);
        from_beginning(&run)
    };
    let outcome = without(5);
    assert_eq!((outcome.from, outcome.cycles, outcome.lost_cycles, outcome.resumed), (0.012, 7, 0, 0));
    // Tick 4 is there, and the state before it is not.
    let outcome = without(4);
    assert_eq!((outcome.cycles, outcome.lost_cycles, outcome.resumed), (7, 1, 1));
    assert!(outcome.is_equal());
}

/// A count that came, and that the file lacks, or one that did not come: the torques tell.
#[test]
fn a_position_that_is_missing_on_the_bus_was_predicted_if_the_torques_say_so() {
    let mut run = run(12).bus_only();
    run.bus[3].counts[1] = None;
    let outcome = from_beginning(&run);
    assert_eq!((outcome.cycles, outcome.predicted_cycles, outcome.missing_positions), (12, 1, 1));
    assert_eq!((outcome.is_equal(), outcome.lost_cycles), (true, 0));
    run.bus[3].sent[1] = Some(999);
    let outcome = from_beginning(&run);
    assert_eq!((outcome.cycles, outcome.predicted_cycles, outcome.lost_cycles), (3, 0, 9));
    assert!(outcome.is_equal(), "nothing is known to differ");
    // Without torques the loop did not go through that cycle.
    run.bus[3].sent = [None; 3];
    let outcome = from_beginning(&run);
    assert_eq!((outcome.cycles, outcome.predicted_cycles, outcome.lost_cycles), (3, 0, 9));
}

/// The loop may have had the count: its record would say so.
#[test]
fn a_position_that_is_missing_in_a_cycle_without_its_record_is_a_gap_in_a_log() {
    let mut run = run(12);
    run.records.remove(2);
    run.bus[2].counts[1] = None;
    let outcome = from_beginning(&run);
    // Ticks 2, 3 and 4 are lost; a keyframe follows tick 4.
    assert_eq!((outcome.cycles, outcome.lost_cycles, outcome.resumed), (9, 3, 1));
}

#[test]
fn torques_that_are_missing_on_the_bus_are_counted() {
    let mut run = run(12).bus_only();
    run.bus[3].sent[1] = None;
    // Of the last cycle they may not have been sent any more.
    run.bus[11].sent[2] = None;
    let outcome = from_beginning(&run);
    assert_eq!((outcome.cycles, outcome.missing_torques, outcome.lost_cycles), (12, 1, 0));
    run.bus[3].sent = [None; 3];
    let outcome = from_beginning(&run);
    assert_eq!((outcome.cycles, outcome.missing_torques, outcome.lost_cycles), (11, 3, 1));
    assert!(outcome.is_equal());
}

/// The process was gone, and something else sent SYNCs: what nobody answered is no part of the run, in whatever window it is.
#[test]
fn cycles_behind_the_last_answer_are_not_lost() {
    let mut run = run(8).bus_only();
    for cycle in &mut run.bus[4..] {
        (cycle.counts, cycle.sent) = ([None; 3], [None; 3]);
    }
    let (mut law, source) = (RampLaw::default(), run.source());
    let mut replay = ExactRun::new(&run.robot, &run.settings, &mut law, Begin::Beginning).unwrap();
    replay.window(&Source { bus: &run.bus[..6], behind: Behind::More, ..source }).unwrap();
    replay.window(&Source { bus: &run.bus[6..], ..source }).unwrap();
    let outcome = replay.finish().unwrap();
    assert_eq!((outcome.cycles, outcome.lost_cycles), (4, 0));
}
