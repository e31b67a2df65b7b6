//! What the supervision may take for granted, and from when on it speaks.

use std::sync::Arc;

use uarm_io::time::Duration;

use super::model::MomentumModel;

/// Bandwidth of the observer, rad/s: 1 to 500.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth(f64);

impl Bandwidth {
    /// The least and the most, rad/s.
    pub const RANGE: [f64; 2] = [1.0, 500.0];
    /// What is taken unless a robot says otherwise, rad/s: 50 % of a torque that sets in are seen after 34 ms.
    const USUAL: f64 = 50.0;
    /// The most by default, radians a period, in slow loops.
    const USUAL_PER_PERIOD: f64 = 0.3;

    /// `None` outside [`RANGE`](Self::RANGE).
    pub fn new(rad_per_s: f64) -> Option<Self> {
        let [least, most] = Self::RANGE;
        (least..=most).contains(&rad_per_s).then_some(Self(rad_per_s))
    }

    /// What a loop of `period` seconds has by default.
    pub fn of_period(period: f64) -> Self {
        let [least, most] = Self::RANGE;
        Self(Self::USUAL.min(Self::USUAL_PER_PERIOD / period).clamp(least, most))
    }

    /// rad/s.
    pub const fn get(self) -> f64 {
        self.0
    }
}

/// Torque that the model does not know, N·m: friction, gravity, cables, what pushes the arm. Above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueAllowance(f64);

impl TorqueAllowance {
    /// Of a joint's largest torque, unless a robot says otherwise: with less than a quarter of its torque left for motion, a joint
    /// could not follow.
    const SHARE_OF_LIMIT: f64 = 0.75;

    /// `None` unless above zero and finite.
    pub fn new(newton_metres: f64) -> Option<Self> {
        (newton_metres > 0.0 && newton_metres.is_finite()).then_some(Self(newton_metres))
    }

    /// What a joint with this largest torque, N·m, has by default; nothing of a joint without torque.
    pub fn of_limit(torque_limit: f64) -> Option<Self> {
        Self::new(Self::SHARE_OF_LIMIT * torque_limit)
    }

    /// N·m.
    pub const fn get(self) -> f64 {
        self.0
    }
}

/// How far the model's inertias may be off, as a share of the torque that moves them: 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelError(f64);

impl ModelError {
    /// `None` outside 0 to 1.
    pub fn new(share: f64) -> Option<Self> {
        (0.0..=1.0).contains(&share).then_some(Self(share))
    }

    /// The share.
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl Default for ModelError {
    /// 40 %: a robot 67 % heavier than its model, or 29 % lighter.
    fn default() -> Self {
        Self(0.4)
    }
}

/// For how long a residual may be beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResidualTime(Duration);

impl ResidualTime {
    /// The longest.
    pub const LONGEST: Duration = Duration::from_secs(1);

    /// `None` if it is zero or longer than [`LONGEST`](Self::LONGEST).
    pub fn new(duration: Duration) -> Option<Self> {
        (!duration.is_zero() && duration <= Self::LONGEST).then_some(Self(duration))
    }

    /// The duration.
    pub const fn duration(self) -> Duration {
        self.0
    }
}

impl Default for ResidualTime {
    /// 10 ms.
    fn default() -> Self {
        Self(Duration::from_millis(10))
    }
}

/// How a robot of `J` joints is supervised.
#[derive(Clone, Debug)]
pub struct SupervisionSettings<const J: usize> {
    /// The manipulator as it is believed to be.
    pub model: Arc<dyn MomentumModel<J>>,
    /// Of the observer.
    pub bandwidth: Bandwidth,
    /// How far the model may be off.
    pub model_error: ModelError,
    /// For how long a residual may be beyond its limit.
    pub residual_time: ResidualTime,
    /// What else may act on each joint; nothing of a joint that is not judged, such as the passive base.
    pub allowances: [Option<TorqueAllowance>; J],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_follow_the_robot() {
        assert_eq!(Bandwidth::of_period(0.003).get(), 50.0);
        assert_eq!(Bandwidth::of_period(0.03).get(), 10.0);
        assert_eq!(TorqueAllowance::of_limit(0.2).map(TorqueAllowance::get), Some(0.75 * 0.2));
        assert_eq!(TorqueAllowance::of_limit(0.0), None);
    }

    #[test]
    fn what_is_out_of_range_cannot_be_built() {
        assert!([0.9, 500.1, f64::NAN].iter().all(|bandwidth| Bandwidth::new(*bandwidth).is_none()));
        assert!([0.0, f64::INFINITY, f64::NAN].iter().all(|torque| TorqueAllowance::new(*torque).is_none()));
        assert!([-0.1, 1.1, f64::NAN].iter().all(|share| ModelError::new(*share).is_none()));
        assert_eq!(ResidualTime::new(Duration::ZERO), None);
        assert_eq!(ResidualTime::new(Duration::from_millis(1_001)), None);
    }
}
