//! Hover texts.

use std::fmt::Write;
use std::ops::Range;

use compiler::sections::Key;
use compiler::{Verb, units};
use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::ParamInfo;
use stdlib_tasks::task::{Nature, TaskKind};

use super::document::{Analysis, Document};
use super::library::Source;
use super::mentions::{Class, Mentions, What};
use super::text::Text;
use super::vocabulary::{FAULTS, MEASURED, TRIGGERS, find};
use super::walk_machines::outcome_of;
use crate::catalogue::{self, describe, presence};
use crate::keys;

/// Maximum number of lines shown of a declaration.
const SHOWN: usize = 16;

/// Hover text for the word at a byte.
pub(super) fn of(document: &Document, byte: usize) -> Option<Hover> {
    let analysis = document.analysis()?;
    let mention = analysis.mentions.at(byte)?;
    let value = match &mention.what {
        What::Declared(class, name) => declared(document, analysis, *class, name)?,
        What::Brought(class, there) => shown(*class, &there.source, &there.whole, &there.name, &[])?,
        What::Link(name) => analysis.urdf.as_ref()?.links.get(name)?.about.clone(),
        What::Joint(name) => analysis.urdf.as_ref()?.joints.get(name)?.about.clone(),
        What::Spec(written) => {
            let file = analysis.imports.iter().find(|i| i.written == *written)?.file.as_ref()?;
            let names = super::walk_reuse::VISIBLE.iter().map(|class| file.mentions.names(*class).count());
            format!("`{written}` declares {} names", names.sum::<usize>())
        }
        What::File => {
            let urdf = analysis.urdf.as_ref()?;
            format!("{} links, {} joints", urdf.links.len(), urdf.joints.len())
        }
        What::Kind(kind) => task_kind(kind),
        What::Parameter(kind, info) => format!("{}\n\nParameter of `{}`.", parameter(info), kind.name),
        What::Told(kind, told) => {
            let unit = catalogue::unit(told.dimension);
            format!("`{}`, in {unit}: {}\n\nWhat a task `{}` tells while it runs.", told.name, told.is, kind.name)
        }
        What::Key(key) => self::key(key),
        What::Verb(verb) => self::verb(verb),
        What::BuiltIn(name) => built_in(name)?,
        What::Unit(unit) => {
            let text = document.text.as_str().get(mention.place.clone()).filter(|_| mention.exact);
            let (factor, dimension) = units::meaning(unit).ok()?;
            let si = units::written(dimension);
            let si = if si.is_empty() { "a bare number".to_string() } else { format!("`{si}`") };
            match text {
                Some(t) => format!("`1 {t}` is {factor} {si}: {}", dimension.describe()),
                None => format!("{factor} {si}: {}", dimension.describe()),
            }
        }
    };
    let contents = HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value });
    Some(Hover { contents, range: Some(document.text.range(mention.place.clone())) })
}

/// Text for a verb: syntax, description, and outcomes.
pub(super) fn verb(verb: &Verb) -> String {
    let outcomes: Vec<String> = verb.outcomes.iter().map(|o| format!("`{o}`")).collect();
    match outcomes.as_slice() {
        [] => format!("`{}`: {}", verb.form, verb.doc),
        some => format!("`{}`: {}\n\nAn event tells how it came out: {}.", verb.form, verb.doc, some.join(" or ")),
    }
}

/// Text for an event: the actions that raise it.
pub(super) fn event(mentions: &Mentions, name: &str) -> Option<String> {
    let outcomes: Vec<&Verb> = outcome_of(name).filter(|_| mentions.raised.contains_key(name)).collect();
    if !outcomes.is_empty() {
        let verbs: Vec<String> = outcomes.iter().map(|v| format!("`{}`", v.name)).collect();
        return Some(format!("event `{name}`: how {} came out", verbs.join(" or ")));
    }
    mentions.raised.contains_key(name).then(|| format!("event `{name}`: raised by `emit {name}`"))
}

fn declared(document: &Document, analysis: &Analysis, class: Class, name: &str) -> Option<String> {
    if class == Class::Raised {
        return event(&analysis.mentions, name);
    }
    let declaration = analysis.mentions.declared.get(&(class, name.to_string()))?;
    match &declaration.elsewhere {
        Some(there) => shown(class, &there.source, &there.whole, name, &declaration.comments),
        None => {
            let here = (&document.text, document.syntax()?);
            code(class, here, &declaration.whole, name, &declaration.comments)
        }
    }
}

/// Text for a declaration of another file.
fn shown(class: Class, source: &Source, whole: &Range<usize>, name: &str, comments: &[String]) -> Option<String> {
    let text = code(class, (&source.text, source.syntax), whole, name, comments)?;
    let file = source.path.file_name()?.to_string_lossy();
    Some(format!("{text}\n\nDeclared in `{file}`."))
}

/// Text for a declaration: class, first lines, comments.
fn code(
    class: Class,
    (text, syntax): (&Text, dsl::Syntax),
    whole: &Range<usize>,
    name: &str,
    comments: &[String],
) -> Option<String> {
    let start = whole.start;
    let whole = text.as_str().get(whole.clone())?;
    // Remove the indentation of the declaration from the following lines.
    let column = text.position(start).character as usize;
    let mut lines = whole.lines().enumerate().map(|(i, l)| match l.get(..column) {
        Some(space) if i > 0 && space.trim().is_empty() => &l[column..],
        _ => l,
    });
    let mut code: Vec<&str> = lines.by_ref().take(SHOWN).collect();
    if lines.next().is_some() {
        code.push("..");
    }
    let language = if syntax == dsl::Syntax::Native { "hq" } else { "yaml" };
    let short = name.rsplit('.').next().unwrap_or(name);
    let mut out = format!("{} `{short}`\n\n```{language}\n{}\n```", class.word(), code.join("\n"));
    let comments = comments.join("\n");
    if !comments.trim().is_empty() {
        let _ = write!(out, "\n\n{}", comments.trim());
    }
    Some(out)
}

/// Text for a key: type, presence, description.
pub(super) fn key(key: &Key) -> String {
    format!("`{}`: {}; {}\n\n{}", key.name, keys::describe(&key.holds), presence(&key.presence), key.doc)
}

/// Text for a parameter: type, presence, description.
pub(super) fn parameter(info: &ParamInfo) -> String {
    format!("`{}`: {}; {}\n\n{}", info.name, describe(&info.ty), presence(&info.presence), info.text())
}

/// Text for a task type: its page of the catalogue.
pub(super) fn task_kind(kind: &TaskKind) -> String {
    let nature = match kind.nature {
        Nature::Limit => "limit",
        Nature::Target => "target",
    };
    let mut out = format!("**{}** ({nature}): {}\n\n{}\n\n", kind.name, kind.summary, kind.docs);
    for info in kind.params {
        let _ = writeln!(out, "- `{}`: {}; {}", info.name, describe(&info.ty), presence(&info.presence));
    }
    let _ = write!(out, "\n```hq\n{}\n```", kind.example);
    out
}

/// Text for a function or a built-in name.
pub(super) fn built_in(name: &str) -> Option<String> {
    let triggers = TRIGGERS.iter().chain(FAULTS).chain(MEASURED);
    if let Some(known) = find(name).or_else(|| triggers.clone().find(|k| k.name == name)) {
        return Some(known.doc.to_string());
    }
    if let Some((of, argument)) = name.split_once('.') {
        let of = compiler::expr::TRAJECTORIES.iter().find(|t| t.name == of)?;
        let named = of.named.iter().find(|n| n.name == argument)?;
        return Some(format!("`{}` of `{}`: {}.", named.name, of.name, named.text));
    }
    if let Some(of) = compiler::expr::TRAJECTORIES.iter().find(|t| t.name == name) {
        let lines = of.named.iter().map(|n| format!("\n- `{}`: {}", n.name, n.text));
        return Some(format!("`{}`: {}.\n{}", of.form, of.text, lines.collect::<String>()));
    }
    let function = compiler::expr::function(name)?;
    Some(format!("`{}`\n\n- arguments: {}\n- result: {}", function.form, function.takes, function.gives))
}

/// Text for a unit symbol: its value in SI.
pub(super) fn unit(symbol: &str) -> Option<String> {
    let unit = dsl::tree::Unit { factors: vec![(symbol.to_string(), 1)], span: dsl::Span::default() };
    let (factor, dimension) = units::meaning(&unit).ok()?;
    let si = if dimension == NONE { String::new() } else { format!(" {}", units::written(dimension)) };
    Some(format!("{factor}{si}"))
}
