//! The desired motion of a run: the task, and before it, if asked for, the way to its start.

use hinf_control::{QuinticReference, Reference};

use crate::reference::TaskReference;

/// The desired motion of `N` active joints. Task time is zero where the task begins, and negative on the way there.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion<const N: usize> {
    approach: Option<QuinticReference<f64, N>>,
    task: TaskReference<N>,
    hold: f64,
}

impl<const N: usize> Motion<N> {
    /// The task alone, whose end is held for `hold` seconds.
    pub fn task(task: impl Into<TaskReference<N>>, hold: f64) -> Self {
        Self { approach: None, task: task.into(), hold }
    }

    /// The same motion after an approach, which should end where the task begins.
    #[must_use]
    pub fn after(self, approach: QuinticReference<f64, N>) -> Self {
        Self { approach: Some(approach), ..self }
    }

    /// The way to the start of the task, if there is one.
    pub const fn approach(&self) -> Option<&QuinticReference<f64, N>> {
        self.approach.as_ref()
    }

    /// The motion of the task, without approach and hold.
    pub const fn task_reference(&self) -> &TaskReference<N> {
        &self.task
    }

    /// The task time at which the motion begins, s: zero, or minus the duration of the approach.
    pub fn start(&self) -> f64 {
        self.approach.map_or(0.0, |approach| -approach.duration())
    }

    /// The task time at which the motion is over, s.
    pub fn end(&self) -> f64 {
        self.task.duration() + self.hold
    }

    /// Is `time` within the task, over which the indices are taken?
    pub fn is_task(&self, time: f64) -> bool {
        (0.0..self.task.duration()).contains(&time)
    }

    /// The desired motion at task time `time`, s.
    pub fn at(&self, time: f64) -> Reference<f64, N> {
        match self.approach {
            Some(approach) if time < 0.0 => approach.at(time + approach.duration()),
            _ => self.task.at(time),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn the_approach_ends_where_the_task_begins_and_joins_it_smoothly() {
        let task = QuinticReference::paper();
        let from = Vector2::new(-0.3, 0.8);
        let motion = Motion::task(task, 0.5).after(QuinticReference::new(from, *task.start(), 5.0).unwrap());
        assert_eq!(motion.start(), -5.0);
        assert_eq!(motion.end(), 3.5);
        assert_eq!(motion.at(-5.0).position, from);
        let (before, after) = (motion.at(-1e-9), motion.at(0.0));
        assert!((before.position - after.position).norm() < 1e-12);
        assert!((before.velocity - after.velocity).norm() < 1e-9);
        assert!(!motion.is_task(-0.1) && motion.is_task(0.0) && motion.is_task(2.999) && !motion.is_task(3.0));
    }

    #[test]
    fn without_an_approach_it_is_the_task() {
        let motion = Motion::task(QuinticReference::paper(), 0.5);
        assert_eq!(motion.start(), 0.0);
        assert_eq!(motion.at(1.5), QuinticReference::paper().at(1.5));
    }
}
