//! What came of a run, recomputed from its cycles: bit for bit what the run itself computed.

use hinf_control::PerformanceIndices;
use nalgebra::Vector2;
use uarm_io::realtime::PageFaults;

use crate::control_loop::record::{CycleRecord, NoRecorder, Recorder};
use crate::control_loop::timing::TimingRecorder;
use crate::experiment::Outcome;
use crate::experiment::report::Indices;
use crate::experiment::statistics::Statistics;
use crate::robot::Robot;

/// What came of `cycles`. Page faults are not among what cycles tell.
pub fn recomputed(robot: &Robot, cycles: &[CycleRecord]) -> Outcome {
    let motion = robot.task.motion();
    let mut indices = PerformanceIndices::new();
    let mut timing = TimingRecorder::new(robot.period.duration());
    let mut statistics = Statistics::new(NoRecorder);
    for record in cycles {
        if motion.is_task(record.time) {
            let torque = Vector2::from(record.torque_applied);
            indices.record(&record.tracking_error(), &torque, robot.period.seconds(1));
        }
        statistics.record(record);
        timing.record(&record.instants, record.elapsed_ticks);
    }
    Outcome {
        indices: Indices { l2: indices.tracking(), e: indices.torque() },
        final_error: statistics.final_error,
        peak_torque: statistics.peak_torque,
        base_drift: statistics.base_drift(),
        limited_cycles: statistics.limited_cycles,
        timing: timing.summary(),
        page_faults: PageFaults::default(),
    }
}
