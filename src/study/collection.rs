//! The results of many experiments in a file, in JSON Lines: what they are of, then a line for each. Parts become a whole of the
//! same bytes as one run writes.

use std::fmt::Debug;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::text_file;

/// What results are of. Results with different headers do not belong together.
pub trait Header: Debug + PartialEq + Serialize + DeserializeOwned {
    /// The numbers of the whole's experiments.
    fn numbers(&self) -> RangeInclusive<u64>;
}

/// The result of one experiment of a whole with the header `H`.
pub trait Numbered<H>: Serialize + DeserializeOwned {
    /// Its number.
    fn number(&self) -> u64;

    /// Why it cannot be of a whole with this header; nothing if it can.
    fn misfit(&self, _header: &H) -> Option<String> {
        None
    }
}

/// Results, or a part of them, by number.
#[derive(Clone, Debug, PartialEq)]
pub struct Collection<H, R> {
    /// What they are of.
    pub header: H,
    /// One for each experiment.
    pub results: Vec<R>,
}

/// Why a file of results, or several together, cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CollectionError {
    /// It cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// A line is not what it must be.
    #[error("{file}: line {line}: {source}; expected a file of results of this subcommand")]
    Line {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// It is empty.
    #[error("{file}: empty, expected a file of results of this subcommand")]
    Empty {
        /// The file.
        file: String,
    },
    /// It belongs to others.
    #[error("{file}: line 1: {field} = {found}: expected {expected}, as in {first}")]
    Other {
        /// The file.
        file: String,
        /// The first field in which the headers differ.
        field: String,
        /// What stands there.
        found: String,
        /// What stands in the first file.
        expected: String,
        /// The first file.
        first: String,
    },
    /// A result does not fit the header.
    #[error("{file}: line {line}: {misfit}")]
    Misfit {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What was found and expected.
        misfit: String,
    },
    /// An experiment is missing, stands in the files twice, or does not belong to the whole.
    #[error("experiment {number} stands in {}, expected once each from {first} to {last}", places(.files))]
    Number {
        /// The experiment.
        number: u64,
        /// In which files it stands.
        files: Vec<String>,
        /// The first of the whole.
        first: u64,
        /// The last of the whole.
        last: u64,
    },
}

/// Files in words.
fn places(files: &[String]) -> String {
    if files.is_empty() { "no file".to_owned() } else { files.join(" and ") }
}

/// The largest file that is read: about four million results.
const LARGEST_FILE: usize = 1 << 30;

impl<H: Header, R: Numbered<H>> Collection<H, R> {
    /// Writes the file.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer(&mut *output, &self.header)?;
        writeln!(output)?;
        for result in &self.results {
            serde_json::to_writer(&mut *output, result)?;
            writeln!(output)?;
        }
        Ok(())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`CollectionError`] names file and line.
    pub fn read(file: &Path) -> Result<Self, CollectionError> {
        let name = file.display().to_string();
        match text_file::read_up_to(file, LARGEST_FILE) {
            Ok(text) => Self::parse(&name, &text),
            Err(source) => Err(CollectionError::Read { file: name, source }),
        }
    }

    fn parse(file: &str, text: &str) -> Result<Self, CollectionError> {
        let wrong = |line: usize| move |source| CollectionError::Line { file: file.to_owned(), line, source };
        let mut lines = text.lines().zip(1..);
        let (first, _) = lines.next().ok_or_else(|| CollectionError::Empty { file: file.to_owned() })?;
        let header = serde_json::from_str(first).map_err(wrong(1))?;
        let mut results = Vec::new();
        for (text, line) in lines {
            let result: R = serde_json::from_str(text).map_err(wrong(line))?;
            if let Some(misfit) = result.misfit(&header) {
                return Err(CollectionError::Misfit { file: file.to_owned(), line, misfit });
            }
            results.push(result);
        }
        Ok(Self { header, results })
    }

    /// The whole of which the files at `paths` are the parts.
    ///
    /// # Errors
    /// [`CollectionError`] if one cannot be read, they are not of one whole, or do not have each of its experiments once.
    pub fn merge(paths: &[impl AsRef<Path>]) -> Result<Self, CollectionError> {
        let read = |path: &Path| Ok((path.display().to_string(), Self::read(path)?));
        Self::join(paths.iter().map(|path| read(path.as_ref())).collect::<Result<_, _>>()?)
    }

    fn join(parts: Vec<(String, Self)>) -> Result<Self, CollectionError> {
        let mut parts = parts.into_iter();
        let (first, whole) = parts.next().ok_or_else(|| CollectionError::Empty { file: "no file".to_owned() })?;
        let Self { header, results } = whole;
        let from = |file: &str, results: Vec<R>| results.into_iter().map(|result| (file.to_owned(), result)).collect();
        let mut all: Vec<(String, R)> = from(&first, results);
        for (file, part) in parts {
            if part.header != header {
                return Err(other(&part.header, &header, file, first));
            }
            all.extend::<Vec<_>>(from(&file, part.results));
        }
        all.sort_by_key(|(_, result)| result.number());
        check_numbers(&header, &all)?;
        Ok(Self { header, results: all.into_iter().map(|(_, result)| result).collect() })
    }
}

/// The error of a header that is another than the first file's: the first field that differs.
fn other<H: Header>(found: &H, expected: &H, file: String, first: String) -> CollectionError {
    let fields = |header: &H| match serde_json::to_value(header) {
        Ok(serde_json::Value::Object(fields)) => fields,
        _ => serde_json::Map::new(),
    };
    let (found, expected) = (fields(found), fields(expected));
    let differs = found.iter().find(|(name, value)| expected.get(*name) != Some(value));
    let (field, found) = differs.map_or_else(Default::default, |(name, value)| (name.clone(), value.to_string()));
    let expected = expected.get(&field).map(ToString::to_string).unwrap_or_default();
    CollectionError::Other { file, field, found, expected, first }
}

/// Refuses sorted results that are not all those of the whole, once each.
fn check_numbers<H: Header, R: Numbered<H>>(header: &H, all: &[(String, R)]) -> Result<(), CollectionError> {
    let (first, last) = header.numbers().into_inner();
    let error = |number: u64| {
        let files = all.iter().filter(|(_, result)| result.number() == number).map(|(file, _)| file.clone()).collect();
        Err(CollectionError::Number { number, files, first, last })
    };
    // The next that must come; nothing once the last is there.
    let mut expected = Some(first).filter(|first| *first <= last);
    for number in all.iter().map(|(_, result)| result.number()) {
        match expected {
            Some(next) if number == next => expected = (next < last).then(|| next + 1),
            Some(next) if number > next && number <= last => return error(next),
            _ => return error(number),
        }
    }
    expected.map_or(Ok(()), error)
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Of {
        robot: String,
    }

    impl Header for Of {
        fn numbers(&self) -> RangeInclusive<u64> {
            1..=4
        }
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Last;

    impl Header for Last {
        fn numbers(&self) -> RangeInclusive<u64> {
            u64::MAX..=u64::MAX
        }
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Result {
        number: u64,
        value: f64,
    }

    impl Numbered<Of> for Result {
        fn misfit(&self, header: &Of) -> Option<String> {
            (self.value < 0.0).then(|| format!("value = {}: expected none below 0 of {}", self.value, header.robot))
        }

        fn number(&self) -> u64 {
            self.number
        }
    }

    impl Numbered<Last> for Result {
        fn number(&self) -> u64 {
            self.number
        }
    }

    type Results = Collection<Of, Result>;

    fn results(numbers: &[u64]) -> Results {
        let result = |number: &u64| Result { number: *number, value: 0.1 * *number as f64 };
        Results { header: Of { robot: "UARM".to_owned() }, results: numbers.iter().map(result).collect() }
    }

    fn joined(parts: &[&[u64]]) -> std::result::Result<Results, String> {
        let parts = parts.iter().zip(1..).map(|(numbers, part)| (format!("part {part}"), results(numbers))).collect();
        Results::join(parts).map_err(|error| error.to_string())
    }

    #[test]
    fn a_file_is_read_as_it_was_written() {
        let mut bytes = Vec::new();
        results(&[1, 2, 3, 4]).write(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert_eq!(text.lines().count(), 5);
        assert_eq!(Results::parse("file", &text).unwrap(), results(&[1, 2, 3, 4]));
    }

    #[test]
    fn parts_become_the_whole() {
        assert_eq!(joined(&[&[1, 3], &[2, 4]]), Ok(results(&[1, 2, 3, 4])));
        assert_eq!(joined(&[&[4], &[2], &[3], &[1]]), Ok(results(&[1, 2, 3, 4])));
    }

    #[test]
    fn what_is_missing_doubled_or_foreign_is_named() {
        for (parts, number, places) in [
            (&[&[1, 3][..], &[4]][..], 2, "no file"),
            (&[&[2, 3, 4]], 1, "no file"),
            (&[&[1, 2, 3]], 4, "no file"),
            (&[&[1, 2], &[2, 3, 4]], 2, "part 1 and part 2"),
            (&[&[0, 1, 2, 3, 4]], 0, "part 1"),
            (&[&[1, 2, 3, 4, 5]], 5, "part 1"),
        ] {
            let expected = format!("experiment {number} stands in {places}, expected once each from 1 to 4");
            assert_eq!(joined(parts), Err(expected));
        }
    }

    #[test]
    fn the_last_of_all_numbers_is_counted_too() {
        let part = |numbers: &[u64]| {
            let result = |number: &u64| Result { number: *number, value: 0.0 };
            vec![("part".to_owned(), Collection { header: Last, results: numbers.iter().map(result).collect() })]
        };
        assert!(Collection::join(part(&[u64::MAX])).is_ok());
        assert!(Collection::join(part(&[])).is_err());
        assert!(Collection::join(part(&[u64::MAX, u64::MAX])).is_err());
    }

    #[test]
    fn a_part_of_another_whole_is_refused_by_name() {
        let mut other = results(&[2, 4]);
        other.header.robot = "another".to_owned();
        let error = Results::join(vec![("a".to_owned(), results(&[1, 3])), ("b".to_owned(), other)]).unwrap_err();
        assert_eq!(error.to_string(), "b: line 1: robot = \"another\": expected \"UARM\", as in a");
    }

    #[test]
    fn a_line_that_is_none_is_named() {
        let error = Results::parse("part.jsonl", "{\"of\":\"1\"}\n").unwrap_err().to_string();
        assert!(error.starts_with("part.jsonl: line 1: missing field"), "{error}");
        let misfit = Results::parse("part.jsonl", "{\"robot\":\"UARM\"}\n{\"number\":1,\"value\":-1.0}\n").unwrap_err();
        assert_eq!(misfit.to_string(), "part.jsonl: line 2: value = -1: expected none below 0 of UARM");
        assert!(Results::parse("part.jsonl", "").unwrap_err().to_string().contains("empty"));
    }
}
