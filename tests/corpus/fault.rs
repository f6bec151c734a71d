//! A seeded fault: an example spoilt in one place, and what is to be said of it.

use std::ops::Range;

/// A spoilt example and the diagnostic that it must give.
pub struct Fault {
    /// What kind of mistake it is; the table of the book has a row for each.
    pub class: String,
    /// File and line of the corpus that seeded it.
    pub origin: String,
    /// The example, `hello.hq` for instance.
    pub file: String,
    /// Its text, spoilt.
    pub text: String,
    /// The bytes that the primary place must be, both ends.
    pub place: Range<usize>,
    /// Codes of which one must be given.
    pub codes: Vec<String>,
    /// A warning is what should come, and not an error.
    pub warning: bool,
}

impl Fault {
    /// A fault; `codes` are separated by `/`, and begin with `warn ` where the spec is to be accepted with a warning.
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

/// All examples, in a fixed order.
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

/// Where the comment of a line begins; the length of the line where it has none.
pub fn comment(line: &str, file: &str) -> usize {
    let sign = if file.ends_with(".hq") { "//" } else { "# " };
    line.find(sign).unwrap_or(line.len())
}
