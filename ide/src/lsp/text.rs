//! Text of an open document. Converts between bytes, used internally, and lines and UTF-16 units, used by the editor.

use std::ops::Range;

use lsp_types::{Position, Range as LspRange, TextDocumentContentChangeEvent};

/// A text with the start of each line. Lines end with `\n`, `\r\n` or `\r`, as the protocol specifies.
#[derive(Clone, Debug)]
pub(super) struct Text {
    text: String,
    lines: Vec<usize>,
}

impl Text {
    /// Indexes the lines of a text.
    pub fn new(text: String) -> Self {
        let bytes = text.as_bytes();
        let mut lines = vec![0];
        lines.extend((0..bytes.len()).filter_map(|i| match bytes[i] {
            b'\n' => Some(i + 1),
            b'\r' if bytes.get(i + 1) != Some(&b'\n') => Some(i + 1),
            _ => None,
        }));
        Text { text, lines }
    }

    /// Returns the whole text.
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// Position of a byte; a byte past the end or inside a character is moved back to the last valid one.
    pub fn position(&self, byte: usize) -> Position {
        let mut byte = byte.min(self.text.len());
        while !self.text.is_char_boundary(byte) {
            byte -= 1;
        }
        let line = self.lines.partition_point(|&start| start <= byte).saturating_sub(1);
        let units: usize = self.text[self.lines[line]..byte].chars().map(char::len_utf16).sum();
        Position::new(line as u32, units as u32)
    }

    /// Byte of a position; past the end of a line it is the end of the line, past the last line the end of the text.
    pub fn byte(&self, position: Position) -> usize {
        let line = position.line as usize;
        let Some(&start) = self.lines.get(line) else { return self.text.len() };
        let end = self.lines.get(line + 1).copied().unwrap_or(self.text.len());
        let content = self.text[start..end].trim_end_matches(['\n', '\r']);
        let mut units = 0;
        for (at, c) in content.char_indices() {
            units += c.len_utf16();
            if units > position.character as usize {
                return start + at;
            }
        }
        start + content.len()
    }

    /// Converts a range of bytes.
    pub fn range(&self, bytes: Range<usize>) -> LspRange {
        LspRange::new(self.position(bytes.start), self.position(bytes.end))
    }

    /// Applies a change.
    pub fn changed(&self, change: &TextDocumentContentChangeEvent) -> Text {
        let Some(range) = change.range else { return Text::new(change.text.clone()) };
        let start = self.byte(range.start);
        let end = self.byte(range.end).max(start);
        Text::new([&self.text[..start], &change.text, &self.text[end..]].concat())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn units_of_wide_characters() {
        let text = Text::new("aé😀b\r\n\u{feff}z\rend".to_string());
        assert_eq!(text.position(3), Position::new(0, 2));
        assert_eq!(text.position(7), Position::new(0, 4));
        assert_eq!(text.byte(Position::new(0, 3)), 3, "half of a pair is before it");
        assert_eq!(text.byte(Position::new(0, 99)), 8, "not into the line's end");
        assert_eq!(text.position(14), Position::new(1, 2));
        assert_eq!(text.position(15), Position::new(2, 0));
        assert_eq!(text.byte(Position::new(9, 9)), 18);
    }

    proptest! {
        /// Every character boundary is mapped to a position and back, except inside `\r\n`.
        #[test]
        fn there_and_back(text in "(a|é|😀|\n|\r\n|\u{200b}| ){0,40}") {
            let indexed = Text::new(text.clone());
            for (byte, _) in text.char_indices() {
                if !(text[..byte].ends_with('\r') && text[byte..].starts_with('\n')) {
                    prop_assert_eq!(indexed.byte(indexed.position(byte)), byte);
                }
            }
        }

        /// A change of a range is equal to the corresponding change of the whole text.
        #[test]
        fn changes(text in "(a|é|😀|\n| ){0,30}", new in "(b|ü|\n){0,5}", i in 0usize..31, k in 0usize..31) {
            let places: Vec<usize> = text.char_indices().map(|c| c.0).chain([text.len()]).collect();
            let (i, k) = (places[i % places.len()], places[k % places.len()]);
            let (start, end) = (i.min(k), i.max(k));
            let old = Text::new(text.clone());
            let range = Some(old.range(start..end));
            let change = TextDocumentContentChangeEvent { range, range_length: None, text: new.clone() };
            let expected = format!("{}{new}{}", &text[..start], &text[end..]);
            let changed = old.changed(&change);
            prop_assert_eq!(changed.as_str(), expected);
        }
    }
}
