//! Whether a joint that was turning can have stopped as its counter did.
//!
//! A joint braked by at most A that goes less than a count in the time s had a velocity of at most v = r/s + A s/2 at its beginning, r
//! being a count; from s = √(2r/A) on, at which the joint may have come to rest, that is √(2 r A). In the time t before, it went at
//! most v t + A t²/2, and rounding may add a count. A counter that went further, and then stands, does not follow its joint.
//!
//! A is what the model leaves: M q̈ = τ + f − C q̇. For a joint of which the counter stops, f may be whatever its allowance says; for the
//! others, as long as they turn, it is what the observer has found, since friction changes only where a joint stops.

use nalgebra::SMatrix;

use super::model::MomentumModel;

/// How many changes of a counter are looked back at: fewer are lost in rounding, more in what may have braked the joint meanwhile.
pub const CHANGES: usize = 3;
/// For how many periods a counter that stopped is looked at: then a joint that can stop at all has.
const PERIODS: f64 = 10.0;
/// How far the instants of sampling may be off, as a share of the period: drives that sample in a cycle of their own.
const SAMPLING_SHARE: f64 = 0.25;

/// A change of a counter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// By how many counts.
    pub counts: f64,
    /// In which time since the change before, s.
    pub time: f64,
}

/// How a counter went lately.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Course {
    /// Its last changes, the newest first.
    pub changes: [Change; CHANGES],
    /// For how long it has not changed, s.
    pub stood: f64,
}

/// A counter that stopped more suddenly than its joint can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the counter stopped after {went:.0} counts in {:.1} ms, expected at most {possible:.1} with a braking of at most {braking:.1} rad/s^2",
    .time * 1e3
)]
pub struct SuddenStop {
    /// How far it went before, counts.
    pub went: f64,
    /// In which time, s.
    pub time: f64,
    /// How far a joint can have gone that stops then, counts.
    pub possible: f64,
    /// What brakes it at most, rad/s².
    pub braking: f64,
}

impl Course {
    /// Takes in by how many counts a counter changed in `elapsed` seconds.
    pub(super) fn take(&mut self, counts: i64, elapsed: f64) {
        self.stood += elapsed;
        if counts != 0 {
            let [first, second, _] = self.changes;
            self.changes = [Change { counts: nalgebra::convert(counts), time: self.stood }, first, second];
            self.stood = 0.0;
        }
    }

    /// Can a joint of which one count is `resolution` rad have stopped like that, in a loop of `period` seconds?
    pub(super) fn judge(
        &self,
        period: f64,
        resolution: f64,
        braking: impl FnOnce(f64) -> f64,
    ) -> Result<(), SuddenStop> {
        let counts: f64 = self.changes.iter().map(|change| change.counts).sum();
        let is_known = self.changes.iter().all(|change| change.counts * counts > 0.0);
        if !is_known || self.stood <= 0.0 || self.stood > PERIODS * period {
            return Ok(());
        }
        let braking = braking(counts.signum()).max(0.0);
        let time: f64 = self.changes.iter().map(|change| change.time).sum();
        let possible = 1.0 + most_before_a_stop(braking / resolution, time + SAMPLING_SHARE * period, self.stood);
        let went = counts.abs();
        if went > possible { Err(SuddenStop { went, time, possible, braking }) } else { Ok(()) }
    }
}

/// How many counts a joint goes at most in `time` seconds before it goes less than one in the `stood` seconds after them, if it is braked
/// by at most `braking`, counts/s².
fn most_before_a_stop(braking: f64, time: f64, stood: f64) -> f64 {
    let until_rest = (2.0 / braking).sqrt().min(stood);
    let velocity = 1.0 / until_rest + braking * until_rest / 2.0;
    velocity * time + braking * time * time / 2.0
}

/// Torques that may act on a joint, N·m: from the least to the most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Torques {
    least: f64,
    most: f64,
}

impl Torques {
    /// From one to the other.
    pub(super) const fn between(one: f64, other: f64) -> Self {
        Self { least: one.min(other), most: one.max(other) }
    }

    /// And this one.
    pub(super) const fn with(self, torque: f64) -> Self {
        Self { least: self.least.min(torque), most: self.most.max(torque) }
    }

    /// Beside another torque around `middle`.
    pub(super) const fn plus(self, middle: f64, either_way: f64) -> Self {
        Self { least: self.least + middle - either_way, most: self.most + middle + either_way }
    }
}

/// −C q̇, N·m: Cᵀ q̇ − Ṁ q̇, Ṁ as a difference over [`DIFFERENCE`].
pub(super) fn centrifugal<const J: usize>(
    model: &dyn MomentumModel<J>,
    inertia: &[[f64; J]; J],
    angles: &[f64; J],
    velocity: &[f64; J],
) -> [f64; J] {
    let mut before = *angles;
    for (angle, velocity) in before.iter_mut().zip(velocity) {
        *angle -= velocity * DIFFERENCE;
    }
    let mut torques = model.velocity_torque(angles, velocity);
    for ((torque, row), earlier) in torques.iter_mut().zip(inertia).zip(&model.inertia(&before)) {
        let entries = row.iter().zip(earlier).zip(velocity);
        *torque -= entries.map(|((now, before), velocity)| (now - before) / DIFFERENCE * velocity).sum::<f64>();
    }
    torques
}

/// Over which time M(q) is differentiated, s: short beside any motion.
const DIFFERENCE: f64 = 1e-5;

/// The most that M(q) q̈ = `torques` + `known` brakes joint `index` by while it turns in `direction`, rad/s²; infinite if M(q) has no inverse.
pub(super) fn strongest_braking<const J: usize>(
    inertia: &[[f64; J]; J],
    torques: &[Torques; J],
    known: &[f64; J],
    index: usize,
    direction: f64,
) -> f64 {
    let matrix = SMatrix::<f64, J, J>::from(*inertia);
    let unit = SMatrix::<f64, J, 1>::from_fn(|row, _| if row == index { -direction } else { 0.0 });
    let Some(factors) = matrix.cholesky() else { return f64::INFINITY };
    // The row of the inverse, which is symmetric, that gives the deceleration.
    let shares = factors.solve(&unit);
    let terms = shares.iter().zip(torques).zip(known);
    terms.map(|((share, range), known)| (share * range.least).max(share * range.most) + share * known).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 1e-3;
    /// One count, rad.
    const RESOLUTION: f64 = 1e-3;

    /// After how many cycles of standing a counter is disbelieved that went by `changes`, of a joint that 1000 rad/s² brake: a count in the
    /// square of a period.
    fn disbelieved(changes: [i64; 4]) -> Option<usize> {
        let mut course = Course::default();
        for change in changes {
            course.take(change, PERIOD);
            course.judge(PERIOD, RESOLUTION, |_| 1_000.0).unwrap();
        }
        (1..20).find(|_| {
            course.take(0, PERIOD);
            course.judge(PERIOD, RESOLUTION, |_| 1_000.0).is_err()
        })
    }

    /// At 1/1 + 1/2 counts a period at most as it stops, √2 if it stands for longer: 1.5 · 3.25 + 3.25²/2 + 1 = 11.2 and 10.9 in three periods.
    #[test]
    fn a_counter_that_stops_more_suddenly_than_its_joint_can_is_disbelieved() {
        assert_eq!(disbelieved([4, 4, 4, 4]), Some(1));
        assert_eq!(disbelieved([4, 4, 4, 3]), Some(2));
        assert_eq!(disbelieved([5, 4, 3, 3]), None);
        assert_eq!(disbelieved([-5, -4, -4, -4]), Some(1));
        assert_eq!(disbelieved([4, 0, 4, 4]), None, "it took longer");
        assert_eq!(disbelieved([9, 9, -1, 1]), None, "it turned back");
    }

    /// Whatever joint brakes by at most that, from any velocity and place between two counts, is believed.
    #[test]
    fn a_joint_that_brakes_as_hard_as_it_can_is_believed() {
        for velocity in (1..40).map(|step| f64::from(step) * 0.25) {
            for place in (0..20).map(|step| f64::from(step) * 0.05) {
                let at = |cycle: i32| {
                    let time = f64::from(cycle).min(velocity + 5.0);
                    let braked = (time - 5.0).max(0.0);
                    (place + velocity * time - braked * braked / 2.0).floor()
                };
                let mut course = Course::default();
                for cycle in 1..60 {
                    course
                        .take(nalgebra::try_convert::<f64, i64>(at(cycle) - at(cycle - 1)).unwrap_or_default(), PERIOD);
                    course.judge(PERIOD, RESOLUTION, |_| 1_000.0).unwrap();
                }
            }
        }
    }

    /// Two wheels on one axle of 0.3 and 0.1 kg·m², the second relative to the first: a torque t between them accelerates it by t/0.3 + t/0.1.
    #[test]
    fn braking_is_what_the_worst_torques_do() {
        let inertia = [[0.4, 0.1], [0.1, 0.1]];
        let torques = [Torques::default(), Torques::between(0.01, -0.02).with(0.0).plus(0.0, 0.01)];
        let braking = |direction| strongest_braking(&inertia, &torques, &[0.0, 0.0], 1, direction);
        approx::assert_relative_eq!(braking(1.0), 0.03 / 0.3 + 0.03 / 0.1, max_relative = 1e-12);
        approx::assert_relative_eq!(braking(-1.0), 0.02 / 0.3 + 0.02 / 0.1, max_relative = 1e-12);
        let known = strongest_braking(&inertia, &torques, &[0.0, -0.01], 1, 1.0);
        approx::assert_relative_eq!(known, 0.04 / 0.3 + 0.04 / 0.1, max_relative = 1e-12);
        assert_eq!(strongest_braking(&[[0.0; 2]; 2], &torques, &[0.0; 2], 1, 1.0), f64::INFINITY);
    }
}
