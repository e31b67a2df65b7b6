//! Instants of frames that a clock gave which was set in between: brought back to one clock, by the SYNC counter.

use serde::Serialize;
use uarm_loop::recording::FrameRecord;
use uarm_loop::uarm_io::drive::wire::Channel;
use uarm_loop::uarm_io::time::{Duration, Instant};

use super::source::{nanoseconds, whole_periods};

/// A clock that was set while it stamped frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockStep {
    /// When, s after the first frame.
    pub after_s: f64,
    /// By how much, s; negative if it was set back.
    pub by_s: f64,
}

/// How regular SYNCs are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Regularity {
    /// Between two SYNCs.
    pub period: Duration,
    /// After so long a pause the drives have stopped, and no SYNC with the next number comes.
    pub longest_pause: Duration,
}

/// Steps below this are not told: frames of two processors are stamped so far out of order.
const TOLD_NS: i128 = 1_000_000;
/// Share of a period by which a SYNC may be early or late.
const JITTER: f64 = 0.1;

/// A SYNC whose next one does not come within so many frames is taken for the last: a bus of 1 Mbit/s carries no more in two seconds.
const MOST_HELD: usize = 1 << 16;

/// Takes the steps of the clock out of instants of frames that come one by one. Without a SYNC counter only steps back can be seen:
/// otherwise the time decides.
#[derive(Debug)]
pub struct OneClock {
    pass: Pass,
    /// The instant of the first frame.
    first: Option<Instant>,
    /// The newest SYNC and what followed it: the next SYNC tells whether the clock was set.
    held: Vec<FrameRecord>,
}

impl OneClock {
    /// No frame yet.
    pub const fn new(regularity: Regularity) -> Self {
        let pass = Pass { regularity, shift: 0, latest: i128::MIN, previous: None, late: 0, steps: Vec::new() };
        Self { pass, first: None, held: Vec::new() }
    }

    /// Takes the next frame, and gives those that are complete, in their order.
    pub fn take(&mut self, frame: FrameRecord, give: &mut dyn FnMut(FrameRecord)) {
        self.first.get_or_insert(frame.at);
        if is_sync(&frame) {
            self.give(Some(i128::from(frame.at.nanoseconds())), give);
        } else if self.held.len() == MOST_HELD {
            self.give(None, give);
        }
        self.held.push(frame);
        // What is not behind a SYNC waits for none.
        if !self.held.first().is_some_and(is_sync) {
            self.give(None, give);
        }
    }

    /// Gives the frames that are left, and the steps.
    pub fn finish(mut self, give: &mut dyn FnMut(FrameRecord)) -> Vec<ClockStep> {
        self.give(None, give);
        self.pass.steps
    }

    /// Gives what is held; `next_sync` is the instant of the SYNC behind it, as it was stamped.
    fn give(&mut self, next_sync: Option<i128>, give: &mut dyn FnMut(FrameRecord)) {
        let Some(first) = self.first else { return };
        for mut frame in self.held.drain(..) {
            self.pass.frame(&mut frame, next_sync, first);
            give(frame);
        }
    }
}

fn is_sync(frame: &FrameRecord) -> bool {
    Channel::of(frame.frame.id()) == Some(Channel::Sync)
}

#[derive(Debug)]
struct Pass {
    regularity: Regularity,
    /// What is added to each instant, ns.
    shift: i128,
    /// The latest instant so far, on the one clock.
    latest: i128,
    /// The previous SYNC with a counter, on the one clock.
    previous: Option<(i128, u8)>,
    /// How late it was, ns, by those before it.
    late: i128,
    steps: Vec<ClockStep>,
}

impl Pass {
    /// `next_sync` is the instant of the SYNC after this frame, as it was stamped.
    fn frame(&mut self, frame: &mut FrameRecord, next_sync: Option<i128>, first: Instant) {
        let raw = i128::from(frame.at.nanoseconds());
        let shift_before = self.shift;
        if raw + self.shift < self.latest {
            self.shift = self.latest - raw;
        }
        let counter = frame.frame.data().first().copied().filter(|_| is_sync(frame));
        if let Some(counter) = counter {
            if let Some((previous, before)) = self.previous {
                let elapsed = raw + self.shift - previous;
                let periods = if counter > before { i128::from(counter - before) } else { 1 };
                let expected = nanoseconds(self.regularity.period) * periods;
                if self.is_step(elapsed, expected, next_sync.map(|next| next - raw)) {
                    self.shift += expected - elapsed;
                    self.late = 0;
                } else {
                    (_, self.late) = whole_periods(elapsed + self.late, nanoseconds(self.regularity.period));
                }
            }
            self.previous = Some((raw + self.shift, counter));
        }
        let by = shift_before - self.shift;
        if by.abs() >= TOLD_NS {
            let after = raw + self.shift - i128::from(first.nanoseconds());
            self.steps.push(ClockStep { after_s: after as f64 * 1e-9, by_s: by as f64 * 1e-9 });
        }
        self.latest = self.latest.max(raw + self.shift);
        frame.at = Instant::from_nanoseconds(u64::try_from(raw + self.shift).unwrap_or_default());
    }

    /// Whether the clock was set, where SYNCs that the counter puts `expected` apart are `elapsed` apart, and the next one
    /// comes `to_next` later.
    fn is_step(&self, elapsed: i128, expected: i128, to_next: Option<i128>) -> bool {
        let period = nanoseconds(self.regularity.period);
        // What follows a late SYNC is early by as much, if the loop is in step again.
        let is_early = elapsed + self.late < expected - period / 2;
        if elapsed > expected + nanoseconds(self.regularity.longest_pause) || is_early {
            return true;
        }
        // A loop that skipped ticks is back in step with the next SYNC; behind a clock that was set, all are as far off.
        let periods = |time: i128| time as f64 / period as f64;
        let off = |time: i128| (periods(time) - periods(time).round()).abs();
        let skips = periods(elapsed - expected) > 0.5;
        skips && off(elapsed) > JITTER && to_next.is_some_and(|next| (periods(next) - 1.0).abs() < JITTER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::StandardId;
    use uarm_loop::uarm_io::frame::Frame;
    use uarm_loop::uarm_io::link::FrameDirection;

    const REGULARITY: Regularity =
        Regularity { period: Duration::from_millis(3), longest_pause: Duration::from_millis(100) };

    /// A SYNC and an answer 0.2 ms later, for each instant in ms.
    fn frames(syncs: &[(f64, u8)]) -> Vec<FrameRecord> {
        let record = |id: u16, data: &[u8], milliseconds: f64| FrameRecord {
            sequence: 0,
            direction: FrameDirection::Sent,
            frame: Frame::new(StandardId::new(id).unwrap(), data).unwrap(),
            at: Instant::from_nanoseconds((milliseconds * 1e6).round() as u64),
        };
        let cycle = |&(at, counter): &(f64, u8)| [record(0x080, &[counter], at), record(0x181, &[0; 6], at + 0.2)];
        syncs.iter().flat_map(cycle).collect()
    }

    /// All frames on one clock, and the steps.
    fn on_one_clock(frames: &[FrameRecord]) -> (Vec<FrameRecord>, Vec<ClockStep>) {
        let (mut clock, mut given) = (OneClock::new(REGULARITY), Vec::new());
        frames.iter().for_each(|frame| clock.take(*frame, &mut |frame| given.push(frame)));
        let steps = clock.finish(&mut |frame| given.push(frame));
        (given, steps)
    }

    /// SYNCs on one clock, ms, and the steps, ms.
    fn one_clock(syncs: &[(f64, u8)]) -> (Vec<f64>, Vec<f64>) {
        let (frames, steps) = on_one_clock(&frames(syncs));
        let milliseconds = |frame: &FrameRecord| frame.at.nanoseconds() as f64 * 1e-6;
        let syncs = frames.iter().filter(|frame| is_sync(frame)).map(milliseconds).collect();
        (syncs, steps.iter().map(|step| (step.by_s * 1e6).round() / 1e3).collect())
    }

    #[test]
    fn a_step_forward_is_taken_out() {
        for step in [1000.0, 50.0, 333_333.0] {
            let syncs = [(3.0, 1), (6.0, 2), (9.0 + step, 3), (12.0 + step, 4)];
            assert_eq!(one_clock(&syncs), (vec![3.0, 6.0, 9.0, 12.0], vec![step]));
        }
    }

    #[test]
    fn a_step_back_is_taken_out() {
        let syncs = [(5003.0, 1), (5006.0, 2), (9.0, 3), (12.0, 240), (15.0, 1)];
        let (syncs, steps) = one_clock(&syncs[..3]);
        assert_eq!((syncs, steps), (vec![5003.0, 5006.0, 5009.0], vec![-5000.0]));
    }

    #[test]
    fn a_step_beside_lost_syncs_is_the_rest_of_the_pause() {
        let syncs = [(3.0, 1), (6.0, 2), (1015.0, 5), (1018.0, 6)];
        assert_eq!(one_clock(&syncs), (vec![3.0, 6.0, 15.0, 18.0], vec![1000.0]));
    }

    /// Behind an answer at 6.2 ms the clock says 1.0 ms: no earlier than that it came.
    #[test]
    fn without_a_counter_a_step_back_is_seen_at_the_next_frame() {
        let mut frames = frames(&[(3.0, 0), (6.0, 0), (1.0, 0)]);
        for frame in frames.iter_mut().filter(|frame| is_sync(frame)) {
            frame.frame = Frame::new(StandardId::new(0x080).unwrap(), &[]).unwrap();
        }
        let (given, steps) = on_one_clock(&frames);
        let instants: Vec<_> = given.iter().map(|frame| frame.at.nanoseconds()).collect();
        assert_eq!(instants, [3_000_000, 3_200_000, 6_000_000, 6_200_000, 6_200_000, 6_400_000]);
        let [ClockStep { after_s, by_s }] = steps.as_slice() else { panic!("{steps:?}") };
        assert!((after_s - 0.0032).abs() < 1e-12 && (by_s + 0.0052).abs() < 1e-12, "{steps:?}");
    }

    #[test]
    fn skipped_ticks_and_lost_syncs_are_no_steps() {
        for syncs in [
            [(3.0, 1), (6.0, 2), (13.0, 3), (15.0, 4)], // late by a third of a period, then in step again
            [(3.0, 1), (6.0, 2), (18.0, 3), (21.0, 4)], // four periods on
            [(3.0, 1), (6.0, 2), (18.0, 6), (21.0, 7)], // lost
            [(3.0, 239), (6.0, 240), (9.0, 1), (12.0, 2)], // the counter begins again
            [(3.0, 1), (6.0, 2), (10.6, 3), (12.0, 4)], // late by more than half a period, then in step again
            [(3.0, 1), (6.0, 2), (14.0, 3), (15.0, 4)], // the same behind a tick that was skipped
        ] {
            let times: Vec<_> = syncs.iter().map(|(at, _)| *at).collect();
            assert_eq!(one_clock(&syncs), (times, Vec::new()), "{syncs:?}");
        }
    }

    #[test]
    fn without_a_counter_the_time_decides() {
        let mut frames = frames(&[(3.0, 0), (6.0, 0), (1009.0, 0)]);
        for frame in frames.iter_mut().filter(|frame| is_sync(frame)) {
            frame.frame = Frame::new(StandardId::new(0x080).unwrap(), &[]).unwrap();
        }
        assert_eq!(on_one_clock(&frames), (frames, Vec::new()));
    }
}
