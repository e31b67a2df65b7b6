//! Recordings, and the windows that they are cut into.

/// How long a window is, s: long against the rounding of encoders, short against the time over which a wrong parameter spoils a motion.
pub const WINDOW: f64 = 0.3;

/// A window with fewer samples says too little of its own start.
const FEWEST: usize = 8;

/// One cycle of a recording of `J` joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const J: usize> {
    /// When the encoders were read, s.
    pub at: f64,
    /// What they read, rad.
    pub position: [f64; J],
    /// The torque that acted then, N·m: that of the cycle before.
    pub torque_before: [f64; J],
    /// The torque that the motors were told in this cycle, N·m.
    pub torque: [f64; J],
    /// When it began to act, s.
    pub torque_at: f64,
    /// What else acted on the joints at `at` and is known, N·m.
    pub disturbance: [f64; J],
}

/// Cuts a recording into windows that share their first and last sample, none shorter than is of use. The rest at its end belongs to the last.
pub(crate) fn windows<const J: usize>(samples: &[Sample<J>]) -> Vec<&[Sample<J>]> {
    let mut windows = Vec::new();
    let mut rest = samples;
    while let [first, _, ..] = rest {
        // Beyond the rounding of the times.
        let length = rest.iter().take_while(|sample| sample.at - first.at <= WINDOW * (1.0 + 1e-9)).count().max(2);
        let left = rest.len() + 1 - length;
        if left < FEWEST {
            windows.push(rest);
            break;
        }
        windows.push(&rest[..length]);
        rest = &rest[length - 1..];
    }
    windows.retain(|window| window.len() >= FEWEST);
    windows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(count: u32) -> Vec<Sample<1>> {
        let sample = |cycle: u32| {
            let at = 0.01 * f64::from(cycle);
            Sample { at, position: [at], torque_before: [0.0], torque: [0.0], torque_at: at, disturbance: [0.0] }
        };
        (0..count).map(sample).collect()
    }

    #[test]
    fn windows_meet_and_leave_nothing_out() {
        for count in [9, 31, 62, 100, 107, 125] {
            let samples = samples(count);
            let windows = windows(&samples);
            assert_eq!(windows[0][0], samples[0]);
            assert_eq!(windows.last().unwrap().last(), samples.last());
            for pair in windows.windows(2) {
                assert_eq!(pair[0].last(), pair[1].first());
            }
            assert!(windows.iter().all(|window| window.len() >= FEWEST), "{count}");
        }
        // 31, 31, 31 and 10 samples; 31, 31 and 37.
        assert_eq!(windows(&samples(100)).len(), 4);
        assert_eq!(windows(&samples(97)).len(), 3);
    }

    #[test]
    fn what_is_too_short_is_no_window() {
        assert!(windows(&samples(7)).is_empty());
        assert!(windows::<1>(&[]).is_empty());
    }
}
