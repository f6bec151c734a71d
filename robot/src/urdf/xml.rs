//! XML parsing, with the checks that come before the robot is read.

use std::ops::Range;

use roxmltree::{Document, Error, ParsingOptions, TextPos};

use super::{UrdfCode, UrdfMessage};
use crate::markup::{MAX_ATTRIBUTES, crowded};

/// Maximum length of the text \[bytes\].
const MAX_BYTES: usize = 64 << 20;
/// Maximum number of XML nodes; bounds the memory that a hostile file can use.
const MAX_NODES: u32 = 4_000_000;

/// Parses the text as XML. Document type definitions are rejected, so that there are no entities to expand.
pub(crate) fn parse(text: &str) -> Result<Document<'_>, UrdfMessage> {
    if text.len() > MAX_BYTES {
        let what = format!("the file has {} MiB, at most 64 are read", text.len() >> 20);
        return Err(UrdfMessage::new(UrdfCode::TooLarge, 0..0, what));
    }
    if let Some(element) = crowded(text) {
        let what = format!("an element has more than {MAX_ATTRIBUTES} attributes");
        return Err(UrdfMessage::new(UrdfCode::TooLarge, element, what));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|e| explain(text, &e))
}

fn explain(text: &str, error: &Error) -> UrdfMessage {
    let at = |start: usize| start..end_of_char(text, start);
    match error {
        Error::DtdDetected => {
            let start = text.find("<!DOCTYPE").unwrap_or(0);
            let span = start..(start + "<!DOCTYPE".len()).min(text.len());
            let what = "document type definitions are not read";
            UrdfMessage::new(UrdfCode::BrokenXml, span, what)
                .help("remove `<!DOCTYPE ...>`, and write out the entities it defines")
        }
        Error::NodesLimitReached | Error::AttributesLimitReached => {
            UrdfMessage::new(UrdfCode::TooLarge, 0..0, format!("the file has more than {MAX_NODES} XML nodes"))
        }
        Error::NoRootNode => UrdfMessage::new(UrdfCode::BrokenXml, at(text.len()), "there is no element in the file"),
        Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
            UrdfMessage::new(UrdfCode::BrokenXml, at(text.len()), "the file ends inside an element")
        }
        other => {
            let full = other.to_string();
            let what = full.rfind(" at ").map_or(full.as_str(), |i| &full[..i]);
            UrdfMessage::new(UrdfCode::BrokenXml, at(offset(text, other.pos())), format!("broken XML: {what}"))
        }
    }
}

/// Returns the byte offset of a line and column (columns count characters).
fn offset(text: &str, pos: TextPos) -> usize {
    let mut line_start = 0;
    for _ in 1..pos.row {
        match text[line_start..].find('\n') {
            Some(i) => line_start += i + 1,
            None => return text.len(),
        }
    }
    text[line_start..]
        .char_indices()
        .nth(pos.col.saturating_sub(1) as usize)
        .map_or(text.len(), |(i, _)| line_start + i)
}

fn end_of_char(text: &str, start: usize) -> usize {
    text[start..].chars().next().map_or(start, |c| start + c.len_utf8())
}

/// Returns the opening tag, cut to its first line, as the location of messages about a whole file.
pub(crate) fn first_line(text: &str, span: Range<usize>) -> Range<usize> {
    let end = text[span.clone()].find('\n').map_or(span.end, |i| span.start + i);
    span.start..end
}
