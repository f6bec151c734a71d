//! Fixes: corrections of a text as edits. A stage that finds a mistake knows the tree and says which change would mend
//! it; the bytes of the change depend on the text and its syntax, and are computed once, for the report.

use std::borrow::Cow;

use blocks::Snippet;

use crate::Syntax;
use crate::span::{Sources, Span};

/// Replacement of a piece of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Bytes to replace.
    pub span: Span,
    /// The text in their place.
    pub new: String,
}

/// Confidence in a fix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applicability {
    /// The author can mean nothing else: `hierarq check --fix` applies it.
    Certain,
    /// One of several things that the author may have meant: an editor offers it.
    Possible,
}

/// A correction.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// Title, unless it follows from the change.
    title: Option<Cow<'static, str>>,
    /// Confidence in the fix.
    pub applicability: Applicability,
    /// The change.
    pub change: Change,
}

/// The change of a fix.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Replaces a piece of the text. Computed from the other changes, or given by the reader of a text.
    Edit(Edit),
    /// Replaces a name; quotes around it stay.
    Name {
        /// The name in the text.
        span: Span,
        /// The name in its place.
        new: String,
    },
    /// Writes a piece of a spec, in the syntax of the file.
    Snippet {
        /// The text in its place.
        span: Span,
        /// The piece.
        new: Snippet,
    },
    /// Adds entries to the block after a name, which is opened if there is none.
    Entries {
        /// The name, or the type of a task.
        after: Span,
        /// Keys with their values.
        entries: Vec<(String, String)>,
    },
    /// Removes a declaration; with its lines, if they contain nothing else.
    Remove {
        /// Its name.
        name: String,
        /// The whole declaration.
        span: Span,
    },
}

impl Fix {
    /// Replaces the text of a span.
    pub fn replace(span: Span, new: impl Into<String>) -> Fix {
        Fix::of(Change::Edit(Edit { span, new: new.into() }))
    }

    /// Replaces the text of a span, with a title.
    pub fn edit(title: impl Into<Cow<'static, str>>, span: Span, new: impl Into<String>) -> Fix {
        Fix { title: Some(title.into()), ..Fix::replace(span, new) }
    }

    /// Inserts a text after a span.
    pub fn insert(title: impl Into<Cow<'static, str>>, after: Span, new: impl Into<String>) -> Fix {
        Fix::edit(title, Span { start: after.end, ..after }, new)
    }

    /// Writes a sign in place of another one after a name, with a blank before it.
    pub fn sign(name: Span, mark: Span, sign: &str) -> Fix {
        let blank = if name.end == mark.start { " " } else { "" };
        Fix::edit(format!("Write `{sign}`"), mark, format!("{blank}{sign}"))
    }

    /// Writes a unit after a value.
    pub fn unit(after: Span, unit: &str) -> Fix {
        Fix::insert(format!("Write the unit `{unit}`"), after, format!(" {unit}"))
    }

    /// Deletes the text of a span, which is `shown`.
    pub fn delete(span: Span, shown: &str) -> Fix {
        Fix::edit(format!("Delete `{shown}`"), span, "")
    }

    /// Replaces a name.
    pub fn name(span: Span, new: impl Into<String>) -> Fix {
        Fix::of(Change::Name { span, new: new.into() })
    }

    /// Writes a piece of a spec in place of a text.
    pub fn snippet(span: Span, new: Snippet) -> Fix {
        Fix::of(Change::Snippet { span, new })
    }

    /// Adds entries to the block after a name.
    pub fn entries(after: Span, entries: Vec<(String, String)>) -> Fix {
        Fix::of(Change::Entries { after, entries })
    }

    /// Removes a declaration.
    pub fn remove(name: &str, span: Span) -> Fix {
        Fix::of(Change::Remove { name: name.to_string(), span })
    }

    // Most titles follow from the change: a text can have a hundred thousand mistakes, of which few are shown.
    fn of(change: Change) -> Fix {
        Fix { title: None, applicability: Applicability::Possible, change }
    }

    /// Title for a menu: "Write `d_min`".
    pub fn title(&self) -> Cow<'_, str> {
        match (&self.title, &self.change) {
            (Some(title), _) => Cow::Borrowed(title),
            (None, Change::Edit(Edit { new, .. }) | Change::Name { new, .. }) => format!("Write `{new}`").into(),
            (None, Change::Snippet { new, .. }) => format!("Write `{}`", new.native()).into(),
            (None, Change::Entries { entries, .. }) => {
                let shown: Vec<String> = entries.iter().map(|(k, v)| format!("`{k} {v}`")).collect();
                format!("Add {}", shown.join(", ")).into()
            }
            (None, Change::Remove { name, .. }) => format!("Remove `{name}`").into(),
        }
    }

    /// The same fix, which the author certainly means.
    pub fn certain(self) -> Fix {
        Fix { applicability: Applicability::Certain, ..self }
    }

    /// The edits: one if it is computed, and none before.
    pub fn edits(&self) -> &[Edit] {
        match &self.change {
            Change::Edit(edit) => std::slice::from_ref(edit),
            _ => &[],
        }
    }

    /// Computes the edit in the original text. `None` if there is no place for them, or if the text of a name is
    /// written otherwise: `joint_1` may come from `joint_${i}`.
    #[must_use]
    pub fn settled(mut self, sources: &Sources, syntax: Syntax) -> Option<Fix> {
        let text = |span: Span| sources.get(span.source).map(|s| s.text.as_str());
        if matches!(self.change, Change::Entries { .. } | Change::Remove { .. }) {
            // The edit alone does not tell what is added or removed.
            self.title = Some(self.title().into_owned().into());
        }
        let mut edit = match self.change {
            Change::Edit(edit) => edit,
            Change::Name { span, new } => {
                let shown = sources.snippet(span);
                if shown.contains("${") {
                    return None;
                }
                let quoted = shown.len() > 1 && shown.starts_with('"') && shown.ends_with('"');
                Edit { span, new: if quoted && !new.starts_with('"') { format!("\"{new}\"") } else { new } }
            }
            Change::Snippet { span, new } => {
                Edit { span, new: if syntax == Syntax::Yaml { new.yaml() } else { new.native() }.to_string() }
            }
            Change::Entries { after, entries } => added(text(after)?, after, syntax, &entries)?,
            Change::Remove { span, .. } => Edit { span: whole_lines(text(span)?, span)?, new: String::new() },
        };
        text(edit.span)?.get(edit.span.range())?;
        // Nothing stands before a byte order mark.
        if edit.span.end == 0 && text(edit.span)?.starts_with('\u{feff}') {
            (edit.span.start, edit.span.end) = (3, 3);
        }
        edit.span = sources.real(edit.span);
        Some(Fix { change: Change::Edit(edit), ..self })
    }
}

/// A span with the rest of its lines, if they contain nothing else.
fn whole_lines(text: &str, span: Span) -> Option<Span> {
    let range = span.range();
    text.get(range.clone())?;
    let line = text[..range.start].rfind('\n').map_or(0, |n| n + 1);
    let rest = text[range.end..].find('\n').map_or(text.len(), |n| range.end + n + 1);
    let alone = text[line..range.start].trim().is_empty() && text[range.end..rest].trim().is_empty();
    Some(if alone { Span::new(span.source, line, rest) } else { span })
}

/// Insertion of entries after a name: into the block that follows, or into a new one.
fn added(text: &str, name: Span, syntax: Syntax, entries: &[(String, String)]) -> Option<Edit> {
    let end = name.range().end;
    let rest = text.get(end..)?;
    let arguments = if rest.starts_with('(') { rest.find(')').map_or(0, |n| n + 1) } else { 0 };
    let (at, rest) = (end + arguments, &rest[arguments..]);
    let insert = |at: usize, new: String| Some(Edit { span: Span::new(name.source, at, at), new });
    let joined = |colon: &str, between: &str| {
        entries.iter().map(|(key, value)| format!("{key}{colon} {value}")).collect::<Vec<_>>().join(between)
    };
    if syntax == Syntax::Native {
        let entries = joined("", "  ");
        return match rest.trim_start_matches([' ', '\t']).starts_with('{') {
            true => insert(at + rest.find('{')? + 1, format!(" {entries} ")),
            false => insert(at, format!(" {{ {entries} }}")),
        };
    }
    let value = rest.strip_prefix(':')?;
    if value.trim_start_matches(' ').starts_with('{') {
        return insert(at + 1 + value.find('{')? + 1, format!(" {},", joined(":", ", ")));
    }
    // An indented block below: its first line determines the indentation.
    let (_, below) = value.split_once('\n')?;
    let indent = &below[..below.len() - below.trim_start_matches(' ').len()];
    insert(text.len() - below.len(), format!("{indent}{}\n", joined(":", &format!("\n{indent}"))))
}

/// Applies fixes to a text, in their order. A fix whose edits touch those of an earlier one, or lie outside the text, is
/// left out. Returns the new text and the fixes that were applied.
pub fn apply<'f>(text: &str, fixes: impl IntoIterator<Item = &'f Fix>) -> (String, Vec<&'f Fix>) {
    let mut all: Vec<&Edit> = Vec::new();
    let mut applied = Vec::new();
    for fix in fixes {
        let touches = |e: &Edit| {
            let (a, outside) = (e.span.range(), text.get(e.span.range()).is_none());
            outside
                || all.iter().any(|other| {
                    let b = other.span.range();
                    a.start < b.end && b.start < a.end || a.start == b.start
                })
        };
        if !fix.edits().iter().any(touches) {
            all.extend(fix.edits());
            applied.push(fix);
        }
    }
    all.sort_by_key(|e| (e.span.start, e.span.end));
    let mut out = text.to_string();
    for edit in all.into_iter().rev() {
        out.replace_range(edit.span.range(), &edit.new);
    }
    (out, applied)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SourceId;

    fn fix(start: usize, end: usize, new: &str) -> Fix {
        Fix::replace(Span::new(SourceId(0), start, end), new)
    }

    #[test]
    fn fixes_that_touch_are_left_out() {
        let all = [fix(1, 3, "Y"), fix(0, 2, "X"), fix(4, 4, "!"), fix(4, 4, "?"), fix(3, 9, "Z")];
        let (text, applied) = apply("abcd", &all);
        assert_eq!(text, "aYd!");
        assert_eq!(applied, [&all[0], &all[2]]);
        assert_eq!(apply("abcd", &[fix(0, 2, "X"), fix(2, 3, "Y")]).0, "XYd");
    }

    #[test]
    fn changes_in_both_syntaxes() {
        for (syntax, before, after) in [
            (Syntax::Native, "robot arm { urdf \"a\" }", "robot arm { rate 1 Hz  urdf \"a\" }"),
            (Syntax::Native, "robot arm\n", "robot arm { rate 1 Hz }\n"),
            (Syntax::Native, "robot arm(x) { }", "robot arm(x) { rate 1 Hz  }"),
            (Syntax::Yaml, "robot: arm: { urdf: a }", "robot: arm: { rate: 1 Hz, urdf: a }"),
            (Syntax::Yaml, "robot: arm:\n  urdf: a\n", "robot: arm:\n  rate: 1 Hz\n  urdf: a\n"),
        ] {
            let mut sources = Sources::default();
            let source = sources.add("x", before);
            let at = before.find("arm").unwrap();
            let fix = Fix::entries(Span::new(source, at, at + 3), vec![("rate".into(), "1 Hz".into())]);
            let fix = fix.settled(&sources, syntax).unwrap();
            assert_eq!(apply(before, [&fix]).0, after);
        }
    }
}
