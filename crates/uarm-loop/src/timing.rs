//! How well the loop keeps time: latencies of every cycle, unfiltered, and what to make of them.

use hdrhistogram::Histogram;
use serde::{Serialize, Serializer};
use uarm_io::time::{Duration, Instant};

/// The largest latency that a histogram resolves; longer ones count as this long, and the true maximum is kept besides.
const LONGEST_LATENCY_NS: u64 = 10_000_000_000;
/// Three significant digits: a quantile is right to 0.1 %.
const SIGNIFICANT_DIGITS: u8 = 3;

/// The instants of one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CycleInstants {
    /// When it was due.
    pub scheduled: Instant,
    /// When the loop woke.
    pub woke: Instant,
    /// When SYNC was handed to the link.
    pub sync_sent: Instant,
    /// When the last encoder count was in.
    pub counts_in: Instant,
    /// When the last torque was handed to the link.
    pub torque_out: Instant,
    /// When the cycle had nothing left to do but to record itself.
    pub done: Instant,
}

impl CycleInstants {
    /// From the scheduled start to the wake-up.
    pub fn wake_up(&self) -> Duration {
        self.woke.since(self.scheduled)
    }

    /// From SYNC to the last encoder count.
    pub fn feedback_latency(&self) -> Duration {
        self.counts_in.since(self.sync_sent)
    }

    /// From the scheduled start to the last torque on the link.
    pub fn total(&self) -> Duration {
        self.torque_out.since(self.scheduled)
    }
}

/// The latencies of one kind, in nanoseconds.
#[derive(Clone, Debug)]
struct Latencies {
    histogram: Histogram<u64>,
    minimum: u64,
    maximum: u64,
}

impl Latencies {
    #[allow(clippy::expect_used, reason = "constants, and before the loop begins")]
    fn new() -> Self {
        let histogram = Histogram::new_with_bounds(1, LONGEST_LATENCY_NS, SIGNIFICANT_DIGITS)
            .expect("the constant bounds are those that the histogram asks for");
        Self { histogram, minimum: u64::MAX, maximum: 0 }
    }

    fn record(&mut self, latency: Duration) {
        let nanoseconds = u64::try_from(latency.as_nanos()).unwrap_or(u64::MAX);
        self.minimum = self.minimum.min(nanoseconds);
        self.maximum = self.maximum.max(nanoseconds);
        self.histogram.saturating_record(nanoseconds);
    }

    fn summary(&self) -> LatencySummary {
        if self.histogram.is_empty() {
            return LatencySummary::default();
        }
        LatencySummary {
            minimum_ns: self.minimum,
            mean_ns: self.histogram.mean(),
            p99_ns: self.histogram.value_at_quantile(0.99).min(self.maximum),
            p999_ns: self.histogram.value_at_quantile(0.999).min(self.maximum),
            maximum_ns: self.maximum,
        }
    }
}

/// One kind of latency over a run, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LatencySummary {
    /// The smallest latency.
    pub minimum_ns: u64,
    /// The mean latency.
    pub mean_ns: f64,
    /// 99 % were at most this.
    pub p99_ns: u64,
    /// 99.9 % were at most this.
    pub p999_ns: u64,
    /// The largest latency.
    pub maximum_ns: u64,
}

/// Collects the timing of a run. Allocates when built, never after.
#[derive(Clone, Debug)]
pub struct TimingRecorder {
    period: Duration,
    wake_up: Latencies,
    feedback_latency: Latencies,
    total: Latencies,
    cycles: u64,
    missed_deadlines: u64,
    skipped_ticks: u64,
}

impl TimingRecorder {
    /// For a loop of this period.
    pub fn new(period: Duration) -> Self {
        Self {
            period,
            wake_up: Latencies::new(),
            feedback_latency: Latencies::new(),
            total: Latencies::new(),
            cycles: 0,
            missed_deadlines: 0,
            skipped_ticks: 0,
        }
    }

    /// Takes in one cycle that followed its predecessor after `elapsed_ticks`.
    pub fn record(&mut self, instants: &CycleInstants, elapsed_ticks: u64) {
        self.cycles += 1;
        self.skipped_ticks += elapsed_ticks.saturating_sub(1);
        self.wake_up.record(instants.wake_up());
        self.feedback_latency.record(instants.feedback_latency());
        let total = instants.total();
        self.total.record(total);
        if total > self.period {
            self.missed_deadlines += 1;
        }
    }

    /// Takes in a cycle that a fault ended `late` after it was due: it has no latencies, but may have missed its deadline.
    pub fn record_unfinished(&mut self, late: Duration) {
        if late > self.period {
            self.missed_deadlines += 1;
        }
    }

    /// The timing of the cycles so far.
    pub fn summary(&self) -> TimingSummary {
        TimingSummary {
            period_ns: u64::try_from(self.period.as_nanos()).unwrap_or(u64::MAX),
            cycles: self.cycles,
            missed_deadlines: self.missed_deadlines,
            skipped_ticks: self.skipped_ticks,
            wake_up: self.wake_up.summary(),
            feedback_latency: self.feedback_latency.summary(),
            total: self.total.summary(),
        }
    }
}

/// The timing of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimingSummary {
    /// The nominal period of the loop.
    pub period_ns: u64,
    /// Cycles that ran.
    pub cycles: u64,
    /// Cycles whose torques left after the next cycle was due.
    pub missed_deadlines: u64,
    /// Ticks that were left out because of that.
    pub skipped_ticks: u64,
    /// From the scheduled start to the wake-up; as the others null in JSON where nothing was measured: without a cycle, and in virtual time.
    #[serde(serialize_with = "measured")]
    pub wake_up: LatencySummary,
    /// From SYNC to the last encoder count.
    #[serde(serialize_with = "measured")]
    pub feedback_latency: LatencySummary,
    /// From the scheduled start to the last torque on the link.
    #[serde(serialize_with = "measured")]
    pub total: LatencySummary,
}

fn measured<S: Serializer>(latency: &LatencySummary, serializer: S) -> Result<S::Ok, S::Error> {
    Some(latency).filter(|latency| **latency != LatencySummary::default()).serialize(serializer)
}

/// What the timing of a run is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No deadline was missed, and half of the period stayed free at the worst.
    Good,
    /// No deadline was missed, but less than half of the period stayed free at the worst.
    Tight,
    /// Deadlines were missed.
    Missed,
}

impl TimingSummary {
    /// What the timing is worth.
    pub fn verdict(&self) -> Verdict {
        if self.missed_deadlines + self.skipped_ticks > 0 {
            Verdict::Missed
        } else if self.total.maximum_ns.saturating_mul(2) > self.period_ns {
            Verdict::Tight
        } else {
            Verdict::Good
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycle(scheduled_ms: u64, wake_us: u64, total_us: u64) -> CycleInstants {
        let scheduled = Instant::from_nanoseconds(scheduled_ms * 1_000_000);
        let woke = scheduled + Duration::from_micros(wake_us);
        let torque_out = scheduled + Duration::from_micros(total_us);
        CycleInstants { scheduled, woke, sync_sent: woke, counts_in: torque_out, torque_out, done: torque_out }
    }

    #[test]
    fn every_cycle_counts_and_the_worst_is_kept_exactly() {
        let mut timing = TimingRecorder::new(Duration::from_millis(3));
        for k in 0..999 {
            timing.record(&cycle(3 * k, 10, 100), 1);
        }
        timing.record(&cycle(3_000, 2_345, 2_999), 1);
        let summary = timing.summary();
        assert_eq!(summary.cycles, 1_000);
        assert_eq!(summary.wake_up.minimum_ns, 10_000);
        assert_eq!(summary.wake_up.maximum_ns, 2_345_000);
        assert_eq!(summary.missed_deadlines, 0);
        assert_eq!(summary.verdict(), Verdict::Tight);
    }

    #[test]
    fn torque_after_the_next_tick_is_a_missed_deadline() {
        let mut timing = TimingRecorder::new(Duration::from_millis(3));
        timing.record(&cycle(0, 10, 100), 0);
        assert_eq!(timing.summary().verdict(), Verdict::Good);
        timing.record(&cycle(3, 10, 3_001), 1);
        timing.record(&cycle(9, 10, 100), 2);
        let summary = timing.summary();
        assert_eq!((summary.missed_deadlines, summary.skipped_ticks), (1, 1));
        assert_eq!(summary.verdict(), Verdict::Missed);
    }

    #[test]
    fn a_cycle_that_a_fault_ended_late_has_missed_its_deadline_and_no_latency() {
        let mut timing = TimingRecorder::new(Duration::from_millis(3));
        timing.record(&cycle(0, 10, 100), 0);
        timing.record_unfinished(Duration::from_millis(3));
        assert_eq!(timing.summary().verdict(), Verdict::Good);
        timing.record_unfinished(Duration::from_secs(1));
        let summary = timing.summary();
        assert_eq!((summary.cycles, summary.missed_deadlines, summary.total.maximum_ns), (1, 1, 100_000));
        assert_eq!(summary.verdict(), Verdict::Missed);
    }

    #[test]
    fn a_run_without_cycles_has_a_summary() {
        assert_eq!(TimingRecorder::new(Duration::from_millis(3)).summary().total, LatencySummary::default());
    }
}
