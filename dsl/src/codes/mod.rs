//! What `hierarq explain` says about each code: the form of such a page, and the pages of the family `HQ01xx`.
//!
//! The pages are Markdown, `*.md` beside this file: a heading `# CODE: title`, paragraphs, and examples in fences
//! marked `hq,bad`, `hq,good`, `yaml,bad` and so on. A test compiles every example: a bad one gives the code of its
//! page and no other, a good one compiles without a word.

use std::sync::LazyLock;

/// The pages of this crate, in rising order of their codes.
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

/// What there is to say about a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// The code, such as `HQ0101`.
    pub code: &'static str,
    /// What is wrong, in a few words.
    pub title: &'static str,
    /// Markdown, without the heading.
    pub text: &'static str,
}

/// A piece of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Paragraphs in Markdown.
    Text(&'static str),
    /// What stands in a fence.
    Example {
        /// The language of the example: `hq`, `yaml`, `xml`.
        language: &'static str,
        /// True where it has the mistake that the page is about.
        bad: bool,
        /// True where nothing is to be added to it: it is a whole file, or tries to be.
        alone: bool,
        /// Its text, ending with a line break.
        text: &'static str,
    },
}

impl Page {
    /// The pieces of the page in their order.
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

/// Reads a file of pages.
pub fn read(markdown: &'static str) -> Vec<Page> {
    let heading = |page: &'static str| {
        let (head, text) = page.strip_prefix("# ")?.split_once('\n')?;
        let (code, title) = head.split_once(": ")?;
        Some(Page { code, title, text: text.trim() })
    };
    let starts: Vec<usize> = markdown.match_indices("# HQ").map(|(at, _)| at).collect();
    let starts = starts.into_iter().filter(|at| *at == 0 || markdown[..*at].ends_with('\n'));
    let mut ends: Vec<usize> = starts.collect();
    ends.push(markdown.len());
    ends.windows(2).filter_map(|w| heading(&markdown[w[0]..w[1]])).collect()
}

/// The page of a code of this crate.
pub fn explain(code: &str) -> Option<Page> {
    PAGES.iter().find(|p| p.code == code).copied()
}
