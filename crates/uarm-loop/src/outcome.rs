//! What came of a run: indices, peaks, timing.

use hinf_control::{Law, PerformanceIndices};
use nalgebra::SVector;
use serde::{Deserialize, Serialize};
use uarm_io::realtime::PageFaults;

use crate::motion::Motion;
use crate::period::Period;
use crate::record::{CycleRecord, NoRecorder, Recorder};
use crate::statistics::Statistics;
use crate::timing::{TimingRecorder, TimingSummary};

/// The performance indices of the paper, section 4.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Indices {
    /// L2 norm of the state tracking error.
    pub l2: f64,
    /// Sum of the applied torques, N·m·s.
    pub e: f64,
}

impl Indices {
    /// The paper's indices of a law (Table 4); `None` for a law that is not in the paper.
    pub fn published(law: Law) -> Option<Self> {
        law.published_indices().map(|published| Self { l2: published.tracking, e: published.torque })
    }
}

impl From<&PerformanceIndices<f64>> for Indices {
    fn from(indices: &PerformanceIndices<f64>) -> Self {
        Self { l2: indices.tracking(), e: indices.torque() }
    }
}

/// What came of one run with `N` active joints.
#[derive(Clone, Copy, Debug)]
pub struct Outcome<const N: usize> {
    /// L2 and E over the task.
    pub indices: Indices,
    /// Task time of the last cycle, s: as far as the other numbers go. Nothing if no cycle ran; they are zero then.
    pub last_time: Option<f64>,
    /// Tracking error of the active joints in the last cycle, rad.
    pub final_error: [f64; N],
    /// Largest torques applied to the active joints, N·m.
    pub peak_torque: [f64; N],
    /// How far the base turned from the first cycle to the last, rad.
    pub base_drift: f64,
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// Cycles in which the angle of some joint was predicted, since its drive sent none that could be believed.
    pub predicted_cycles: u64,
    /// Supply voltages and temperatures that were worth a warning.
    pub reading_warnings: u64,
    /// Timing of the loop.
    pub timing: TimingSummary,
    /// Page faults of the loop's thread between its first cycle and its last.
    pub page_faults: PageFaults,
}

impl<const N: usize> Outcome<N> {
    /// What was collected during a run.
    pub fn new<R>(
        indices: Indices,
        statistics: &Statistics<R, N>,
        timing: TimingSummary,
        page_faults: PageFaults,
    ) -> Self {
        Self {
            indices,
            last_time: statistics.last_time,
            final_error: statistics.final_error,
            peak_torque: statistics.peak_torque,
            base_drift: statistics.base_drift(),
            limited_cycles: statistics.limited_cycles,
            predicted_cycles: statistics.predicted_cycles,
            reading_warnings: statistics.reading_warnings,
            timing,
            page_faults,
        }
    }

    /// What came of a run, computed again from its cycles, as [`OutcomeOfCycles`] does.
    pub fn of_cycles<const J: usize>(motion: &Motion<N>, period: Period, cycles: &[CycleRecord<J, N>]) -> Self {
        let mut outcome = OutcomeOfCycles::new(motion.clone(), period);
        cycles.iter().for_each(|record| outcome.record(record));
        outcome.outcome()
    }
}

/// What came of a run, computed again from its cycles, one by one: bit for bit what the run itself computed. Cycles tell nothing of
/// page faults.
#[derive(Debug)]
pub struct OutcomeOfCycles<const N: usize> {
    motion: Motion<N>,
    period: Period,
    indices: PerformanceIndices<f64>,
    timing: TimingRecorder,
    statistics: Statistics<NoRecorder, N>,
}

impl<const N: usize> OutcomeOfCycles<N> {
    /// Of a run along `motion`, without a cycle so far.
    pub fn new(motion: Motion<N>, period: Period) -> Self {
        Self {
            motion,
            period,
            indices: PerformanceIndices::new(),
            timing: TimingRecorder::new(period.duration()),
            statistics: Statistics::new(NoRecorder),
        }
    }

    /// Takes in a cycle, in the order of ticks.
    pub fn record<const J: usize>(&mut self, record: &CycleRecord<J, N>) {
        if self.motion.is_task(record.time) {
            let torque = SVector::from(record.torque_applied);
            self.indices.record(&record.tracking_error(), &torque, self.period.seconds(1));
        }
        self.statistics.record(record);
        self.timing.record(&record.instants, record.elapsed_ticks);
    }

    /// What came of the cycles so far.
    pub fn outcome(&self) -> Outcome<N> {
        Outcome::new(Indices::from(&self.indices), &self.statistics, self.timing.summary(), PageFaults::default())
    }
}
