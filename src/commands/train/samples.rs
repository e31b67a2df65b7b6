//! What the fuzzy systems shall learn, and from which signals.
//!
//! Inputs are those of the systems: velocity error q̃̇_k (°/s) and position error q̃_k (°) of joint k, measured less desired.
//!
//! Target: the part of the applied torque that is not feedback, τ_k − (T11⁻¹u)_k (N·m). The fuzzy law is
//! τ = ΞΦ + T11⁻¹u (paper eq. 43), and its ΞΦ stands for F + E − δ, which nobody can measure (eq. 41). With the law's
//! s = q̃̇ + Λq̃ the closed loop is M_mm ṡ + C_mm s = T11⁻¹u + (ΞΦ − (F + E − δ)), so that τ − T11⁻¹u differs from
//! F + E − δ by M_mm ṡ + C_mm s − T11⁻¹u alone: nothing but transients. The run should therefore be one that tracks well with
//! what it adapted, friction included, such as `neural`; the paper, too, trained on an earlier adaptive run (its section 4).
//!
//! The samples of all joints are pooled, since their systems share the sets. Joints whose torque was cut are left out: there the
//! torque is the limiter's.

use std::path::{Path, PathBuf};

use anfis::{AnfisError, DataSet};
use hinf_control::{Law, Synthesis};

use uarm_loop::dimensions;

use super::points::{self, Place, Point, PointsError};
use crate::robot::Robot;

/// How far the recorded u may be from u of the law, relative to 1: rounding, many times over.
const INPUT_TOLERANCE: f64 = 1e-6;

/// The most samples: a training holds all of them, with about 300 bytes for each. A run at 3 ms gives 667 a second, and so many in 100 minutes.
const MOST_SAMPLES: usize = 4_000_000;

/// Samples that cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// A recorded run cannot be used.
    #[error(transparent)]
    Points(#[from] PointsError),
    /// A law whose torque is not made of feedback T11⁻¹u and the rest.
    #[error(
        "--controller {}: expected one of the paper's laws; this one has another feedback, which the recorded torque cannot be rid of",
        law.name()
    )]
    Law {
        /// The law.
        law: Law,
    },
    /// The law's weights.
    #[error("controllers.{law}: {source}")]
    Weights {
        /// The law's name.
        law: &'static str,
        /// Why the weights are refused.
        source: hinf_control::SynthesisError,
    },
    /// Another law, or another robot file, made the recording.
    #[error(
        "{}, {place}: control_input_{joint} = {found}: expected {expected}, as {law} has it with this robot file; \
         name the law that ran with --controller, and its file with --robot", file.display()
    )]
    OtherLaw {
        /// The recorded run.
        file: PathBuf,
        /// Where it stands there.
        place: Place,
        /// The joint.
        joint: usize,
        /// u as recorded.
        found: f64,
        /// u of the law.
        expected: f64,
        /// The law that was expected.
        law: &'static str,
    },
    /// More samples than a training holds.
    #[error(
        "{}, {place}: more than {most} samples with this cycle: expected at most so many in all recorded runs; a training holds all of them",
        file.display()
    )]
    TooMany {
        /// The most.
        most: usize,
        /// The recorded run.
        file: PathBuf,
        /// Where it stands there.
        place: Place,
    },
    /// Too few samples, or values beyond reason.
    #[error("the recorded runs: {0}")]
    Data(#[from] AnfisError),
}

/// One sample: velocity and position error, deg/s and deg, and the target, N m.
type Sample = ([f64; 2], f64);

/// The samples of several recorded runs of `law` with the weights of `robot`. The runs are read cycle by cycle; the samples are held.
///
/// # Errors
/// [`SampleError`].
pub fn samples<const J: usize, const N: usize>(
    runs: &[PathBuf],
    law: Law,
    robot: &Robot<J, N>,
) -> Result<DataSet, SampleError> {
    samples_up_to(MOST_SAMPLES, runs, law, robot)
}

fn samples_up_to<const J: usize, const N: usize>(
    most: usize,
    runs: &[PathBuf],
    law: Law,
    robot: &Robot<J, N>,
) -> Result<DataSet, SampleError> {
    if robot.controllers.state_weights(law).is_none() {
        return Err(SampleError::Law { law });
    }
    let synthesis = Synthesis::new(&robot.controllers.weights(law))
        .map_err(|source| SampleError::Weights { law: law.name(), source })?;
    let mut samples: Vec<Sample> = Vec::new();
    for file in runs {
        let before = samples.len();
        let take = |of_run: &mut Vec<Sample>, point: &Point<N>| {
            check_input::<J, N>(file, point, law, &synthesis)?;
            of_run.extend(samples_of(point, &synthesis));
            if before + of_run.len() > most {
                return Err(SampleError::TooMany { most, file: file.clone(), place: point.place });
            }
            Ok(())
        };
        samples.extend(points::read::<_, _, J, N>(file, Vec::new, take)?);
    }
    Ok(DataSet::new(samples)?)
}

/// The samples of one cycle: none of a joint whose torque was cut.
fn samples_of<const N: usize>(
    point: &Point<N>,
    synthesis: &Synthesis<f64, N>,
) -> impl Iterator<Item = Sample> + use<N> {
    let Point { error, limited, .. } = *point;
    let rest = point.torque_applied - synthesis.feedback_torque(&error);
    (0..N)
        .filter(move |joint| !limited[*joint])
        .map(move |joint| ([error.velocity[joint].to_degrees(), error.position[joint].to_degrees()], rest[joint]))
}

fn check_input<const J: usize, const N: usize>(
    file: &Path,
    point: &Point<N>,
    law: Law,
    synthesis: &Synthesis<f64, N>,
) -> Result<(), SampleError> {
    let expected = synthesis.control_input(&point.error);
    for joint in 0..N {
        let (found, expected) = (point.control_input[joint], expected[joint]);
        if (found - expected).abs() > INPUT_TOLERANCE * expected.abs().max(1.0) {
            let (file, place, law) = (file.to_owned(), point.place, law.name());
            let joint = dimensions::number_of_active::<J, N>(joint);
            return Err(SampleError::OtherLaw { file, place, joint, found, expected, law });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_samples_than_are_held_are_refused_by_file_and_line() {
        // A joint that stands still where it should, in four cycles: two samples each.
        let row = vec!["0"; points::columns::<3, 2>().len()].join(",");
        let text = format!("{}\n{}", points::columns::<3, 2>().join(","), format!("{row}\n").repeat(4));
        let file = std::env::temp_dir().join(format!("uarm-train-samples-{}.csv", std::process::id()));
        std::fs::write(&file, text).unwrap();
        let robot = Robot::load(None).unwrap();
        let found = |most, runs| match samples_up_to(most, &vec![file.clone(); runs], Law::Fuzzy, &robot) {
            Err(SampleError::TooMany { most, file: named, place }) => {
                assert_eq!(named, file);
                Some((most, place.to_string()))
            }
            _ => None,
        };
        assert_eq!(found(7, 1), Some((7, "line 5".to_owned())));
        assert_eq!(found(8, 1), None);
        assert_eq!(found(8, 2), Some((8, "line 2".to_owned())), "those of all runs count");
        std::fs::remove_file(&file).unwrap();
    }
}
