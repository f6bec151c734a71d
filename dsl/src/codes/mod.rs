//! Explanations of diagnostic codes for `hierarq explain`: the format of the pages, and the pages of the family
//! `HQ01xx`.
//!
//! The pages are Markdown, `*.md` beside this file: a heading `# CODE: title`, `# CODE (warning): title` if it can be a warning, paragraphs, and examples in fences
//! marked `hq,bad`, `hq,good`, `yaml,bad` and so on. A test compiles every example: a bad one must produce the code of
//! its page and no other, a good one must produce no diagnostics.

use std::sync::LazyLock;

/// The pages of this crate, in ascending order of their codes.
pub static PAGES: LazyLock<Vec<Page>> = LazyLock::new(|| {
    [
        include_str!("form.md"),
        include_str!("yaml.md"),
        include_str!("machines.md"),
        include_str!("missions.md"),
        include_str!("bounds.md"),
    ]
    .into_iter()
    .flat_map(read)
    .collect()
});

/// Explanation of a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// The code, such as `HQ0101`.
    pub code: &'static str,
    /// Short description of the error.
    pub title: &'static str,
    /// True if it can be a warning, which a spec may allow.
    pub warning: bool,
    /// Markdown, without the heading.
    pub text: &'static str,
}

/// A part of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Paragraphs in Markdown.
    Text(&'static str),
    /// Content of a fence.
    Example {
        /// The language of the example: `hq`, `yaml`, `xml` for a URDF, `srdf`.
        language: &'static str,
        /// True if it contains the error of the page.
        bad: bool,
        /// True if it is a complete file, or tries to be: nothing has to be added to it.
        alone: bool,
        /// Its text, ending with a line break.
        text: &'static str,
    },
}

impl Page {
    /// Splits the page into its parts.
    pub fn parts(&self) -> Vec<Part> {
        let mut out = Vec::new();
        for (i, piece) in self.text.split("```").enumerate() {
            if i % 2 == 0 {
                if !piece.trim().is_empty() {
                    out.push(Part::Text(piece.trim()));
                }
            } else if let Some((marks, text)) = piece.split_once('\n') {
                let has = |word: &str| marks.split(',').any(|m| m == word);
                let language = marks.split(',').next().unwrap_or("");
                out.push(Part::Example { language, bad: has("bad"), alone: has("alone"), text });
            }
        }
        out
    }
}

/// Parses a file of pages.
pub fn read(markdown: &'static str) -> Vec<Page> {
    let heading = |page: &'static str| {
        let (head, text) = page.strip_prefix("# ")?.split_once('\n')?;
        let (code, title) = head.split_once(": ")?;
        let (code, warning) = code.strip_suffix(" (warning)").map_or((code, false), |code| (code, true));
        Some(Page { code, title, warning, text: text.trim() })
    };
    let starts: Vec<usize> = markdown.match_indices("# HQ").map(|(at, _)| at).collect();
    let starts = starts.into_iter().filter(|at| *at == 0 || markdown[..*at].ends_with('\n'));
    let mut ends: Vec<usize> = starts.collect();
    ends.push(markdown.len());
    ends.windows(2).filter_map(|w| heading(&markdown[w[0]..w[1]])).collect()
}

/// Returns the page of a code of this crate.
pub fn explain(code: &str) -> Option<Page> {
    PAGES.iter().find(|p| p.code == code).copied()
}
