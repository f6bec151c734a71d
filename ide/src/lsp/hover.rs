//! Hover texts.

use std::fmt::Write;

use compiler::resolve::{FAULTS, File, FileId, MEASURED, Meaning, Resolution, Symbol, SymbolId, SymbolKind, TRIGGERS};
use compiler::sections::Key;
use compiler::{VERBS, Verb, resolve, units};
use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::ParamInfo;
use stdlib_tasks::task::{RowKind, TaskKind};

use super::allowances;
use super::document::Document;
use super::text::Text;
use crate::catalogue::{self, describe, presence};
use crate::keys;

/// Maximum number of lines shown of a declaration.
const SHOWN: usize = 16;

/// Hover text for the word at a byte.
pub(super) fn of(document: &Document, byte: usize) -> Option<Hover> {
    if let Some(code) = allowances::hover(document, byte) {
        return Some(code);
    }
    let names = document.names()?;
    let reference = names.at(byte)?;
    let value = match &reference.meaning {
        Meaning::Symbol(id) => symbol(names, *id)?,
        Meaning::Unknown(..) => return None,
        Meaning::File(file) => self::file(names, (*file)?),
        Meaning::TaskType(kind) => task_kind(kind),
        Meaning::Parameter(kind, info) => format!("{}\n\nParameter of `{}`.", parameter(info), kind.name),
        Meaning::Output(kind, output) => {
            let unit = catalogue::unit(output.dimension);
            format!(
                "`{}`, in {unit}: {}\n\nOutput of a task `{}` while it runs.",
                output.name, output.description, kind.name
            )
        }
        Meaning::Argument(of) => {
            let unit = catalogue::unit(of.dimension);
            format!("`{}`, in {unit}: {}\n\nArgument of this function.", of.name, of.doc)
        }
        Meaning::Key(key) => self::key(key),
        Meaning::Verb(verb) => self::verb(verb),
        Meaning::BuiltIn(name) => built_in(name)?,
        Meaning::Unit(unit, _) => {
            let text = document.text.as_str().get(reference.place.clone()).filter(|_| reference.exact);
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
    Some(Hover { contents, range: Some(document.text.range(reference.place.clone())) })
}

/// Text for a verb: syntax, description, and outcomes.
pub(super) fn verb(verb: &Verb) -> String {
    let outcomes: Vec<String> = verb.outcomes.iter().map(|o| format!("`{o}`")).collect();
    match outcomes.as_slice() {
        [] => format!("`{}`: {}", verb.form, verb.doc),
        some => format!("`{}`: {}\n\nIts outcome is an event: {}.", verb.form, verb.doc, some.join(" or ")),
    }
}

/// Verbs with this outcome.
pub(super) fn verbs_with(outcome: &str) -> impl Iterator<Item = &'static Verb> {
    VERBS.iter().filter(move |v| v.outcomes.contains(&outcome))
}

/// Text for a symbol: its declaration, or its description.
pub(super) fn symbol(names: &Resolution, id: SymbolId) -> Option<String> {
    let origin = names.symbol(names.origin(id));
    let name = &names.symbol(id).name;
    match origin.kind {
        // A part of the URDF or of the SRDF.
        _ if names.files[origin.file.0].syntax.is_none() => Some(origin.doc.concat()),
        SymbolKind::RaisedEvent => Some(format!("event `{name}`: raised by `emit {name}`")),
        SymbolKind::Outcome => {
            let verbs: Vec<String> = verbs_with(name).map(|v| format!("`{}`", v.name)).collect();
            Some(format!("event `{name}`: how {} came out", verbs.join(" or ")))
        }
        _ => {
            let file = &names.files[origin.file.0];
            let code = code(origin, name, names.text(file), file)?;
            if origin.file == FileId(0) {
                return Some(code);
            }
            Some(format!("{code}\n\nDeclared in `{}`.", file.path.file_name()?.to_string_lossy()))
        }
    }
}

/// Text for a declaration: kind, first lines, comments.
fn code(symbol: &Symbol, name: &str, text: &str, file: &File) -> Option<String> {
    let start = symbol.whole.start;
    let whole = text.get(symbol.whole.clone())?;
    // Remove the indentation of the declaration from the following lines.
    let column = Text::new(text.to_string()).position(start).character as usize;
    let mut lines = whole.lines().enumerate().map(|(i, l)| match l.get(..column) {
        Some(space) if i > 0 && space.trim().is_empty() => &l[column..],
        _ => l,
    });
    let mut code: Vec<&str> = lines.by_ref().take(SHOWN).collect();
    if lines.next().is_some() {
        code.push("..");
    }
    let language = if file.syntax == Some(dsl::Syntax::Native) { "hq" } else { "yaml" };
    let mut out = format!("{} `{name}`\n\n```{language}\n{}\n```", symbol.kind.word(), code.join("\n"));
    let comments = symbol.doc.join("\n");
    if !comments.trim().is_empty() {
        let _ = write!(out, "\n\n{}", comments.trim());
    }
    Some(out)
}

/// Text for a file: the number of its names.
fn file(names: &Resolution, id: FileId) -> String {
    let own = || names.symbols.iter().filter(|s| s.file == id);
    let count = |kind: SymbolKind| own().filter(|s| s.kind == kind).count();
    let file = &names.files[id.0];
    match file.syntax {
        None if count(SymbolKind::Link) == 0 => {
            format!("{} groups, {} postures", count(SymbolKind::JointGroup), count(SymbolKind::Posture))
        }
        None => format!("{} links, {} joints", count(SymbolKind::Link), count(SymbolKind::Joint)),
        Some(_) => {
            let name = file.path.file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
            format!("`{name}` declares {} names", own().filter(|s| s.container.is_none()).count())
        }
    }
}

/// Text for a key: type, presence, description.
pub(super) fn key(key: &Key) -> String {
    format!("`{}`: {}; {}\n\n{}", key.name, keys::describe(&key.value), presence(&key.presence), key.doc)
}

/// Text for a parameter: type, presence, description.
pub(super) fn parameter(info: &ParamInfo) -> String {
    format!("`{}`: {}; {}\n\n{}", info.name, describe(&info.ty), presence(&info.presence), info.text())
}

/// Text for a task type: its page of the catalogue.
pub(super) fn task_kind(kind: &TaskKind) -> String {
    let row_kind = match kind.row_kind {
        RowKind::Inequality => "limit",
        RowKind::Equality => "target",
    };
    let mut out = format!("**{}** ({row_kind}): {}\n\n{}\n\n", kind.name, kind.summary, kind.docs);
    for info in kind.params {
        let _ = writeln!(out, "- `{}`: {}; {}", info.name, describe(&info.ty), presence(&info.presence));
    }
    let _ = write!(out, "\n```hq\n{}\n```", kind.example);
    out
}

/// Text for a function or a built-in name.
pub(super) fn built_in(name: &str) -> Option<String> {
    let triggers = TRIGGERS.iter().chain(FAULTS).chain(MEASURED);
    if let Some(known) = resolve::built_in(name).or_else(|| triggers.clone().find(|k| k.name == name)) {
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
