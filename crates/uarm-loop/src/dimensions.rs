//! How the joints of a robot are counted: `J` joints with a drive each, of which the last `N` have motors that the law commands.
//!
//! Either joint 1 is the base, passive, and its encoder tells how it turns: J = N + 1, as on the paper's robot. Or no sensor is on the
//! base: J = N.
//!
//! Both numbers are const parameters of nearly every type in this crate. Stable Rust cannot say that in a type, so
//! [`check`] says it where a loop is built: another pair does not compile.

use nalgebra::SVector;

/// Refuses, at compile time, a number of joints that is neither that of the active joints nor one more.
pub const fn check<const J: usize, const N: usize>() {
    const { assert!(J == N || J == N + 1, "J joints are N active joints, and a passive base or none") }
}

/// How many joints come before the active ones: 1 if there is a passive base, else 0.
pub const fn passive<const J: usize, const N: usize>() -> usize {
    J.saturating_sub(N)
}

/// The value of the passive base, joint 1, among the values of all joints; where no sensor is on the base, the default: at rest.
pub fn base<V: Copy + Default, const J: usize, const N: usize>(values: &[V; J]) -> V {
    values.iter().take(passive::<J, N>()).next().copied().unwrap_or_default()
}

/// The values of the active joints among those of all joints.
pub fn active<const J: usize, const N: usize>(values: &[f64; J]) -> SVector<f64, N> {
    SVector::from_fn(|row, _| values.get(row + passive::<J, N>()).copied().unwrap_or_default())
}

/// The values of all joints, of which the passive base's is zero.
pub fn of_all<const J: usize, const N: usize>(active: &SVector<f64, N>) -> [f64; J] {
    let mut all = [0.0; J];
    for (to, from) in all.iter_mut().skip(passive::<J, N>()).zip(active) {
        *to = *from;
    }
    all
}

/// The number by which people count the active joint at `index`: 2 for the first behind a passive base.
pub const fn number_of_active<const J: usize, const N: usize>(index: usize) -> usize {
    index + passive::<J, N>() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_base_comes_first() {
        check::<3, 2>();
        assert_eq!(base::<_, 3, 2>(&[7, 8, 9]), 7);
        assert_eq!(active::<4, 3>(&[1.0, 2.0, 3.0, 4.0]), SVector::from([2.0, 3.0, 4.0]));
        assert_eq!(of_all::<4, 3>(&SVector::from([2.0, 3.0, 4.0])), [0.0, 2.0, 3.0, 4.0]);
        assert_eq!(number_of_active::<4, 3>(0), 2);
    }

    #[test]
    fn without_a_sensor_on_the_base_all_joints_are_active() {
        check::<3, 3>();
        assert_eq!(base::<_, 3, 3>(&[7, 8, 9]), 0);
        assert_eq!(active::<3, 3>(&[1.0, 2.0, 3.0]), SVector::from([1.0, 2.0, 3.0]));
        assert_eq!(of_all::<3, 3>(&SVector::from([2.0, 3.0, 4.0])), [2.0, 3.0, 4.0]);
        assert_eq!(number_of_active::<3, 3>(0), 1);
    }
}
