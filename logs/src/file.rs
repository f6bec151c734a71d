//! The file of a log: attachments and metadata first, then messages in chunks that are compressed with LZ4, then the index.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Error, Result, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};

use crate::about::{About, COLUMNS, DEGREES_OF_FREEDOM, END, METADATA, PROGRAM, SOURCE};
use crate::messages::Messages;
use crate::topics::Topic;

/// Name of the program that wrote a file, with its version; `Kind`s of files begin with it.
const LIBRARY: &str = concat!("hierarq ", env!("CARGO_PKG_VERSION"));

/// Channel of a topic, and the number of its messages.
struct Channel {
    id: u16,
    messages: u32,
}

/// A file that grows.
pub struct LogFile<W: Write> {
    writer: Writer<NoSeek<W>>,
    channels: BTreeMap<Topic, Channel>,
    names: BTreeMap<Topic, BTreeMap<String, String>>,
}

fn failed(e: McapError) -> Error {
    match e {
        McapError::Io(e) => e,
        other => Error::other(other),
    }
}

impl<W: Write> LogFile<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// The stream failed.
    pub fn new(out: W, about: &About, messages: &Messages) -> Result<LogFile<W>> {
        let options = WriteOptions::new().compression(Some(Compression::Lz4)).profile("ros2").library(LIBRARY);
        let mut writer = options.disable_seeking(true).create(NoSeek::new(out)).map_err(failed)?;
        let text = about.program_text().map_err(Error::other)?;
        let sources = about.sources.iter().map(|s| (format!("{SOURCE}{}", s.name), "text/plain", s.text.as_bytes()));
        let program = (PROGRAM.to_string(), "application/json", text.as_bytes());
        for (name, media_type, data) in [program].into_iter().chain(sources) {
            let data = Cow::Borrowed(data);
            let attachment = Attachment { log_time: 0, create_time: 0, name, media_type: media_type.to_string(), data };
            writer.attach(&attachment).map_err(failed)?;
        }
        let metadata = Metadata { name: METADATA.to_string(), metadata: about.metadata(&text) };
        writer.write_metadata(&metadata).map_err(failed)?;
        let named = |key: &str, names: &[String]| {
            BTreeMap::from([(key.to_string(), serde_json::Value::from(names).to_string())])
        };
        let names = BTreeMap::from([
            (Topic::Columns, named(COLUMNS, messages.columns())),
            (Topic::Command, named(DEGREES_OF_FREEDOM, messages.command())),
        ]);
        Ok(LogFile { writer, channels: BTreeMap::new(), names })
    }

    /// Writes a message at a time in ns.
    ///
    /// # Errors
    /// The stream failed.
    pub fn write(&mut self, topic: Topic, time: u64, message: &[u8]) -> Result<()> {
        if !self.channels.contains_key(&topic) {
            let channel = self.declare(topic)?;
            self.channels.insert(topic, channel);
        }
        let Some(channel) = self.channels.get_mut(&topic) else { return Ok(()) };
        let header =
            MessageHeader { channel_id: channel.id, sequence: channel.messages, log_time: time, publish_time: time };
        channel.messages += 1;
        self.writer.write_to_known_channel(&header, message).map_err(failed)
    }

    fn declare(&mut self, topic: Topic) -> Result<Channel> {
        let definition = topic.definition();
        let text = definition.text();
        let schema = self.writer.add_schema(&definition.schema_name(), "ros2msg", text.as_bytes()).map_err(failed)?;
        let mut metadata = self.names.remove(&topic).unwrap_or_default();
        metadata.insert("offered_qos_profiles".to_string(), topic.quality_of_service());
        let id = self.writer.add_channel(schema, topic.name(), "cdr", &metadata).map_err(failed)?;
        Ok(Channel { id, messages: 0 })
    }

    /// Ends the file, after so many ticks of which some were left out, and returns the stream.
    ///
    /// # Errors
    /// The stream failed.
    pub fn finish(mut self, ticks: usize, dropped: u64) -> Result<W> {
        let numbers = [("ticks", ticks.to_string()), ("dropped", dropped.to_string())];
        let metadata = numbers.into_iter().map(|(key, x)| (key.to_string(), x)).collect();
        self.writer.write_metadata(&Metadata { name: END.to_string(), metadata }).map_err(failed)?;
        self.writer.finish().map_err(failed)?;
        Ok(self.writer.into_inner().into_inner())
    }
}
