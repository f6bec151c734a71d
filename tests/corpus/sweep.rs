//! Generates faults mechanically: a word is misspelt at each of its occurrences in the examples.
//!
//! The same misspelling in an equal line of another example counts once. Comments are not changed.

use std::collections::BTreeSet;

use super::fault::{Fault, comment, files};

/// An occurrence of a pattern in an example.
struct Place {
    file: String,
    text: String,
    /// The marked part of the pattern, in bytes of the text.
    at: std::ops::Range<usize>,
}

/// Returns all occurrences of a pattern `before«word»after` in the examples of a syntax; those in equal lines once.
fn places(syntax: &str, pattern: &str, origin: &str) -> Vec<Place> {
    let marked = pattern.split_once('«').and_then(|(b, r)| Some((b, r.split_once('»')?)));
    let (before, (word, after)) = marked.unwrap_or_else(|| panic!("{origin}: `{pattern}` has no `«word»`"));
    let literal = format!("{before}{word}{after}");
    let (mut seen, mut all) = (BTreeSet::new(), Vec::new());
    for file in files().into_iter().filter(|f| f.ends_with(syntax)) {
        let text = super::text_of(&format!("tests/corpus/specs/{file}"));
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            for (i, _) in line[..comment(line, &file)].match_indices(&literal) {
                let at = start + i + before.len()..start + i + before.len() + word.len();
                let inner = |b: Option<&u8>| b.is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_');
                let bytes = text.as_bytes();
                let before = at.start.checked_sub(1).and_then(|i| bytes.get(i));
                let grown = |a: Option<&u8>, b: Option<&u8>| inner(a) && inner(b);
                let whole = !grown(before, bytes.get(at.start)) && !grown(bytes.get(at.end - 1), bytes.get(at.end));
                if whole && seen.insert((line.to_string(), i)) {
                    all.push(Place { file: file.clone(), text: text.clone(), at });
                }
            }
            start += line.len();
        }
    }
    assert!(!all.is_empty(), "{origin}: no example has `{literal}`");
    all
}

/// Returns the rows of a table: class, origin, columns.
fn rows(path: &str) -> Vec<(String, String, Vec<String>)> {
    let (mut class, mut all) = (String::new(), Vec::new());
    let name = path.rsplit('/').next().unwrap_or(path);
    for (number, line) in super::text_of(path).lines().enumerate() {
        if let Some(title) = line.strip_prefix("== ") {
            class = title.trim().to_string();
        } else if !line.trim().is_empty() && !line.starts_with("//") {
            let columns =
                line.split(" | ").map(|c| c.trim_matches(' ').replace('·', " ").replace("\\n", "\n")).collect();
            all.push((class.clone(), format!("{name}:{}", number + 1), columns));
        }
    }
    all
}

/// Misspelt words: `SYNTAX | before«word»after | CODES`, with `·` for a blank at an end of the pattern. The faulty
/// text is the misspelt word; with a fourth column, extended by the parts of that column before and after `*`.
pub fn slips(path: &str) -> Vec<Fault> {
    let mut all = Vec::new();
    for (class, origin, columns) in rows(path) {
        let [syntax, pattern, codes, rest @ ..] = columns.as_slice() else { panic!("{origin}: three columns") };
        let (wider, longer) = rest.first().and_then(|c| c.split_once('*')).unwrap_or(("", ""));
        for p in places(syntax, pattern, &origin) {
            let word = misspelt(&p.text[p.at.clone()], all.len());
            let (before, after) = (&p.text[..p.at.start], &p.text[p.at.end..]);
            assert!(before.ends_with(wider) && after.starts_with(longer), "{origin}: `{wider}*{longer}` is not there");
            let place = p.at.start - wider.len()..p.at.start + word.len() + longer.len();
            all.push(Fault::new(&class, &origin, &p.file, &format!("{before}{word}{after}"), place, codes));
        }
    }
    all
}

/// Misspells a word in its second half: a letter omitted, inserted, or two swapped, in turn.
fn misspelt(word: &str, turn: usize) -> String {
    let letters: Vec<char> = word.chars().collect();
    let at = letters.len() / 2;
    let mut slip = letters.clone();
    match turn % 3 {
        0 if letters.len() > 2 => {
            slip.remove(at);
        }
        1 if letters.len() > 2 && letters[at] != letters[at - 1] => slip.swap(at, at - 1),
        _ => slip.insert(at, 'x'),
    }
    slip.into_iter().collect()
}
