//! Forms of a value: text, name, list, block; and the keys of blocks.

use std::collections::BTreeSet;

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Spanned};
use names::{list, suggest};

use crate::sections::BlockSchema;

/// Reports the unknown keys of a section.
pub fn check_keys(block: &Block, section: &BlockSchema, diagnostics: &mut Vec<Diagnostic>) {
    let keys: Vec<&str> = section.entries().collect();
    unknown_keys(block, &keys, section.name, diagnostics);
}

/// Number of diagnostics, more than a report shows, after which unknown keys are reported without a help.
const EXPLAINED: usize = 1000;

/// Reports the unknown keys of a block, each once. Returns true if there are some.
pub fn unknown_keys(block: &Block, keys: &[&str], what: &str, diagnostics: &mut Vec<Diagnostic>) -> bool {
    let mut seen: BTreeSet<&str> = BTreeSet::new();
    for (i, e) in block.entries.iter().enumerate().filter(|(_, e)| !keys.contains(&e.key.value.as_str())) {
        // A repeated key was reported as such.
        if seen.insert(&e.key.value) {
            diagnostics.push(unknown_key(diagnostics.len(), block, i, keys, what));
        }
    }
    !seen.is_empty()
}

/// Diagnostic for the unknown key of entry `i`, after `told` other diagnostics. A word after a bare number may have
/// been meant as its unit.
pub fn unknown_key(told: usize, block: &Block, i: usize, keys: &[&str], what: &str) -> Diagnostic {
    let key = &block.entries[i].key;
    let mut d = Diagnostic::unknown_key("HQ0205", key.span, format!("{what} has no `{}`", key.value));
    if told > EXPLAINED {
        return d;
    }
    let before = i.checked_sub(1).map(|k| &block.entries[k]);
    if ["and", "or", "not"].contains(&key.value.as_str()) {
        d = d.help(format!("use brackets around `{}` between conditions, as in `(a < b and b < c)`", key.value));
    } else if let Some(meant) = synonym(&key.value).filter(|m| keys.contains(m)) {
        d = d.write(meant);
    } else if let Some(near) = suggest(&key.value, keys.iter().copied()) {
        d = d.meant(near);
    } else if let Some(Entry { value: Value { kind: ValueKind::Number(n), span }, .. }) = before
        && key.span.start >= span.end
        && key.span.start - span.end <= 2
    {
        d = d.help(format!("if `{}` was meant as the unit of {}, the language does not know it", key.value, n.text));
    } else {
        d = d.help(format!("it may have {}", list(keys.iter().copied(), 30)));
    }
    d
}

/// Returns the keys that the unknown keys of the block were probably meant as. The diagnostics of these cover that the keys
/// are missing.
pub fn meant_keys(block: &Block, schema: &'static BlockSchema) -> impl Iterator<Item = &'static str> {
    let words = block.entries.iter().map(|e| e.key.value.as_str());
    let unknown = words.filter(|word| schema.entries().all(|known| known != *word));
    unknown.take(EXPLAINED).filter_map(|word| suggest(word, schema.entries()))
}

/// Key of this language for a key that users know from elsewhere.
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

/// Separator of several joints from a parameter used as one key. No key in a text contains it.
pub const KEY_SEPARATOR: &str = ", ";

/// Names that a key represents: itself, or those of a parameter.
pub fn names_of_key(key: &Spanned<String>) -> Vec<Value> {
    let one = |name: &str| Value { kind: ValueKind::Text(name.to_string()), span: key.span };
    key.value.split(KEY_SEPARATOR).map(one).collect()
}

/// Text of a value that must be a text or a name.
pub fn text_of(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Text(s) => Some(s),
        ValueKind::Name(s) => Some(written(s)),
        _ => None,
    }
}

/// Source text of a name. The expansion writes `NAME@VALUE` if the name may be that of a value with a different name in
/// the program.
pub fn written(name: &str) -> &str {
    name.split_once('@').map_or(name, |n| n.0)
}

/// Name in the program of the value that a name may refer to; see [`written`].
pub fn target(name: &str) -> &str {
    name.split_once('@').map_or(name, |n| n.1)
}

/// Parses a dotted name such as `arms.left`.
pub fn path_of(value: &Value) -> Option<String> {
    match &value.kind {
        ValueKind::Name(n) => Some(written(n).to_string()),
        ValueKind::Text(n) => Some(n.clone()),
        ValueKind::Field(inner, field) => Some(format!("{}.{}", path_of(inner)?, field.value)),
        _ => None,
    }
}

/// Block of a value that must be one.
pub fn block_of<'v>(value: &'v Value, what: &str, diagnostics: &mut Vec<Diagnostic>) -> Option<&'v Block> {
    match &value.kind {
        ValueKind::Block(b) => Some(b),
        ValueKind::Missing => None,
        _ => {
            diagnostics.push(
                Diagnostic::error("HQ0304", value.span, format!("named values are needed for {what}"))
                    .help(Help::write(Snippet::braces([Snippet::entry("name", "value"), Snippet::dots()]))),
            );
            None
        }
    }
}
