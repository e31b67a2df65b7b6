//! What one experiment does, beyond what the robot's description says.

use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm_io::time::Duration;

use crate::schedule::OverrunPolicy;
use crate::task_clock::PeriodSource;
use crate::torque::DisturbanceSite;

/// The settings of one experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The control law.
    pub law: Law,
    /// What keeps the adapted parameters Φ from drifting.
    pub guard: AdaptationGuard,
    /// What to do about late cycles.
    pub overrun: OverrunPolicy,
    /// Where the period that estimators and laws are told comes from.
    pub period_source: PeriodSource,
    /// How long the way to the start of the task may take; without it, the joints must be there.
    pub approach: Option<Duration>,
    /// The disturbance of the experiment.
    pub disturbance: Disturbance,
    /// Where the disturbance acts.
    pub disturbance_site: DisturbanceSite,
}

impl Settings {
    /// The paper's experiment: nothing guards the adaptation, and eq. 48 disturbs the joints.
    pub fn paper(law: Law) -> Self {
        Self {
            law,
            guard: AdaptationGuard::None,
            overrun: OverrunPolicy::default(),
            period_source: PeriodSource::default(),
            approach: None,
            disturbance: Disturbance::Paper,
            disturbance_site: DisturbanceSite::Plant,
        }
    }
}
