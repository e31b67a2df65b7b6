//! Stops a run on NaN or infinity in an estimate, a command or an adapted parameter, before a torque is made of it.

use std::fmt;

use hinf_control::Command;

use crate::dimensions::number_of_active;
use crate::estimation::Estimate;

/// What a joint has that must be a finite number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointSignal {
    /// The angle that the encoder gives, rad.
    MeasuredAngle,
    /// The estimated angle, rad.
    Angle,
    /// The estimated velocity, rad/s.
    Velocity,
    /// The estimated acceleration, rad/s².
    Acceleration,
    /// The torque that the law asks for, N·m.
    Torque,
    /// The law's control input u (eq. 10).
    ControlInput,
}

impl fmt::Display for JointSignal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::MeasuredAngle => "measured angle",
            Self::Angle => "estimated angle",
            Self::Velocity => "estimated velocity",
            Self::Acceleration => "estimated acceleration",
            Self::Torque => "torque that the law asks for",
            Self::ControlInput => "control input",
        })
    }
}

/// A number is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotFinite {
    /// One of a joint.
    #[error("joint {joint}: the {signal} is {found}, expected a finite number")]
    Joint {
        /// The joint, counted from 1.
        joint: usize,
        /// Which of its numbers.
        signal: JointSignal,
        /// What was found.
        found: f64,
    },
    /// One of the adapted parameters Φ.
    #[error("adapted parameter {number} is {found}, expected a finite number")]
    Parameter {
        /// The parameter, counted from 1.
        number: usize,
        /// What was found.
        found: f64,
    },
    /// One within the law, which then asked for no torque.
    #[error("a number within the control law is not finite")]
    Law,
}

/// Checks what the encoders tell.
///
/// # Errors
/// [`NotFinite::Joint`] for the first joint with a number that is not finite.
pub fn check_estimate<const J: usize>(estimate: &Estimate<J>) -> Result<(), NotFinite> {
    for ((motion, measured), joint) in estimate.joints.iter().zip(estimate.measured).zip(1..) {
        let signals = [
            (JointSignal::MeasuredAngle, measured),
            (JointSignal::Angle, motion.position),
            (JointSignal::Velocity, motion.velocity),
            (JointSignal::Acceleration, motion.acceleration),
        ];
        for (signal, found) in signals {
            finite(joint, signal, found)?;
        }
    }
    Ok(())
}

/// Checks what a law asks for, and its adapted `parameters`.
///
/// # Errors
/// [`NotFinite`] for the first number that is not finite.
pub fn check_command<const J: usize, const N: usize>(
    command: &Command<f64, N>,
    parameters: &[f64],
) -> Result<(), NotFinite> {
    if command.adaptation.not_finite {
        return Err(NotFinite::Law);
    }
    for (index, (torque, input)) in command.torque.iter().zip(&command.control_input).enumerate() {
        let joint = number_of_active::<J, N>(index);
        finite(joint, JointSignal::Torque, *torque)?;
        finite(joint, JointSignal::ControlInput, *input)?;
    }
    match parameters.iter().zip(1..).find(|(found, _)| !found.is_finite()) {
        Some((found, number)) => Err(NotFinite::Parameter { number, found: *found }),
        None => Ok(()),
    }
}

fn finite(joint: usize, signal: JointSignal, found: f64) -> Result<(), NotFinite> {
    if found.is_finite() { Ok(()) } else { Err(NotFinite::Joint { joint, signal, found }) }
}
