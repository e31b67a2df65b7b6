//! Lists in messages, and the arrays that they are read into.

/// Why a message does not fit: a list in it has another number of values than the robot has joints.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} has {found} values, expected {expected}")]
pub struct ShapeError {
    /// The field, with its message.
    pub field: &'static str,
    /// Values found in it.
    pub found: usize,
    /// Values expected, or the most that fit.
    pub expected: usize,
}

/// The values of a list as an array.
///
/// # Errors
/// [`ShapeError`] if there are more or fewer than `S`.
pub fn array<V: Copy, const S: usize>(field: &'static str, values: &[V]) -> Result<[V; S], ShapeError> {
    values.try_into().map_err(|_| ShapeError { field, found: values.len(), expected: S })
}

/// The values of a list as an array, without copying them.
///
/// # Errors
/// [`ShapeError`] if there are more or fewer than `S`.
pub fn array_ref<'a, V, const S: usize>(field: &'static str, values: &'a [V]) -> Result<&'a [V; S], ShapeError> {
    values.try_into().map_err(|_| ShapeError { field, found: values.len(), expected: S })
}
