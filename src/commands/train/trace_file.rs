//! Reads the columns of a trace that training needs. Columns are found by their names, so that others may be added.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use hinf_control::TrackingError;
use nalgebra::Vector2;

/// One cycle of joints 2 and 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePoint {
    /// Where it stands, for messages.
    pub line: usize,
    /// Rate and position errors, rad/s and rad.
    pub error: TrackingError<f64>,
    /// The H∞ control input u.
    pub control_input: Vector2<f64>,
    /// The torque after the limiter, N·m.
    pub torque_applied: Vector2<f64>,
    /// Did the limiter cut it?
    pub limited: [bool; 2],
}

/// A trace that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A place in it is not as it should be.
    #[error("{}, line {line}: {found}: expected {expected}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should.
        expected: String,
    },
}

/// The columns in the order in which [`TracePoint`] needs them.
const COLUMNS: [&str; 14] = [
    "rate_2_rad_per_s",
    "rate_3_rad_per_s",
    "position_2_rad",
    "position_3_rad",
    "reference_rate_2_rad_per_s",
    "reference_rate_3_rad_per_s",
    "reference_position_2_rad",
    "reference_position_3_rad",
    "control_input_2",
    "control_input_3",
    "torque_applied_2_nm",
    "torque_applied_3_nm",
    "limited_2",
    "limited_3",
];

/// Reads a trace.
///
/// # Errors
/// [`TraceError`] names file, line, what was found and what was expected.
pub fn read(file: &Path) -> Result<Vec<TracePoint>, TraceError> {
    let bytes = std::fs::read(file).map_err(|source| TraceError::Read { file: file.to_owned(), source })?;
    parse(file, &bytes)
}

/// Reads a trace from its bytes; `file` is what messages call it.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &Path, bytes: &[u8]) -> Result<Vec<TracePoint>, TraceError> {
    let refuse = |line: usize, found: &dyn Display, expected: &str| TraceError::Line {
        file: file.to_owned(),
        line,
        found: shortened(&found.to_string()),
        expected: expected.to_owned(),
    };
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
        refuse(line, &"bytes that are no text", "UTF-8, as uarm run --trace writes")
    })?;
    let mut lines = text.lines().zip(1..);
    let header: Vec<&str> = lines.next().map(|(line, _)| line.split(',').collect()).unwrap_or_default();
    let mut places = [0; COLUMNS.len()];
    for (place, name) in places.iter_mut().zip(COLUMNS) {
        *place = header.iter().position(|column| *column == name).ok_or_else(|| {
            refuse(1, &format!("no column {name}"), "the header of a file that uarm run --trace writes")
        })?;
    }
    let mut points = Vec::new();
    for (text, line) in lines {
        let fields: Vec<&str> = text.split(',').collect();
        if fields.len() != header.len() {
            let expected = format!("{} fields, as in the header", header.len());
            return Err(refuse(line, &format!("{} fields", fields.len()), &expected));
        }
        let mut values = [0.0; COLUMNS.len()];
        for ((value, place), name) in values.iter_mut().zip(places).zip(COLUMNS) {
            *value = fields[place]
                .parse()
                .ok()
                .filter(|value: &f64| value.is_finite())
                .ok_or_else(|| refuse(line, &format!("{name} = {:?}", fields[place]), "a finite number"))?;
        }
        points.push(point(line, values));
    }
    if points.is_empty() { Err(refuse(2, &"nothing", "a row for each cycle of a run")) } else { Ok(points) }
}

fn point(line: usize, values: [f64; COLUMNS.len()]) -> TracePoint {
    let pair = |first: usize| Vector2::new(values[first], values[first + 1]);
    TracePoint {
        line,
        error: TrackingError { velocity: pair(0) - pair(4), position: pair(2) - pair(6) },
        control_input: pair(8),
        torque_applied: pair(10),
        limited: [values[12] != 0.0, values[13] != 0.0],
    }
}

/// Long lines of a file that is no trace would bury the message.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 80;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(text: &str) -> Result<Vec<TracePoint>, String> {
        parse(Path::new("run.csv"), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn errors_are_measured_less_desired() {
        let text = format!("tick,{}\n7,3,4,0.5,0.6,1,1.5,0.1,0.4,8,9,0.01,0.02,0,1\n", COLUMNS.join(","));
        let points = parsed(&text).unwrap();
        assert_eq!(points.len(), 1);
        assert_eq!(points[0].line, 2);
        assert_eq!(points[0].error.velocity, Vector2::new(2.0, 2.5));
        assert_eq!(points[0].error.position, Vector2::new(0.5 - 0.1, 0.6 - 0.4));
        assert_eq!(points[0].torque_applied, Vector2::new(0.01, 0.02));
        assert_eq!(points[0].limited, [false, true]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let header = COLUMNS.join(",");
        let row = ["0"; COLUMNS.len()].join(",");
        for (text, message) in [
            (String::new(), "run.csv, line 1: no column rate_2_rad_per_s: expected the header"),
            ("a,b\n1,2\n".into(), "run.csv, line 1: no column rate_2_rad_per_s"),
            (format!("{header}\n"), "run.csv, line 2: nothing: expected a row"),
            (format!("{header}\n{row}\n1,2\n"), "run.csv, line 3: 2 fields: expected 14 fields"),
            (
                format!("{header}\n{}", row.replacen('0', "NaN", 1)),
                "line 2: rate_2_rad_per_s = \"NaN\": expected a finite",
            ),
            (format!("{header}\n{}", row.replacen('0', "x", 1)), "line 2: rate_2_rad_per_s = \"x\": expected a finite"),
        ] {
            let found = parsed(&text).unwrap_err();
            assert!(found.contains(message), "{found}");
        }
        let found = parse(Path::new("run.csv"), b"a\nb\xff").unwrap_err().to_string();
        assert!(found.starts_with("run.csv, line 2: bytes that are no text"), "{found}");
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            let _ = parse(Path::new("x"), &bytes);
            let with_header = [COLUMNS.join(",").as_bytes(), b"\n", &bytes].concat();
            let _ = parse(Path::new("x"), &with_header);
        }

        #[test]
        fn no_row_makes_it_panic(row in "[-+0-9.eEinfNa,\n]{0,200}") {
            if let Ok(points) = parsed(&format!("{}\n{row}", COLUMNS.join(","))) {
                prop_assert!(points.iter().all(|point| point.torque_applied.iter().all(|torque| torque.is_finite())));
            }
        }
    }
}
