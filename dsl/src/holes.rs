//! Holes in names and texts: the `${side}` of `arm_${side}_1`, which a `for` or a parameter fills; also `${i + 1}`,
//! with sums and products of integers.

/// A part of a word, in source order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part<'t> {
    /// Literal text, including a `${` that does not begin a valid hole.
    Text(&'t str),
    /// Content of `${..}`: a name, or a sum that contains a name.
    Hole(&'t str),
}

/// Splits `text` into its parts. Joined again, with `${..}` around the holes, they are equal to `text`.
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

/// Returns the hole at the start of `text`, and the text after it.
pub(crate) fn leading(text: &str) -> Option<(&str, &str)> {
    let behind = text.strip_prefix("${")?;
    // The search ends at the first character that no hole contains: another hole may begin there.
    let part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | ' ' | '+' | '-' | '*');
    let (hole, rest) = behind.split_at(behind.find(|c| !part(c))?);
    rest.strip_prefix('}').filter(|_| is_hole(hole)).map(|after| (hole, after))
}

/// Returns true if `text` is allowed between `${` and `}`.
pub(crate) fn is_hole(text: &str) -> bool {
    is_plain_name(text) || sum(text).is_some_and(|s| s.iter().flat_map(|t| &t.1).any(|f| matches!(f, Factor::Name(_))))
}

/// A factor of a product in a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor<'t> {
    /// A name.
    Name(&'t str),
    /// An integer.
    Number(i64),
}

/// A product: true if it is subtracted, and its factors.
pub type Product<'t> = (bool, Vec<Factor<'t>>);

/// Parses a hole as a sum of products; `None` if it is not a sum.
pub fn sum(text: &str) -> Option<Vec<Product<'_>>> {
    let mut products: Vec<Product> = Vec::new();
    let (mut rest, mut sign) = (text.trim_matches(' '), '+');
    loop {
        let (negative, operand) = rest.strip_prefix('-').map_or((false, rest), |r| (true, r));
        let end = operand.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(operand.len());
        let (word, behind) = operand.split_at(end);
        let factor = match word {
            number if (1..=9).contains(&number.len()) && number.bytes().all(|b| b.is_ascii_digit()) => {
                Factor::Number(number.parse().ok()?)
            }
            name => is_plain_name(name).then_some(Factor::Name(name))?,
        };
        match products.last_mut().filter(|_| sign == '*') {
            Some((minus, factors)) => {
                *minus ^= negative;
                factors.push(factor);
            }
            None => products.push(((sign == '-') ^ negative, vec![factor])),
        }
        rest = behind.trim_start_matches(' ');
        let Some(next) = rest.chars().next() else { return Some(products) };
        if !matches!(next, '+' | '-' | '*') {
            return None;
        }
        (sign, rest) = (next, rest[1..].trim_start_matches(' '));
    }
}

/// Evaluates a sum; `of` returns the integer values of names. `None` if a name has no such value, or if the result
/// overflows.
pub fn number(sum: &[Product], mut of: impl FnMut(&str) -> Option<i64>) -> Option<i64> {
    sum.iter().try_fold(0_i64, |total, (minus, factors)| {
        let product = factors.iter().try_fold(1_i64, |product, factor| {
            product.checked_mul(match factor {
                Factor::Name(name) => of(name)?,
                Factor::Number(n) => *n,
            })
        })?;
        if *minus { total.checked_sub(product) } else { total.checked_add(product) }
    })
}

/// Returns true for `[A-Za-z_][A-Za-z0-9_]*`.
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
        assert_eq!(all("5 ${ and ${1+1} ${c"), [Text("5 ${ and ${1+1} ${c")]);
        assert_eq!(all("a${i+1}${ 2*i - k }${i++}"), [Text("a"), Hole("i+1"), Hole(" 2*i - k "), Text("${i++}")]);
        assert_eq!(all("${${a}"), [Text("${"), Hole("a")]);
        assert_eq!(all(""), []);
    }

    #[test]
    fn sums_are_numbers() {
        let of = |name: &str| Some(if name == "i" { 3 } else { -5 });
        for (text, is) in [
            ("i", Some(3)),
            ("i+1", Some(4)),
            ("2*i - k", Some(11)),
            ("-i*-2*k+10", Some(-20)),
            ("i - 1 - 1", Some(1)),
            ("i*999999999*999999999*999999999", None),
            ("", None),
            ("2i", None),
            ("i+", None),
            ("i/2", None),
            ("1234567890", None),
        ] {
            assert_eq!(sum(text).and_then(|s| number(&s, of)), is, "{text}");
        }
    }

    proptest! {
        #[test]
        fn parts_join_to_the_text(text in "([a1${}_ +*-]|é){0,24}") {
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
