//! How late a periodic thread really wakes up on this machine.

use crate::finding::{Finding, Verdict};
use crate::monotonic::MonotonicClock;
use crate::realtime::{PageFaults, RealtimeError, RealtimeSettings, RealtimeThread};
use crate::time::{Clock, Duration};
use hdrhistogram::Histogram;
use std::io;

/// Periods that can be measured: below, the measurement itself is the load; above, it never ends.
const PERIODS: core::ops::RangeInclusive<Duration> = Duration::from_micros(100)..=Duration::from_secs(1);
/// Largest latency told apart, nanoseconds: no machine that is alive sleeps longer.
const LARGEST_LATENCY: u64 = 10_000_000_000;
/// Significant decimal digits kept of each latency.
const DIGITS: u8 = 3;
/// Upper edges of the buckets shown, nanoseconds: 1-2-5 steps from 1 µs to 50 ms.
const EDGES: [u64; 15] = [
    1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000, 2_000_000, 5_000_000,
    10_000_000, 20_000_000, 50_000_000,
];

/// Why wake-ups could not be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasurementError {
    /// The policy demands what the system does not grant.
    #[error(transparent)]
    Realtime(#[from] RealtimeError),
    /// A period that cannot be measured.
    #[error("a period of {found:?}, expected {:?} to {:?}", PERIODS.start(), PERIODS.end())]
    Period {
        /// The period asked for.
        found: Duration,
    },
    /// The histogram could not be made.
    #[error("cannot make the histogram: {0}")]
    Histogram(#[from] hdrhistogram::CreationError),
    /// The measuring thread could not be started.
    #[error("cannot start the measuring thread: {0}")]
    Thread(#[source] io::Error),
}

/// Wake-ups with a latency up to an edge and above the edge before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct LatencyBucket {
    /// The edge, nanoseconds; `None` for the last bucket, which is open.
    pub up_to_nanoseconds: Option<u64>,
    /// How many wake-ups.
    pub count: u64,
}

/// Latencies of a periodic thread, from the instant asked for to the instant it ran, all of them, unfiltered.
#[derive(Clone, Debug, serde::Serialize)]
pub struct WakeupReport {
    /// The period, nanoseconds; also the deadline.
    pub period_nanoseconds: u64,
    /// How many wake-ups were measured.
    pub samples: u64,
    /// How many came so late that their whole period was over.
    pub missed: u64,
    /// The smallest latency, nanoseconds.
    pub minimum_nanoseconds: u64,
    /// The mean latency, nanoseconds.
    pub mean_nanoseconds: f64,
    /// 99 % of the latencies are at most this, nanoseconds.
    pub p99_nanoseconds: u64,
    /// 99.9 % of the latencies are at most this, nanoseconds.
    pub p999_nanoseconds: u64,
    /// The largest latency, nanoseconds.
    pub maximum_nanoseconds: u64,
    /// The histogram.
    pub buckets: Vec<LatencyBucket>,
    /// Page faults of the thread while it ran: minor and major.
    pub page_faults: (u64, u64),
    /// What the thread was granted.
    pub realtime: Vec<Finding>,
    /// The judgement of the largest latency against the period.
    pub verdict: Verdict,
    /// What to do about it; empty if nothing.
    pub advice: String,
}

/// Lets a thread of its own wake up every `period` for `duration`, under `settings`, and tells how late it was.
///
/// A late wake-up does not hide those that it delayed: each deadline is measured, also if it had passed before the thread
/// could sleep for it.
///
/// # Errors
/// [`MeasurementError`], under [`RealtimePolicy::Enforce`](crate::realtime::RealtimePolicy::Enforce) also if anything is
/// not granted.
pub fn measure_wakeups(
    period: Duration,
    duration: Duration,
    settings: &RealtimeSettings,
) -> Result<WakeupReport, MeasurementError> {
    if !PERIODS.contains(&period) {
        return Err(MeasurementError::Period { found: period });
    }
    let samples = u64::try_from(duration.as_nanos() / period.as_nanos()).unwrap_or(u64::MAX).max(1);
    let settings = *settings;
    let thread = std::thread::Builder::new()
        .name("uarm-wakeup".to_owned())
        .spawn(move || run(period, samples, &settings))
        .map_err(MeasurementError::Thread)?;
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

fn run(period: Duration, samples: u64, settings: &RealtimeSettings) -> Result<WakeupReport, MeasurementError> {
    let mut latencies = Histogram::new_with_bounds(1, LARGEST_LATENCY, DIGITS)?;
    let realtime = RealtimeThread::enter(settings)?;
    let mut clock = MonotonicClock;
    // The first reading of the clock maps the kernel's clock page, which no locking covers: before the faults are counted.
    let mut deadline = clock.now() + period;
    let faults_before = PageFaults::of_this_thread();
    for _ in 0..samples {
        clock.sleep_until(deadline);
        let latency = clock.now().since(deadline);
        latencies.saturating_record(u64::try_from(latency.as_nanos()).unwrap_or(LARGEST_LATENCY));
        deadline = deadline + period;
    }
    let faults = PageFaults::of_this_thread().since(faults_before);
    Ok(summary(period, &latencies, faults, realtime.report().to_vec()))
}

fn summary(period: Duration, latencies: &Histogram<u64>, faults: PageFaults, realtime: Vec<Finding>) -> WakeupReport {
    let period = u64::try_from(period.as_nanos()).unwrap_or(u64::MAX);
    let (verdict, advice) = judge(latencies.max(), period, &realtime);
    WakeupReport {
        period_nanoseconds: period,
        samples: latencies.len(),
        missed: latencies
            .iter_recorded()
            .filter(|step| step.value_iterated_to() >= period)
            .map(|step| step.count_at_value())
            .sum(),
        minimum_nanoseconds: latencies.min(),
        mean_nanoseconds: latencies.mean(),
        p99_nanoseconds: latencies.value_at_quantile(0.99),
        p999_nanoseconds: latencies.value_at_quantile(0.999),
        maximum_nanoseconds: latencies.max(),
        buckets: buckets(latencies),
        page_faults: (faults.minor, faults.major),
        realtime,
        verdict,
        advice,
    }
}

fn buckets(latencies: &Histogram<u64>) -> Vec<LatencyBucket> {
    let edges = EDGES.into_iter().map(Some).chain([None]);
    let mut buckets: Vec<_> = edges.map(|up_to_nanoseconds| LatencyBucket { up_to_nanoseconds, count: 0 }).collect();
    for step in latencies.iter_recorded() {
        let place = EDGES.partition_point(|&edge| edge < step.value_iterated_to());
        if let Some(bucket) = buckets.get_mut(place) {
            bucket.count += step.count_at_value();
        }
    }
    buckets
}

/// Judges the largest latency. A tenth of the period moves the sampling instant by as much, which is a 10 % error of one
/// rate sample; half of it leaves no room for bus (0.7 ms of 3 ms at 1 Mbit/s), drives and computing.
fn judge(largest: u64, period: u64, realtime: &[Finding]) -> (Verdict, String) {
    const GOOD_DIVISOR: u64 = 10;
    const WARNING_DIVISOR: u64 = 2;
    let verdict = match largest {
        _ if largest <= period / GOOD_DIVISOR => return (Verdict::Good, String::new()),
        _ if largest <= period / WARNING_DIVISOR => Verdict::Warning,
        _ => Verdict::Bad,
    };
    let advice = if realtime.is_empty() {
        "measured without real-time scheduling: ask for the policy `prefer`"
    } else if realtime.iter().any(|item| item.verdict != Verdict::Good) {
        "the thread was not granted all it asked for: get what is missing above, then measure again"
    } else {
        "the thread had all it asked for: look for firmware interrupts (`hwlatdetect`), a virtual machine, or drivers that block interrupts; use a PREEMPT_RT kernel and an isolated processor"
    };
    (verdict, advice.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::RealtimePolicy;

    const PERIOD: u64 = 3_000_000;

    fn report(latencies: &[u64]) -> WakeupReport {
        let mut histogram = Histogram::new_with_bounds(1, LARGEST_LATENCY, DIGITS).unwrap();
        latencies.iter().for_each(|&latency| histogram.saturating_record(latency));
        summary(Duration::from_nanos(PERIOD), &histogram, PageFaults::default(), Vec::new())
    }

    #[test]
    fn the_largest_latency_decides() {
        assert_eq!(report(&[5_000; 100]).verdict, Verdict::Good);
        assert_eq!(report(&[5_000, 5_000, 400_000]).verdict, Verdict::Warning);
        let bad = report(&[5_000, 2_000_000]);
        assert_eq!((bad.verdict, bad.missed), (Verdict::Bad, 0));
        assert_eq!(report(&[5_000, 3_100_000, 90_000_000]).missed, 2);
    }

    #[test]
    fn every_wakeup_is_in_one_bucket() {
        let latencies = [0, 900, 1_500, 49_000, 51_000, 700_000, 60_000_000, 20_000_000_000];
        let report = report(&latencies);
        assert_eq!(report.buckets.iter().map(|bucket| bucket.count).sum::<u64>(), 8);
        let filled: Vec<_> = report.buckets.iter().filter(|bucket| bucket.count > 0).collect();
        let edges: Vec<_> = filled.iter().map(|bucket| bucket.up_to_nanoseconds).collect();
        assert_eq!(edges, [Some(1_000), Some(2_000), Some(50_000), Some(100_000), Some(1_000_000), None]);
        assert_eq!((filled[0].count, filled[5].count), (2, 2));
    }

    #[test]
    fn a_measurement_takes_every_sample() {
        let settings = RealtimeSettings { policy: RealtimePolicy::Prefer, ..Default::default() };
        let report = measure_wakeups(Duration::from_micros(500), Duration::from_millis(50), &settings).unwrap();
        assert_eq!(report.samples, 100);
        assert!(
            report.minimum_nanoseconds <= report.p99_nanoseconds
                && report.p99_nanoseconds <= report.maximum_nanoseconds
        );
        assert!(!report.realtime.is_empty());
    }

    #[test]
    fn odd_periods_are_refused() {
        for period in [Duration::ZERO, Duration::from_secs(2)] {
            let refused = measure_wakeups(period, Duration::from_secs(1), &RealtimeSettings::default()).unwrap_err();
            assert!(matches!(refused, MeasurementError::Period { found } if found == period));
        }
    }
}
