//! Transfer of comments from the text to the tree: readers take them from a pool in the order of the text.

use crate::tree::Comments;

/// A comment in the text.
#[derive(Clone, Debug)]
pub(crate) struct Comment {
    /// First byte of the marker.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
    /// True if only white space precedes it on its line.
    pub whole_line: bool,
    /// Its text without the marker.
    pub text: String,
}

impl Comment {
    /// Creates a comment from the text after the marker.
    pub fn new(start: usize, end: usize, whole_line: bool, text: &str) -> Self {
        let text = text.strip_prefix(' ').unwrap_or(text).trim_end();
        let text = text.chars().map(|c| if c.is_control() || c == '\u{feff}' { ' ' } else { c }).collect::<String>();
        let text = text.trim_end().to_owned();
        Comment { start, end, whole_line, text }
    }
}

/// The comments of a text; each is taken once.
#[derive(Debug)]
pub(crate) struct Pool<'t> {
    text: &'t str,
    comments: Vec<Comment>,
    next: usize,
    /// End of the last taken comment.
    taken: usize,
}

impl<'t> Pool<'t> {
    /// Creates a pool of comments in the order of the text.
    pub fn new(text: &'t str, comments: Vec<Comment>) -> Self {
        Pool { text, comments, next: 0, taken: 0 }
    }

    fn peek(&self) -> Option<&Comment> {
        self.comments.get(self.next)
    }

    /// Adds all comments that begin before byte `end` to `lines`.
    pub fn before(&mut self, end: usize, lines: &mut Vec<String>) {
        let mut last_end = None;
        while let Some(comment) = self.peek().filter(|c| c.start < end).cloned() {
            self.push(comment, &mut last_end, lines);
        }
        tidy(lines);
    }

    fn push(&mut self, comment: Comment, last_end: &mut Option<usize>, lines: &mut Vec<String>) {
        let gap = last_end.and_then(|from| self.text.get(from..comment.start)).unwrap_or("");
        if gap.bytes().filter(|&b| b == b'\n').count() > 1 {
            lines.push(String::new());
        }
        *last_end = Some(comment.end);
        self.taken = comment.end;
        lines.push(comment.text);
        self.next += 1;
    }

    /// Takes the comment after byte `from` on the same line, if only white space and `between` are in the gap.
    pub fn behind(&mut self, from: usize, between: &[char], slot: &mut Option<String>) {
        if slot.is_some() {
            return;
        }
        let Some(comment) = self.peek().filter(|c| c.start >= from) else { return };
        let Some(gap) = self.text.get(from..comment.start) else { return };
        if gap.len() < 200 && gap.chars().all(|c| matches!(c, ' ' | '\t') || between.contains(&c)) {
            *slot = Some(comment.text.clone()).filter(|t| !t.is_empty());
            self.taken = comment.end;
            self.next += 1;
        }
    }

    /// Takes the whole-line comments that directly follow byte `from`, at least `column` bytes from the start of their
    /// line. (In YAML no closing brace ends a block.)
    pub fn indented(&mut self, from: usize, column: usize, lines: &mut Vec<String>) {
        let (mut from, mut last_end) = (from.max(self.taken), None);
        while let Some(comment) = self.peek().cloned() {
            let gap_blank = self.text.get(from..comment.start).is_some_and(|gap| gap.trim().is_empty());
            let line = self.text[..comment.start].rfind('\n').map_or(0, |n| n + 1);
            if !gap_blank || !comment.whole_line || comment.start - line < column {
                break;
            }
            from = comment.end;
            self.push(comment, &mut last_end, lines);
        }
        tidy(lines);
    }
}

/// Removes empty comments at the ends, and duplicate ones.
fn tidy(lines: &mut Vec<String>) {
    lines.dedup_by(|a, b| a.is_empty() && b.is_empty());
    if lines.first().is_some_and(String::is_empty) {
        lines.remove(0);
    }
    if lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
}

/// Returns true if there are no comments to print.
pub(crate) fn is_empty(comments: &Comments) -> bool {
    comments.before.is_empty() && comments.behind.is_none()
}
