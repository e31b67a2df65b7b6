//! The records of an MCAP file, as far as they are there.
//!
//! Memory grows with the bytes that were read, never with a length that a record claims. Behind a damaged place the next
//! chunk or metadata of a log is looked for.

use std::io::{self, Read};

use mcap::records::op;

/// The first bytes of every MCAP file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// The longest record that is believed, in bytes: a log's chunks and attachments have about one million. As far as that, the
/// next record is looked for behind a damaged one.
pub const MOST_RECORD_BYTES: usize = 64 * 1024 * 1024;

/// How many bytes are read at a time.
const READ_BYTES: usize = 64 * 1024;
/// Opcode and length before each record.
const PREFIX_BYTES: usize = 1 + size_of::<u64>();
/// The opcodes from here on are for private records.
const FIRST_PRIVATE: u8 = 0x80;
/// So many bytes of a record tell whether it is a chunk or metadata of a log.
const SIGNATURE_BYTES: usize = PREFIX_BYTES + 44;

/// Reads records, chunks as a whole, from a file that may end anywhere, or still grow.
pub struct Records<R> {
    input: R,
    buffer: Vec<u8>,
    start: usize,
    place: Place,
    /// Of the section that is being read; nothing behind a damaged place.
    checksum: Option<crc32fast::Hasher>,
}

/// What comes next in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    StartMagic,
    Record,
    EndMagic,
    Ended,
}

/// What the next step of reading met.
#[derive(Debug)]
pub enum Step {
    /// A record, which was handed over.
    Record,
    /// The input has no more bytes now, and the format is not at its end.
    Starved,
    /// The end of the format.
    End,
    /// Bytes that are not MCAP: [`Records::find_next`] may find what follows them.
    Broken(Broken),
    /// A section was read to its end, but its checksum is another: something in it is not as it was written.
    Checksum {
        /// The section.
        section: &'static str,
        /// The checksum that the file tells.
        expected: u32,
        /// That of its bytes.
        found: u32,
    },
}

/// What is not MCAP.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Broken {
    /// The first bytes.
    #[error("it does not begin as an MCAP file does")]
    StartMagic,
    /// The last bytes.
    #[error("it does not end as an MCAP file does")]
    EndMagic,
    /// A kind of record that there is not.
    #[error("no record has the opcode {0:02X}h")]
    Opcode(u8),
    /// A length beyond all that a log has.
    #[error("a record claims {claimed} bytes, at most {MOST_RECORD_BYTES} are believed")]
    Length {
        /// What the length says, bytes.
        claimed: u64,
    },
}

impl<R: Read> Records<R> {
    /// Reads from `input`.
    pub fn new(input: R) -> Self {
        let checksum = Some(crc32fast::Hasher::new());
        Self { input, buffer: Vec::new(), start: 0, place: Place::StartMagic, checksum }
    }

    /// Reads on; gives the opcode and the body of a record to `take`.
    ///
    /// # Errors
    /// If the input cannot be read.
    pub fn step(&mut self, take: impl FnOnce(u8, &[u8])) -> io::Result<Step> {
        match self.place {
            Place::StartMagic => match self.magic(Broken::StartMagic)? {
                None => self.record(take),
                Some(step) => Ok(step),
            },
            Place::Record => self.record(take),
            Place::EndMagic => Ok(self.magic(Broken::EndMagic)?.unwrap_or(Step::End)),
            Place::Ended => Ok(Step::End),
        }
    }

    /// Takes the magic; nothing if it is there.
    fn magic(&mut self, otherwise: Broken) -> io::Result<Option<Step>> {
        if !self.fill(MAGIC.len())? {
            // Fewer bytes can already be other ones.
            let is_other = !MAGIC.starts_with(self.unread());
            return Ok(Some(if is_other { Step::Broken(otherwise) } else { Step::Starved }));
        }
        if !self.unread().starts_with(&MAGIC) {
            return Ok(Some(Step::Broken(otherwise)));
        }
        self.consume(MAGIC.len());
        self.place = if self.place == Place::StartMagic { Place::Record } else { Place::Ended };
        Ok(None)
    }

    fn record(&mut self, take: impl FnOnce(u8, &[u8])) -> io::Result<Step> {
        if !self.fill(PREFIX_BYTES)? {
            return Ok(Step::Starved);
        }
        let Some((&[opcode, ref length @ ..], _)) = self.unread().split_first_chunk::<PREFIX_BYTES>() else {
            return Ok(Step::Starved);
        };
        let claimed = u64::from_le_bytes(*length);
        if !((op::HEADER..=op::DATA_END).contains(&opcode) || opcode >= FIRST_PRIVATE) {
            return Ok(Step::Broken(Broken::Opcode(opcode)));
        }
        let Some(body) = usize::try_from(claimed).ok().filter(|length| *length <= MOST_RECORD_BYTES) else {
            return Ok(Step::Broken(Broken::Length { claimed }));
        };
        if !self.fill(PREFIX_BYTES + body)? {
            return Ok(Step::Starved);
        }
        take(opcode, self.unread().get(PREFIX_BYTES..PREFIX_BYTES + body).unwrap_or_default());
        let step = self.check(opcode, body);
        self.consume(PREFIX_BYTES + body);
        if opcode == op::DATA_END {
            // The summary has a checksum of its own.
            self.checksum = self.checksum.is_some().then(crc32fast::Hasher::new);
        }
        Ok(step)
    }

    /// Compares the checksum at the end of a section; 0 is none.
    fn check(&mut self, opcode: u8, body: usize) -> Step {
        let record = self.buffer.get(self.start..self.start + PREFIX_BYTES + body).unwrap_or_default();
        let (section, covered) = match opcode {
            op::DATA_END => ("data", &record[..0]),
            op::FOOTER => {
                self.place = Place::EndMagic;
                ("summary", record.get(..record.len().saturating_sub(size_of::<u32>())).unwrap_or_default())
            }
            _ => return Step::Record,
        };
        let (Some(mut hasher), Some(expected)) = (self.checksum.clone(), record.last_chunk()) else {
            return Step::Record;
        };
        hasher.update(covered);
        let (expected, found) = (u32::from_le_bytes(*expected), hasher.finalize());
        if expected == 0 || expected == found { Step::Record } else { Step::Checksum { section, expected, found } }
    }

    /// Looks for the next chunk or metadata of a log behind a damaged place, at most [`MOST_RECORD_BYTES`] away. Gives how many
    /// bytes are left out; nothing if there is none.
    ///
    /// # Errors
    /// If the input cannot be read.
    pub fn find_next(&mut self) -> io::Result<Option<usize>> {
        if matches!(self.place, Place::StartMagic | Place::Ended) {
            return Ok(None);
        }
        let mut skipped = 0;
        while skipped < MOST_RECORD_BYTES && !self.unread().is_empty() {
            self.fill(READ_BYTES)?;
            let first = usize::from(skipped == 0);
            let found = self.unread().windows(SIGNATURE_BYTES).skip(first).position(begins_record);
            if let Some(position) = found {
                self.start += position + first;
                self.place = Place::Record;
                self.checksum = None;
                return Ok(Some(skipped + position + first));
            }
            let looked_at = (self.unread().len() + 1).saturating_sub(SIGNATURE_BYTES);
            if looked_at == 0 {
                break;
            }
            self.start += looked_at;
            skipped += looked_at;
        }
        Ok(None)
    }

    fn unread(&self) -> &[u8] {
        self.buffer.get(self.start..).unwrap_or_default()
    }

    /// Reads until `wanted` bytes are there; false if the input has no more now.
    fn fill(&mut self, wanted: usize) -> io::Result<bool> {
        while self.unread().len() < wanted {
            if self.start > READ_BYTES.max(self.buffer.len() / 2) {
                self.buffer.drain(..self.start);
                self.start = 0;
            }
            let before = self.buffer.len();
            self.input.by_ref().take(READ_BYTES as u64).read_to_end(&mut self.buffer)?;
            if self.buffer.len() == before {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn consume(&mut self, count: usize) {
        if let Some(checksum) = &mut self.checksum {
            checksum.update(self.buffer.get(self.start..self.start + count).unwrap_or_default());
        }
        self.start += count;
    }
}

/// What a wrong checksum of a section says about a log.
pub fn checksum_damage(section: &str) -> String {
    format!("something in it is not as it was written: the checksum of the {section} is another")
}

/// Whether a chunk or metadata of a log begins with these bytes: lengths that fit one another do not come about by chance.
fn begins_record(bytes: &[u8]) -> bool {
    let number = |at: usize| {
        let bytes = bytes.get(at..)?.first_chunk()?;
        usize::try_from(u64::from_le_bytes(*bytes)).ok()
    };
    let name = |at: usize| {
        let length = u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?);
        let start = at + size_of::<u32>();
        bytes.get(start..start + usize::try_from(length).ok()?.min(bytes.len()))
    };
    let is_chunk = || {
        /// Before the name of the compression: two times, a size and a checksum.
        const NUMBERS: usize = 28;
        let compression = name(PREFIX_BYTES + NUMBERS)?;
        let packed_at = PREFIX_BYTES + NUMBERS + size_of::<u32>() + compression.len();
        let header = packed_at + size_of::<u64>() - PREFIX_BYTES;
        let is_known = matches!(compression, b"" | b"zstd" | b"lz4");
        Some(is_known && number(1)? <= MOST_RECORD_BYTES && number(packed_at)?.checked_add(header)? == number(1)?)
    };
    match bytes.first() {
        Some(&op::CHUNK) => is_chunk().unwrap_or(false),
        Some(&op::METADATA) => name(PREFIX_BYTES).is_some_and(|name| name.starts_with(b"uarm.")),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
        [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
    }

    fn chunk(records: &[u8]) -> Vec<u8> {
        let body =
            [&[0; 28][..], &4_u32.to_le_bytes(), b"zstd", &(records.len() as u64).to_le_bytes(), records].concat();
        record(op::CHUNK, &body)
    }

    /// All that was met, in words.
    fn read(bytes: &[u8]) -> Vec<String> {
        let mut records = Records::new(bytes);
        let mut met = Vec::new();
        loop {
            let mut opcode = 0;
            match records.step(|found, _| opcode = found).unwrap() {
                Step::Record => met.push(format!("record {opcode:02X}")),
                Step::End => return met,
                Step::Checksum { section, .. } => met.push(format!("record {opcode:02X}, {section} checksum")),
                other => {
                    met.push(match other {
                        Step::Broken(broken) => broken.to_string(),
                        other => format!("{other:?}"),
                    });
                    match records.find_next().unwrap() {
                        Some(skipped) => met.push(format!("{skipped} bytes left out")),
                        None => return met,
                    }
                }
            }
        }
    }

    #[test]
    fn behind_a_damaged_length_the_next_chunk_is_found() {
        let mut damaged = chunk(&[1; 30]);
        damaged[6] = 0x7F;
        let left_out = format!("{} bytes left out", damaged.len());
        let file = [&MAGIC[..], &damaged, &chunk(&[2; 200]), &chunk(&[3; 10])].concat();
        let claimed = u64::from_le_bytes(damaged[1..9].try_into().unwrap());
        let broken = Broken::Length { claimed }.to_string();
        assert_eq!(read(&file), [broken.as_str(), &left_out, "record 06", "record 06", "Starved"]);
    }

    /// 1 MiB is a length that could be, and the file ends before.
    #[test]
    fn a_length_beyond_the_end_of_the_file_costs_one_record() {
        let mut damaged = chunk(&[1; 30]);
        damaged[3] = 0x10;
        let metadata =
            record(op::METADATA, &[&8_u32.to_le_bytes()[..], b"uarm.end", &0_u32.to_le_bytes(), &[0; 60]].concat());
        let file = [&MAGIC[..], &damaged, &metadata].concat();
        let left_out = format!("{} bytes left out", damaged.len());
        assert_eq!(read(&file), ["Starved", &left_out, "record 0C", "Starved"]);
    }

    #[test]
    fn what_is_no_mcap_is_told_by_its_first_bytes() {
        let start = [Broken::StartMagic.to_string()];
        assert_eq!(read(b"hello"), start);
        assert_eq!(read(&[0; 100]), start);
        assert_eq!(read(&MAGIC[..3]), ["Starved"]);
        let file = [&MAGIC[..], &[0; 100]].concat();
        assert_eq!(read(&file), [Broken::Opcode(0).to_string()]);
    }

    #[test]
    fn a_claimed_length_takes_no_memory() {
        let claimed = (MOST_RECORD_BYTES as u64).to_le_bytes();
        let file = [&MAGIC[..], &[op::ATTACHMENT], &claimed, &[0; 50]].concat();
        let mut records = Records::new(file.as_slice());
        assert!(matches!(records.step(|_, _| {}).unwrap(), Step::Starved));
        assert!(records.buffer.capacity() <= 2 * READ_BYTES, "{}", records.buffer.capacity());
    }

    #[test]
    fn checksums_of_data_and_summary_are_compared() {
        let data = [&MAGIC[..], &record(op::HEADER, &[0; 8])].concat();
        let data_end = record(op::DATA_END, &crc32fast::hash(&data).to_le_bytes());
        let footer = |checksum: u32| record(op::FOOTER, &[&[0; 16][..], &checksum.to_le_bytes()].concat());
        let summary = record(op::STATISTICS, &[0; 46]);
        let covered = [&summary[..], &footer(0)[..PREFIX_BYTES + 16]].concat();
        let file = |data: &[u8], summary: &[u8]| {
            read(&[data, &data_end, summary, &footer(crc32fast::hash(&covered)), &MAGIC].concat())
        };
        assert_eq!(file(&data, &summary), ["record 01", "record 0F", "record 0B", "record 02"]);
        let change = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            *bytes.last_mut().unwrap() ^= 1;
            bytes
        };
        let wrong_data = ["record 01", "record 0F, data checksum", "record 0B", "record 02"];
        assert_eq!(file(&change(&data), &summary), wrong_data);
        let wrong_summary = ["record 01", "record 0F", "record 0B", "record 02, summary checksum"];
        assert_eq!(file(&data, &change(&summary)), wrong_summary);
    }
}
