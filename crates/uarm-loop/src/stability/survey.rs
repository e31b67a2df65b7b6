//! Where in its workspace a loop is how stable.

use hinf_control::Controller;
use nalgebra::SVector;

use super::sampled_loop::SampledLoop;
use crate::reference::TaskReference;

/// The grid of the workspace: multiples of this angle that lie within the joints' limits, and the limits themselves.
pub const GRID_DEGREES: f64 = 10.0;
/// Configurations of a task that are looked at: this many steps of equal time from start to end of a quintic, and in each of as many
/// parts as the shortest part of another motion goes into it.
const TASK_STEPS: u32 = 20;
/// The most parts that are looked at in so many steps.
const MOST_PARTS: f64 = 20.0;

/// A configuration and the spectral radius there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst<const N: usize = 2> {
    /// The spectral radius of the frozen loop.
    pub radius: f64,
    /// The angles of the active joints, rad.
    pub configuration: SVector<f64, N>,
}

impl<const N: usize> Worst<N> {
    /// Whether the loop is unstable, or no number.
    pub fn is_unstable(&self) -> bool {
        self.radius >= 1.0 || self.radius.is_nan()
    }
}

/// The worst of `configurations`; `None` if there are none.
pub fn worst<const J: usize, const N: usize>(
    sampled: &SampledLoop<J, N>,
    law: &mut dyn Controller<f64, N>,
    configurations: impl IntoIterator<Item = SVector<f64, N>>,
) -> Option<Worst<N>> {
    let at = |configuration| Worst { radius: sampled.spectral_radius(law, &configuration), configuration };
    // NaN is the largest in the total order.
    configurations.into_iter().map(at).max_by(|one, other| one.radius.total_cmp(&other.radius))
}

/// The configurations that a task visits from wherever within `tolerance`, rad, of its reference: the reference in steps of
/// equal time, and the corners of the square, cube, … around each; for more than [`MOST_CORNERED`] joints, of which there are too
/// many, the middles of its faces.
pub fn task<const N: usize>(reference: TaskReference<N>, tolerance: f64) -> impl Iterator<Item = SVector<f64, N>> {
    let around = around::<N>();
    let mut parts = 1_u32;
    while f64::from(parts) < (reference.duration() / reference.finest()).min(MOST_PARTS) {
        parts += 1;
    }
    let steps = parts * TASK_STEPS;
    (0..=steps).flat_map(move |step| {
        let position = reference.at(reference.duration() * f64::from(step) / f64::from(steps)).position;
        around.clone().into_iter().map(move |direction| position + direction * tolerance)
    })
}

/// Up to this many joints the corners around a configuration are looked at.
pub const MOST_CORNERED: usize = 3;

/// Zero, and where else a configuration is looked at within its tolerance, in units of that.
fn around<const N: usize>() -> Vec<SVector<f64, N>> {
    let mut around = vec![SVector::zeros()];
    if N <= MOST_CORNERED {
        let sign = |corner: usize, joint: usize| if corner >> joint & 1 == 0 { 1.0 } else { -1.0 };
        around.extend((0..1 << N).map(|corner| SVector::from_fn(|joint, _| sign(corner, joint))));
    } else {
        let face = |joint: usize, sign: f64| SVector::from_fn(|row, _| if row == joint { sign } else { 0.0 });
        around.extend((0..N).flat_map(|joint| [face(joint, 1.0), face(joint, -1.0)]));
    }
    around
}

/// The grid of the workspace within `limits`, least and most angle of each active joint, rad, in steps of [`GRID_DEGREES`] for two
/// joints; of more joints, so coarse that no more configurations are looked at than [`MOST_CONFIGURATIONS`], the limits among them.
/// A joint that may turn further than once is looked at over one turn.
pub fn workspace<const N: usize>(limits: [[f64; 2]; N]) -> impl Iterator<Item = SVector<f64, N>> {
    let grids = if N <= 2 { limits.map(grid) } else { limits.map(|limits| coarse(limits, points_of_each::<N>())) };
    let count = grids.iter().map(Vec::len).product();
    (0..count).map(move |index: usize| {
        let mut rest = index;
        // The last joint runs fastest.
        let mut configuration = SVector::<f64, N>::zeros();
        for (angle, grid) in configuration.iter_mut().zip(&grids).rev() {
            *angle = grid.get(rest % grid.len()).copied().unwrap_or_default();
            rest /= grid.len();
        }
        configuration
    })
}

/// The most configurations of the workspace of an arm of more than two joints.
pub const MOST_CONFIGURATIONS: usize = 2_500;

/// How many angles of each of `N` joints make no more configurations than [`MOST_CONFIGURATIONS`]; two at least.
fn points_of_each<const N: usize>() -> u32 {
    let fits = |points: &u32| {
        (0..N)
            .try_fold(1_usize, |product, _| product.checked_mul(usize::try_from(*points).ok()?))
            .is_some_and(|product| product <= MOST_CONFIGURATIONS)
    };
    (2..).take_while(fits).last().unwrap_or(2)
}

/// One turn of a joint that may turn further.
fn one_turn([least, most]: [f64; 2]) -> [f64; 2] {
    let half_turn = core::f64::consts::PI;
    if most - least >= 2.0 * half_turn { [-half_turn, half_turn] } else { [least, most] }
}

/// So many angles at equal distances, both limits among them.
fn coarse(limits: [f64; 2], points: u32) -> Vec<f64> {
    let [least, most] = one_turn(limits);
    (0..points).map(|point| least + (most - least) * f64::from(point) / f64::from(points - 1)).collect()
}

fn grid(limits: [f64; 2]) -> Vec<f64> {
    let [least, most] = one_turn(limits);
    let step = GRID_DEGREES.to_radians();
    let mut angles = vec![least];
    let mut multiple = (least / step).floor() + 1.0;
    while multiple * step < most {
        angles.push(multiple * step);
        multiple += 1.0;
    }
    angles.push(most);
    angles
}

#[cfg(test)]
mod tests {
    use hinf_control::QuinticReference;

    use super::*;

    #[test]
    fn the_grid_has_the_multiples_and_both_ends() {
        let degrees = |least: f64, most: f64| {
            grid([least.to_radians(), most.to_radians()])
                .iter()
                .map(|angle| (angle.to_degrees() * 1e6).round() / 1e6)
                .collect::<Vec<_>>()
        };
        assert_eq!(degrees(-14.0, 25.0), [-14.0, -10.0, 0.0, 10.0, 20.0, 25.0]);
        assert_eq!(degrees(-10.0, 10.0), [-10.0, 0.0, 10.0]);
        let turns = degrees(-3600.0, 3600.0);
        assert_eq!((turns.first(), turns.last(), turns.len()), (Some(&-180.0), Some(&180.0), 37));
        assert_eq!(workspace([[-0.1, 0.1], [-0.1, 0.1]]).count(), 9);
    }

    #[test]
    fn the_grid_of_many_joints_is_coarse_and_has_the_corners() {
        let limits = [[-1.0, 1.0], [0.0, 2.0], [-9.0, 9.0]];
        let configurations: Vec<_> = workspace(limits).collect();
        assert_eq!(configurations.len(), 13 * 13 * 13, "14 cubed are more than 2500");
        let half_turn = core::f64::consts::PI;
        assert_eq!(configurations.first(), Some(&SVector::from([-1.0, 0.0, -half_turn])));
        assert_eq!(configurations.last(), Some(&SVector::from([1.0, 2.0, half_turn])));
        assert_eq!(workspace([[-1.0, 1.0]; 7]).count(), 3_usize.pow(7));
    }

    #[test]
    fn a_configuration_is_looked_at_in_its_corners_or_in_the_middles_of_its_faces() {
        assert_eq!(around::<3>().len(), 1 + 8);
        assert_eq!(around::<7>().len(), 1 + 14);
        assert!(around::<7>().iter().skip(1).all(|direction| direction.norm() == 1.0));
    }

    #[test]
    fn a_task_is_looked_at_from_start_to_end_with_its_tolerance() {
        let reference = QuinticReference::paper();
        let configurations: Vec<_> = task(reference.into(), 0.1).collect();
        assert_eq!(configurations.len(), 5 * 21);
        assert_eq!(configurations.first(), Some(reference.start()));
        let corner = reference.end() - SVector::<f64, 2>::repeat(0.1);
        assert!((configurations.last().unwrap() - corner).norm() < 1e-12);
    }
}
