//! Logs that Hierarq wrote, read again: the program with its hash, and the messages in order.

use std::collections::BTreeMap;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, Message, MessageStream};
use runtime::Program;
use runtime::program::{CompiledFile, ScenarioProgram};

use crate::about::{END, METADATA, Origin, PROGRAM, VERSION, sha256};

/// Reason why a log cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file is something else.
    #[error("it is no log in MCAP")]
    NotMcap,
    /// The end is missing.
    #[error("it is cut off: the end of a log in MCAP is missing, as after a run that was killed")]
    Truncated,
    /// A record cannot be read.
    #[error("it is damaged: {0}")]
    Damaged(McapError),
    /// Somebody else's log.
    #[error("it is a log of another program: it has no metadata `{METADATA}`, so nothing says what ran")]
    Foreign,
    /// The contents are those of another version.
    #[error("its contents have version {0}, and this build of Hierarq reads version {VERSION}")]
    Version(String),
    /// The program is missing.
    #[error("it has no attachment `{PROGRAM}`, so there is no program to run again")]
    NoProgram,
    /// The program is not the one that the hash says.
    #[error("its attachment `{PROGRAM}` is not the one that ran: its SHA-256 is another one")]
    Hash,
    /// The program cannot be run.
    #[error("its attachment `{PROGRAM}` cannot be used: {0}")]
    Program(String),
    /// Ticks are missing.
    #[error("{0} of its ticks were dropped when it was written, and only a complete log can be compared")]
    Dropped(u64),
}

impl From<McapError> for LogError {
    fn from(e: McapError) -> LogError {
        match e {
            McapError::BadMagic => LogError::NotMcap,
            McapError::UnexpectedEof | McapError::BadFooter | McapError::UnexpectedEoc => LogError::Truncated,
            other => LogError::Damaged(other),
        }
    }
}

/// Longest record of a log that is shorter than this itself (bytes).
const LONGEST: usize = 64 << 20;

/// Checks the lengths of all records and the checksums of all chunks: a damaged length would have the library ask for any amount of
/// memory.
fn sound(bytes: &[u8]) -> Result<(), LogError> {
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(bytes.len().max(LONGEST));
    let mut reader = LinearReader::new_with_options(options);
    let mut left = bytes;
    while let Some(event) = reader.next_event() {
        if let LinearReadEvent::ReadRequest(wanted) = event? {
            let (read, rest) = left.split_at(wanted.min(left.len()));
            reader.insert(read.len()).copy_from_slice(read);
            reader.notify_read(read.len());
            left = rest;
        }
    }
    Ok(())
}

/// A log.
pub struct Log<'b> {
    bytes: &'b [u8],
    /// The program that ran.
    pub program: Program,
    /// True if the run was that of the only scenario of the program.
    pub in_scenario: bool,
    /// Source of the numbers.
    pub origin: Origin,
    /// Number of ticks.
    pub ticks: usize,
    /// Number of ticks that were dropped.
    pub dropped: u64,
    /// Version of Hierarq that wrote it.
    pub hierarq: String,
}

impl<'b> Log<'b> {
    /// Reads what a log says of its run.
    ///
    /// # Errors
    /// The bytes are no complete log of this version.
    pub fn read(bytes: &'b [u8]) -> Result<Log<'b>, LogError> {
        if !bytes.starts_with(MAGIC) {
            return Err(LogError::NotMcap);
        }
        if bytes.len() < 2 * MAGIC.len() || !bytes.ends_with(MAGIC) {
            return Err(LogError::Truncated);
        }
        sound(bytes)?;
        let mut metadata: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        let mut program = None;
        for record in mcap::read::LinearReader::new(bytes)? {
            match record? {
                Record::Metadata(m) => {
                    metadata.insert(m.name, m.metadata);
                }
                Record::Attachment { header, data, .. } if header.name == PROGRAM => program = Some(data.into_owned()),
                _ => {}
            }
        }
        let about = metadata.remove(METADATA).ok_or(LogError::Foreign)?;
        let word = |key: &str| about.get(key).map(String::as_str).unwrap_or_default();
        if word("version") != VERSION {
            return Err(LogError::Version(word("version").to_string()));
        }
        let text = program.ok_or(LogError::NoProgram)?;
        if sha256(&text) != word("program_sha256") {
            return Err(LogError::Hash);
        }
        let text = String::from_utf8(text).map_err(|_| LogError::Program("it is not UTF-8 text".to_string()))?;
        let file = CompiledFile::read(&text).map_err(LogError::Program)?;
        let program = file.program.ok_or_else(|| LogError::Program("it declares no robot".to_string()))?;
        let in_scenario = about.contains_key("scenario");
        if in_scenario && program.scenarios.is_empty() {
            return Err(LogError::Program("its scenario is missing".to_string()));
        }
        let end = metadata.remove(END).ok_or(LogError::Truncated)?;
        let number = |key: &str| end.get(key).and_then(|text| text.parse::<u64>().ok()).ok_or(LogError::Truncated);
        Ok(Log {
            bytes,
            in_scenario,
            origin: if word("origin") == Origin::Csv.word() { Origin::Csv } else { Origin::Run },
            ticks: number("ticks")? as usize,
            dropped: number("dropped")?,
            hierarq: word("hierarq").to_string(),
            program,
        })
    }

    /// The scenario of the run, if it was one.
    pub fn scenario(&self) -> Option<&ScenarioProgram> {
        self.program.scenarios.first().filter(|_| self.in_scenario)
    }

    /// The messages, in the order in which they were written.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn messages(&self) -> Result<impl Iterator<Item = Result<Message<'b>, LogError>>, LogError> {
        Ok(MessageStream::new(self.bytes)?.map(|message| message.map_err(LogError::from)))
    }
}
