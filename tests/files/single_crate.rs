//! Files are read and written in one crate, so that every reader and writer has its bounds and checks.

use crate::common::sources;

/// Calls that open, write or move a file without that crate.
const CALLS: [&str; 12] = [
    "fs::write(",
    "fs::read(",
    "fs::read_to_string(",
    "fs::rename(",
    "fs::copy(",
    "fs::remove_file(",
    "fs::hard_link(",
    "File::open(",
    "File::create(",
    "File::create_new(",
    "File::options(",
    "OpenOptions",
];

#[test]
fn files_are_read_and_written_in_one_place() {
    let all = sources::of_crates(|name| name != "files");
    assert!(all.len() > 300, "{} files", all.len());
    let mut found = Vec::new();
    for path in all {
        // Tests of a crate are exempt; they are in a file of tests, or at the end of a file.
        if path.components().any(|c| c.as_os_str() == "tests") || path.file_name().is_some_and(|n| n == "tests.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("readable");
        let tests = ["#[cfg(test)]\nmod ", "#[cfg(test)]\npub(super) mod "].map(|m| text.find(m).unwrap_or(text.len()));
        let own = &text[..tests[0].min(tests[1])];
        let code = own.lines().filter(|line| !line.trim_start().starts_with("//"));
        for line in code.filter(|line| CALLS.iter().any(|call| line.contains(call))) {
            found.push(format!("{}: {}", path.display(), line.trim()));
        }
    }
    assert!(found.is_empty(), "use the crate in `files/`:\n{}", found.join("\n"));
}
