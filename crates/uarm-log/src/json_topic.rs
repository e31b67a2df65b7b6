//! A file of one topic with JSON messages: what is recorded beside runs, such as a simulated plant's truth.

use std::io::{BufWriter, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapResult, WriteOptions, Writer};

use crate::description::Fields;
use crate::topic::LIBRARY;

/// What a topic is.
#[derive(Clone, Copy, Debug)]
pub struct JsonTopic {
    /// Its name, such as `/truth`.
    pub name: &'static str,
    /// The name of its messages' type.
    pub schema_name: &'static str,
    /// Their JSON schema.
    pub schema: &'static str,
}

/// Writes the file.
pub struct JsonTopicWriter<W: Write> {
    writer: Writer<NoSeek<BufWriter<W>>>,
    channel: u16,
}

impl<W: Write> JsonTopicWriter<W> {
    /// Begins a file; `output` may be a pipe.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(output: W, topic: &JsonTopic) -> McapResult<Self> {
        let library = format!("{LIBRARY}{}", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().profile("").library(library).disable_seeking(true);
        let mut writer = options.create(NoSeek::new(BufWriter::new(output)))?;
        let schema = writer.add_schema(topic.schema_name, "jsonschema", topic.schema.as_bytes())?;
        let channel = writer.add_channel(schema, topic.name, "json", &Fields::new())?;
        Ok(Self { writer, channel })
    }

    /// Writes a message, at a time in ns since 1970-01-01 UTC.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, at_ns: u64, json: &[u8]) -> McapResult<()> {
        let header = MessageHeader { channel_id: self.channel, sequence: 0, log_time: at_ns, publish_time: at_ns };
        self.writer.write_to_known_channel(&header, json)
    }

    /// Writes what is in hand: what comes after it a killed process may lose.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn flush(&mut self) -> McapResult<()> {
        self.writer.flush()
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> McapResult<()> {
        self.writer.finish().map(|_| ())
    }
}
