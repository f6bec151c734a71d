//! Syntactic checks of finished parts of the tree that both readers share.

use crate::diagnostic::clip;
use crate::fix::Fix;
use crate::tree::{Block, Entry, Stack, Value, ValueKind};
use crate::vocabulary::ALLOW;
use crate::words::{is_quoted_key, is_text_key};
use crate::{Diagnostic, Help, Snippet, Span};
use std::collections::BTreeMap;

/// Reports keys that appear twice in a block.
pub(crate) fn duplicates(entries: &[Entry], diags: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
    for entry in entries {
        match seen.get(entry.key.as_str()) {
            Some(first) => diags.push(duplicate(&entry.key.value, *first, entry.key.span)),
            None => {
                seen.insert(&entry.key.value, entry.key.span);
            }
        }
    }
}

/// Returns the diagnostic for a key that appears twice.
pub(crate) fn duplicate(key: &str, first: Span, second: Span) -> Diagnostic {
    Diagnostic::error("HQ0115", second, format!("`{}` is given twice", clip(key)))
        .here("given again here")
        .label(first, "first given here")
        .help("keep one of them")
}

/// Converts the value of a key that takes text to a text, and reports values that are no text.
pub(crate) fn text_value(key: &str, value: &mut Value, text: &str, diags: &mut Vec<Diagnostic>) {
    if is_text_key(key) {
        all_text(key, &format!("{} ", clip(key)), value, text, diags);
    }
}

/// Returns the diagnostic for `[..]` without quotes after a key that takes texts.
pub(crate) fn unquoted_texts(key: &str, raw: &str, span: Span) -> Diagnostic {
    let items: Vec<String> =
        raw.trim_matches(['[', ']']).split(',').map(|item| format!("\"{}\"", item.trim())).collect();
    let items = items.join(", ");
    Diagnostic::error("HQ0119", span, format!("`{}` takes texts", clip(key)))
        .here("not in quotes")
        .help(format!("write `{} [{items}]`", clip(key)))
        // A text may contain a comma.
        .fix(Fix::edit("Put them in quotes", span, format!("[{items}]")))
}

/// Converts a value, or the items of a list, to texts; `lead` precedes the text in the proposed correction.
fn all_text(key: &str, lead: &str, value: &mut Value, text: &str, diags: &mut Vec<Diagnostic>) {
    match &mut value.kind {
        ValueKind::Text(_) | ValueKind::Missing => {}
        ValueKind::List(items) => {
            for item in items {
                all_text(key, "", item, text, diags);
            }
        }
        ValueKind::Block(_) => {
            diags.push(
                Diagnostic::error("HQ0119", value.span, format!("`{}` takes a text, not a block", clip(key)))
                    .help(format!("write `{lead}\"..\"`")),
            );
            value.kind = ValueKind::Missing;
        }
        _ => {
            let raw = text.get(value.span.range()).unwrap_or("").trim().to_owned();
            diags.push(
                Diagnostic::error("HQ0119", value.span, format!("`{}` takes a text", clip(key)))
                    .here("not in quotes")
                    .help(format!("write `{lead}\"{}\"`", clip(&raw)))
                    .fix(Fix::edit("Put it in quotes", value.span, format!("\"{}\"", raw.trim_matches('\'')))),
            );
            value.kind = ValueKind::Text(raw);
        }
    }
}

/// Words that cannot be settings of a stack.
pub(crate) const STACK_WORDS: &[&str] = &["level", "levels", "from", "changes", "replace", "add", "remove"];

/// Words that cannot be settings of a level.
pub(crate) const LEVEL_WORDS: &[&str] = &["name", "tasks", "replace", "add", "remove", "before", "after"];

/// Checks the range of a `param`: `min` and `max`, each a single value.
pub(crate) fn range(range: &mut Block, diags: &mut Vec<Diagnostic>) {
    range.entries.retain_mut(|entry| {
        let key = &entry.key.value;
        if key == ALLOW {
            return true;
        }
        if key != "min" && key != "max" {
            diags.push(
                Diagnostic::error("HQ0127", entry.key.span, format!("the range of a param has no `{}`", clip(key)))
                    .help("write `{ min 0.05 m  max 0.3 m }`, in YAML `{ value: .., min: .., max: .. }`"),
            );
            return false;
        }
        if crate::words::has_block(&entry.value) {
            let text = format!("`{key}` is a single value");
            diags.push(Diagnostic::error("HQ0127", entry.value.span, text).help(format!("write `{key} 0.3 m`")));
            entry.value.kind = ValueKind::Missing;
        }
        true
    });
}

/// Checks that a stack either has levels of its own or changes those of its base stack, and removes the others. `from`
/// is true if the stack names a base; `at` is the location of its name.
pub(crate) fn changes(stack: &mut Stack, at: Span, from: bool, diags: &mut Vec<Diagnostic>) {
    if from {
        for level in std::mem::take(&mut stack.levels) {
            let name = &level.name.value;
            diags.push(
                Diagnostic::error(
                    "HQ0126",
                    level.name.span,
                    "a stack that is derived from another one may only list changes",
                )
                .label(stack.base.as_ref().map_or(at, |base| base.span), "derived from this stack")
                .help(Help::with(
                    "write a change: {}, {}",
                    ["add", "replace"].map(|word| {
                        let change = format!("{{ {word}: {name}, tasks: [..] }}");
                        Snippet::each(format!("{word} {name} {{ .. }}"), change)
                    }),
                )),
            );
        }
    } else if let Some(change) = stack.changes.first() {
        let (word, span) = match change {
            crate::tree::Change::Replace(level) => ("replace", level.name.span),
            crate::tree::Change::Add(level, _) => ("add", level.name.span),
            crate::tree::Change::Remove(removal) => ("remove", removal.level.span),
        };
        diags.push(
            Diagnostic::error(
                "HQ0126",
                span,
                format!("`{word}` changes a level of a base stack, and this stack has none"),
            )
            .label(at, "this stack has no base")
            .help(Help::with(
                "write {}, or a new level, {}",
                [
                    Snippet::each("stack NAME from OTHER { .. }", "NAME: { from: OTHER, .. }"),
                    Snippet::each("level NAME { .. }", "levels: [ { name: NAME, .. } ]"),
                ],
            )),
        );
        stack.changes.clear();
    }
}

/// Reports and removes settings that would have another meaning in one of the syntaxes.
pub(crate) fn reserved(settings: &mut Block, words: &[&str], what: &str, diags: &mut Vec<Diagnostic>) {
    settings.entries.retain(|entry| {
        let clash = words.contains(&entry.key.value.as_str());
        if clash {
            let key = &entry.key.value;
            diags.push(
                Diagnostic::error("HQ0121", entry.key.span, format!("`{key}` cannot be a setting of a {what}"))
                    .note("the word is a keyword there in one of the two syntaxes")
                    .help(match what {
                        "robot" => "derive a robot from another one by `robot NAME from OTHER { .. }`",
                        "stack" => "levels are written `level NAME { .. }`, in YAML as the sequence `levels:`",
                        "level" => "write the tasks of a level in its braces, in YAML in the sequence `tasks:`",
                        "signal" => "the type of a signal follows its name: `signal NAME : point`",
                        "scenario" => "an expectation is written `expect FORMULA`, in YAML in the sequence `expect:`",
                        _ => "take another word",
                    }),
            );
        }
        let quoted = what != "robot" && is_quoted_key(&entry.key.value);
        if quoted {
            let kind = if entry.key.value.contains(['*', '?']) { "a pattern" } else { "a name in quotes" };
            let text = format!("{kind} cannot be a setting of a {what}");
            diags.push(Diagnostic::error("HQ0121", entry.key.span, text).help("write the name of a setting"));
        }
        !clash && !quoted
    });
}

/// Returns the diagnostic for `level hard { .. }`: a level that was meant to be hard would be a soft one with that
/// name.
pub(crate) fn hard_is_no_name(span: Span) -> Diagnostic {
    Diagnostic::incomplete("HQ0116", span, "this level has no name: `hard` is a keyword")
        .help("write a name before `hard`, in YAML after `name:`")
}

/// Sorts the diagnostics by location, and keeps the first hundred.
pub(crate) fn finish(mut diags: Vec<Diagnostic>) -> Vec<Diagnostic> {
    use crate::limits::MAX_DIAGNOSTICS;
    diags.sort_by_key(|d| (d.primary.span.start, d.primary.span.end, d.code));
    diags.dedup_by(|b, a| a.code == b.code && a.primary.span == b.primary.span);
    if diags.len() > MAX_DIAGNOSTICS {
        let left = diags.len() - MAX_DIAGNOSTICS;
        let span = diags[MAX_DIAGNOSTICS].primary.span;
        diags.truncate(MAX_DIAGNOSTICS);
        diags.push(
            Diagnostic::error("HQ0192", span, format!("{left} more errors are not shown"))
                .help("fix the first errors; the others may be consequences"),
        );
    }
    diags
}
