//! The records of an MCAP file, as far as they are there.

use std::io::{self, Read};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// The first bytes of every MCAP file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// The longest record that is believed, in bytes: a log's chunks and attachments have about one million.
const LONGEST_RECORD: usize = 64 * 1024 * 1024;

/// Reads records, chunks as a whole, from a file that may end anywhere, or still grow.
pub struct Records<R> {
    input: R,
    reader: LinearReader,
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
    /// Bytes that are not MCAP; nothing after them can be found.
    Broken(McapError),
}

impl<R: Read> Records<R> {
    /// Reads from `input`.
    pub fn new(input: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_record_length_limit(LONGEST_RECORD)
            .with_validate_data_section_crc(true);
        Self { input, reader: LinearReader::new_with_options(options) }
    }
}

/// Reads the records in a chunk, which is given as its whole body. The chunk's length and checksum are compared before
/// the first record is given: a wrong byte in it could make a record of any length, and more memory than there is.
pub fn in_chunk(body: &[u8]) -> Records<impl Read> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_record_length_limit(LONGEST_RECORD)
        .with_prevalidate_chunk_crcs(true);
    let length = u64::try_from(body.len()).unwrap_or(u64::MAX).to_le_bytes();
    let input = io::Cursor::new([op::CHUNK]).chain(io::Cursor::new(length)).chain(body);
    Records { input, reader: LinearReader::new_with_options(options) }
}

impl<R: Read> Records<R> {
    /// Reads on; gives the opcode and the body of a record to `take`.
    ///
    /// # Errors
    /// If the input cannot be read.
    pub fn step(&mut self, take: impl FnOnce(u8, &[u8])) -> io::Result<Step> {
        loop {
            match self.reader.next_event() {
                None => return Ok(Step::End),
                Some(Err(error)) => return Ok(Step::Broken(error)),
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    take(opcode, data);
                    return Ok(Step::Record);
                }
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                    let read = self.input.read(self.reader.insert(wanted))?;
                    if read == 0 {
                        return Ok(Step::Starved);
                    }
                    self.reader.notify_read(read);
                }
            }
        }
    }
}
