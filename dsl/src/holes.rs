//! Holes in names and texts: the `${side}` of `arm_${side}_1`, which a `for` or a parameter fills.

/// A part of a word, in the order of writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part<'t> {
    /// Letters as they stand; a `${` that no name and `}` follow is among them.
    Text(&'t str),
    /// The name between `${` and `}`.
    Hole(&'t str),
}

/// The parts of `text`; joined, with `${..}` around the holes, they are the text again.
pub fn parts(text: &str) -> impl Iterator<Item = Part<'_>> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        if let Some((hole, after)) = leading(rest) {
            rest = after;
            return Some(Part::Hole(hole));
        }
        let end = rest.match_indices("${").map(|(at, _)| at).find(|&at| leading(&rest[at..]).is_some());
        let (here, after) = rest.split_at(end.unwrap_or(rest.len()));
        rest = after;
        Some(Part::Text(here))
    })
}

/// The hole with which `text` begins, and what follows it.
fn leading(text: &str) -> Option<(&str, &str)> {
    text.strip_prefix("${")?.split_once('}').filter(|(hole, _)| is_plain_name(hole))
}

/// True for `[A-Za-z_][A-Za-z0-9_]*`.
pub(crate) fn is_plain_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && word.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Part::{Hole, Text};
    use super::*;

    #[test]
    fn holes_are_names_in_braces() {
        let all = |text| parts(text).collect::<Vec<_>>();
        assert_eq!(all("arm_${side}_1"), [Text("arm_"), Hole("side"), Text("_1")]);
        assert_eq!(all("${a}${b}"), [Hole("a"), Hole("b")]);
        assert_eq!(all("5 ${ and ${i+1} ${c"), [Text("5 ${ and ${i+1} ${c")]);
        assert_eq!(all("${${a}"), [Text("${"), Hole("a")]);
        assert_eq!(all(""), []);
    }

    proptest! {
        #[test]
        fn parts_join_to_the_text(text in "([a${}_ ]|é){0,24}") {
            let joined: String = parts(&text)
                .map(|part| match part {
                    Text(t) => t.to_owned(),
                    Hole(h) => format!("${{{h}}}"),
                })
                .collect();
            prop_assert_eq!(joined, text);
        }
    }
}
