//! Differences as text: for a terminal, and as Markdown for a review.

use std::fmt::Write;

use super::{Difference, Differences, Finding};

/// Form of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// For a terminal.
    Plain,
    /// Markdown.
    Markdown,
}

/// Stands for the subject after a whole one.
const WHOLE: &str = "+";

/// Renders differences; `names` are those of the two files.
pub fn render(of: &Differences, names: [&str; 2], form: Form) -> String {
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(of, names, form, &mut out);
    out
}

fn write(of: &Differences, [before, after]: [&str; 2], form: Form, out: &mut String) -> std::fmt::Result {
    let markdown = form == Form::Markdown;
    let heading = |out: &mut String, text: &str| match markdown {
        true => writeln!(out, "\n#### {text}\n"),
        false => writeln!(out, "\n{text}"),
    };
    if markdown {
        writeln!(out, "### Behaviour of `{after}` compared with `{before}`")?;
    }
    if of.is_empty() {
        return writeln!(out, "{}no difference in behaviour", if markdown { "\n" } else { "" });
    }
    let mut subject = "";
    for difference in &of.behaviour {
        if difference.attribute.is_empty() {
            let (sign, words) = if difference.after.is_some() { ('+', "added") } else { ('-', "removed") };
            // Those that come one after another are a list.
            if subject != WHOLE {
                writeln!(out)?;
            }
            match markdown {
                true => writeln!(out, "- `{}` {words}", difference.subject)?,
                false => writeln!(out, "{sign} {}", difference.subject)?,
            }
            subject = WHOLE;
            continue;
        }
        if difference.subject != subject {
            subject = &difference.subject;
            heading(out, subject)?;
        }
        line(difference, markdown, out)?;
    }
    for (title, findings) in [("new warnings", &of.gained), ("warnings that are gone", &of.lost)] {
        if !findings.is_empty() {
            heading(out, title)?;
        }
        for Finding { code, message } in findings {
            match markdown {
                true => writeln!(out, "- `{code}` {message}")?,
                false => writeln!(out, "  {code} {message}")?,
            }
        }
    }
    if of.findings_unknown {
        writeln!(out, "\nwarnings are not compared: a compiled program has none")?;
    }
    Ok(())
}

/// A digest behind a text says that something differs, and nothing to a reader.
fn without_digest(text: &str) -> &str {
    match text.rsplit_once('#') {
        Some((words, digest)) if digest.len() == 6 && digest.chars().all(|c| c.is_ascii_hexdigit()) => words.trim_end(),
        _ => text,
    }
}

fn line(difference: &Difference, markdown: bool, out: &mut String) -> std::fmt::Result {
    let Difference { attribute, before, after, .. } = difference;
    let quoted = |text: &str| if markdown { format!("`{text}`") } else { text.to_string() };
    let name = quoted(attribute);
    let start = if markdown { "- " } else { "  " };
    match (before.as_deref().map(without_digest), after.as_deref().map(without_digest)) {
        (Some(a), Some(b)) if a == b => writeln!(out, "{start}{name}: changed"),
        (Some(a), Some(b)) => {
            let or_none = |text: &str| if text.is_empty() { "nothing".to_string() } else { quoted(text) };
            writeln!(out, "{start}{name}: {} -> {}", or_none(a), or_none(b))
        }
        (None, Some("")) => writeln!(out, "{start}+ {name}"),
        (Some(""), None) => writeln!(out, "{start}- {name}"),
        (None, Some(b)) => writeln!(out, "{start}+ {name}: {}", quoted(b)),
        (Some(a), None) => writeln!(out, "{start}- {name}: {}", quoted(a)),
        (None, None) => Ok(()),
    }
}
