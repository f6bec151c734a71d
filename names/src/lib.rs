//! Names in messages: the nearest candidate for a misspelt name, and lists of names. One metric for the whole program,
//! so that a misspelt word gets the same suggestion at every lookup.

use std::borrow::Cow;

/// Maximum number of candidates of similar length that are compared.
const MOST: usize = 200;

/// Returns the candidate nearest to `word`, if it is near enough to be a typo. Among equally near ones it is the one
/// whose letters differ least: `joint_9` gives `joint_7` if there are seven joints.
pub fn suggest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = lowercase(word);
    let length = word.chars().count();
    candidates
        .into_iter()
        .filter(|c| c.chars().count().abs_diff(length) <= 1 + length / 4)
        .take(MOST)
        .map(|c| (strsim::damerau_levenshtein(&lower, &lowercase(c)), letters_apart(&lower, c), c))
        .filter(|(distance, _, c)| {
            let length = c.chars().count().min(word.chars().count());
            *distance <= 1 + length / 4 && *distance < length
        })
        .min()
        .map(|(_, _, c)| c)
}

/// Converts to lower case; most names are written so, and need no copy.
fn lowercase(word: &str) -> Cow<'_, str> {
    match word.chars().any(char::is_uppercase) {
        true => word.to_lowercase().into(),
        false => word.into(),
    }
}

fn letters_apart(a: &str, b: &str) -> u32 {
    a.chars().zip(b.chars()).map(|(x, y)| (x as u32).abs_diff(y as u32)).fold(0, u32::saturating_add)
}

/// Formats a list in words: `a`, `b` and `c`; at most `most` names are listed, the rest is counted.
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

/// Formats several names as one pattern that matches them all, or as a list.
pub fn pattern(names: &[&str]) -> String {
    let first = names.first().copied().unwrap_or("");
    let same = |n: &usize| first.is_char_boundary(*n) && names.iter().all(|name| name.starts_with(&first[..*n]));
    match (1..=first.len()).rev().find(same) {
        Some(n) if n >= 3 && names.len() > 1 => format!("`\"{}*\"`", &first[..n]),
        _ => list(names.iter().copied(), 4),
    }
}

/// Writes names in lines of at most 110 columns, indented below a head.
///
/// # Errors
/// The output cannot be written.
pub fn wrapped(head: &str, names: &[&str], out: &mut impl std::fmt::Write) -> std::fmt::Result {
    let mut line = format!("      {head}");
    for (i, n) in names.iter().enumerate() {
        let comma = if i + 1 < names.len() { "," } else { "" };
        if line.chars().count() + n.chars().count() + 2 > 110 {
            writeln!(out, "{line}")?;
            line = "          ".to_string();
        }
        line.push(' ');
        line.push_str(n);
        line.push_str(comma);
    }
    writeln!(out, "{line}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names() {
        let joints = ["joint_1", "joint_2", "joint_7"];
        assert_eq!(suggest("joint_9", joints), Some("joint_7"));
        assert_eq!(suggest("jiont_2", joints), Some("joint_2"));
        assert_eq!(suggest("elbow", joints), None);
        assert_eq!(suggest("x", ["t", "pi"]), None);
        assert_eq!(suggest("T", ["t", "pi"]), Some("t"));
    }

    #[test]
    fn patterns() {
        assert_eq!(pattern(&["joint_1", "joint_2"]), "`\"joint_*\"`");
        assert_eq!(pattern(&["elbow", "wrist"]), "`elbow` and `wrist`");
        assert_eq!(pattern(&["joint_1"]), "`joint_1`");
    }

    #[test]
    fn lists() {
        assert_eq!(list([], 3), "none");
        assert_eq!(list(["a"], 3), "`a`");
        assert_eq!(list(["a", "b", "c"], 3), "`a`, `b` and `c`");
        assert_eq!(list(["a", "b", "c"], 2), "`a`, `b` and 1 more");
    }
}
