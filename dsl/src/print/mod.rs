//! Printers of both syntaxes: parsing their output produces an equal tree, and printing that again produces the same
//! text.

mod expr;
mod formulas;
mod hq;
mod hq_allowances;
mod hq_levels;
mod hq_machines;
mod hq_missions;
mod hq_reuse;
mod yaml;
mod yaml_allowances;
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

/// Maximum width of a line with several parts, in columns.
const WIDTH: usize = 120;

/// Output text under construction.
struct Lines {
    out: String,
    marker: char,
}

impl Lines {
    /// Creates an empty text. `marker` begins a comment; `/` stands for `//`.
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

    /// Prints whole-line comments.
    fn before(&mut self, lines: &[String], columns: usize) {
        for line in lines {
            if !line.is_empty() {
                self.indent(columns);
                self.comment(line);
            }
            self.out.push('\n');
        }
    }

    /// Ends the line, with the comment after it if there is one.
    fn end(&mut self, behind: &Option<String>) {
        if let Some(text) = behind {
            self.out.push_str("  ");
            self.comment(text);
        }
        self.out.push('\n');
    }

    /// Returns the column of the next character.
    fn column(&self) -> usize {
        let line = self.out.rfind('\n').map_or(0, |n| n + 1);
        self.out[line..].chars().count()
    }
}

/// A line of text with a maximum width; pushing fails beyond it.
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
