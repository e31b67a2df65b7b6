//! Lengths inside a record of MCAP, held against the bytes that are there before anything believes them: a length of 32 bits
//! can ask for 4 GiB.

use mcap::records::op;

/// A part of a record as its specification orders them (<https://mcap.dev/spec>, records).
#[derive(Clone, Copy, Debug)]
enum Part {
    /// So many bytes of numbers.
    Numbers(usize),
    /// A length of 32 bits, and so many bytes.
    Counted(&'static str),
    /// A length of 32 bits, and so many bytes of pairs of strings.
    Strings(&'static str),
    /// A length of 64 bits, and so many bytes.
    CountedLong(&'static str),
}
use Part::{Counted, CountedLong, Numbers, Strings};

/// A length that asks for more bytes than its record has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{record}: {field} claims {claimed} bytes, {left} are left in the record")]
pub struct LengthError {
    /// The kind of the record.
    pub record: &'static str,
    /// The field of the record.
    pub field: &'static str,
    /// What the length says, bytes.
    pub claimed: u64,
    /// What there is, bytes.
    pub left: usize,
}

/// The name and the parts of a kind of record; nothing for kinds without lengths.
const fn layout(opcode: u8) -> Option<(&'static str, &'static [Part])> {
    Some(match opcode {
        op::HEADER => ("header", &[Counted("profile"), Counted("library")]),
        op::SCHEMA => ("schema", &[Numbers(2), Counted("name"), Counted("encoding"), Counted("data")]),
        op::CHANNEL => ("channel", &[Numbers(4), Counted("topic"), Counted("encoding"), Strings("metadata")]),
        op::CHUNK => ("chunk", &[Numbers(28), Counted("compression"), CountedLong("records")]),
        op::MESSAGE_INDEX => ("message index", &[Numbers(2), Counted("entries")]),
        op::CHUNK_INDEX => {
            ("chunk index", &[Numbers(32), Counted("message indexes"), Numbers(8), Counted("compression"), Numbers(16)])
        }
        op::ATTACHMENT => ("attachment", &[Numbers(16), Counted("name"), Counted("media type"), CountedLong("data")]),
        op::ATTACHMENT_INDEX => ("attachment index", &[Numbers(40), Counted("name"), Counted("media type")]),
        op::STATISTICS => ("statistics", &[Numbers(42), Counted("message counts")]),
        op::METADATA => ("metadata", &[Counted("name"), Strings("values")]),
        op::METADATA_INDEX => ("metadata index", &[Numbers(16), Counted("name")]),
        _ => return None,
    })
}

/// Holds all lengths in a record against its bytes.
///
/// # Errors
/// [`LengthError`] for the first that asks for more than there is.
pub fn check(opcode: u8, body: &[u8]) -> Result<(), LengthError> {
    let Some((record, parts)) = layout(opcode) else { return Ok(()) };
    let mut rest = Rest { record, bytes: body };
    for part in parts {
        match *part {
            Numbers(count) => {
                rest.take("a number", u64::try_from(count).unwrap_or(u64::MAX))?;
            }
            Counted(field) => {
                rest.counted(field)?;
            }
            CountedLong(field) => {
                let claimed = u64::from_le_bytes(rest.array(field)?);
                rest.take(field, claimed)?;
            }
            Strings(field) => {
                let mut strings = Rest { record, bytes: rest.counted(field)? };
                while !strings.bytes.is_empty() {
                    strings.counted(field)?;
                }
            }
        }
    }
    Ok(())
}

struct Rest<'a> {
    record: &'static str,
    bytes: &'a [u8],
}

impl<'a> Rest<'a> {
    fn take(&mut self, field: &'static str, claimed: u64) -> Result<&'a [u8], LengthError> {
        let count = usize::try_from(claimed).unwrap_or(usize::MAX);
        let wrong = LengthError { record: self.record, field, claimed, left: self.bytes.len() };
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or(wrong)?;
        self.bytes = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], LengthError> {
        let wrong = LengthError {
            record: self.record,
            field,
            claimed: u64::try_from(N).unwrap_or(u64::MAX),
            left: self.bytes.len(),
        };
        let (taken, rest) = self.bytes.split_first_chunk().ok_or(wrong)?;
        self.bytes = rest;
        Ok(*taken)
    }

    fn counted(&mut self, field: &'static str) -> Result<&'a [u8], LengthError> {
        let claimed = u32::from_le_bytes(self.array(field)?);
        self.take(field, claimed.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_is_held_against_what_is_there() {
        let name = |length: u32| [&[0; 16][..], &length.to_le_bytes(), b"uarm.run"].concat();
        assert_eq!(check(op::METADATA_INDEX, &name(8)), Ok(()));
        let wrong = LengthError { record: "metadata index", field: "name", claimed: 3_478_540_441, left: 8 };
        assert_eq!(check(op::METADATA_INDEX, &name(3_478_540_441)), Err(wrong));
        assert_eq!(wrong.to_string(), "metadata index: name claims 3478540441 bytes, 8 are left in the record");
    }

    #[test]
    fn strings_in_a_map_are_looked_at_one_by_one() {
        let map = |value: u32| {
            let pair = [&1_u32.to_le_bytes()[..], b"k", &value.to_le_bytes(), b"v"].concat();
            let length = u32::try_from(pair.len()).unwrap().to_le_bytes();
            [&1_u32.to_le_bytes()[..], b"n", &length, &pair].concat()
        };
        assert_eq!(check(op::METADATA, &map(1)), Ok(()));
        assert_eq!(check(op::METADATA, &map(2)).unwrap_err().left, 1);
    }

    #[test]
    fn lengths_of_64_bits_and_records_that_end_early_are_refused() {
        let chunk = |records: u64| [&[0; 28][..], &[0; 4], &records.to_le_bytes(), &[1, 2, 3]].concat();
        assert_eq!(check(op::CHUNK, &chunk(3)), Ok(()));
        assert_eq!(check(op::CHUNK, &chunk(u64::MAX)).unwrap_err().claimed, u64::MAX);
        for length in 0..40 {
            assert!(check(op::CHUNK, &chunk(3)[..length]).is_err(), "{length}");
        }
        assert_eq!(check(op::DATA_END, &[]), Ok(()), "a kind without lengths");
    }
}
