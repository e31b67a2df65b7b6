//! The limits of the robot, beyond which a run ends: torque zero, quick stop, brakes.

use std::fmt;

use hinf_control::Reference;
use uarm_io::time::Duration;

use crate::barrier::{Stopping, Times};
use crate::dimensions;
use crate::estimation::Estimate;
use crate::motion::Motion;

/// What one joint may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Smallest and largest angle, rad.
    pub position: [f64; 2],
    /// Largest velocity either way, rad/s.
    pub velocity: f64,
}

/// Checks the limits of a run in each cycle.
#[derive(Clone, Copy, Debug)]
pub struct Guard<const J: usize> {
    /// What each joint may do, the passive base first.
    pub joints: [JointLimits; J],
    /// How each joint comes to rest.
    pub stopping: [Stopping; J],
    /// How far an active joint may be from its reference, rad.
    pub tracking_error: f64,
    /// How far an active joint may be from its reference in the first cycle, rad.
    pub start_tolerance: f64,
}

/// What went beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The joint's angle.
    Position,
    /// The joint's velocity.
    Velocity,
    /// Where the joint would come to rest if it were stopped one cycle later.
    StoppingAngle,
    /// How fast it would be by then.
    StoppingVelocity,
    /// The distance from the reference.
    TrackingError,
    /// The distance from the reference in the first cycle.
    StartError,
    /// The largest velocity of the approach.
    ApproachVelocity,
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Position => "angle",
            Self::Velocity => "velocity",
            Self::StoppingAngle => "angle at which it would stand if stopped a cycle later",
            Self::StoppingVelocity => "velocity that it may have if stopped a cycle later",
            Self::TrackingError => "tracking error",
            Self::StartError => "distance from the start of the motion",
            Self::ApproachVelocity => "largest velocity of the approach",
        })
    }
}

impl Quantity {
    const fn per_second(self) -> &'static str {
        match self {
            Self::Velocity | Self::StoppingVelocity | Self::ApproachVelocity => "/s",
            Self::Position | Self::StoppingAngle | Self::TrackingError | Self::StartError => "",
        }
    }
}

/// A limit was passed, or would be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "joint {joint} at {time:.3} s: {quantity} is {:.2} deg{unit}, expected {:.2} to {:.2} deg{unit}{}",
    .found.to_degrees(), .allowed[0].to_degrees(), .allowed[1].to_degrees(),
    Coasting(*.braking), unit = .quantity.per_second()
)]
pub struct LimitViolation {
    /// The joint, counted from 1.
    pub joint: usize,
    /// Task time, s.
    pub time: f64,
    /// Which limit was passed.
    pub quantity: Quantity,
    /// The value found, rad or rad/s.
    pub found: f64,
    /// The range allowed, rad or rad/s.
    pub allowed: [f64; 2],
    /// From what the joint would have to come to rest, where that is the question.
    pub braking: Option<Braking>,
}

/// What a joint that is stopped comes to rest from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Braking {
    /// Its velocity by its last two counts, rad/s.
    pub velocity: f64,
    /// From the command to stop until its brake holds.
    pub brake: Duration,
}

/// The end of a message, where there is a [`Braking`].
struct Coasting(Option<Braking>);

impl fmt::Display for Coasting {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(Braking { velocity, brake }) = self.0 else { return Ok(()) };
        let (velocity, brake) = (velocity.to_degrees(), brake.as_millis());
        write!(formatter, "; it turns by {velocity:.2} deg/s, and its brake takes {brake} ms (brake_ms)")
    }
}

/// The largest velocity of a quintic from rest to rest, times its duration over its travel (paper eq. 47 at half time).
const PEAK_OF_QUINTIC: f64 = 15.0 / 8.0;

impl<const J: usize> Guard<J> {
    /// Checks a motion that begins with the joints at rest at `angles`, rad, before brakes open: where they stand, how far that
    /// is from the motion's start, and how fast the approach is. The task itself is checked with the robot file.
    ///
    /// # Errors
    /// [`LimitViolation`] for the first limit that is, or would be, passed.
    pub fn check_start<const N: usize>(&self, angles: &[f64; J], motion: &Motion<N>) -> Result<(), LimitViolation> {
        let time = motion.start();
        for (index, (angle, limits)) in angles.iter().zip(&self.joints).enumerate() {
            within(index + 1, time, Quantity::Position, *angle, limits.position)?;
        }
        let error = dimensions::active::<J, N>(angles) - motion.at(time).position;
        for (index, error) in error.iter().enumerate() {
            let allowed = [-self.start_tolerance, self.start_tolerance];
            within(dimensions::number_of_active::<J, N>(index), time, Quantity::StartError, *error, allowed)?;
        }
        let Some(approach) = motion.approach() else { return Ok(()) };
        let travel = approach.end() - approach.start();
        for (index, travel) in travel.iter().enumerate() {
            let joint = dimensions::number_of_active::<J, N>(index);
            let peak = PEAK_OF_QUINTIC * travel / approach.duration();
            let allowed = self.joints.get(joint - 1).map_or(0.0, |limits| limits.velocity);
            within(joint, time, Quantity::ApproachVelocity, peak, [-allowed, allowed])?;
        }
        Ok(())
    }

    /// Checks the cycle at task time `time` that comes `elapsed` ticks after its predecessor, 0 if it is the first.
    ///
    /// # Errors
    /// [`LimitViolation`] for the first limit that is passed.
    pub fn check<const N: usize>(
        &self,
        time: f64,
        elapsed: u64,
        estimate: &Estimate<J>,
        reference: &Reference<f64, N>,
    ) -> Result<(), LimitViolation> {
        for (index, (joint, limits)) in estimate.joints.iter().zip(&self.joints).enumerate() {
            within(index + 1, time, Quantity::Position, joint.position, limits.position)?;
            within(index + 1, time, Quantity::Velocity, joint.velocity, [-limits.velocity, limits.velocity])?;
        }
        let (quantity, allowed) = match elapsed {
            0 => (Quantity::StartError, self.start_tolerance),
            _ => (Quantity::TrackingError, self.tracking_error),
        };
        let error = dimensions::active::<J, N>(&estimate.position()) - reference.position;
        for (index, error) in error.iter().enumerate() {
            within(dimensions::number_of_active::<J, N>(index), time, quantity, *error, [-allowed, allowed])?;
        }
        Ok(())
    }

    /// Checks that each joint, now at `measured` and a cycle before at `before`, rad, can be stopped within its limits one cycle later.
    ///
    /// # Errors
    /// [`LimitViolation`] for the first limit that might be passed.
    pub fn check_stopping(
        &self,
        times: &Times,
        before: &[Option<f64>; J],
        measured: &[f64; J],
    ) -> Result<(), LimitViolation> {
        let mut turned = [0.0; J];
        for ((turned, before), angle) in turned.iter_mut().zip(before).zip(measured) {
            *turned = before.map_or(0.0, |before| angle - before);
        }
        let fastest = turned.iter().fold(0.0_f64, |fastest, turned| fastest.max(turned.abs()));
        let fastest = if times.elapsed > 0.0 { fastest / times.elapsed } else { 0.0 };
        let joints = self.joints.iter().zip(&self.stopping).zip(measured.iter().zip(turned));
        for (index, ((limits, stopping), (angle, turned))) in joints.enumerate() {
            for direction in [1.0, -1.0] {
                let reach = stopping.reach(direction * turned, fastest, times);
                let [angle, velocity] = [angle + direction * reach.distance, direction * reach.velocity];
                let now = if times.elapsed > 0.0 { turned / times.elapsed } else { 0.0 };
                let told = |violation| LimitViolation {
                    braking: Some(Braking { velocity: now, brake: stopping.brake }),
                    ..violation
                };
                let allowed = [-limits.velocity, limits.velocity];
                within(index + 1, times.time, Quantity::StoppingAngle, angle, limits.position).map_err(told)?;
                within(index + 1, times.time, Quantity::StoppingVelocity, velocity, allowed).map_err(told)?;
            }
        }
        Ok(())
    }
}

fn within(joint: usize, time: f64, quantity: Quantity, found: f64, allowed: [f64; 2]) -> Result<(), LimitViolation> {
    let [least, most] = allowed;
    // Written so that NaN is outside.
    if found >= least && found <= most {
        Ok(())
    } else {
        Err(LimitViolation { joint, time, quantity, found, allowed, braking: None })
    }
}
