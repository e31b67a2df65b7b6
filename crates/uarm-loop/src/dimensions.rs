//! How the joints of a robot are counted: `J` joints with a drive each, of which joint 1 is the passive base and the other
//! `N` have motors.
//!
//! Both numbers are const parameters of nearly every type in this crate. Stable Rust cannot say `J = N + 1` in a type, so
//! [`check`] says it where a loop is built: another pair does not compile.

use nalgebra::SVector;

/// Refuses, at compile time, a number of joints that is not one more than that of the active joints.
pub const fn check<const J: usize, const N: usize>() {
    const { assert!(J == N + 1, "J joints are one passive base and N active joints") }
}

/// The value of the passive base, joint 1, among the values of all joints.
pub fn base<V: Copy + Default, const J: usize>(values: &[V; J]) -> V {
    values.first().copied().unwrap_or_default()
}

/// The values of the active joints, joints 2 to J, among those of all joints.
pub fn active<const J: usize, const N: usize>(values: &[f64; J]) -> SVector<f64, N> {
    SVector::from_fn(|row, _| values.get(row + 1).copied().unwrap_or_default())
}

/// The values of all joints, of which the passive base's is zero.
pub fn of_all<const J: usize, const N: usize>(active: &SVector<f64, N>) -> [f64; J] {
    let mut all = [0.0; J];
    for (to, from) in all.iter_mut().skip(1).zip(active) {
        *to = *from;
    }
    all
}

/// The number by which people count the active joint at `index`: 2 for the first.
pub const fn number_of_active(index: usize) -> usize {
    index + 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_base_comes_first() {
        check::<3, 2>();
        assert_eq!(base(&[7, 8, 9]), 7);
        assert_eq!(active::<4, 3>(&[1.0, 2.0, 3.0, 4.0]), SVector::from([2.0, 3.0, 4.0]));
        assert_eq!(of_all::<4, 3>(&SVector::from([2.0, 3.0, 4.0])), [0.0, 2.0, 3.0, 4.0]);
        assert_eq!(number_of_active(0), 2);
    }
}
