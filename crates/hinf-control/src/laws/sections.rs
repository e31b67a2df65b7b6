//! Sections of a file that a file may lack.

use core::any::Any;

/// A law without settings, for an arm that the paper has none for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no section `{law}`, expected one for an arm of {joints} joints: the paper has settings for two")]
pub(super) struct MissingSection {
    pub(super) law: &'static str,
    pub(super) joints: usize,
}

/// The paper's settings, if `S` is their type: if the arm has two joints.
pub(super) fn of_the_paper<P: Any + Default, S: Any + Copy>() -> Option<S> {
    let paper: &dyn Any = &P::default();
    paper.downcast_ref::<S>().copied()
}
