//! A cycle's record as the messages of `/control`, `/timing` and `/drives`, and back.

use uarm_loop::uarm_io::drive::cia402::Statusword;
use uarm_loop::uarm_io::time::Duration;

use crate::proto::{ControlSample, DriveState, DriveStates, LoopTiming, drive_state};
use crate::shape::{ShapeError, array, array_ref};
use crate::time_axis::TimeAxis;
use uarm_loop::estimation::AngleSource;
use uarm_loop::record::{CycleFlags, CycleRecord, Unexplained};
use uarm_loop::supervisor::Authority;
use uarm_loop::timing::CycleInstants;
use uarm_loop::torque::ActualTorque;

/// The three messages of a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleMessages {
    /// The signals, for `/control`.
    pub control: ControlSample,
    /// The instants, for `/timing`.
    pub timing: LoopTiming,
    /// What the drives said and were told, for `/drives`.
    pub drives: DriveStates,
}

fn microseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e6
}

impl CycleMessages {
    /// Messages of `record`, of drives with these `nodes`.
    pub fn new<const J: usize, const N: usize>(record: &CycleRecord<J, N>, nodes: [u8; J], axis: TimeAxis) -> Self {
        Self { control: control(record), timing: timing(record, axis), drives: drives(record, nodes) }
    }

    /// The record, bit for bit the one that was recorded.
    ///
    /// # Errors
    /// [`ShapeError`] if a field has another number of values.
    pub fn record<const J: usize, const N: usize>(&self, axis: TimeAxis) -> Result<CycleRecord<J, N>, ShapeError> {
        let Self { control, timing, drives } = self;
        let tick = control.tick;
        let states: &[DriveState; J] = array_ref("DriveStates.drives", &drives.drives)?;
        let mut record = CycleRecord {
            tick,
            elapsed_ticks: timing.elapsed_ticks,
            time: control.time,
            period: control.period,
            authority: if control.stopping { Authority::Fading } else { Authority::Full },
            instants: CycleInstants {
                scheduled: axis.instant(timing.scheduled_ns),
                woke: axis.instant(timing.woke_ns),
                sync_sent: axis.instant(timing.sync_sent_ns),
                counts_in: axis.instant(timing.counts_in_ns),
                torque_out: axis.instant(timing.torque_out_ns),
                done: axis.instant(timing.done_ns),
            },
            counts: states.each_ref().map(|drive| drive.counts),
            angle_sources: states.each_ref().map(|drive| angle_source(drive.angle_source())),
            statuswords: states.each_ref().map(|drive| narrow(drive.statusword)),
            measured_position: array("ControlSample.measured_position", &control.measured_position)?,
            position: array("ControlSample.position", &control.position)?,
            velocity: array("ControlSample.velocity", &control.velocity)?,
            base_acceleration: control.base_acceleration,
            reference_position: array("ControlSample.reference_position", &control.reference_position)?,
            reference_velocity: array("ControlSample.reference_velocity", &control.reference_velocity)?,
            reference_acceleration: array("ControlSample.reference_acceleration", &control.reference_acceleration)?,
            control_input: array("ControlSample.control_input", &control.control_input)?,
            torque_requested: array("ControlSample.torque_requested", &control.torque_requested)?,
            torque_applied: array("ControlSample.torque_applied", &control.torque_applied)?,
            torque_sent: states.each_ref().map(|drive| i16::try_from(drive.torque_sent).unwrap_or_default()),
            torque_actual: states.each_ref().map(actual),
            disturbance: array("ControlSample.disturbance", &control.disturbance)?,
            unexplained: unexplained(control)?,
            flags: CycleFlags {
                limited: array("ControlSample.limited", &control.limited)?,
                projected: control.projected,
                at_bound: control.at_bound,
                frozen: control.frozen,
                fell_back: control.fell_back,
            },
            ..CycleRecord::default()
        };
        record.set_parameters(&control.parameters);
        Ok(record)
    }
}

/// Logs of earlier versions, and runs without supervision, have none.
fn unexplained<const N: usize>(control: &ControlSample) -> Result<Option<Unexplained<N>>, ShapeError> {
    if control.residual.is_empty() && control.residual_limit.is_empty() {
        return Ok(None);
    }
    Ok(Some(Unexplained {
        residual: array("ControlSample.residual", &control.residual)?,
        limit: array("ControlSample.residual_limit", &control.residual_limit)?,
    }))
}

fn actual(drive: &DriveState) -> Option<ActualTorque> {
    let per_mille = i16::try_from(drive.torque_actual?).ok()?;
    Some(ActualTorque { per_mille, newton_metres: drive.torque_actual_nm? })
}

fn narrow(statusword: u32) -> u16 {
    u16::try_from(statusword).unwrap_or_default()
}

fn control<const J: usize, const N: usize>(record: &CycleRecord<J, N>) -> ControlSample {
    let CycleFlags { limited, projected, at_bound, frozen, fell_back } = record.flags;
    ControlSample {
        tick: record.tick,
        time: record.time,
        period: record.period,
        measured_position: record.measured_position.to_vec(),
        position: record.position.to_vec(),
        velocity: record.velocity.to_vec(),
        base_acceleration: record.base_acceleration,
        reference_position: record.reference_position.to_vec(),
        reference_velocity: record.reference_velocity.to_vec(),
        reference_acceleration: record.reference_acceleration.to_vec(),
        tracking_error: record.tracking_error().position.as_slice().to_vec(),
        control_input: record.control_input.to_vec(),
        torque_requested: record.torque_requested.to_vec(),
        torque_applied: record.torque_applied.to_vec(),
        disturbance: record.disturbance.to_vec(),
        parameters: record.parameters().to_vec(),
        limited: limited.to_vec(),
        projected,
        at_bound,
        frozen,
        fell_back,
        stopping: record.authority == Authority::Fading,
        residual: record.unexplained.map(|unexplained| unexplained.residual.to_vec()).unwrap_or_default(),
        residual_limit: record.unexplained.map(|unexplained| unexplained.limit.to_vec()).unwrap_or_default(),
    }
}

fn timing<const J: usize, const N: usize>(record: &CycleRecord<J, N>, axis: TimeAxis) -> LoopTiming {
    let CycleInstants { scheduled, woke, sync_sent, counts_in, torque_out, done } = record.instants;
    LoopTiming {
        tick: record.tick,
        elapsed_ticks: record.elapsed_ticks,
        scheduled_ns: axis.at(scheduled),
        woke_ns: axis.at(woke),
        sync_sent_ns: axis.at(sync_sent),
        counts_in_ns: axis.at(counts_in),
        torque_out_ns: axis.at(torque_out),
        done_ns: axis.at(done),
        wake_up_us: microseconds(record.instants.wake_up()),
        feedback_latency_us: microseconds(record.instants.feedback_latency()),
        total_us: microseconds(record.instants.total()),
    }
}

fn drives<const J: usize, const N: usize>(record: &CycleRecord<J, N>, nodes: [u8; J]) -> DriveStates {
    let state = |joint: usize| {
        let (node, statusword) = (nodes[joint], record.statuswords[joint]);
        DriveState {
            node: node.into(),
            statusword: statusword.into(),
            state: state_in_words(statusword),
            counts: record.counts[joint],
            torque_sent: record.torque_sent[joint].into(),
            torque_actual: record.torque_actual[joint].map(|actual| actual.per_mille.into()),
            torque_actual_nm: record.torque_actual[joint].map(|actual| actual.newton_metres),
            angle_source: message_of(record.angle_sources[joint]).into(),
        }
    };
    DriveStates { tick: record.tick, drives: (0..nodes.len()).map(state).collect() }
}

fn message_of(source: AngleSource) -> drive_state::AngleSource {
    match source {
        AngleSource::Measured => drive_state::AngleSource::Measured,
        AngleSource::Missing => drive_state::AngleSource::Missing,
        AngleSource::Refused => drive_state::AngleSource::Refused,
    }
}

fn angle_source(message: drive_state::AngleSource) -> AngleSource {
    match message {
        drive_state::AngleSource::Measured => AngleSource::Measured,
        drive_state::AngleSource::Missing => AngleSource::Missing,
        drive_state::AngleSource::Refused => AngleSource::Refused,
    }
}

/// The CiA 402 state that a statusword tells.
pub fn state_in_words(statusword: u16) -> String {
    Statusword::from_bits(statusword)
        .state()
        .map_or_else(|| "not a state of CiA 402".to_owned(), |state| state.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use uarm_loop::record::PARAMETER_CAPACITY;
    use uarm_loop::uarm_io::time::Instant;

    fn any_record() -> impl Strategy<Value = CycleRecord<3, 2>> {
        let numbers = prop::collection::vec(any::<u64>().prop_map(f64::from_bits), 80);
        let instants = prop::array::uniform6(0..1_u64 << 60);
        let actual = any::<[Option<(i16, u64)>; 3]>();
        let words = (any::<[i32; 3]>(), any::<[u16; 3]>(), any::<[i16; 3]>(), any::<[bool; 10]>(), actual);
        (any::<[u64; 2]>(), numbers, instants, words, 0..=PARAMETER_CAPACITY).prop_map(
            |(
                [tick, elapsed_ticks],
                numbers,
                instants,
                (counts, statuswords, torque_sent, flags, actual),
                parameter_count,
            )| {
                let mut numbers = numbers.into_iter();
                let mut next = || numbers.next().unwrap();
                let [scheduled, woke, sync_sent, counts_in, torque_out, done] = instants.map(Instant::from_nanoseconds);
                let mut record = CycleRecord {
                    tick,
                    elapsed_ticks,
                    time: next(),
                    period: next(),
                    authority: if flags[9] { Authority::Fading } else { Authority::Full },
                    instants: CycleInstants { scheduled, woke, sync_sent, counts_in, torque_out, done },
                    counts,
                    angle_sources: [flags[6], flags[7], flags[8]]
                        .map(|is_missing| if is_missing { AngleSource::Missing } else { AngleSource::Measured }),
                    statuswords,
                    measured_position: [next(), next(), next()],
                    position: [next(), next(), next()],
                    velocity: [next(), next(), next()],
                    base_acceleration: next(),
                    reference_position: [next(), next()],
                    reference_velocity: [next(), next()],
                    reference_acceleration: [next(), next()],
                    control_input: [next(), next()],
                    torque_requested: [next(), next()],
                    torque_applied: [next(), next()],
                    torque_sent,
                    torque_actual: actual.map(|actual| {
                        let (per_mille, bits) = actual?;
                        Some(ActualTorque { per_mille, newton_metres: f64::from_bits(bits) })
                    }),
                    disturbance: [next(), next()],
                    unexplained: flags[0].then(|| Unexplained { residual: [next(), next()], limit: [next(), next()] }),
                    parameters: [0.0; PARAMETER_CAPACITY],
                    parameter_count: 0,
                    flags: CycleFlags {
                        limited: [flags[0], flags[1]],
                        projected: flags[2],
                        at_bound: flags[3],
                        frozen: flags[4],
                        fell_back: flags[5],
                    },
                };
                let parameters: Vec<_> = numbers.take(parameter_count).collect();
                record.set_parameters(&parameters);
                record
            },
        )
    }

    proptest! {
        /// Through the encoder as well, since a message only matters once it is bytes.
        #[test]
        fn a_record_comes_back_bit_for_bit(record in any_record()) {
            use prost::Message;
            let axis = TimeAxis::simulated();
            let written = CycleMessages::new(&record, [1, 2, 3], axis);
            let read = CycleMessages {
                control: ControlSample::decode(written.control.encode_to_vec().as_slice()).unwrap(),
                timing: LoopTiming::decode(written.timing.encode_to_vec().as_slice()).unwrap(),
                drives: DriveStates::decode(written.drives.encode_to_vec().as_slice()).unwrap(),
            };
            let read = read.record::<3, 2>(axis).unwrap();
            // As text, in which NaN equals itself, and as bits, in which one zero differs from the other.
            prop_assert_eq!(format!("{read:?}"), format!("{record:?}"));
            prop_assert_eq!(read.torque_applied.map(f64::to_bits), record.torque_applied.map(f64::to_bits));
        }
    }

    #[test]
    fn a_message_of_another_shape_is_refused_by_name() {
        let record = CycleMessages {
            control: ControlSample::default(),
            timing: LoopTiming::default(),
            drives: DriveStates::default(),
        };
        let error = record.record::<3, 2>(TimeAxis::simulated()).unwrap_err();
        assert_eq!(error.to_string(), "DriveStates.drives has 0 values, expected 3");
    }
}
