//! Quick fixes: proposals of a diagnostic as edits of the text. Each fix is tested before it is offered, so proposals
//! may be speculative.

use std::ops::Range;

use dsl::tree::{ItemKind, Spec};
use dsl::{Diagnostic, Syntax};
use stdlib_tasks::params::ParamType;

/// A proposed replacement of some bytes, with a title.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fix {
    /// Title for a menu.
    pub title: String,
    /// Bytes to replace.
    pub range: Range<usize>,
    /// Replacement.
    pub new: String,
}

impl Fix {
    fn new(title: impl Into<String>, range: Range<usize>, new: impl Into<String>) -> Fix {
        Fix { title: title.into(), range, new: new.into() }
    }
}

/// Proposals for a diagnostic of a text.
pub(super) fn of(d: &Diagnostic, text: &str, spec: &Spec, syntax: Syntax) -> Vec<Fix> {
    let range = d.primary.span.range();
    let Some(shown) = text.get(range.clone()) else { return Vec::new() };
    let help = d.help.as_deref().unwrap_or("");
    let first = quoted(help).next();
    let replace = |new: &str| Fix::new(format!("Write `{new}`"), range.clone(), new);
    if help.starts_with("did you mean") {
        let Some(near) = first else { return Vec::new() };
        let new = match shown.strip_prefix('"').and_then(|s| s.strip_suffix('"')) {
            Some(_) if !near.starts_with('"') => format!("\"{near}\""),
            _ => near.to_string(),
        };
        return vec![replace(&new)];
    }
    match d.code {
        "HQ0101" => first.map(|line| Fix::new(format!("Write `{line}` at the top"), 0..0, format!("{line}\n"))),
        "HQ0104" if shown.is_empty() => Some(Fix::new("Write `=`", range, " =")),
        "HQ0104" if shown == ":" => Some(Fix::new("Write `=`", range, " =")),
        "HQ0104" | "HQ0106" | "HQ0108" => Some(Fix::new(format!("Delete `{shown}`"), range, "")),
        "HQ0110" => {
            shown.strip_prefix('#').map(|rest| Fix::new("Begin the comment with `//`", range, format!("//{rest}")))
        }
        "HQ0109" | "HQ0111" | "HQ0113" if help.starts_with("write `") => return quoted(help).map(replace).collect(),
        "HQ0117" if help.starts_with("write `{`") => {
            let line = text[range.end..].find('\n').map_or(text.len(), |n| range.end + n);
            let end = range.end + text[range.end..line].trim_end().len();
            Some(Fix::new("Write the missing `{`", end..end, " {"))
        }
        "HQ0119" if syntax == Syntax::Native => {
            Some(Fix::new("Put it in quotes", range, format!("\"{}\"", shown.trim_matches('\''))))
        }
        "HQ0137" => first.map(|new| Fix::new("Put it in quotes", range, new)),
        "HQ0136" => Some(Fix::new("Delete the tag", range, "")),
        "HQ0301" if help.starts_with("give it a unit") => {
            return first.map(|unit| behind(unit, range)).into_iter().collect();
        }
        "HQ0305" => return quoted(help).map(|unit| behind(unit, range.clone())).collect(),
        "HQ0203" => removal(d, text, spec),
        "HQ0206" => return missing(d, text, syntax),
        _ => None,
    }
    .into_iter()
    .collect()
}

/// Parts of a text between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// Appends a unit to a value.
fn behind(unit: &str, range: Range<usize>) -> Fix {
    Fix::new(format!("Write the unit `{unit}`"), range.end..range.end, format!(" {unit}"))
}

/// Removes the declaration of a diagnostic, with its lines if they contain nothing else.
fn removal(d: &Diagnostic, text: &str, spec: &Spec) -> Option<Fix> {
    let (item, name) = spec.items.iter().find_map(|item| {
        let name = match &item.kind {
            ItemKind::Param(p) => &p.name,
            ItemKind::Task(t) => &t.name,
            _ => return None,
        };
        (name.span == d.primary.span).then_some((item, name))
    })?;
    let Range { mut start, mut end } = item.span.range();
    let line = text[..start].rfind('\n').map_or(0, |n| n + 1);
    let rest = text[end..].find('\n').map_or(text.len(), |n| end + n + 1);
    if text[line..start].trim().is_empty() && text[end..rest].trim().is_empty() {
        (start, end) = (line, rest);
    }
    Some(Fix::new(format!("Remove `{}`", name.value), start..end, ""))
}

/// Adds required parameters of a task type or a robot, if a neutral value exists: the current state, or zero velocity.
fn missing(d: &Diagnostic, text: &str, syntax: Syntax) -> Vec<Fix> {
    let mut words = quoted(&d.message);
    let (Some(owner), keys) = (words.next(), words.collect::<Vec<_>>()) else { return Vec::new() };
    let entries: Option<Vec<(&str, String)>> = match stdlib_tasks::find(owner) {
        Some(kind) if d.message.starts_with("task type") => (keys.iter())
            .map(|&key| {
                let info = kind.params.iter().find(|p| p.name == key)?;
                let rests = matches!(info.ty, ParamType::JointVelocities).then(|| "0 rad/s".to_string());
                let captured = kind.current_values.iter().any(|a| a.name == key).then(|| format!("initial({key})"));
                Some((key, captured.or(rests)?))
            })
            .collect(),
        None if keys == ["rate"] => Some(vec![("rate", "100 Hz".to_string())]),
        _ => None,
    };
    let Some(entries) = entries.filter(|e| !e.is_empty()) else { return Vec::new() };
    let title = format!("Add {}", entries.iter().map(|(k, v)| format!("`{k} {v}`")).collect::<Vec<_>>().join(", "));
    places(text, d.primary.span.range().end, syntax, &entries)
        .into_iter()
        .map(|(range, new)| Fix::new(title.clone(), range, new))
        .collect()
}

/// Insertion of entries after a word: into the block that follows, or into a new one.
fn places(text: &str, end: usize, syntax: Syntax, entries: &[(&str, String)]) -> Vec<(Range<usize>, String)> {
    let rest = &text[end..];
    let args = if rest.starts_with('(') { rest.find(')').map_or(0, |n| n + 1) } else { 0 };
    let (at, rest) = (end + args, &rest[args..]);
    let joined = |colon: &str, sep: &str| {
        let one = |(k, v): &(&str, String)| format!("{k}{colon} {v}");
        entries.iter().map(one).collect::<Vec<_>>().join(sep)
    };
    if syntax == Syntax::Native {
        let entries = joined("", "  ");
        return match rest.trim_start_matches([' ', '\t']).starts_with('{') {
            true => {
                let open = at + rest.find('{').unwrap_or(0) + 1;
                vec![(open..open, format!(" {entries} "))]
            }
            false => vec![(at..at, format!(" {{ {entries} }}"))],
        };
    }
    let Some(value) = rest.strip_prefix(':') else { return Vec::new() };
    if value.trim_start_matches(' ').starts_with('{') {
        let open = at + 1 + value.find('{').unwrap_or(0) + 1;
        return vec![(open..open, format!(" {},", joined(":", ", ")))];
    }
    // An indented block below: its first line determines the indentation.
    let Some((_, below)) = value.split_once('\n') else { return Vec::new() };
    let line = text.len() - below.len();
    let indent = &below[..below.len() - below.trim_start_matches(' ').len()];
    vec![(line..line, format!("{indent}{}\n", joined(":", &format!("\n{indent}"))))]
}
