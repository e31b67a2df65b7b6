//! What disturbs the joints.

use core::time::Duration;
use nalgebra::{ComplexField, SVector};

/// A torque that acts at the joints beside the motors': it is part of the plant, not of the controller's torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Disturbance {
    /// Nothing acts but the motors.
    #[default]
    None,
    /// The paper's eq. 48: with s = t − 1 s, `e^(−5s) sin(6πs) · [0.075, 0.05]` N·m at joints 2 and 3 from s = 0 on.
    ///
    /// The paper prints absolute time; s runs from the onset (only so does the peak of about 75 % of the undisturbed
    /// peak torque, which the text states, come out).
    Paper,
}

impl Disturbance {
    /// When the paper's disturbance sets in, plant time.
    pub const PAPER_ONSET: Duration = Duration::from_secs(1);
    /// Amplitudes at joints 2 and 3, N·m (eq. 48).
    const PAPER_AMPLITUDE: [f64; 2] = [0.075, 0.05];
    /// Decay rate, 1/s (eq. 48).
    const PAPER_DECAY: f64 = 5.0;
    /// Angular frequency, rad/s (eq. 48).
    const PAPER_FREQUENCY: f64 = 6.0 * core::f64::consts::PI;

    /// The torque at the `N` active joints, N·m, `offset` seconds (≥ 0) after the plant time `time`. Joints that the paper's
    /// robot has not are left alone.
    ///
    /// Instant and offset come apart so that the onset is met exactly: whole nanoseconds are subtracted as integers.
    pub fn torque<const N: usize>(self, time: Duration, offset: f64) -> SVector<f64, N> {
        match self {
            Self::None => SVector::zeros(),
            Self::Paper => match time.checked_sub(Self::PAPER_ONSET) {
                None => SVector::zeros(),
                Some(since) => Self::paper(since.as_secs_f64() + offset),
            },
        }
    }

    fn paper<const N: usize>(s: f64) -> SVector<f64, N> {
        let shape = ComplexField::exp(-Self::PAPER_DECAY * s) * ComplexField::sin(Self::PAPER_FREQUENCY * s);
        SVector::from_fn(|row, _| Self::PAPER_AMPLITUDE.get(row).map_or(0.0, |amplitude| amplitude * shape))
    }

    /// The next instant after `time` at which the torque is not smooth: an integrator must step onto it.
    pub fn next_event_after(self, time: Duration) -> Option<Duration> {
        match self {
            Self::None => None,
            Self::Paper => (time < Self::PAPER_ONSET).then_some(Self::PAPER_ONSET),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acts_from_one_second_on_and_peaks_as_in_the_paper() {
        let just_before = Duration::from_nanos(999_999_999);
        assert_eq!(Disturbance::Paper.torque::<2>(just_before, 0.0), SVector::<f64, 2>::zeros());
        assert_eq!(Disturbance::Paper.torque::<2>(Duration::from_secs(1), 0.0), SVector::<f64, 2>::zeros());
        // The maximum of e^(−5s) sin(6πs) lies at tan(6πs) = 6π/5.
        let s = (6.0 * core::f64::consts::PI / 5.0).atan() / (6.0 * core::f64::consts::PI);
        let peak: SVector<f64, 3> = Disturbance::Paper.torque(Duration::from_secs(1), s);
        let expected = (-5.0 * s).exp() * (6.0 * core::f64::consts::PI * s).sin();
        approx::assert_relative_eq!(peak.x, 0.075 * expected, max_relative = 1e-14);
        approx::assert_relative_eq!(peak.y, 0.05 * expected, max_relative = 1e-14);
        assert_eq!(peak.z, 0.0, "the paper's robot has two active joints");
    }

    #[test]
    fn instant_and_offset_may_be_split_anywhere() {
        let whole: SVector<f64, 2> = Disturbance::Paper.torque(Duration::from_millis(1_250), 0.0);
        let split = Disturbance::Paper.torque(Duration::from_millis(1_125), 0.125);
        approx::assert_relative_eq!(whole, split, max_relative = 1e-13);
    }

    #[test]
    fn the_onset_is_the_only_event() {
        assert_eq!(Disturbance::Paper.next_event_after(Duration::ZERO), Some(Disturbance::PAPER_ONSET));
        assert_eq!(Disturbance::Paper.next_event_after(Disturbance::PAPER_ONSET), None);
        assert_eq!(Disturbance::None.next_event_after(Duration::ZERO), None);
    }
}
