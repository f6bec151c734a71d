//! Extracts the lines of a text that a message shows, so that the cost of drawing is independent of the text's length.

use std::ops::Range;

use dsl::SourceText;
use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use crate::diagnostics::report::colourless;

/// Number of lines shown before and after the marked ones, plus one with which the renderer detects the end of a line.
const AROUND: usize = 3;

/// Some lines of a text, with their position in it.
pub(crate) struct Window {
    /// The lines.
    pub text: String,
    name: String,
    /// Number of bytes and lines of the text before them.
    bytes: usize,
    lines: usize,
}

impl Window {
    /// Extracts the lines around some byte ranges of a text.
    pub fn around(source: &SourceText, places: impl Iterator<Item = Range<usize>>) -> Window {
        let text = source.text.as_str();
        let (mut start, mut end) = (text.len(), 0);
        for place in places {
            start = start.min(place.start);
            end = end.max(place.end).min(text.len());
        }
        let mut end = end.max(start);
        for _ in 0..AROUND {
            start = text.as_bytes()[..start].iter().rposition(|b| *b == b'\n').unwrap_or(0);
            end = text.as_bytes()[end..].iter().position(|b| *b == b'\n').map_or(text.len(), |n| end + n + 1);
        }
        if start > 0 {
            start += 1;
        }
        let lines = text.as_bytes()[..start].iter().filter(|b| **b == b'\n').count();
        let shown = text.get(start..end).unwrap_or("");
        Window { text: colourless(shown), name: colourless(&source.name), bytes: start, lines }
    }
}

impl SourceCode for Window {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let offset = span.offset().checked_sub(self.bytes).ok_or(MietteError::OutOfBounds)?;
        let inner = self.text.read_span(&SourceSpan::new(offset.into(), span.len()), before, after)?;
        let at = SourceSpan::new((inner.span().offset() + self.bytes).into(), inner.span().len());
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            inner.data(),
            at,
            inner.line() + self.lines,
            inner.column(),
            inner.line_count(),
        )))
    }
}
