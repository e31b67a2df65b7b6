//! The file of a campaign's trials, in JSON Lines: what it is of, then a line a seed. Parts become a whole of the same bytes as
//! one run writes.

use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::trial::Trial;
use crate::text_file;

/// What a file's trials are of. Trials with different headers do not belong together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The version of the program, with its commit.
    pub uarm: String,
    /// The robot's name.
    pub robot: String,
    /// CRC-32 of the robot file.
    pub robot_crc32: u32,
    /// The first seed.
    pub first_seed: u64,
    /// The number of seeds.
    pub seeds: u64,
}

/// Trials of a campaign, or of a part of it, by seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Trials {
    /// What they are of.
    pub header: Header,
    /// One for each seed.
    pub trials: Vec<Trial>,
}

/// Why a file of trials, or several together, cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// It cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// A line is not what it must be.
    #[error("{file}: line {line}: {source}; expected a file that `uarm campaign --output` wrote")]
    Line {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// It is empty.
    #[error("{file}: empty, expected a file that `uarm campaign --output` wrote")]
    Empty {
        /// The file.
        file: String,
    },
    /// It belongs to another campaign.
    #[error("{file}: of {found:?}, expected {expected:?} as the first file")]
    Other {
        /// The file.
        file: String,
        /// Its header.
        found: Box<Header>,
        /// The first file's.
        expected: Box<Header>,
    },
    /// A seed stands in it twice, or in two of the files, or does not belong to the campaign.
    #[error("seed {seed} stands in the files {count} times, expected once each from {first} to {last}")]
    Seed {
        /// The seed.
        seed: u64,
        /// How often.
        count: usize,
        /// The first seed of the campaign.
        first: u64,
        /// The last seed of the campaign.
        last: u64,
    },
}

/// The largest file that is read: about four million trials.
const LARGEST_FILE: usize = 1 << 30;

impl Trials {
    /// Writes the file.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer(&mut *output, &self.header)?;
        writeln!(output)?;
        for trial in &self.trials {
            serde_json::to_writer(&mut *output, trial)?;
            writeln!(output)?;
        }
        Ok(())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`StoreError`] names file and line.
    pub fn read(file: &Path) -> Result<Self, StoreError> {
        let name = file.display().to_string();
        match text_file::read_up_to(file, LARGEST_FILE) {
            Ok(text) => Self::parse(&name, &text),
            Err(source) => Err(StoreError::Read { file: name, source }),
        }
    }

    fn parse(file: &str, text: &str) -> Result<Self, StoreError> {
        let wrong = |line: usize| move |source| StoreError::Line { file: file.to_owned(), line, source };
        let mut lines = text.lines().zip(1..);
        let (first, _) = lines.next().ok_or_else(|| StoreError::Empty { file: file.to_owned() })?;
        let header = serde_json::from_str(first).map_err(wrong(1))?;
        let trials = lines.map(|(text, line)| serde_json::from_str(text).map_err(wrong(line)));
        Ok(Self { header, trials: trials.collect::<Result<_, _>>()? })
    }

    /// The whole of which `parts` are the parts, each with the name of its file.
    ///
    /// # Errors
    /// [`StoreError`] if they are not of one campaign, or do not have each of its seeds once.
    pub fn merge(parts: Vec<(String, Self)>) -> Result<Self, StoreError> {
        let mut parts = parts.into_iter();
        let (_, mut whole) = parts.next().ok_or_else(|| StoreError::Empty { file: "no file".to_owned() })?;
        for (file, part) in parts {
            if part.header != whole.header {
                let (found, expected) = (Box::new(part.header), Box::new(whole.header));
                return Err(StoreError::Other { file, found, expected });
            }
            whole.trials.extend(part.trials);
        }
        whole.trials.sort_by_key(|trial| trial.seed);
        whole.check_seeds()?;
        Ok(whole)
    }

    fn check_seeds(&self) -> Result<(), StoreError> {
        let Header { first_seed: first, seeds, .. } = self.header;
        let last = first.saturating_add(seeds.saturating_sub(1));
        let error = |seed, count| StoreError::Seed { seed, count, first, last };
        let mut expected = first;
        for trial in &self.trials {
            if trial.seed != expected {
                let is_twice = trial.seed < expected && trial.seed >= first;
                return Err(if is_twice { error(trial.seed, 2) } else { error(expected, 0) });
            }
            if trial.seed > last {
                return Err(error(trial.seed, 1));
            }
            expected = expected.saturating_add(1);
        }
        if expected <= last { Err(error(expected, 0)) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(seed: u64) -> Trial {
        Trial {
            seed,
            controller: "fuzzy".to_owned(),
            fault: "nothing".to_owned(),
            detail: "nothing".to_owned(),
            joint: 1,
            at_s: 0.1 * seed as f64,
            end: "completed".to_owned(),
            reaction_ms: None,
            violations: Vec::new(),
        }
    }

    fn trials(seeds: &[u64]) -> Trials {
        let header = Header { uarm: "0".to_owned(), robot: "UARM".to_owned(), robot_crc32: 7, first_seed: 1, seeds: 4 };
        Trials { header, trials: seeds.iter().copied().map(trial).collect() }
    }

    fn merged(parts: &[&[u64]]) -> Result<Trials, String> {
        let parts = parts.iter().map(|seeds| ("part".to_owned(), trials(seeds))).collect();
        Trials::merge(parts).map_err(|error| error.to_string())
    }

    #[test]
    fn a_file_is_read_as_it_was_written() {
        let mut bytes = Vec::new();
        trials(&[1, 2, 3, 4]).write(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert_eq!(text.lines().count(), 5);
        assert_eq!(Trials::parse("file", &text).unwrap(), trials(&[1, 2, 3, 4]));
    }

    #[test]
    fn parts_become_the_whole() {
        assert_eq!(merged(&[&[1, 3], &[2, 4]]), Ok(trials(&[1, 2, 3, 4])));
        assert_eq!(merged(&[&[4], &[2], &[3], &[1]]), Ok(trials(&[1, 2, 3, 4])));
    }

    #[test]
    fn seeds_that_are_missing_doubled_or_foreign_are_named() {
        for (parts, expected) in [
            (&[&[1, 3][..], &[4]][..], "seed 2 stands in the files 0 times"),
            (&[&[1, 2], &[2, 3, 4]], "seed 2 stands in the files 2 times"),
            (&[&[1, 2, 3]], "seed 4 stands in the files 0 times"),
            (&[&[0, 1, 2, 3, 4]], "expected once each from 1 to 4"),
            (&[&[1, 2, 3, 4, 5]], "seed 5 stands in the files 1 times, expected once each from 1 to 4"),
        ] {
            let error = merged(parts).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_part_of_another_campaign_is_refused_by_name() {
        let mut other = trials(&[2, 4]);
        other.header.robot_crc32 = 8;
        let error = Trials::merge(vec![("a".to_owned(), trials(&[1, 3])), ("b".to_owned(), other)]).unwrap_err();
        assert!(error.to_string().starts_with("b: of Header"), "{error}");
    }

    #[test]
    fn a_line_that_is_none_is_named() {
        let error = Trials::parse("part.jsonl", "{\"uarm\":\"1\"}\n").unwrap_err().to_string();
        assert!(error.starts_with("part.jsonl: line 1: missing field"), "{error}");
        assert!(Trials::parse("part.jsonl", "").unwrap_err().to_string().contains("empty"));
    }
}
