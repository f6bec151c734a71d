//! Cells of comma-separated values, as RFC 4180 has them.

use std::borrow::Cow;

/// A text as a cell: in quotes, which double inside, where a comma, a quote or an end of line would break the line apart,
/// or a space at its border would be lost.
pub fn cell(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        return format!("\"{}\"", text.replace('"', "\"\"")).into();
    }
    text.into()
}
