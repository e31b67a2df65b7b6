use super::*;

const PERIOD: Duration = Duration::from_millis(3);

/// 93.7 counts are a degree of the paper's robot; 360 degrees per second are its velocity limit.
fn watch(motor: Motor) -> Watch {
    Watch { node: 2, period: PERIOD, travel: 9_370.0, speed: 33_739.0, timeout: Duration::from_secs(10), motor }
}

/// Statuswords of *Operation enabled* with these bits, as the table of CiA 402-2 has them.
const RUNNING: u16 = 0x0027;
const IDLE: u16 = 0x0427;
const ATTAINED: u16 = 0x1027;
const DONE: u16 = 0x1427;
const FAILED: u16 = 0x2427;

/// What comes of these readings, one a cycle, the first five of which are before the start.
fn outcome(motor: Motor, readings: impl IntoIterator<Item = (i32, u16)>) -> Result<Option<usize>, HomingError<()>> {
    let watch = watch(motor);
    let mut progress = Progress::new(&watch, Instant::default());
    for (cycle, (position, bits)) in readings.into_iter().enumerate() {
        let tick = Instant::default() + PERIOD * cycle as u32;
        if progress.note(position, Statusword::from_bits(bits), tick)? == Stage::Home {
            return Ok(Some(cycle));
        }
        let starts = progress.command(tick).contains(Controlword::HOMING_START);
        assert_eq!(starts, cycle >= 4, "cycle {cycle}");
    }
    Ok(None)
}

fn lead(bits: u16) -> impl Iterator<Item = (i32, u16)> {
    std::iter::repeat_n((0, bits), 6)
}

#[test]
fn home_is_where_the_drive_says_that_it_is_done_and_stands() {
    let way = [(0, RUNNING), (50, RUNNING), (90, ATTAINED), (90, DONE)];
    assert_eq!(outcome(Motor::Turns, lead(IDLE).chain(way)).unwrap(), Some(9));
}

#[test]
fn what_an_earlier_homing_left_is_not_taken_for_this_one() {
    // Bit 12 of the last homing falls a cycle after the start.
    let way = [(0, DONE), (0, RUNNING), (9, DONE)];
    assert_eq!(outcome(Motor::Turns, lead(DONE).chain(way)).unwrap(), Some(8));
    // One that never falls is none of this homing, for a method that turns the motor.
    assert_eq!(outcome(Motor::Turns, std::iter::repeat_n((0, DONE), 100)).unwrap(), None);
    // A method that does not may be done within a cycle: 5 cycles and 100 ms.
    assert_eq!(outcome(Motor::Stays, std::iter::repeat_n((0, DONE), 100)).unwrap(), Some(4 + 34));
    // So is an error that stood there before.
    let way = [(0, FAILED), (0, RUNNING), (9, DONE)];
    assert_eq!(outcome(Motor::Turns, lead(FAILED).chain(way)).unwrap(), Some(8));
}

#[test]
fn an_error_of_the_drive_ends_it() {
    for way in [vec![(0, RUNNING), (0, FAILED)], vec![(0, FAILED)]] {
        let error = outcome(Motor::Turns, lead(IDLE).chain(way)).unwrap_err();
        assert!(matches!(error, HomingError::Failed { node: 2, statusword: FAILED }), "{error:?}");
    }
    let stays = outcome(Motor::Turns, std::iter::repeat_n((0, FAILED), 100)).unwrap_err();
    assert!(stays.to_string().contains("homing error"), "{stays}");
}

#[test]
fn a_joint_that_goes_too_far_or_too_fast_or_takes_too_long_ends_it() {
    let far = (0..400).map(|cycle| (cycle * 30, RUNNING));
    let error = outcome(Motor::Turns, far).unwrap_err().to_string();
    assert!(error.contains("moved by +9390 counts") && error.contains("travel_deg"), "{error}");
    // 33 739 counts per second are 101.2 in 3 ms.
    let fast = (0..80).map(|cycle| (cycle * -110, RUNNING));
    let error = outcome(Motor::Turns, fast).unwrap_err().to_string();
    assert!(error.contains("turned at 36667 counts per second"), "{error}");
    let slow = std::iter::repeat_n((0, RUNNING), 4_000);
    let error = outcome(Motor::Turns, slow).unwrap_err().to_string();
    assert!(error.contains("not home after 10s"), "{error}");
}

/// The drive counts from home when it has found it: that step is none of the joint.
#[test]
fn the_counter_may_be_set_anew_once() {
    let way = [(5_000, RUNNING), (5_001, RUNNING), (0, DONE)];
    assert_eq!(outcome(Motor::Turns, [(5_000, IDLE); 6].into_iter().chain(way)).unwrap(), Some(8));
    let way = [(9_000, RUNNING), (5_000, RUNNING), (9_000, DONE)];
    let error = outcome(Motor::Turns, [(9_000, IDLE); 6].into_iter().chain(way)).unwrap_err().to_string();
    assert!(error.contains("jumped by +4000 counts again"), "{error}");
}
