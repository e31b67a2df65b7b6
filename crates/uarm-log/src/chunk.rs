//! The records in a chunk of MCAP, compressed or not.

use std::borrow::Cow;
use std::io::Read;

use mcap::McapError;
use mcap::records::{ChunkHeader, Record, op};

use crate::layout;
use crate::records::MOST_RECORD_BYTES;

/// The most bytes that a chunk is unpacked to. A log's own chunks have one million; Foxglove's tools make some of four.
pub const MOST_UNPACKED_BYTES: usize = 64 * 1024 * 1024;

/// The largest window of Zstandard that is given memory, as a power of two: 8 MiB, which the format asks every reader for.
const MOST_WINDOW_LOG: u32 = 23;

/// Why the records of a chunk cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum ChunkError {
    /// A length in its header is wrong.
    #[error(transparent)]
    Length(#[from] layout::LengthError),
    /// Its header cannot be read.
    #[error("chunk: {0}")]
    Header(#[from] McapError),
    /// A compression that is not known.
    #[error("chunk: compression `{0}`, expected `zstd`, `lz4` or none")]
    Compression(String),
    /// It cannot be unpacked.
    #[error("chunk: cannot be unpacked: {0}")]
    Unpacking(std::io::Error),
    /// It unpacks to more than is believed.
    #[error("chunk: unpacks to more than {MOST_UNPACKED_BYTES} bytes")]
    TooLarge,
    /// Its bytes are not those that were written.
    #[error("chunk: checksum {found:08X}, expected {expected:08X}")]
    Checksum {
        /// The checksum in its header.
        expected: u32,
        /// That of its bytes.
        found: u32,
    },
    /// It has another length than its header says, and no checksum tells which is right.
    #[error("chunk: {found} bytes, its header says {expected}")]
    Size {
        /// The length in its header, bytes.
        expected: u64,
        /// That of its records, bytes.
        found: usize,
    },
    /// A record in it does not end in it.
    #[error("chunk: a record of {claimed} bytes where {left} are left")]
    Record {
        /// The length of the record, bytes.
        claimed: u64,
        /// What there is, bytes.
        left: usize,
    },
}

/// The records of a chunk, as bytes whose checksum is right.
#[derive(Debug)]
pub struct Chunk<'a> {
    records: Cow<'a, [u8]>,
}

impl<'a> Chunk<'a> {
    /// Unpacks the chunk in `body`. Memory grows with what is unpacked, not with what the header promises.
    ///
    /// # Errors
    /// [`ChunkError`].
    pub fn unpack(body: &'a [u8]) -> Result<Self, ChunkError> {
        layout::check(op::CHUNK, body)?;
        let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, body)? else {
            return Ok(Self { records: Cow::Borrowed(&[]) });
        };
        let records = unpacked(&header.compression, data)?;
        check(&header, &records)?;
        Ok(Self { records })
    }

    /// Gives opcode and body of each record to `take`.
    ///
    /// # Errors
    /// [`ChunkError::Record`] if one does not end in the chunk; those before it were given.
    pub fn for_each(&self, mut take: impl FnMut(u8, &[u8])) -> Result<(), ChunkError> {
        let mut rest = &*self.records;
        while let Some((&[opcode, ref length @ ..], behind)) = rest.split_first_chunk::<{ 1 + size_of::<u64>() }>() {
            let claimed = u64::from_le_bytes(*length);
            let wrong = ChunkError::Record { claimed, left: behind.len() };
            let count = usize::try_from(claimed).unwrap_or(usize::MAX).min(MOST_RECORD_BYTES + 1);
            let (body, next) = behind.split_at_checked(count).ok_or(wrong)?;
            take(opcode, body);
            rest = next;
        }
        Ok(())
    }
}

fn unpacked<'a>(compression: &str, data: Cow<'a, [u8]>) -> Result<Cow<'a, [u8]>, ChunkError> {
    match compression {
        "" => Ok(data),
        "zstd" => {
            let mut decoder = zstd::stream::read::Decoder::with_buffer(&*data).map_err(ChunkError::Unpacking)?;
            decoder.window_log_max(MOST_WINDOW_LOG).map_err(ChunkError::Unpacking)?;
            all_of(decoder).map(Cow::Owned)
        }
        "lz4" => all_of(lz4_flex::frame::FrameDecoder::new(&*data)).map(Cow::Owned),
        other => Err(ChunkError::Compression(other.to_owned())),
    }
}

fn all_of(decoder: impl Read) -> Result<Vec<u8>, ChunkError> {
    let mut bytes = Vec::new();
    let limit = u64::try_from(MOST_UNPACKED_BYTES).unwrap_or(u64::MAX).saturating_add(1);
    decoder.take(limit).read_to_end(&mut bytes).map_err(ChunkError::Unpacking)?;
    if bytes.len() > MOST_UNPACKED_BYTES { Err(ChunkError::TooLarge) } else { Ok(bytes) }
}

/// A checksum of 0 is none.
fn check(header: &ChunkHeader, records: &[u8]) -> Result<(), ChunkError> {
    let (expected, found) = (header.uncompressed_crc, crc32fast::hash(records));
    if expected != 0 && found != expected {
        return Err(ChunkError::Checksum { expected, found });
    }
    if u64::try_from(records.len()) != Ok(header.uncompressed_size) {
        return Err(ChunkError::Size { expected: header.uncompressed_size, found: records.len() });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The body of a chunk that holds `data`, with sizes and checksum of `records`.
    fn body(compression: &str, data: &[u8], records: &[u8]) -> Vec<u8> {
        let (unpacked, packed) = (records.len() as u64, data.len() as u64);
        let name = u32::try_from(compression.len()).unwrap();
        [
            &[0; 16][..],
            &unpacked.to_le_bytes(),
            &crc32fast::hash(records).to_le_bytes(),
            &name.to_le_bytes(),
            compression.as_bytes(),
            &packed.to_le_bytes(),
            data,
        ]
        .concat()
    }

    fn read(body: &[u8]) -> Result<Vec<(u8, Vec<u8>)>, ChunkError> {
        let mut records = Vec::new();
        Chunk::unpack(body)?.for_each(|opcode, body| records.push((opcode, body.to_vec())))?;
        Ok(records)
    }

    /// Two records, with three bytes and with none.
    const RECORDS: [u8; 21] = [5, 3, 0, 0, 0, 0, 0, 0, 0, 7, 8, 9, 0x80, 0, 0, 0, 0, 0, 0, 0, 0];

    #[test]
    fn records_are_read_from_chunks_of_each_compression() {
        let expected = vec![(5, vec![7, 8, 9]), (0x80, vec![])];
        assert_eq!(read(&body("", &RECORDS, &RECORDS)).unwrap(), expected);
        let zstd = zstd::encode_all(&RECORDS[..], 1).unwrap();
        assert_eq!(read(&body("zstd", &zstd, &RECORDS)).unwrap(), expected);
        // `lz4 -l`-independent: an LZ4 frame with one block that is stored, as `lz4 --no-frame-crc` of 21 bytes writes it.
        let lz4 = [&[0x04, 0x22, 0x4D, 0x18, 0x60, 0x40, 0x82, 21, 0, 0, 0x80][..], &RECORDS, &[0; 4]].concat();
        assert_eq!(read(&body("lz4", &lz4, &RECORDS)).unwrap(), expected);
    }

    #[test]
    fn what_is_wrong_with_a_chunk_is_named() {
        let whole = body("", &RECORDS, &RECORDS);
        let message = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut body = whole.clone();
            change(&mut body);
            read(&body).unwrap_err().to_string()
        };
        assert!(message(&|body| body[60] ^= 1).starts_with("chunk: checksum "));
        assert_eq!(message(&|body| body[16] = 200), "chunk: 21 bytes, its header says 200");
        assert!(message(&|body| body[35] = 0x7F).contains("records claims"), "the packed size");
        let unknown = body("zip", &RECORDS, &RECORDS);
        assert!(read(&unknown).unwrap_err().to_string().contains("compression `zip`"));
        let mut record = RECORDS;
        record[8] = 0x10;
        assert!(read(&body("", &record, &record)).unwrap_err().to_string().contains("where 12 are left"));
    }

    /// 65 MiB of zeros are 3 kB as Zstandard packs them.
    #[test]
    fn a_chunk_that_unpacks_to_more_than_the_limit_is_refused() {
        let zeros = std::io::repeat(0).take(65 * 1024 * 1024);
        let bomb = zstd::encode_all(zeros, 1).unwrap();
        assert!(bomb.len() < 10_000);
        assert!(matches!(read(&body("zstd", &bomb, &[])), Err(ChunkError::TooLarge)));
    }
}
