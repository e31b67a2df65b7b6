//! Where in its workspace a loop is how stable.

use hinf_control::{Controller, QuinticReference};
use nalgebra::Vector2;

use super::sampled_loop::SampledLoop;

/// The grid of the workspace: multiples of this angle that lie within the joints' limits, and the limits themselves.
pub const GRID_DEGREES: f64 = 10.0;
/// Configurations of a task that are looked at: this many steps of equal time from start to end.
const TASK_STEPS: u32 = 20;

/// A configuration and the spectral radius there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// The spectral radius of the frozen loop.
    pub radius: f64,
    /// [q2, q3], rad.
    pub configuration: Vector2<f64>,
}

impl Worst {
    /// Whether the loop is unstable, or no number.
    pub fn is_unstable(&self) -> bool {
        self.radius >= 1.0 || self.radius.is_nan()
    }
}

/// The worst of `configurations`; `None` if there are none.
pub fn worst(
    sampled: &SampledLoop,
    law: &mut dyn Controller<f64>,
    configurations: impl IntoIterator<Item = Vector2<f64>>,
) -> Option<Worst> {
    let at = |configuration| Worst { radius: sampled.spectral_radius(law, &configuration), configuration };
    // NaN is the largest in the total order.
    configurations.into_iter().map(at).max_by(|one, other| one.radius.total_cmp(&other.radius))
}

/// The configurations that a task visits from wherever within `tolerance`, rad, of its reference: the reference in steps of
/// equal time, and the corners of the square around each.
pub fn task(reference: QuinticReference<f64, 2>, tolerance: f64) -> impl Iterator<Item = Vector2<f64>> {
    (0..=TASK_STEPS).flat_map(move |step| {
        let position = reference.at(reference.duration() * f64::from(step) / f64::from(TASK_STEPS)).position;
        [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(second, third)| position + Vector2::new(second, third) * tolerance)
    })
}

/// The grid of the workspace within `limits`, least and most angle of each driven joint, rad. A joint that may turn further
/// than once is looked at over one turn.
pub fn workspace(limits: [[f64; 2]; 2]) -> impl Iterator<Item = Vector2<f64>> {
    let [second, third] = limits.map(grid);
    second.into_iter().flat_map(move |second| third.clone().into_iter().map(move |third| Vector2::new(second, third)))
}

fn grid([least, most]: [f64; 2]) -> Vec<f64> {
    let half_turn = core::f64::consts::PI;
    let (least, most) = if most - least >= 2.0 * half_turn { (-half_turn, half_turn) } else { (least, most) };
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
    fn a_task_is_looked_at_from_start_to_end_with_its_tolerance() {
        let reference = QuinticReference::paper();
        let configurations: Vec<_> = task(reference, 0.1).collect();
        assert_eq!(configurations.len(), 5 * 21);
        assert_eq!(configurations.first(), Some(reference.start()));
        let corner = reference.end() - Vector2::repeat(0.1);
        assert!((configurations.last().unwrap() - corner).norm() < 1e-12);
    }
}
