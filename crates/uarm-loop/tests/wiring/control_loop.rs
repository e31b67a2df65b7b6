//! The loop on a bus whose every step takes a known time.

use std::convert::Infallible;
use std::f64::consts::TAU;

use uarm_loop::control_loop::{ControlLoop, LoopEnd, LoopFault};
use uarm_loop::fade::{Fade, StopRamp};
use uarm_loop::keyframe::Keyframe;
use uarm_loop::motion::Motion;
use uarm_loop::period::Period;
use uarm_loop::progress::{Progress, ProgressSnapshot};
use uarm_loop::record::{CycleRecord, HealthRecord, Recorder};
use uarm_loop::schedule::{Allowed, Overrun, OverrunPolicy, Schedule};
use uarm_loop::signal_path::SignalFault;
use uarm_loop::stop_request::StopRequest;
use uarm_loop::supervisor::{Authority, Ordinary, Supervisor};
use uarm_loop::task_clock::{PeriodSource, TaskClock};
use uarm_loop::timing::{CycleInstants, TimingRecorder, TimingSummary, Verdict};
use uarm_loop::uarm_io::drive::network::CycleError;
use uarm_loop::uarm_io::drive::{DriveNetwork, NmtState};
use uarm_loop::uarm_io::time::{Duration, Instant};

use crate::fake_bus::{FakeBus, LateClock, network};
use crate::fake_path::{FakeLaw, PARAMETERS, path, rest};

/// The first tick.
const ORIGIN: Instant = Instant::from_nanoseconds(3_000_000);

struct Experiment {
    clock: LateClock,
    drives: DriveNetwork<FakeBus, 3>,
    motion: Motion<2>,
    period: Duration,
    source: PeriodSource,
    overrun: OverrunPolicy,
    stop: StopRequest,
    progress: Progress<2>,
    start_tolerance: f64,
    stop_ramp: Duration,
}

impl Experiment {
    fn new(motion: Motion<2>) -> Self {
        let clock = LateClock::default();
        Self {
            drives: network(&clock),
            clock,
            motion,
            period: Duration::from_millis(3),
            source: PeriodSource::Scheduled,
            overrun: OverrunPolicy::Skip,
            stop: StopRequest::default(),
            progress: Progress::default(),
            start_tolerance: 100.0,
            stop_ramp: Duration::from_millis(12),
        }
    }

    /// Runs the loop; `after` is called with the number of records after each of them.
    fn run(
        &mut self,
        after: impl FnMut(usize),
    ) -> (Result<LoopEnd, LoopFault<CycleError<Infallible>>>, Recorded, TimingSummary) {
        let mut law = FakeLaw::constant(0.05, -0.04);
        let period = Period::new(self.period).unwrap();
        let mut path = path(&mut law, self.motion.clone());
        path.task_clock = TaskClock::new(self.source, self.motion.start());
        path.guard.start_tolerance = self.start_tolerance;
        path.torque.fade = Fade::new(StopRamp::new(self.stop_ramp).unwrap());
        let timing = TimingRecorder::new(self.period);
        let mut control_loop =
            ControlLoop { path, feedback_timeout: self.period, timing, progress: &self.progress, stop: &self.stop };
        let mut schedule = Schedule::new(ORIGIN, period, self.overrun);
        let mut recorder = Recording { recorded: Recorded::default(), after };
        let mut supervisor = Supervisor::<()>::default();
        for event in [Ordinary::Begin, Ordinary::Prepared, Ordinary::Enabled] {
            supervisor.take(event);
        }
        let end = control_loop.run(&mut self.drives, &mut self.clock, &mut schedule, &mut recorder, &mut supervisor);
        (end, recorder.recorded, control_loop.timing.summary())
    }

    fn syncs(&self) -> usize {
        self.drives.link().syncs
    }
}

#[derive(Default)]
struct Recorded {
    cycles: Vec<CycleRecord<3, 2>>,
    /// When, what, and after how many cycles.
    keyframes: Vec<(Instant, Keyframe<3, 2>, usize)>,
    health: Vec<(HealthRecord<3>, usize)>,
}

struct Recording<A> {
    recorded: Recorded,
    after: A,
}

impl<A: FnMut(usize)> Recorder<3, 2> for Recording<A> {
    fn record(&mut self, record: &CycleRecord<3, 2>) {
        self.recorded.cycles.push(*record);
        (self.after)(self.recorded.cycles.len());
    }
    fn keyframe(&mut self, keyframe: &Keyframe<3, 2>, at: Instant) {
        self.recorded.keyframes.push((at, *keyframe, self.recorded.cycles.len()));
    }
    fn health(&mut self, health: &HealthRecord<3>) {
        self.recorded.health.push((*health, self.recorded.cycles.len()));
    }
}

fn nothing(_: usize) {}

/// A motion of 8 + 4 periods of 2⁻⁸ s, so that sums of periods are exact.
fn twelve_periods(source: PeriodSource) -> Experiment {
    let motion = rest([0.0; 2], 8.0 / 256.0, 4.0 / 256.0);
    Experiment { period: Duration::from_nanos(3_906_250), source, ..Experiment::new(motion) }
}

#[test]
fn the_loop_completes_with_the_last_cycle_before_the_end_of_the_motion() {
    for source in [PeriodSource::Scheduled, PeriodSource::Measured] {
        let mut experiment = twelve_periods(source);
        let (end, recorded, timing) = experiment.run(nothing);
        assert_eq!(end.unwrap(), LoopEnd::Completed);
        let times: Vec<f64> = recorded.cycles.iter().map(|cycle| cycle.time * 256.0).collect();
        assert_eq!(times, (0_u8..12).map(f64::from).collect::<Vec<_>>());
        assert_eq!((experiment.syncs(), timing.cycles), (12, 12));
        assert_eq!(experiment.drives.link().torques, [[0, 250, -200]; 12]);
    }
}

/// A wake-up takes 70 µs, sending a frame 20 µs, feedback 400 µs; three torques are sent, and in the first cycle the master's
/// heartbeat.
#[test]
fn every_instant_of_a_cycle_is_taken_where_it_belongs() {
    let (_, recorded, timing) = Experiment::new(rest([0.0; 2], 0.03, 0.0)).run(nothing);
    let at = |microseconds: u64| Instant::from_nanoseconds(microseconds * 1_000);
    let first = CycleInstants {
        scheduled: at(3_000),
        woke: at(3_070),
        sync_sent: at(3_090),
        counts_in: at(3_490),
        torque_out: at(3_550),
        done: at(3_570),
    };
    assert_eq!(recorded.cycles[0].instants, first);
    assert_eq!(recorded.cycles[1].instants.done, at(6_550));
    let spans = [timing.wake_up, timing.feedback_latency, timing.total].map(|span| (span.minimum_ns, span.maximum_ns));
    assert_eq!(spans, [(70_000, 70_000), (400_000, 400_000), (550_000, 550_000)]);
    assert_eq!(timing.verdict(), Verdict::Good);
}

#[test]
fn a_cycle_leaves_its_signals_behind() {
    let mut experiment = Experiment::new(rest([0.0; 2], 0.03, 0.0));
    experiment.drives.link_mut().counts = [7, 1_000, -500];
    let (_, recorded, _) = experiment.run(nothing);
    let cycle = recorded.cycles[9];
    assert_eq!((cycle.tick, cycle.elapsed_ticks, cycle.time, cycle.period), (9, 1, 0.027, 0.003));
    assert_eq!(cycle.counts, [7, 1_000, -500]);
    assert_eq!(cycle.statuswords, [0x27; 3], "operation enabled");
    assert_eq!(cycle.parameters(), PARAMETERS);
    assert_eq!((cycle.torque_applied, cycle.torque_sent), ([0.05, -0.04], [0, 250, -200]));
    let counts = TAU / 36_000.0;
    let seen = ProgressSnapshot { time: 0.027, error: [1_000.0 * counts, -500.0 * counts], torque: [0.05, -0.04] };
    assert_eq!(experiment.progress.snapshot(), seen);
}

/// The heartbeats of joint 3 come until 100 ms. The cycle of 300 ms is the first to end more than 200 ms later: at
/// 300 ms + 70 µs + 20 µs + 400 µs + 3 · 20 µs.
#[test]
fn a_drive_that_falls_silent_ends_the_loop_and_the_last_cycle_is_recorded() {
    let mut experiment = Experiment::new(rest([0.0; 2], 1.0, 0.0));
    experiment.drives.link_mut().silent_from = Instant::from_nanoseconds(120_000_000);
    let (end, recorded, timing) = experiment.run(nothing);
    let LoopFault::Drives(fault) = end.unwrap_err() else { panic!("another fault") };
    let limit = Duration::from_millis(200);
    assert_eq!(fault, CycleError::Lost { node: 3, silence: Duration::from_micros(200_550), limit });
    assert_eq!((recorded.cycles.len(), experiment.syncs(), timing.cycles), (100, 100, 100));
    assert_eq!(recorded.cycles[99].instants.scheduled, Instant::from_nanoseconds(300_000_000));
    assert_eq!(experiment.progress.snapshot().time, 0.297);
}

#[test]
fn a_drive_that_is_not_operational_ends_the_loop() {
    let mut experiment = Experiment::new(rest([0.0; 2], 1.0, 0.0));
    experiment.drives.link_mut().state_of_joint_2 = NmtState::PreOperational;
    let (end, recorded, _) = experiment.run(nothing);
    let LoopFault::Drives(fault) = end.unwrap_err() else { panic!("another fault") };
    assert_eq!(fault, CycleError::NotOperational { node: 2, found: NmtState::PreOperational });
    assert_eq!(recorded.cycles.len(), 1);
}

#[test]
fn a_limit_that_is_passed_ends_the_loop_before_a_torque_is_sent() {
    let mut experiment = Experiment { start_tolerance: 0.4, ..Experiment::new(rest([0.5, 0.0], 1.0, 0.0)) };
    let (end, recorded, _) = experiment.run(nothing);
    assert!(matches!(end.unwrap_err(), LoopFault::Signals(SignalFault::Limit(violation)) if violation.joint == 2));
    assert_eq!((experiment.syncs(), recorded.cycles.len()), (1, 0));
    assert!(experiment.drives.link().torques.is_empty());
}

/// The law asks for 0.05 and −0.04 N·m, 250 and −200 per mille, all the time. The ramp of 12 ms is four periods
/// long; 62.5 per mille come out a rounding error below.
#[test]
fn a_stop_request_lets_the_torques_fade_and_the_cycle_go_on() {
    let mut experiment = Experiment::new(rest([0.0; 2], 1.0, 0.0));
    let stop = experiment.stop.clone();
    let (end, recorded, _) = experiment.run(|cycles| {
        if cycles == 5 {
            stop.make();
        }
    });
    assert_eq!(end.unwrap(), LoopEnd::Interrupted);
    assert_eq!((experiment.syncs(), recorded.cycles.len()), (9, 9));
    let faded = [[0, 188, -150], [0, 125, -100], [0, 62, -50], [0, 0, 0]];
    assert_eq!(experiment.drives.link().torques[4..], [[[0, 250, -200]].as_slice(), &faded].concat());
    let authority: Vec<_> = recorded.cycles.iter().map(|cycle| cycle.authority).collect();
    assert_eq!(authority, [[Authority::Full; 5].as_slice(), &[Authority::Fading; 4]].concat());
}

#[test]
fn a_second_request_or_a_ramp_of_zero_ends_the_loop_before_the_next_sync() {
    let mut experiment = Experiment::new(rest([0.0; 2], 1.0, 0.0));
    let stop = experiment.stop.clone();
    let (end, recorded, _) = experiment.run(|cycles| {
        if cycles == 5 || cycles == 7 {
            stop.make();
        }
    });
    assert_eq!(end.unwrap(), LoopEnd::Interrupted);
    assert_eq!((experiment.syncs(), recorded.cycles.len()), (7, 7));

    let mut experiment = Experiment { stop_ramp: Duration::ZERO, ..Experiment::new(rest([0.0; 2], 1.0, 0.0)) };
    let stop = experiment.stop.clone();
    let (end, recorded, _) = experiment.run(|cycles| {
        if cycles == 5 {
            stop.make();
        }
    });
    assert_eq!(end.unwrap(), LoopEnd::Interrupted);
    assert_eq!((experiment.syncs(), recorded.cycles.len()), (5, 5));
}

/// A fault during the ramp is a fault, and what is left of the torque goes at once.
#[test]
fn what_fails_while_the_torques_fade_does_not_wait_for_them() {
    let mut experiment = Experiment::new(rest([0.0; 2], 1.0, 0.0));
    let (stop, clock) = (experiment.stop.clone(), experiment.clock.clone());
    experiment.overrun = OverrunPolicy::Stop;
    let (end, recorded, _) = experiment.run(|cycles| {
        if cycles == 5 {
            stop.make();
        }
        if cycles == 6 {
            clock.delay_next(Duration::from_millis(3));
        }
    });
    assert!(matches!(end, Err(LoopFault::Overrun(_))), "{end:?}");
    assert_eq!(recorded.cycles.len(), 7);
}

/// Under the policy to leave out ticks: each cycle wakes 2.9 ms late, and ends 0.55 ms later.
#[test]
fn three_late_cycles_in_a_row_end_the_loop() {
    let mut experiment = Experiment::new(rest([0.0; 2], 1.0, 0.0));
    let clock = experiment.clock.clone();
    let (end, recorded, timing) = experiment.run(|cycles| {
        if cycles >= 4 {
            clock.delay_next(Duration::from_micros(2_830));
        }
    });
    let LoopFault::Overrun(overrun) = end.unwrap_err() else { panic!("another fault") };
    assert_eq!((overrun.in_a_row, overrun.index), (3, 7));
    assert_eq!((recorded.cycles.len(), timing.missed_deadlines), (7, 3));
}

/// Cycle 4 wakes 2.6 periods late and ends 550 µs later: tick 5 has passed by then, tick 6 (two periods after tick 4) too, but
/// not tick 7.
#[test]
fn late_cycles_are_counted_and_the_ticks_that_they_cost() {
    for source in [PeriodSource::Scheduled, PeriodSource::Measured] {
        let mut experiment = twelve_periods(source);
        let clock = experiment.clock.clone();
        let (end, recorded, timing) = experiment.run(|cycles| {
            if cycles == 4 {
                clock.delay_next(Duration::from_nanos(10_156_250));
            }
        });
        assert_eq!(end.unwrap(), LoopEnd::Completed);
        let ticks: Vec<u64> = recorded.cycles.iter().map(|cycle| cycle.tick).collect();
        assert_eq!(ticks, [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11]);
        let [before, after] = [recorded.cycles[4], recorded.cycles[5]];
        assert_eq!(after.elapsed_ticks, 2);
        let told = match source {
            PeriodSource::Scheduled => 2.0 / 256.0,
            PeriodSource::Measured => after.instants.sync_sent.since(before.instants.sync_sent).as_secs_f64(),
        };
        assert_eq!(after.period, told);
        assert_eq!((timing.missed_deadlines, timing.skipped_ticks, timing.verdict()), (1, 1, Verdict::Missed));
        assert_eq!(recorded.cycles.last().unwrap().time * 256.0, 11.0);
    }
}

#[test]
fn the_policy_to_stop_ends_the_loop_at_the_first_late_cycle() {
    let mut experiment = Experiment { overrun: OverrunPolicy::Stop, ..Experiment::new(rest([0.0; 2], 1.0, 0.0)) };
    let clock = experiment.clock.clone();
    let (end, recorded, timing) = experiment.run(|cycles| {
        if cycles == 4 {
            clock.delay_next(Duration::from_millis(3));
        }
    });
    // It ends 550 microseconds after the tick that it missed.
    let late = Duration::from_micros(550);
    assert!(
        matches!(end, Err(LoopFault::Overrun(overrun)) if overrun == Overrun { index: 5, late, in_a_row: 1, allowed: Allowed::None })
    );
    assert_eq!((recorded.cycles.len(), experiment.syncs(), timing.missed_deadlines), (5, 5, 1));
}

/// In cycles of 10 ms: a keyframe before the first cycle, after it, and after each second; health after every tenth cycle.
#[test]
fn keyframes_come_every_second_and_health_ten_times_as_often() {
    let motion = rest([0.0; 2], 2.5, 0.0);
    let mut experiment = Experiment { period: Duration::from_millis(10), ..Experiment::new(motion) };
    let (_, recorded, _) = experiment.run(nothing);
    assert_eq!(recorded.cycles.len(), 250);

    let keyframes: Vec<usize> = recorded.keyframes.iter().map(|(_, _, cycles)| *cycles).collect();
    assert_eq!(keyframes, [0, 1, 101, 201]);
    let (at, before, _) = recorded.keyframes[0];
    assert_eq!((at, before.task_clock.previous_sync), (Instant::default(), None));
    let (at, keyframe, _) = recorded.keyframes[2];
    assert_eq!((at, keyframe.task_clock.previous_tick), (recorded.cycles[100].instants.done, 100));

    let health: Vec<usize> = recorded.health.iter().map(|(_, cycles)| *cycles).collect();
    assert_eq!(health, (0..25).map(|tenth| 10 * tenth + 1).collect::<Vec<_>>());
    let (health, _) = recorded.health[3];
    assert_eq!((health.at, health.network.syncs), (recorded.cycles[30].instants.done, 31));
}
