//! "Did you mean": the nearest of the names that could have been written.

/// The candidate nearest to `word`, if near enough to be a slip of the finger.
pub fn suggest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(&lower, &c.to_lowercase()), c))
        .filter(|(distance, c)| *distance <= 1 + c.chars().count().min(word.chars().count()) / 4)
        .min()
        .map(|(_, c)| c)
}

/// A list in words: `a`, `b` and `c`; at most `most` of them.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let all: Vec<&str> = names.into_iter().collect();
    let shown: Vec<String> = all.iter().take(most).map(|n| format!("`{n}`")).collect();
    let rest = all.len().saturating_sub(most);
    match (shown.as_slice(), rest) {
        ([], _) => "none".to_string(),
        (_, 0) if shown.len() == 1 => shown[0].clone(),
        (_, 0) => format!("{} and {}", shown[..shown.len() - 1].join(", "), shown[shown.len() - 1]),
        (_, n) => format!("{} and {n} more", shown.join(", ")),
    }
}
