//! Converts pieces of `*.hq` text in helps to YAML: `robot r { serve 20 s }` becomes `robots: { r: { serve: 20 s } }`.
//!
//! A piece may be incomplete, `{ at ..  .. }`; two blanks separate its entries. A piece that is not understood as a
//! whole is not converted.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use dsl::vocabulary::ROLES;

use crate::sections::ALL;

/// Keys that have a value.
static KEYS: LazyLock<BTreeSet<&str>> = LazyLock::new(|| {
    let keys = ALL.iter().flat_map(|section| section.keys);
    keys.filter(|key| key.is_entry()).map(|key| key.name).collect()
});

/// Converts a piece to YAML; `None` if YAML has the same syntax, or if it is not a piece of a spec.
pub fn in_yaml(piece: &str) -> Option<String> {
    if piece.starts_with('{') {
        let known = |part: &&str| part.split_once(' ').is_some_and(|(key, _)| KEYS.contains(key));
        return parts(inside(piece)?).iter().any(known).then(|| block(piece)).flatten();
    }
    if let Some(mission) = piece.strip_prefix("mission ").and_then(|rest| rest.split_once(" : ")) {
        let (kind, body) = mission.1.split_once(' ').unwrap_or((mission.1, "{ .. }"));
        return Some(format!("missions: {{ {}: {{ {kind}: {} }} }}", mission.0, block(body)?));
    }
    if piece.starts_with('[') {
        return piece.contains("] ").then(|| format!("\"{piece}\""));
    }
    let known = |part: &str| member(part).is_some() || part.split(' ').next().is_some_and(|key| KEYS.contains(key));
    let parts = parts(piece);
    if parts.is_empty() {
        return None;
    }
    parts.iter().all(|part| known(part)).then(|| entries(&parts)).flatten()
}

/// Content between the braces of a block.
fn inside(text: &str) -> Option<&str> {
    text.strip_prefix('{')?.strip_suffix('}').map(str::trim)
}

/// Splits a text into entries at two blanks outside of brackets and quotes.
fn parts(text: &str) -> Vec<&str> {
    let (mut all, mut start, mut depth, mut quoted) = (Vec::new(), 0, 0_usize, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b'(' | b'[' | b'{' if !quoted => depth += 1,
            b')' | b']' | b'}' if !quoted => depth = depth.saturating_sub(1),
            b' ' if depth == 0 && !quoted && text[at..].starts_with("  ") => {
                all.push(text[start..at].trim());
                start = at;
            }
            _ => {}
        }
    }
    all.push(text[start..].trim());
    all.retain(|part| !part.is_empty());
    all
}

fn entries(parts: &[&str]) -> Option<String> {
    let all: Option<Vec<String>> = parts.iter().map(|part| entry(part)).collect();
    all.map(|all| all.join(", "))
}

/// Converts an entry: `serve 20 s`, `robot r { .. }`, or the ellipsis `..`.
fn entry(text: &str) -> Option<String> {
    if text == ".." {
        return Some(text.to_string());
    }
    if let Some(member) = member(text) {
        return Some(member);
    }
    let (key, text) = text.split_once(' ')?;
    Some(format!("{key}: {}", value(text)?))
}

/// Converts a member: `robot r { .. }`, `task t = pick { .. }`, `task t = pick`.
fn member(text: &str) -> Option<String> {
    let (role, rest) = text.split_once(' ').filter(|(role, _)| ROLES.contains(role))?;
    let (name, rest) = rest.split_once(' ')?;
    let body = match rest.strip_prefix("= ") {
        Some(action) => match action.split_once(" {") {
            Some((called, _)) if called.contains('(') => return None,
            Some((action, _)) => format!("{{ {action}: {} }}", block(&rest[2 + action.len() + 1..])?),
            None => action.to_string(),
        },
        None => block(rest)?,
    };
    Some(format!("{role}s: {{ {name}: {body} }}"))
}

fn block(text: &str) -> Option<String> {
    match inside(text)? {
        "" => Some("{}".to_string()),
        ".." => Some("{ .. }".to_string()),
        text => Some(format!("{{ {} }}", entries(&parts(text))?)),
    }
}

/// Converts a value: one word, a number with its unit, a list with or without a unit, a call, a text or a block.
fn value(text: &str) -> Option<String> {
    let one_word = |text: &str| !text.contains(' ');
    match text.as_bytes().first()? {
        b'{' => block(text),
        b'"' => Some(text.to_string()),
        b'[' => match text.rsplit_once("] ") {
            Some((_, unit)) => (one_word(unit) && unit != "..").then(|| format!("\"{text}\"")),
            None => text.ends_with(']').then(|| text.to_string()),
        },
        _ if text.contains(['{', '"', '>', '=']) => None,
        _ if text.ends_with(')') && text.split('(').next().is_some_and(one_word) => Some(format!("\"{text}\"")),
        b'0'..=b'9' => text.split_once(' ').is_none_or(|(_, unit)| one_word(unit)).then(|| text.to_string()),
        _ => one_word(text).then(|| text.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces() {
        for (hq, yaml) in [
            ("serve 20 s", "serve: 20 s"),
            ("depot [4, -1.5] m", "depot: \"[4, -1.5] m\""),
            ("duration normal(204 s, 20 s)", "duration: \"normal(204 s, 20 s)\""),
            ("features [cube, red]", "features: [cube, red]"),
            ("{ at ..  .. }", "{ at: .., .. }"),
            ("skills { pick 2 s }", "skills: { pick: 2 s }"),
            ("layer NAME { task NAME = SKILL { .. } }", "layers: { NAME: { tasks: { NAME: { SKILL: { .. } } } } }"),
            ("place shelf { at [0.4, 0, 0.1] m }", "places: { shelf: { at: \"[0.4, 0, 0.1] m\" } }"),
            ("task one = pick", "tasks: { one: pick }"),
            ("mission NAME : schedule { .. }", "missions: { NAME: { schedule: { .. } } }"),
            ("[0.05, 0.2] m/s", "\"[0.05, 0.2] m/s\""),
        ] {
            assert_eq!(in_yaml(hq).as_deref(), Some(yaml));
        }
        for same in ["serve: 20 s", "serve", "[x, y, z]", "NAME", "hierarq context", "from 2 s to 5 s", "served", ""] {
            assert_eq!(in_yaml(same), None, "{same}");
        }
    }
}
