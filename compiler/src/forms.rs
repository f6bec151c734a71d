//! The forms that a written value can have: text, name, list, block; and the keys of blocks.

use std::collections::BTreeSet;

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Spanned};
use names::{list, suggest};

use crate::sections::Section;

/// Reports a key that has no meaning in a section.
pub fn check_keys(block: &Block, section: &Section, diagnostics: &mut Vec<Diagnostic>) {
    let keys: Vec<&str> = section.entries().collect();
    unknown_keys(block, &keys, section.name, diagnostics);
}

/// Behind so many diagnostics, more than a report shows, it is only said that a key is unknown.
const EXPLAINED: usize = 1000;

/// Reports the keys of a block that are not among those that it may have, each once. True where there are some.
pub fn unknown_keys(block: &Block, keys: &[&str], what: &str, diagnostics: &mut Vec<Diagnostic>) -> bool {
    let mut seen: BTreeSet<&str> = BTreeSet::new();
    for (i, e) in block.entries.iter().enumerate().filter(|(_, e)| !keys.contains(&e.key.value.as_str())) {
        // A key that is given again was reported for that.
        if seen.insert(&e.key.value) {
            diagnostics.push(unknown_key(diagnostics.len(), block, i, keys, what));
        }
    }
    !seen.is_empty()
}

/// The diagnostic for the unknown key of entry `i`, behind `told` others; a word behind a bare number may have been meant
/// as its unit.
pub fn unknown_key(told: usize, block: &Block, i: usize, keys: &[&str], what: &str) -> Diagnostic {
    let key = &block.entries[i].key;
    let mut d = Diagnostic::error("HQ0205", key.span, format!("{what} has no `{}`", key.value));
    if told > EXPLAINED {
        return d;
    }
    let before = i.checked_sub(1).map(|k| &block.entries[k]);
    if ["and", "or", "not"].contains(&key.value.as_str()) {
        d = d.help(format!("between conditions `{}` stands inside brackets, as in `(a < b and b < c)`", key.value));
    } else if let Some(meant) = synonym(&key.value).filter(|m| keys.contains(m)) {
        d = d.help(format!("write `{meant}`"));
    } else if let Some(near) = suggest(&key.value, keys.iter().copied()) {
        d = d.help(format!("did you mean `{near}`?"));
    } else if let Some(Entry { value: Value { kind: ValueKind::Number(n), span }, .. }) = before
        && key.span.start >= span.end
        && key.span.start - span.end <= 2
    {
        d = d.help(format!("if `{}` was meant as the unit of {}, the language does not know it", key.value, n.text));
    } else {
        d = d.help(format!("it may have {}", list(keys.iter().copied(), 20)));
    }
    d
}

/// True where a key that the section does not have was meant as this one: that it is missing is said with that.
pub fn misspelt(block: &Block, section: &Section, name: &str) -> bool {
    let unknown = block.entries.iter().map(|e| e.key.value.as_str()).filter(|key| section.entries().all(|k| k != *key));
    unknown.take(EXPLAINED).any(|key| suggest(key, section.entries()) == Some(name))
}

/// What a key is called elsewhere in the language, for one that people bring along.
fn synonym(key: &str) -> Option<&'static str> {
    let known = [
        ("lower", "min"),
        ("upper", "max"),
        ("min", "lower"),
        ("max", "upper"),
        ("minimum", "min"),
        ("maximum", "max"),
        ("at_least", "min"),
        ("at_most", "max"),
        ("goal", "target"),
        ("setpoint", "target"),
        ("desired", "target"),
        ("kp", "gain"),
        ("margin", "sampled_margin"),
        ("delay", "lag"),
        ("time", "duration"),
    ];
    known.iter().find(|k| k.0 == key.to_lowercase()).map(|k| k.1)
}

/// What stands between names where a parameter that is several joints was written for a key. No key has it in a text.
pub const KEY_SEPARATOR: &str = ", ";

/// The names that a key stands for: itself, or those of a parameter.
pub fn names_of_key(key: &Spanned<String>) -> Vec<Value> {
    let one = |name: &str| Value { kind: ValueKind::Text(name.to_string()), span: key.span };
    key.value.split(KEY_SEPARATOR).map(one).collect()
}

/// The text of a value that must be text or a name.
pub fn text_of(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Text(s) => Some(s),
        ValueKind::Name(s) => Some(written(s)),
        _ => None,
    }
}

/// What a name is in the text. An expansion writes `NAME@VALUE` where the name could be that of a value which has
/// another name in the program.
pub fn written(name: &str) -> &str {
    name.split_once('@').map_or(name, |n| n.0)
}

/// The name in the program of the value that a name could be that of; see [`written`].
pub fn target(name: &str) -> &str {
    name.split_once('@').map_or(name, |n| n.1)
}

/// A dotted name such as `arms.left`.
pub fn path_of(value: &Value) -> Option<String> {
    match &value.kind {
        ValueKind::Name(n) => Some(written(n).to_string()),
        ValueKind::Text(n) => Some(n.clone()),
        ValueKind::Field(inner, field) => Some(format!("{}.{}", path_of(inner)?, field.value)),
        _ => None,
    }
}

/// A value as a list: a list's items, or the value itself.
pub fn items_of(value: &Value) -> &[Value] {
    match &value.kind {
        ValueKind::List(items) => items,
        _ => std::slice::from_ref(value),
    }
}

/// The block of a value that must be one.
pub fn block_of<'v>(value: &'v Value, what: &str, diagnostics: &mut Vec<Diagnostic>) -> Option<&'v Block> {
    match &value.kind {
        ValueKind::Block(b) => Some(b),
        ValueKind::Missing => None,
        _ => {
            diagnostics.push(
                Diagnostic::error("HQ0304", value.span, format!("named values are needed for {what}"))
                    .help("write `{ name value .. }`"),
            );
            None
        }
    }
}
