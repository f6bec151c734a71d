//! Printers of both spellings: a tree that was read from what they write compares equal, and printing it again
//! gives the same text.

mod expr;
mod formulas;
mod hq;
mod hq_levels;
mod hq_machines;
mod hq_missions;
mod hq_reuse;
mod yaml;
mod yaml_levels;
mod yaml_machines;
mod yaml_missions;
mod yaml_reuse;

pub(crate) use expr::text as expression;
pub(crate) use formulas::{text as formula, trigger_text};
pub(crate) use hq::print as hq;
pub(crate) use yaml::print as yaml;

use crate::tree::Comments;
use crate::words::has_block;

/// Columns that a line with several parts may have.
const WIDTH: usize = 120;

/// Lines under construction.
struct Lines {
    out: String,
    marker: char,
}

impl Lines {
    /// `marker` begins a comment; `/` stands for `//`.
    fn new(marker: char) -> Self {
        Lines { out: String::new(), marker }
    }

    fn indent(&mut self, columns: usize) {
        self.out.extend(std::iter::repeat_n(' ', columns));
    }

    fn comment(&mut self, text: &str) {
        if self.marker == '/' {
            self.out.push_str("//");
        } else {
            self.out.push('#');
        }
        if !text.is_empty() && !text.starts_with(self.marker) {
            self.out.push(' ');
        }
        self.out.push_str(text);
    }

    /// Whole-line comments.
    fn before(&mut self, lines: &[String], columns: usize) {
        for line in lines {
            if !line.is_empty() {
                self.indent(columns);
                self.comment(line);
            }
            self.out.push('\n');
        }
    }

    /// Ends the line, with the comment behind it if there is one.
    fn end(&mut self, behind: &Option<String>) {
        if let Some(text) = behind {
            self.out.push_str("  ");
            self.comment(text);
        }
        self.out.push('\n');
    }

    /// The column at which the next character will stand.
    fn column(&self) -> usize {
        let line = self.out.rfind('\n').map_or(0, |n| n + 1);
        self.out[line..].chars().count()
    }
}

/// One line of text that gives up when it grows beyond the width.
struct OneLine {
    text: String,
    limit: usize,
}

impl OneLine {
    fn new(limit: usize) -> Self {
        OneLine { text: String::new(), limit }
    }

    fn push(&mut self, text: &str) -> Option<()> {
        self.text.push_str(text);
        (self.text.len() <= self.limit).then_some(())
    }
}

fn no_comments(comments: &Comments) -> bool {
    crate::comments::is_empty(comments)
}
