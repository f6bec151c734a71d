//! Suggestions for unknown names, as a fix.

/// Returns "did you mean `x`?" for a close name, else a list of the known names.
pub(super) fn suggest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    // The text is untrusted: truncate long words.
    let word: String = word.chars().take(64).collect();
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    names.dedup();
    if let Some(name) = ::names::suggest(&word, names.iter().copied()) {
        return format!("did you mean `{name}`?");
    }
    match names.len() {
        0 => "there is none".into(),
        count if count <= SHOWN => format!("there is {}", listed(&names)),
        count => format!("there are {}, and {} more", listed(&names[..SHOWN]), count - SHOWN),
    }
}

/// Returns names as a list in a message.
pub(super) fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", name.as_ref())).collect();
    quoted.join(", ")
}
