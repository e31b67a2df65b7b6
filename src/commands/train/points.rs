//! Reads from recorded runs what training needs of each cycle: from logs, or from CSV files such as `uarm show --csv`
//! writes. Columns are found by their names, so that others may be added.

use std::fmt;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use csv::{ErrorKind, ReaderBuilder, StringRecord};
use hinf_control::TrackingError;
use nalgebra::SVector;
use uarm_log::ordered::InOrder;
use uarm_log::reader::ReadError;
use uarm_log::records::MAGIC;
use uarm_log::regular_file;

use uarm_loop::dimensions;

use crate::dimensions::{CycleRecord, OrderedLog};

/// One cycle of the `N` active joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<const N: usize = 2> {
    /// Where it stands in its file, for messages.
    pub place: Place,
    /// Velocity and position errors, rad/s and rad.
    pub error: TrackingError<f64, N>,
    /// The H∞ control input u.
    pub control_input: SVector<f64, N>,
    /// The torque after the limiter, N·m.
    pub torque_applied: SVector<f64, N>,
    /// Whether the limiter cut it, joint by joint.
    pub limited: [bool; N],
}

/// Where a cycle stands in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The line of a CSV file, counted from 1.
    Line(u64),
    /// The tick in a log.
    Tick(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(formatter, "line {line}"),
            Self::Tick(tick) => write!(formatter, "tick {tick}"),
        }
    }
}

/// A recorded run that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why it cannot be read.
        source: std::io::Error,
    },
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] ReadError),
    /// A part of the log is missing or damaged.
    #[error("{}: {found}: expected a whole log", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// What is missing.
        found: String,
    },
    /// A line of a CSV file is not as it should be.
    #[error("{}, line {line}: {found}: expected {expected}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What stands there.
        found: String,
        /// What should.
        expected: String,
    },
}

/// The longest header of a CSV file, in bytes: that of `uarm show --csv` has four thousand.
const MOST_HEADER_BYTES: usize = 64 * 1024;

/// What is read of each joint: the beginnings and ends of the names of its columns, in the order in which [`point`] takes them.
const SIGNALS: [[&str; 2]; 7] = [
    ["velocity_", "_rad_per_s"],
    ["position_", "_rad"],
    ["reference_velocity_", "_rad_per_s"],
    ["reference_position_", "_rad"],
    ["control_input_", ""],
    ["torque_applied_", "_nm"],
    ["limited_", ""],
];

/// The columns of a robot of `J` joints, signal by signal and joint by joint.
pub(super) fn columns<const J: usize, const N: usize>() -> Vec<String> {
    let of_joints = |[before, after]: [&'static str; 2]| {
        (0..N).map(move |index| format!("{before}{}{after}", dimensions::number_of_active::<J, N>(index)))
    };
    SIGNALS.into_iter().flat_map(of_joints).collect()
}

/// Reads a log or a CSV file, cycle by cycle, and gives each to `take` with a value that `start` makes; where a log holds late
/// records it is gone through twice, with another value. Gives that value.
///
/// # Errors
/// [`PointsError`] names file, place, what was found and what was expected; or the first error of `take`.
pub fn read<V, E: From<PointsError>, const J: usize, const N: usize>(
    file: &Path,
    start: impl Fn() -> V,
    mut take: impl FnMut(&mut V, &Point<N>) -> Result<(), E>,
) -> Result<V, E> {
    let read_error = |source| PointsError::Read { file: file.to_owned(), source };
    let mut input = BufReader::with_capacity(MOST_HEADER_BYTES, regular_file::open(file).map_err(read_error)?);
    let beginning = input.fill_buf().map_err(read_error)?;
    if beginning.starts_with(&MAGIC) {
        return from_log::<V, E, J, N>(file, start, take);
    }
    // A line without an end would be held in memory.
    if beginning.len() == MOST_HEADER_BYTES && !beginning.contains(&b'\n') {
        return Err(E::from(PointsError::Line {
            file: file.to_owned(),
            line: 1,
            found: format!("more than {MOST_HEADER_BYTES} bytes without an end of line"),
            expected: "a log, or a CSV file that uarm show --csv writes".to_owned(),
        }));
    }
    let mut value = start();
    from_csv::<E, J, N>(file, input, |point| take(&mut value, point))?;
    Ok(value)
}

fn from_log<V, E: From<PointsError>, const J: usize, const N: usize>(
    file: &Path,
    start: impl Fn() -> V,
    mut take: impl FnMut(&mut V, &Point<N>) -> Result<(), E>,
) -> Result<V, E> {
    let mut log = OrderedLog::<J, N>::new(file);
    let each = |(cycles, value): &mut (u64, Result<V, E>), record: InOrder<'_, J, N>| {
        let InOrder::Cycle(record) = record else { return };
        *cycles += 1;
        if let Ok(taken) = value
            && let Err(error) = take(taken, &Point::from(record))
        {
            *value = Err(error);
        }
    };
    let ((cycles, value), told) = log.pass(|| (0, Ok(start())), each).map_err(PointsError::from)?;
    let damaged = |found: &str| E::from(PointsError::Damaged { file: file.to_owned(), found: found.to_owned() });
    match told.damage.first() {
        Some(damage) => Err(damaged(damage)),
        None if cycles == 0 => Err(damaged("no cycles")),
        None => value,
    }
}

impl<const J: usize, const N: usize> From<&CycleRecord<J, N>> for Point<N> {
    fn from(record: &CycleRecord<J, N>) -> Self {
        Self {
            place: Place::Tick(record.tick),
            error: record.tracking_error(),
            control_input: record.control_input.into(),
            torque_applied: record.torque_applied.into(),
            limited: record.flags.limited,
        }
    }
}

/// Reads a CSV file from `input`, line by line, and gives each cycle to `take`; `file` is what messages call it.
///
/// # Errors
/// As [`read`].
pub fn from_csv<E: From<PointsError>, const J: usize, const N: usize>(
    file: &Path,
    input: impl Read,
    mut take: impl FnMut(&Point<N>) -> Result<(), E>,
) -> Result<(), E> {
    let refuse = |line: u64, found: &str, expected: &str| PointsError::Line {
        file: file.to_owned(),
        line,
        found: shortened(found),
        expected: expected.to_owned(),
    };
    let malformed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        match error.kind() {
            ErrorKind::UnequalLengths { expected_len, len, .. } => {
                refuse(line, &format!("{len} fields"), &format!("{expected_len} fields, as in the header"))
            }
            ErrorKind::Utf8 { .. } => refuse(line, "bytes that are not text", "UTF-8, as uarm show --csv writes"),
            _ => refuse(line, &error.to_string(), "a line of a CSV file"),
        }
    };
    let mut reader = ReaderBuilder::new().from_reader(input);
    let header = reader.headers().map_err(malformed)?.clone();
    let columns = columns::<J, N>();
    let place = |name: &String| {
        header.iter().position(|column| column == name).ok_or_else(|| {
            refuse(
                1,
                &format!("no column {name}"),
                "the header of a file that uarm show --csv writes of a run of this robot",
            )
        })
    };
    let places = columns.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    let mut values = vec![0.0; columns.len()];
    let mut is_empty = true;
    for record in reader.records() {
        let record: StringRecord = record.map_err(malformed)?;
        let line = record.position().map_or(1, csv::Position::line);
        for ((value, place), name) in values.iter_mut().zip(&places).zip(&columns) {
            let text = record.get(*place).unwrap_or_default();
            *value = text
                .parse()
                .ok()
                .filter(|value: &f64| value.is_finite())
                .ok_or_else(|| refuse(line, &format!("{name} = {text:?}"), "a finite number"))?;
        }
        take(&point(line, &values))?;
        is_empty = false;
    }
    if is_empty { Err(E::from(refuse(2, "nothing", "a row for each cycle of a run"))) } else { Ok(()) }
}

/// The cycle in a line whose columns have these values, in the order of [`columns`].
fn point<const N: usize>(line: u64, values: &[f64]) -> Point<N> {
    let mut signals = values.chunks_exact(N).map(SVector::<f64, N>::from_column_slice);
    let mut next = || signals.next().unwrap_or_else(SVector::zeros);
    let [velocity, position, reference_velocity, reference_position] = [(); 4].map(|()| next());
    Point {
        place: Place::Line(line),
        error: TrackingError { velocity: velocity - reference_velocity, position: position - reference_position },
        control_input: next(),
        torque_applied: next(),
        limited: next().map(|limited| limited != 0.0).into(),
    }
}

/// Long lines of a file of another kind would bury the message.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 80;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;
    use proptest::prelude::*;

    use super::*;

    fn parsed(text: impl AsRef<[u8]>) -> Result<Vec<Point>, String> {
        let mut points = Vec::new();
        let take = |point: &Point| {
            points.push(*point);
            Ok::<(), PointsError>(())
        };
        from_csv::<_, 3, 2>(Path::new("run.csv"), text.as_ref(), take).map_err(|error| error.to_string())?;
        Ok(points)
    }

    #[test]
    fn errors_are_measured_less_desired() {
        let text = format!("tick,{}\n7,3,4,0.5,0.6,1,1.5,0.1,0.4,8,9,0.01,0.02,0,1\n", columns::<3, 2>().join(","));
        let points = parsed(&text).unwrap();
        assert_eq!(points.len(), 1);
        assert_eq!(points[0].place, Place::Line(2));
        assert_eq!(points[0].error.velocity, Vector2::new(2.0, 2.5));
        assert_eq!(points[0].error.position, Vector2::new(0.5 - 0.1, 0.6 - 0.4));
        assert_eq!(points[0].torque_applied, Vector2::new(0.01, 0.02));
        assert_eq!(points[0].limited, [false, true]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let columns = columns::<3, 2>();
        let header = columns.join(",");
        let row = vec!["0"; columns.len()].join(",");
        for (text, message) in [
            (String::new(), "run.csv, line 1: no column velocity_2_rad_per_s: expected the header"),
            ("a,b\n1,2\n".into(), "run.csv, line 1: no column velocity_2_rad_per_s"),
            (format!("{header}\n"), "run.csv, line 2: nothing: expected a row"),
            (format!("{header}\n{row}\n1,2\n"), "run.csv, line 3: 2 fields: expected 14 fields"),
            (
                format!("{header}\n{}", row.replacen('0', "NaN", 1)),
                "line 2: velocity_2_rad_per_s = \"NaN\": expected a finite",
            ),
            (
                format!("{header}\n{}", row.replacen('0', "x", 1)),
                "line 2: velocity_2_rad_per_s = \"x\": expected a finite",
            ),
        ] {
            let found = parsed(&text).unwrap_err();
            assert!(found.contains(message), "{found}");
        }
        let bytes = [header.as_bytes(), b"\n", row.as_bytes(), b"\nb\xff\n"].concat();
        let found = parsed(bytes).unwrap_err();
        assert!(found.starts_with("run.csv, line 3: "), "{found}");
    }

    /// The names that `uarm show --csv` gives joints of a robot without a base.
    #[test]
    fn columns_are_numbered_as_the_joints_are() {
        let columns = columns::<3, 3>();
        assert_eq!(columns[..3], ["velocity_1_rad_per_s", "velocity_2_rad_per_s", "velocity_3_rad_per_s"]);
        assert_eq!(columns[20], "limited_3");
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            let _ = parsed(&bytes);
            let _ = parsed([columns::<3, 2>().join(",").as_bytes(), b"\n", &bytes].concat());
            let log = std::env::temp_dir().join(format!("uarm-train-any-bytes-{}.mcap", std::process::id()));
            std::fs::write(&log, [&MAGIC, bytes.as_slice()].concat()).unwrap();
            let found = read::<_, PointsError, 3, 2>(&log, || (), |(), _| Ok(()));
            std::fs::remove_file(&log).unwrap();
            prop_assert!(found.is_err(), "there is no cycle in it");
        }

        #[test]
        fn no_row_makes_it_panic(row in "[-+0-9.eEinfNa,\n]{0,200}") {
            if let Ok(points) = parsed(format!("{}\n{row}", columns::<3, 2>().join(","))) {
                prop_assert!(points.iter().all(|point| point.torque_applied.iter().all(|torque| torque.is_finite())));
            }
        }
    }
}
