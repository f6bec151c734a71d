//! Reads the handwritten faults.
//!
//! A line is `FILE | FIND | REPLACEMENT | CODES`. `FIND` is a piece of the example that occurs once, or ends in `#2`
//! for its second occurrence. `REPLACEMENT` replaces it; the part between `«` and `»` is the faulty text. If the faulty
//! text is elsewhere, a fifth column contains it, again with `#2` for the second occurrence. `\n` is a line break, `\t`
//! a tab. A line `== NAME` begins a class, `//` a comment.

use super::fault::Fault;

/// Reads all faults of a file.
pub fn faults(path: &str) -> Vec<Fault> {
    let (mut class, mut all) = (String::new(), Vec::new());
    let name = path.rsplit('/').next().unwrap_or(path);
    for (number, line) in super::text_of(path).lines().enumerate() {
        if let Some(title) = line.strip_prefix("== ") {
            class = title.trim().to_string();
        } else if !line.trim().is_empty() && !line.starts_with("//") {
            all.push(fault(&class, &format!("{name}:{}", number + 1), line));
        }
    }
    all
}

fn fault(class: &str, origin: &str, line: &str) -> Fault {
    let columns: Vec<String> = line.split(" | ").map(|c| c.trim().replace("\\n", "\n").replace("\\t", "\t")).collect();
    let (file, find, with, codes) = match columns.as_slice() {
        [file, find, with, codes] | [file, find, with, codes, _] => (file, find, with, codes),
        _ => panic!("{origin}: a fault has four columns, or five"),
    };
    let text = super::text_of(&format!("tests/corpus/specs/{file}"));
    let at = place(&text, find, origin);
    let (before, after) = (&text[..at.start], &text[at.end..]);
    if let Some(elsewhere) = columns.get(4) {
        let spoilt = format!("{before}{}{after}", with.replace(['«', '»'], ""));
        assert_ne!(spoilt, text, "{origin}: nothing is spoilt");
        let place = place(&spoilt, elsewhere, origin);
        return Fault::new(class, origin, file, &spoilt, place, codes);
    }
    let (head, rest) = with.split_once('«').unwrap_or_else(|| panic!("{origin}: no faulty text is marked"));
    let (faulty, tail) = rest.split_once('»').unwrap_or_else(|| panic!("{origin}: `»` is missing"));
    let start = before.len() + head.len();
    let spoilt = format!("{before}{head}{faulty}{tail}{after}");
    assert_ne!(spoilt, text, "{origin}: nothing is spoilt");
    Fault::new(class, origin, file, &spoilt, start..start + faulty.len(), codes)
}

/// Returns the place of a piece: the only one, or the one with the given number.
fn place(text: &str, piece: &str, origin: &str) -> std::ops::Range<usize> {
    let numbered = piece.rsplit_once('#').and_then(|(p, n)| Some((p, n.parse::<usize>().ok()?)));
    let (piece, wanted) = numbered.map_or((piece, None), |(p, n)| (p, Some(n)));
    let places: Vec<usize> = text.match_indices(piece).map(|m| m.0).collect();
    assert!(wanted.is_some() || places.len() == 1, "{origin}: `{piece}` stands there {} times", places.len());
    let start = places.get(wanted.unwrap_or(1) - 1).unwrap_or_else(|| panic!("{origin}: no such `{piece}`"));
    *start..start + piece.len()
}
