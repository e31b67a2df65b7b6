//! Postures on the way from a CSV file.

use std::path::Path;

use super::error::{Checker, RobotError};
use super::file::{RobotFile, Role, ViaPoint};
use crate::text_file;

/// The longest file that is read, bytes: a log holds the postures, too.
const MOST_BYTES: usize = 1 << 20;
/// The column of times.
const TIME: &str = "at_s";

/// Puts the postures of `task.via_csv` into `task.via`, if there is such a file; a path is relative to the folder of the file `name`.
///
/// Its first line names the columns: `at_s`, then the active joints in their order. Angles are in degrees.
///
/// # Errors
/// If it cannot be read, or has other columns or what is no number; the line is named.
pub fn resolve<const N: usize>(name: &Path, file: &mut RobotFile<N>, check: &Checker<'_>) -> Result<(), RobotError> {
    let Some(csv) = file.task.via_csv.take() else { return Ok(()) };
    if !file.task.via.is_empty() {
        return Err(check.refuse("task.via_csv", csv.display(), "task.via or task.via_csv, not both"));
    }
    let path = name.parent().unwrap_or(Path::new("")).join(&csv);
    let refused = |expected: String| check.refuse("task.via_csv", path.display(), expected);
    let text = text_file::read_up_to(&path, MOST_BYTES)
        .map_err(|error| refused(format!("a file that can be read: {error}")))?;
    let active = file.joints.iter().filter(|joint| joint.role == Role::Active).map(|joint| joint.name.as_str());
    let columns: Vec<&str> = std::iter::once(TIME).chain(active).collect();
    file.task.via = read(&text, &columns).map_err(refused)?;
    Ok(())
}

/// # Errors
/// What was expected, in words that name the line.
fn read(text: &str, columns: &[&str]) -> Result<Vec<ViaPoint>, String> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?;
    if header != columns {
        let found = header.iter().collect::<Vec<_>>().join(",");
        return Err(format!("a first line {:?}, not {found:?}", columns.join(",")));
    }
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| format!("as many numbers in each line as columns: {error}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |text: &str| {
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| format!("finite numbers, not {text:?} in line {line}"))
        };
        let numbers = record.iter().map(number).collect::<Result<Vec<_>, _>>()?;
        let Some((at_s, angles_deg)) = numbers.split_first() else { continue };
        points.push(ViaPoint { at_s: *at_s, angles_deg: angles_deg.to_vec(), passing: Default::default() });
    }
    if points.is_empty() {
        return Err("one posture at least behind its first line".to_owned());
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: [&str; 3] = [TIME, "joint 2", "joint 3"];

    #[test]
    fn a_line_is_a_posture() {
        let points = read("at_s, joint 2, joint 3\n# by hand\n0.5, 10, -2.5e1\n1,0,0\n", &COLUMNS).unwrap();
        let [first, second] = points.as_slice() else { panic!("{points:?}") };
        assert_eq!((first.at_s, first.angles_deg.as_slice()), (0.5, [10.0, -25.0].as_slice()));
        assert_eq!((second.at_s, second.angles_deg.as_slice()), (1.0, [0.0, 0.0].as_slice()));
    }

    #[test]
    fn what_is_no_table_of_postures_is_told_with_its_line() {
        for (text, expected) in [
            ("at_s,joint 3,joint 2\n", "a first line \"at_s,joint 2,joint 3\", not \"at_s,joint 3,joint 2\""),
            ("at_s,joint 2,joint 3\n0.5,1,2\n0.6,1,x\n", "finite numbers, not \"x\" in line 3"),
            ("at_s,joint 2,joint 3\n0.5,1,nan\n", "finite numbers, not \"nan\" in line 2"),
            ("at_s,joint 2,joint 3\n0.5,1\n", "as many numbers in each line as columns: CSV error: record 1 (line: 2"),
            ("at_s,joint 2,joint 3\n", "one posture at least"),
        ] {
            let error = read(text, &COLUMNS).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
