//! What the loop must know of a robot: joints, task, period, bus and limits, all checked.
//!
//! How a robot is described in a file is the business of whoever reads that file; these types are what it is turned into.

use hinf_control::{TorqueLimitError, TorqueLimiter, TorqueLimits};
use nalgebra::SVector;
use uarm_io::bus_time::{BitRate, BusTime};
use uarm_io::drive::NodeId;
use uarm_io::drive::network::{EmergencyReaction, IgnoredTargetReaction, Timeouts};
use uarm_io::drive::odrive::Positions;
use uarm_io::drive::wishes::{DriveConfiguration, SyncCounterChoice, TorqueApplies};
use uarm_io::encoder::EncoderConfiguration;
use uarm_io::estimator::AnyEstimator;
use uarm_io::time::Duration;
use uarm_io::torque::TorqueScale;

use crate::barrier::Stopping;
use crate::fade::StopRamp;
use crate::guard::{Guard, JointLimits};
use crate::motion::Motion;
use crate::period::Period;
use crate::plausibility::AccelerationBound;
use crate::reference::TaskReference;
use crate::rest::RestVelocity;
use crate::saturation::SaturationLimit;
use crate::schedule::OverrunsInARow;
use crate::supervision::settings::SupervisionSettings;
use crate::supervision::{JointTraits, Supervision};

/// A robot with `J` joints: the passive base and `N` active joints.
#[derive(Clone, Debug)]
pub struct Robot<const J: usize, const N: usize> {
    /// The robot's name, for reports and logs.
    pub name: String,
    /// The joints, the passive base first.
    pub joints: [Joint; J],
    /// The motion of the experiment.
    pub task: Task<N>,
    /// The loop's period.
    pub period: Period,
    /// The largest accelerations of the joints, by which counts are believed; without them, by their velocities alone.
    pub acceleration_bounds: Option<[AccelerationBound; J]>,
    /// How long after SYNC the drives' positions are waited for; at most the period.
    pub feedback_timeout: Duration,
    /// Largest tracking error of an active joint, rad; beyond it a run ends.
    pub tracking_error_limit: f64,
    /// How many late cycles in a row end a run, whatever the overrun policy.
    pub overruns_in_a_row: OverrunsInARow,
    /// For how long the torque of a joint may be cut without a break.
    pub saturation_limit: SaturationLimit,
    /// The fastest that a joint may turn before brakes open.
    pub rest_velocity: RestVelocity,
    /// How counts and torques are held against the model; without it, they are not.
    pub supervision: Option<SupervisionSettings<J>>,
    /// How the torques fade when somebody asks for the end.
    pub stop_ramp: StopRamp,
    /// The bus and its heartbeats.
    pub bus: Bus,
}

/// One joint with its drive and encoder.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The joint's name, for reports and logs.
    pub name: String,
    /// The node id of its drive, 1 to 126.
    pub node: NodeId,
    /// Its encoder.
    pub encoder: EncoderConfiguration,
    /// Its velocity estimator, as it is before the first count.
    pub estimator: AnyEstimator<f64>,
    /// From N·m to the drive's per mille of rated torque.
    pub torque_scale: TorqueScale,
    /// What the master wants of its drive.
    pub drive: DriveConfiguration,
    /// From the instant at which a command acts in the drive to the torque of the motor; shorter than the loop's period.
    pub torque_delay: Duration,
    /// Largest torque either way, N·m; zero for the passive joint.
    pub torque_limit: f64,
    /// Largest change of torque, N·m/s; above zero, but for the passive joint.
    pub torque_rate_limit: f64,
    /// Limits of motion, beyond which a run ends.
    pub limits: JointLimits,
    /// From the command to stop until the brake holds.
    pub brake: Duration,
}

/// The motion of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Task<const N: usize> {
    /// The motion from start to end, which holds its end afterwards: a quintic (paper eq. 47) unless more is asked for.
    pub reference: TaskReference<N>,
    /// How long the end is held, s.
    pub hold: f64,
    /// How far from the start a run may begin, rad.
    pub start_tolerance: f64,
}

/// What the drives speak.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Protocol {
    /// CANopen, CiA 402.
    #[default]
    Canopen,
    /// ODrive CANSimple, with positions that come so.
    Odrive(Positions),
}

/// The bus, and who must be heard on it how often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bus {
    /// What the drives speak.
    pub protocol: Protocol,
    /// The bit rate, bit/s.
    pub bit_rate: BitRate,
    /// How much of each period the bus is busy.
    pub time: BusTime,
    /// How often the controller sends its heartbeat.
    pub controller_heartbeat: Duration,
    /// After how long a silent controller makes the drives brake.
    pub controller_timeout: Duration,
    /// How often each drive sends its heartbeat.
    pub drive_heartbeat: Duration,
    /// After how long a silent drive ends the run.
    pub drive_timeout: Duration,
    /// How long it is listened for another controller before anything is sent.
    pub listen: Duration,
    /// How long the steps of start and stop may take.
    pub timeouts: Timeouts,
    /// Whether the SYNC is to carry a counter.
    pub sync_counter: SyncCounterChoice,
    /// What an emergency of a drive does in the cycle.
    pub emergency_reaction: EmergencyReaction,
    /// What a target torque that a drive ignores does.
    pub ignored_target_reaction: IgnoredTargetReaction,
}

impl<const N: usize> Task<N> {
    /// The desired motion.
    pub fn motion(&self) -> Motion<N> {
        Motion::task(self.reference.clone(), self.hold)
    }
}

impl<const J: usize, const N: usize> Robot<J, N> {
    /// The limits beyond which a run ends.
    pub fn guard(&self) -> Guard<J> {
        Guard {
            joints: self.joints.each_ref().map(|joint| joint.limits),
            stopping: self.stopping(),
            tracking_error: self.tracking_error_limit,
            start_tolerance: self.task.start_tolerance,
        }
    }

    /// How each joint comes to rest.
    fn stopping(&self) -> [Stopping; J] {
        let mut stopping = [Stopping::default(); J];
        for (stopping, joint) in stopping.iter_mut().zip(&self.joints) {
            stopping.brake = joint.brake;
            stopping.torque_delay = joint.torque_delay;
            stopping.resolution = joint.encoder.counts_per_revolution.resolution();
        }
        for (stopping, bound) in stopping.iter_mut().zip(self.acceleration_bounds.iter().flatten()) {
            stopping.acceleration = *bound;
        }
        stopping
    }

    /// The limiter of the active joints' torques.
    ///
    /// # Errors
    /// [`TorqueLimitError`] if a limit is not a positive number.
    pub fn torque_limiter(&self) -> Result<TorqueLimiter<f64, N>, TorqueLimitError> {
        let of_active = |limit: fn(&Joint) -> f64| -> SVector<f64, N> {
            crate::dimensions::active(&self.joints.each_ref().map(limit))
        };
        let limits = TorqueLimits::new(of_active(|joint| joint.torque_limit))?
            .with_rate(of_active(|joint| joint.torque_rate_limit))?;
        Ok(TorqueLimiter::new(limits))
    }

    /// What holds counts and torques against the model, before the first cycle.
    pub fn supervision(&self) -> Option<Supervision<J>> {
        let settings = self.supervision.clone()?;
        let joints = self.joints.each_ref().map(|joint| JointTraits {
            resolution: joint.encoder.counts_per_revolution.resolution(),
            delay: (self.command_delay(joint) + joint.torque_delay).as_secs_f64() / self.period.seconds(1),
        });
        Some(Supervision::new(settings, joints))
    }

    /// From the SYNC that latches the counts to the instant at which the command made of them acts in the drive of `joint`: the frames of a
    /// cycle, at their longest. What the computer needs for its part, some ten microseconds, is not in it.
    pub fn command_delay(&self, joint: &Joint) -> Duration {
        match joint.drive.torque_applies {
            TorqueApplies::OnReception => self.bus.time.cyclic,
            TorqueApplies::AtSync => self.period.duration(),
        }
    }

    /// The node ids of the drives, the base's first.
    pub fn nodes(&self) -> [u8; J] {
        self.joints.each_ref().map(|joint| joint.node.raw())
    }
}
