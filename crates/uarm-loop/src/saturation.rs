//! A law whose torque is cut for long is no longer in control: lasting saturation ends a run.

use uarm_io::time::Duration;

use crate::dimensions::number_of_active;

/// For how long the torque of a joint may be cut without a break.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SaturationLimit(Duration);

impl SaturationLimit {
    /// The longest: later than that nobody would call it a reaction.
    pub const LONGEST: Duration = Duration::from_secs(10);

    /// `None` if it is zero or longer than [`LONGEST`](Self::LONGEST).
    pub fn new(duration: Duration) -> Option<Self> {
        (!duration.is_zero() && duration <= Self::LONGEST).then_some(Self(duration))
    }

    /// The duration.
    pub const fn duration(self) -> Duration {
        self.0
    }
}

impl Default for SaturationLimit {
    /// Half a second.
    fn default() -> Self {
        Self(Duration::from_millis(500))
    }
}

/// The torque of a joint was cut for too long.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "joint {joint}: the torque was cut by its limits for {:.0} ms without a break, expected at most {:.0} ms",
    .lasted * 1e3, .limit.0.as_secs_f64() * 1e3
)]
pub struct LastingSaturation {
    /// The joint, counted from 1.
    pub joint: usize,
    /// For how long, s.
    pub lasted: f64,
    /// For how long it may be.
    pub limit: SaturationLimit,
}

/// Watches for how long the torques of `N` active joints have been cut.
#[derive(Clone, Copy, Debug)]
pub struct SaturationWatch<const N: usize> {
    /// None: a torque may be cut for as long as it is.
    limit: Option<SaturationLimit>,
    /// For how long each torque has been cut without a break, s.
    lasting: [f64; N],
}

impl<const N: usize> SaturationWatch<N> {
    /// Nothing has been cut yet.
    pub const fn new(limit: SaturationLimit) -> Self {
        Self { limit: Some(limit), lasting: [0.0; N] }
    }

    /// Watches, and ends nothing: for an open loop.
    pub const fn unlimited() -> Self {
        Self { limit: None, lasting: [0.0; N] }
    }

    /// For how long each torque has been cut without a break, s: the whole inner state.
    pub const fn lasting(&self) -> [f64; N] {
        self.lasting
    }

    /// Goes on from a frozen state.
    pub const fn thaw(&mut self, lasting: [f64; N]) {
        self.lasting = lasting;
    }

    /// Takes in which torques were cut in a cycle of `period` seconds, of a robot of `J` joints.
    ///
    /// # Errors
    /// [`LastingSaturation`] for the first joint for which it was too long.
    pub fn watch<const J: usize>(&mut self, limited: [bool; N], period: f64) -> Result<(), LastingSaturation> {
        for (lasting, limited) in self.lasting.iter_mut().zip(limited) {
            *lasting = if limited { *lasting + period } else { 0.0 };
        }
        let Some(limit) = self.limit else { return Ok(()) };
        let most = limit.0.as_secs_f64();
        match self.lasting.iter().enumerate().find(|(_, lasting)| **lasting > most) {
            Some((index, lasted)) => {
                Err(LastingSaturation { joint: number_of_active::<J, N>(index), lasted: *lasted, limit })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_saturation_without_a_break_adds_up() {
        let mut watch = SaturationWatch::<2>::new(SaturationLimit::new(Duration::from_millis(10)).unwrap());
        for cycle in 0..100 {
            assert_eq!(watch.watch::<3>([cycle % 5 != 0, false], 0.0025), Ok(()), "four in a row are 10 ms");
        }
        assert_eq!(watch.watch::<3>([false, true], 0.0025), Ok(()));
        for _ in 0..3 {
            assert_eq!(watch.watch::<3>([false, true], 0.0025), Ok(()));
        }
        let fault = watch.watch::<3>([false, true], 0.0025).unwrap_err();
        assert_eq!((fault.joint, fault.lasted), (3, 0.0125));
        assert!(fault.to_string().ends_with("for 12 ms without a break, expected at most 10 ms"), "{fault}");
        let mut unlimited = SaturationWatch::<2>::unlimited();
        assert!((0..1_000).all(|_| unlimited.watch::<3>([true; 2], 1.0).is_ok()));
    }

    /// A replay goes on in the middle of a saturation: two cycles before the keyframe and three behind it are 12.5 ms.
    #[test]
    fn a_thawed_watch_goes_on_counting() {
        let limit = SaturationLimit::new(Duration::from_millis(10)).unwrap();
        let mut watch = SaturationWatch::<2>::new(limit);
        for _ in 0..2 {
            watch.watch::<3>([false, true], 0.0025).unwrap();
        }
        assert_eq!(watch.lasting(), [0.0, 0.005]);
        let mut thawed = SaturationWatch::<2>::new(limit);
        thawed.thaw([0.0, 0.005]);
        for _ in 0..2 {
            thawed.watch::<3>([false, true], 0.0025).unwrap();
        }
        assert_eq!(
            thawed.watch::<3>([false, true], 0.0025),
            Err(LastingSaturation { joint: 3, lasted: 0.0125, limit })
        );
    }

    #[test]
    fn a_limit_is_neither_zero_nor_endless() {
        assert_eq!(SaturationLimit::new(Duration::ZERO), None);
        assert_eq!(SaturationLimit::new(Duration::from_millis(10_001)), None);
        assert_eq!(SaturationLimit::default().duration(), Duration::from_millis(500));
    }
}
