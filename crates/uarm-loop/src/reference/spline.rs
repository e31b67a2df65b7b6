//! The spline of least jerk through postures.
//!
//! Between two postures each joint follows a polynomial of the fifth degree, given by position, velocity and acceleration at both
//! ends. Where a posture is passed in motion, velocity and acceleration are those for which the third and the fourth derivative,
//! too, are the same before and behind it: the stationary point of ∫ q⃛² dt over all of them, which is the least since the integral
//! is a convex quadratic form.

use super::via::{Passing, ViaPoint};
use hinf_control::Reference;
use nalgebra::{Matrix2, SMatrix, SVector};

/// Position, velocity and acceleration of `N` joints at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot<const N: usize> {
    time: f64,
    position: SVector<f64, N>,
    velocity: SVector<f64, N>,
    acceleration: SVector<f64, N>,
}

/// Quintics from posture to posture.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline<const N: usize> {
    first: Knot<N>,
    /// The others, of which there is one at least.
    behind: Vec<Knot<N>>,
}

impl<const N: usize> Spline<N> {
    /// Through `points`, whose times increase, the first and the last at rest; `None` for less than two, or if a velocity has no
    /// solution in floating point.
    pub(super) fn through(points: &[ViaPoint<N>]) -> Option<Self> {
        let mut knots: Vec<_> = points.iter().map(at_rest).collect();
        // A posture at rest ends one spline and begins the next.
        let mut begin = 0;
        for (end, point) in points.iter().enumerate().skip(1) {
            if point.passing == Passing::Stop || end + 1 == points.len() {
                pass(knots.get_mut(begin..=end)?)?;
                begin = end;
            }
        }
        let behind = knots.split_off(1.min(knots.len()));
        let first = knots.pop().filter(|_| !behind.is_empty())?;
        Some(Self { first, behind })
    }

    pub(super) fn is_finite(&self) -> bool {
        let middles = self.segments().map(|(before, after)| 0.5 * (before.time + after.time));
        middles
            .chain(self.behind.iter().map(|knot| knot.time))
            .map(|time| self.at(time))
            .all(|reference| reference.velocity.iter().chain(&reference.acceleration).all(|value| value.is_finite()))
    }

    fn segments(&self) -> impl Iterator<Item = (&Knot<N>, &Knot<N>)> {
        std::iter::once(&self.first).chain(&self.behind).zip(&self.behind)
    }

    fn last(&self) -> &Knot<N> {
        self.behind.last().unwrap_or(&self.first)
    }

    pub(super) fn start(&self) -> &SVector<f64, N> {
        &self.first.position
    }

    pub(super) fn end(&self) -> &SVector<f64, N> {
        &self.last().position
    }

    pub(super) fn duration(&self) -> f64 {
        self.last().time
    }

    pub(super) fn shortest_segment(&self) -> f64 {
        self.segments().map(|(before, after)| after.time - before.time).fold(self.duration(), f64::min)
    }

    pub(super) fn at(&self, time: f64) -> Reference<f64, N> {
        let next = self.behind.partition_point(|knot| knot.time <= time);
        let before = next.checked_sub(1).and_then(|before| self.behind.get(before)).unwrap_or(&self.first);
        match self.behind.get(next) {
            Some(after) if time >= before.time => between(before, after, time),
            Some(_) => rest(self.first.position),
            None => rest(self.last().position),
        }
    }
}

fn rest<const N: usize>(position: SVector<f64, N>) -> Reference<f64, N> {
    Reference { position, velocity: SVector::zeros(), acceleration: SVector::zeros() }
}

fn at_rest<const N: usize>(point: &ViaPoint<N>) -> Knot<N> {
    let ViaPoint { time, position, .. } = *point;
    Knot { time, position, velocity: SVector::zeros(), acceleration: SVector::zeros() }
}

/// The quintic from `before` to `after`, at a `time` between them. With s = (t − t_0)/T, velocities times T and accelerations times
/// T², and the distance D: q = q_0 + V_0 s + A_0 s²/2 + c_3 s³ + c_4 s⁴ + c_5 s⁵.
fn between<const N: usize>(before: &Knot<N>, after: &Knot<N>, time: f64) -> Reference<f64, N> {
    let duration = after.time - before.time;
    let s = (time - before.time) / duration;
    let distance = after.position - before.position;
    let (v0, v1) = (before.velocity * duration, after.velocity * duration);
    let (a0, a1) = (before.acceleration * (duration * duration), after.acceleration * (duration * duration));
    let c3 = distance * 10.0 - v0 * 6.0 - v1 * 4.0 - a0 * 1.5 + a1 * 0.5;
    let c4 = distance * -15.0 + v0 * 8.0 + v1 * 7.0 + a0 * 1.5 - a1;
    let c5 = distance * 6.0 - (v0 + v1) * 3.0 - (a0 - a1) * 0.5;
    let velocity = v0 + (a0 + (c3 * 3.0 + (c4 * 4.0 + c5 * (5.0 * s)) * s) * s) * s;
    let acceleration = a0 + (c3 * 6.0 + (c4 * 12.0 + c5 * (20.0 * s)) * s) * s;
    Reference {
        position: before.position + (v0 + (a0 * 0.5 + (c3 + (c4 + c5 * s) * s) * s) * s) * s,
        velocity: velocity / duration,
        acceleration: acceleration / (duration * duration),
    }
}

/// Gives all knots but the first and the last, which stay at rest, their velocity and acceleration. `None` if there is no solution
/// in floating point.
///
/// Continuity of jerk and snap at knot k, with x_k = (v_k, a_k), is A_k x_{k−1} + B_k x_k + C_k x_{k+1} = r_k: block tridiagonal
/// with blocks of 2 × 2, solved by elimination from the front. The rows are the steps of (−snap, jerk), which makes the whole the
/// symmetric positive definite Hessian of the integral: no pivoting is needed.
fn pass<const N: usize>(knots: &mut [Knot<N>]) -> Option<()> {
    let rows: Vec<_> = knots.windows(3).map(Row::of).collect::<Option<_>>()?;
    let mut reduced: Vec<(Matrix2<f64>, SMatrix<f64, 2, N>)> = Vec::with_capacity(rows.len());
    for row in &rows {
        let (pivot, right) = match reduced.last() {
            Some((ahead, right)) => (row.own - row.before * ahead, row.right - row.before * right),
            None => (row.own, row.right),
        };
        let inverse = pivot.try_inverse()?;
        reduced.push((inverse * row.after, inverse * right));
    }
    let mut next = SMatrix::<f64, 2, N>::zeros();
    for (knot, (ahead, right)) in knots.iter_mut().skip(1).zip(&reduced).rev() {
        next = right - ahead * next;
        (knot.velocity, knot.acceleration) = (next.row(0).transpose(), next.row(1).transpose());
    }
    Some(())
}

/// One block row.
struct Row<const N: usize> {
    before: Matrix2<f64>,
    own: Matrix2<f64>,
    after: Matrix2<f64>,
    right: SMatrix<f64, 2, N>,
}

impl<const N: usize> Row<N> {
    /// Of the middle one of three knots.
    fn of(knots: &[Knot<N>]) -> Option<Self> {
        let [left, middle, right] = knots else { return None };
        let (h, g) = (middle.time - left.time, right.time - middle.time);
        let (to, from) = (middle.position - left.position, right.position - middle.position);
        let [h2, g2] = [h * h, g * g];
        let [h3, g3] = [h2 * h, g2 * g];
        let snap = (from / (g3 * g) + to / (h3 * h)) * 360.0;
        let jerk = (from / g3 - to / h3) * 60.0;
        Some(Self {
            before: Matrix2::new(168.0 / h3, 24.0 / h2, -24.0 / h2, -3.0 / h),
            own: Matrix2::new(192.0 / h3 + 192.0 / g3, 36.0 / g2 - 36.0 / h2, 36.0 / g2 - 36.0 / h2, 9.0 / h + 9.0 / g),
            after: Matrix2::new(168.0 / g3, -24.0 / g2, 24.0 / g2, -3.0 / g),
            right: SMatrix::<f64, 2, N>::from_rows(&[snap.transpose(), jerk.transpose()]),
        })
    }
}
