//! What the tests of this crate share.

pub mod hyper_dual;
pub mod random;

use nalgebra::SMatrix;
use serde_json::Value;

/// The JSON file `name` of the repository's vectors.
pub fn vectors(name: &str) -> Value {
    let path = format!("{}/tests/vectors/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The numbers of an array, or of an array of rows, in reading order.
pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap_or_else(|| panic!("{other} is no number"))],
    }
}

/// Refuses a matrix that is further from the expected one than `tolerance`, relative to the greatest entry.
pub fn assert_close<const ROWS: usize, const COLUMNS: usize>(
    what: &str,
    found: &SMatrix<f64, ROWS, COLUMNS>,
    expected: &SMatrix<f64, ROWS, COLUMNS>,
    tolerance: f64,
) {
    let distance = (found - expected).amax();
    let scale = expected.amax();
    assert!(
        distance <= tolerance * scale,
        "{what}: off by {:e} of {scale}:\n{found}instead of{expected}",
        distance / scale
    );
}
