//! Lookup of misspelt words, and predicates on names, keys and values.

use std::borrow::Cow;

use crate::holes::{Part, is_plain_name, parts};
use crate::tree::{Value, ValueKind};
use crate::vocabulary::TEXT_KEYS;

/// Returns the candidate nearest to `word`, if it is near enough to be a typo. Words of more than 64 bytes are not
/// compared.
pub(crate) fn nearest<'c>(word: &str, candidates: &[&'c str]) -> Option<&'c str> {
    if word.len() > 64 { None } else { ::names::suggest(word, candidates.iter().copied()) }
}

/// Returns the unit symbol that a misspelt one probably stands for.
pub(crate) fn nearest_unit(word: &str) -> Option<&'static str> {
    const SPELT_OUT: &[(&str, &str)] = &[
        ("meter", "m"),
        ("metre", "m"),
        ("mtr", "m"),
        ("second", "s"),
        ("sec", "s"),
        ("degree", "deg"),
        ("radian", "rad"),
        ("newton", "N"),
        ("hertz", "Hz"),
        ("minute", "min"),
        ("hour", "h"),
        ("kilogram", "kg"),
        ("gram", "g"),
        ("millimeter", "mm"),
        ("millimetre", "mm"),
        ("centimeter", "cm"),
        ("centimetre", "cm"),
        ("joule", "J"),
        ("watt", "W"),
    ];
    let lower = word.to_lowercase();
    let singular = lower.strip_suffix('s').unwrap_or(&lower);
    SPELT_OUT
        .iter()
        .find(|(long, _)| *long == lower || *long == singular)
        .map(|(_, symbol)| *symbol)
        .or_else(|| crate::vocabulary::UNITS.iter().find(|u| u.to_lowercase() == lower).copied())
        .or_else(|| nearest(word, crate::vocabulary::UNITS))
}

/// Replaces the holes of a word, such as `${side}`, by a letter.
fn filled(word: &str) -> Cow<'_, str> {
    if !word.contains("${") {
        return Cow::Borrowed(word);
    }
    parts(word)
        .map(|part| match part {
            Part::Text(text) => text,
            Part::Hole(_) => "x",
        })
        .collect()
}

/// Returns true for `[A-Za-z_][A-Za-z0-9_]*`, in which holes such as `${side}` may replace letters.
pub(crate) fn is_name(word: &str) -> bool {
    is_plain_name(&filled(word))
}

/// Returns true for texts that YAML may write in a single pair of quotes: `arm_left_*`, `*_elbow`, `arm_?_joint`.
pub(crate) fn is_glob(word: &str) -> bool {
    let word = filled(word);
    word.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'*' | b'?'))
        && (word.starts_with('*') || word.ends_with('*') || word.contains('?'))
}

/// Returns true for words that need quotes as a key: a pattern such as `finger_*`, a name such as `joint-1`.
pub(crate) fn is_quoted_key(word: &str) -> bool {
    let word = filled(word);
    let fits = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'*' | b'?' | b'-' | b'.' | b'/' | b':');
    !word.is_empty() && word.bytes().all(fits) && !is_plain_name(&word)
}

/// Returns true for a key whose value is text.
pub(crate) fn is_text_key(key: &str) -> bool {
    TEXT_KEYS.contains(&key)
}

/// Returns true if a unit may follow the last token of a value: a number, `)`, `]`, a unit.
pub(crate) fn takes_unit(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Number(_) | ValueKind::Unit(..) | ValueKind::Call(..) | ValueKind::List(_) => true,
        ValueKind::Negate(inner) | ValueKind::Not(inner) | ValueKind::Binary(_, _, inner) => {
            takes_unit(inner) || !is_atom(inner)
        }
        _ => false,
    }
}

/// Returns true if a value never needs parentheses.
pub(crate) fn is_atom(value: &Value) -> bool {
    !matches!(value.kind, ValueKind::Negate(_) | ValueKind::Not(_) | ValueKind::Binary(..))
}

/// Returns true if a value is a block or a list that contains one.
pub(crate) fn has_block(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Block(_) => true,
        ValueKind::List(items) => items.iter().any(has_block),
        _ => false,
    }
}
