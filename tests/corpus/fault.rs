//! A seeded fault: an example with one inserted mistake, and the expected diagnostic.

use std::ops::Range;

/// An example with a mistake, and the diagnostic that it must cause.
pub struct Fault {
    /// Kind of mistake; the table of the book has a row for each.
    pub class: String,
    /// File and line of the corpus that seeded it.
    pub origin: String,
    /// Name of the example, for instance `hello.hq`.
    pub file: String,
    /// Its text with the mistake.
    pub text: String,
    /// Expected primary span (bytes).
    pub place: Range<usize>,
    /// Accepted codes.
    pub codes: Vec<String>,
    /// True if a warning is expected, and not an error.
    pub warning: bool,
}

impl Fault {
    /// Creates a fault; `codes` are separated by `/`, and begin with `warn ` if the spec must be accepted with a
    /// warning.
    pub fn new(class: &str, origin: &str, file: &str, text: &str, place: Range<usize>, codes: &str) -> Fault {
        let (warning, codes) = codes.strip_prefix("warn ").map_or((false, codes), |c| (true, c));
        Fault {
            class: class.to_string(),
            origin: origin.to_string(),
            file: file.to_string(),
            text: text.to_string(),
            place,
            codes: codes.split('/').map(|c| c.trim().to_string()).collect(),
            warning,
        }
    }
}

/// Returns all examples, in a fixed order.
pub fn files() -> Vec<String> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/specs");
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let mut names: Vec<String> = entries
        .filter_map(|e| e.expect("readable").file_name().into_string().ok())
        .filter(|n| n.ends_with(".hq") || n.ends_with(".yaml"))
        .collect();
    names.sort();
    names
}

/// Returns the start of the comment of a line, or the length of a line without one.
pub fn comment(line: &str, file: &str) -> usize {
    let sign = if file.ends_with(".hq") { "//" } else { "# " };
    line.find(sign).unwrap_or(line.len())
}
