//! Reads lines of a stream, each of at most [`MAX_LINE`] bytes.

use std::io::{BufRead, Read, Result};

use super::MAX_LINE;

/// A line without its line break.
#[derive(Debug, PartialEq, Eq)]
pub enum Line<'a> {
    /// Contents of the line.
    Bytes(&'a [u8]),
    /// The line is longer than [`MAX_LINE`] and was skipped.
    TooLong,
}

/// Reads a stream line by line into one buffer.
pub struct Lines<R> {
    input: R,
    buffer: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Lines<R> {
    /// Creates a reader of a stream.
    pub fn new(input: R) -> Lines<R> {
        Lines { input, buffer: Vec::new(), number: 0 }
    }

    /// Returns the next line with its number, counted from 1; `None` at the end.
    ///
    /// # Errors
    /// The stream cannot be read.
    pub fn read(&mut self) -> Result<Option<(u64, Line<'_>)>> {
        self.buffer.clear();
        self.input.by_ref().take(MAX_LINE as u64 + 1).read_until(b'\n', &mut self.buffer)?;
        if self.buffer.is_empty() {
            return Ok(None);
        }
        self.number += 1;
        if self.buffer.last() == Some(&b'\n') {
            self.buffer.pop();
        } else if self.buffer.len() > MAX_LINE {
            self.skip()?;
            return Ok(Some((self.number, Line::TooLong)));
        }
        Ok(Some((self.number, Line::Bytes(&self.buffer))))
    }

    /// Skips the rest of the line.
    fn skip(&mut self) -> Result<()> {
        loop {
            let rest = self.input.fill_buf()?;
            let end = rest.iter().position(|b| *b == b'\n');
            let (used, over) = (end.map_or(rest.len(), |i| i + 1), end.is_some() || rest.is_empty());
            self.input.consume(used);
            if over {
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_skipped_and_the_rest_is_read() {
        let mut text = b"one\n\n".to_vec();
        text.extend(vec![b'x'; MAX_LINE]);
        text.push(b'\n');
        text.extend(vec![b'y'; MAX_LINE + 1]);
        text.extend(b"\nlast");
        let mut lines = Lines::new(&text[..]);
        assert_eq!(lines.read().expect("read"), Some((1, Line::Bytes(b"one"))));
        assert_eq!(lines.read().expect("read"), Some((2, Line::Bytes(b""))));
        assert!(matches!(lines.read().expect("read"), Some((3, Line::Bytes(b))) if b.len() == MAX_LINE));
        assert_eq!(lines.read().expect("read"), Some((4, Line::TooLong)));
        assert_eq!(lines.read().expect("read"), Some((5, Line::Bytes(b"last"))));
        assert_eq!(lines.read().expect("read"), None);
    }
}
