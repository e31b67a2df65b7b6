//! The end that somebody asks for: an envelope around the torques that shrinks linearly to zero.

use nalgebra::SVector;
use uarm_io::time::Duration;

use crate::supervisor::Authority;

/// How long the torques take to fade to zero after a request to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StopRamp(Duration);

impl StopRamp {
    /// The longest: who asks for the end does not wait longer for the quick stop.
    pub const LONGEST: Duration = Duration::from_millis(100);

    /// A ramp of that duration; zero is none. `None` if it is longer than [`LONGEST`](Self::LONGEST).
    pub fn new(duration: Duration) -> Option<Self> {
        (duration <= Self::LONGEST).then_some(Self(duration))
    }

    /// How long the torques take to fade to zero.
    pub const fn duration(self) -> Duration {
        self.0
    }
}

impl Default for StopRamp {
    /// 50 ms: long against the period, short against the motion.
    fn default() -> Self {
        Self(Duration::from_millis(50))
    }
}

/// Keeps the torques of `N` joints within the envelope of a stop.
#[derive(Clone, Copy, Debug)]
pub struct Fade<const N: usize> {
    ramp: StopRamp,
    /// The stop that is going on.
    stopping: Option<Stopping<N>>,
}

#[derive(Clone, Copy, Debug)]
struct Stopping<const N: usize> {
    /// Magnitude of the torques that were applied when the stop began, N·m.
    from: SVector<f64, N>,
    /// Since then, s.
    elapsed: f64,
}

/// The magnitude that each torque may have, N·m; nothing bounds it without a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Envelope<const N: usize>(Option<SVector<f64, N>>);

impl<const N: usize> Fade<N> {
    /// No stop yet.
    pub const fn new(ramp: StopRamp) -> Self {
        Self { ramp, stopping: None }
    }

    /// How long a stop takes.
    pub const fn ramp(&self) -> StopRamp {
        self.ramp
    }

    /// The envelope of this cycle, whose torques act for `period` seconds. The first cycle with [`Authority::Fading`] begins the stop
    /// from `applied`, N·m, the torques that act until then: its own are already smaller by the share of one period.
    pub fn envelope(&mut self, authority: Authority, applied: &SVector<f64, N>, period: f64) -> Envelope<N> {
        match authority {
            Authority::Full => {
                self.stopping = None;
                Envelope(None)
            }
            Authority::Fading => {
                let stopping = self.stopping.get_or_insert(Stopping { from: applied.abs(), elapsed: 0.0 });
                stopping.elapsed += period;
                let left = 1.0 - stopping.elapsed / self.ramp.0.as_secs_f64();
                // Written so that a ramp of zero, too, leaves nothing.
                let left = if left > ROUNDING { left } else { 0.0 };
                Envelope(Some(stopping.from * left))
            }
        }
    }

    /// Whether the stop has come to zero torque.
    pub fn is_over(&self) -> bool {
        let ramp = self.ramp.0.as_secs_f64();
        self.stopping.is_some_and(|stopping| stopping.elapsed >= ramp * (1.0 - ROUNDING))
    }
}

/// What sums of periods may miss of the ramp by rounding, as a share of it.
const ROUNDING: f64 = 1e-9;

impl<const N: usize> Envelope<N> {
    /// `torque`, N·m, as far as the envelope allows it.
    pub fn bound(&self, torque: SVector<f64, N>) -> SVector<f64, N> {
        match &self.0 {
            None => torque,
            Some(most) => torque.zip_map(most, |torque, most| torque.clamp(-most, most)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn fade(milliseconds: u64) -> Fade<2> {
        Fade::new(StopRamp::new(Duration::from_millis(milliseconds)).unwrap())
    }

    #[test]
    fn the_envelope_shrinks_linearly_from_what_was_applied() {
        let mut fade = fade(12);
        let applied = Vector2::new(0.4, -0.8);
        assert_eq!(
            fade.envelope(Authority::Full, &applied, 0.003).bound(Vector2::new(9.0, -9.0)),
            Vector2::new(9.0, -9.0)
        );
        for left in [0.75, 0.5, 0.25, 0.0] {
            assert!(!fade.is_over());
            // What acts in the meantime does not matter.
            let applied = if left == 0.75 { applied } else { Vector2::new(7.0, 7.0) };
            let envelope = fade.envelope(Authority::Fading, &applied, 0.003);
            let bounded = envelope.bound(Vector2::new(-1.0, 1.0));
            assert!((bounded - Vector2::new(-0.4 * left, 0.8 * left)).norm() < 1e-12, "{bounded}");
            let inside = Vector2::new(0.3 * left, -0.7 * left);
            assert_eq!(envelope.bound(inside), inside, "inside the envelope, the law's torque stays");
        }
        assert!(fade.is_over());
        assert_eq!(fade.envelope(Authority::Fading, &applied, 0.003).bound(applied), Vector2::zeros());
    }

    #[test]
    fn no_ramp_is_zero_at_once_and_longer_than_a_tenth_of_a_second_is_refused() {
        let mut fade = fade(0);
        let applied = Vector2::new(0.4, -0.8);
        assert_eq!(fade.envelope(Authority::Fading, &applied, 0.003).bound(applied), Vector2::zeros());
        assert!(fade.is_over());
        assert_eq!(StopRamp::new(Duration::from_micros(100_001)), None);
    }
}
