//! The name that somebody may have meant.

/// The number of characters to insert, delete or replace to come from one word to the other.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// "did you mean `x`?" for a close name, else what there is.
pub(super) fn suggest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    // Long words are cut: they come from outside.
    let word: String = word.chars().take(64).collect();
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    names.dedup();
    let close = names.iter().map(|name| (distance(&word, name), *name)).min();
    if let Some((_, name)) = close.filter(|(far, name)| *far <= name.chars().count().max(3) / 3) {
        return format!("did you mean `{name}`?");
    }
    match names.len() {
        0 => "there is none".into(),
        count if count <= SHOWN => format!("there is {}", listed(&names)),
        count => format!("there are {}, and {} more", listed(&names[..SHOWN]), count - SHOWN),
    }
}

/// Names as they are listed in a message.
pub(super) fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", name.as_ref())).collect();
    quoted.join(", ")
}
