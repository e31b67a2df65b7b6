//! What the residual of a joint says: does the encoder stand still, does the torque push the wrong way, do counts contradict the model?

use super::settings::{ModelError, ResidualTime, TorqueAllowance};
use super::stop::{Course, SuddenStop};

/// How much heavier than its model a joint may be.
const INERTIA_MARGIN: f64 = 2.0;
/// By how many counts a joint must have moved whose counter did not: rounding takes one, and one more is for edges that are not exact.
const STANDING_COUNTS: f64 = 3.0;
/// For how long a joint must accelerate against its torque, s: longer than the observer, of any bandwidth that finds it in time, takes for one angle
/// that was sampled at another instant.
const REVERSED_TIME: f64 = 20e-3;

/// What of one joint is judged in one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// Since the cycle before, s.
    pub elapsed: f64,
    /// The loop's period, s.
    pub period: f64,
    /// What the encoder counted.
    pub count: i32,
    /// One count, rad.
    pub resolution: f64,
    /// Filtered velocity, rad/s.
    pub velocity: f64,
    /// Filtered torque of the motor, N·m.
    pub torque: f64,
    /// The residual, N·m.
    pub residual: f64,
    /// How far rounding of the angles may put it off, N·m.
    pub rounding: f64,
    /// How far rounding and the instants of sampling may put it off, N·m.
    pub noise: f64,
    /// The joint's own entry of M, kg·m².
    pub inertia: f64,
}

/// How one joint is judged.
#[derive(Clone, Copy, Debug)]
pub struct Criterion {
    /// What else may act on the joint.
    pub allowance: TorqueAllowance,
    /// How far the model may be off.
    pub model_error: ModelError,
    /// For how long a residual may be beyond its limit.
    pub residual_time: ResidualTime,
}

/// What speaks against a joint so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Suspicion {
    /// The last count.
    pub count: i32,
    /// How fast the joint must be whose counter stands still, rad/s.
    pub standing_velocity: f64,
    /// How far it must have moved, rad.
    pub standing_distance: f64,
    /// For how long it has accelerated against its torque, s.
    pub reversed: f64,
    /// For how long its residual has been beyond its limit, s.
    pub beyond: f64,
    /// How its counts went lately.
    pub course: Course,
}

/// What contradicts the model. Torques in N·m.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Contradiction {
    /// The counter stands still, and the joint cannot.
    #[error(
        "the counter stands still against {held:.3} N m, expected friction and other torques of at most {allowed:.3} N m: the joint would have gone {:.3} deg",
        .distance.to_degrees()
    )]
    Stuck {
        /// What would have to hold the joint.
        held: f64,
        /// What may.
        allowed: f64,
        /// How far it must have gone, rad.
        distance: f64,
    },
    /// The counter stopped, and the joint cannot have.
    #[error(transparent)]
    Stopped(#[from] SuddenStop),
    /// The joint accelerates against its torque.
    #[error(
        "it accelerates against a torque of {torque:.3} N m as if another of {residual:.3} N m acted, expected at most {allowed:.3} N m"
    )]
    Reversed {
        /// Of the motor.
        torque: f64,
        /// The residual.
        residual: f64,
        /// What may act.
        allowed: f64,
    },
    /// Counts and torque do not go together.
    #[error(
        "counts and torque contradict the model by {residual:.3} N m for {:.0} ms, expected at most {allowed:.3} N m",
        .lasted * 1e3
    )]
    Residual {
        /// The residual.
        residual: f64,
        /// Its limit.
        allowed: f64,
        /// For how long, s.
        lasted: f64,
    },
}

impl Criterion {
    /// How large the residual may be, N·m.
    pub fn limit(&self, evidence: &Evidence) -> f64 {
        self.allowance.get() + self.model_error.get() * evidence.torque.abs() + evidence.noise
    }
}

impl Suspicion {
    /// Nothing against a joint with this count.
    pub fn of(count: i32) -> Self {
        Self { count, ..Self::default() }
    }

    /// Does its counter stand still?
    pub fn stands(&self) -> bool {
        self.course.stood > 0.0
    }

    /// Bears a cycle of `elapsed` seconds with an angle that was not measured: how the joint went is not known any more.
    pub fn forget_motion(&mut self, elapsed: f64) {
        self.course = Course { stood: self.course.stood + elapsed, ..Course::default() };
    }

    /// Takes in the evidence of one cycle. `braking` tells what can brake the joint at most while it turns in a direction, rad/s².
    ///
    /// # Errors
    /// [`Contradiction`].
    pub fn judge(
        &mut self,
        criterion: &Criterion,
        evidence: &Evidence,
        braking: impl FnOnce(f64) -> f64,
    ) -> Result<(), Contradiction> {
        let change = i64::from(evidence.count) - i64::from(self.count);
        self.count = evidence.count;
        self.course.take(change, evidence.elapsed);
        self.standing(criterion, evidence)?;
        self.against_its_torque(criterion, evidence)?;
        self.beyond_its_limit(criterion, evidence)?;
        Ok(self.course.judge(evidence.period, evidence.resolution, braking)?)
    }

    /// While the counter stands still, the residual is what holds the joint. What is beyond the allowance moves even a heavy joint.
    fn standing(&mut self, criterion: &Criterion, evidence: &Evidence) -> Result<(), Contradiction> {
        let held = evidence.residual;
        let allowed = criterion.allowance.get();
        let surplus = held.abs() - allowed;
        if !(self.stands() && surplus > 0.0 && held * self.standing_velocity <= 0.0) {
            (self.standing_velocity, self.standing_distance) = (0.0, 0.0);
            return Ok(());
        }
        let acceleration = surplus / (INERTIA_MARGIN * evidence.inertia);
        self.standing_velocity -= acceleration.copysign(held) * evidence.elapsed;
        self.standing_distance += self.standing_velocity.abs() * evidence.elapsed;
        let distance = self.standing_distance;
        if distance > STANDING_COUNTS * evidence.resolution {
            return Err(Contradiction::Stuck { held: held.abs(), allowed, distance });
        }
        Ok(())
    }

    /// Friction brakes a joint, but does not accelerate it: only a stronger torque of something else does, or the motor the wrong way.
    fn against_its_torque(&mut self, criterion: &Criterion, evidence: &Evidence) -> Result<(), Contradiction> {
        let Evidence { torque, residual, velocity, elapsed, rounding, .. } = *evidence;
        let moving = torque + residual;
        let allowed = criterion.allowance.get() + rounding;
        let speeds_up = moving * velocity > 0.0;
        if moving * torque < 0.0 && speeds_up && residual.abs() > allowed {
            self.reversed += elapsed;
        } else {
            self.reversed = 0.0;
        }
        if self.reversed > REVERSED_TIME { Err(Contradiction::Reversed { torque, residual, allowed }) } else { Ok(()) }
    }

    fn beyond_its_limit(&mut self, criterion: &Criterion, evidence: &Evidence) -> Result<(), Contradiction> {
        let (residual, allowed) = (evidence.residual, criterion.limit(evidence));
        self.beyond = if residual.abs() > allowed { self.beyond + evidence.elapsed } else { 0.0 };
        let lasted = self.beyond;
        if lasted > criterion.residual_time.duration().as_secs_f64() {
            return Err(Contradiction::Residual { residual, allowed, lasted });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn criterion() -> Criterion {
        Criterion {
            allowance: TorqueAllowance::new(0.1).unwrap(),
            model_error: ModelError::new(0.5).unwrap(),
            residual_time: ResidualTime::default(),
        }
    }

    /// A joint of 0.05 kg·m² with counts of 1 mrad, looked at each millisecond.
    const AT_REST: Evidence = Evidence {
        elapsed: 1e-3,
        period: 1e-3,
        count: 7,
        resolution: 1e-3,
        velocity: 0.0,
        torque: 0.0,
        residual: 0.0,
        rounding: 0.02,
        noise: 0.02,
        inertia: 0.05,
    };

    /// After how many cycles what is contradicted, within 1000.
    fn judged(evidence: impl Fn(i32) -> Evidence) -> Option<(i32, Contradiction)> {
        let mut suspicion = Suspicion { count: 7, ..Suspicion::default() };
        (1..=1_000)
            .find_map(|cycle| Some((cycle, suspicion.judge(&criterion(), &evidence(cycle), |_| f64::INFINITY).err()?)))
    }

    /// 0.15 N·m beyond 0.1 accelerate twice 0.05 kg·m² by 0.5 rad/s²: 3 mrad after √(2 · 0.003 / 0.5) s = 110 ms.
    #[test]
    fn a_counter_that_stands_still_is_believed_until_the_joint_must_have_moved() {
        let torque = 0.15;
        let held = Evidence { torque, residual: -torque, ..AT_REST };
        let (cycles, found) = judged(|_| held).unwrap();
        assert!((108..=112).contains(&cycles), "{cycles}");
        assert!(matches!(found, Contradiction::Stuck { .. }), "{found}");
        let friction = Evidence { torque: 0.099, residual: -0.099, ..AT_REST };
        assert_eq!(judged(|_| friction), None, "friction may hold that");
        assert_eq!(judged(|cycle| Evidence { count: 7 + cycle / 50, ..held }), None, "it moves");
    }

    #[test]
    fn a_joint_that_speeds_up_against_its_torque_goes_the_wrong_way() {
        let away = Evidence { count: 0, torque: 0.06, residual: -0.14, velocity: -0.1, ..AT_REST };
        let counting = |evidence: Evidence| judged(|cycle| Evidence { count: cycle, ..evidence });
        let (cycles, found) = counting(away).unwrap();
        assert!((20..=21).contains(&cycles), "{cycles}");
        assert!(found.to_string().contains("against a torque of 0.060 N m as if another of -0.140 N m"), "{found}");
        assert_eq!(counting(Evidence { velocity: 0.1, ..away }), None, "friction brakes it");
        assert_eq!(counting(Evidence { residual: -0.11, ..away }), None, "something pushes it");
        assert_eq!(counting(Evidence { torque: 0.16, ..away }), None, "the torque is the stronger");
    }

    #[test]
    fn a_residual_may_be_beyond_its_limit_for_a_while() {
        let beyond = |cycle: i32, residual: f64| Evidence { count: cycle, torque: 0.2, residual, ..AT_REST };
        // 0.1 + 0.5 · 0.2 + 0.02.
        assert_eq!(judged(|cycle| beyond(cycle, 0.219)), None);
        let (cycles, found) = judged(|cycle| beyond(cycle, 0.221)).unwrap();
        assert!((10..=11).contains(&cycles), "{cycles}");
        assert!(found.to_string().starts_with("counts and torque contradict the model by 0.221 N m for 1"), "{found}");
        assert_eq!(judged(|cycle| beyond(cycle, if cycle % 9 == 0 { 0.0 } else { 1.0 })), None);
    }
}
