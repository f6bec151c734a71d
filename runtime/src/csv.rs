//! Cells of comma-separated values (RFC 4180).

use std::borrow::Cow;

/// Formats a text as a cell. The cell is quoted, with inner quotes doubled, if the text contains a comma, a quote or an
/// end of line, or begins or ends with white space.
pub fn cell(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        return format!("\"{}\"", text.replace('"', "\"\"")).into();
    }
    text.into()
}
