//! Arguments of `fault(..)`, and tasks that triggers name.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Span};
use names::list;
use runtime::FaultKind;
use runtime::program::FaultPattern;

use crate::diagnostics::examples;
use crate::diagnostics::refused::{Refused, refuse};
use crate::forms::{path_of, text_of};

/// Names in scope of a pattern of faults.
pub(super) struct Known<'k> {
    pub signals: Vec<&'k str>,
    /// People, with the indices of their points among the signals.
    pub humans: Vec<(&'k str, &'k [usize])>,
    pub tasks: &'k [&'k str],
    /// For each task, true if it is a limit.
    pub limits: Vec<bool>,
    /// Names of the levels of all stacks, with `true` for hard ones; `None` if some are unknown.
    pub levels: Option<&'k [(&'k str, bool)]>,
}

/// Lowers the argument of `fault(..)`.
pub(super) fn pattern(args: &[Value], at: Span, known: &Known) -> Result<FaultPattern, Refused> {
    let [value] = args else {
        let d = Diagnostic::error("HQ0310", at, "`fault` takes one kind of fault");
        return refuse(d.help("write `fault(any)`, `fault(stale(SIGNAL))`, `fault(infeasible)`"));
    };
    let words = || FaultKind::ALL.into_iter().map(FaultKind::word);
    if let ValueKind::Call(kind, args) = &value.kind {
        let name = args.first().filter(|_| args.len() == 1).and_then(path_of);
        let name = name.as_deref();
        if let ("stale", Some(name)) = (kind.value.as_str(), name)
            && let Some((_, points)) = known.humans.iter().find(|h| h.0 == name)
        {
            return Ok(FaultPattern::StaleAmong(points.to_vec()));
        }
        return match (kind.value.as_str(), name) {
            ("stale", Some(name)) => match known.signals.iter().position(|s| *s == name) {
                Some(signal) => Ok(FaultPattern::Stale(signal)),
                None => {
                    let d = Diagnostic::undeclared("signal", name, args[0].span);
                    refuse(
                        d.help(Help::with("declare it: {}", [examples::signal("TYPE")]))
                            .nearest(name, known.signals.iter().chain(known.humans.iter().map(|h| &h.0)).copied()),
                    )
                }
            },
            ("infeasible", Some(name)) => match known.levels.and_then(|all| no_hard_level(name, args[0].span, all)) {
                Some(d) => refuse(d),
                None => Ok(FaultPattern::Infeasible(name.to_string())),
            },
            ("limit", Some(_)) => {
                let task = task_of(args.first(), at, known.tasks).map_err(Some)?;
                if !known.limits[task] {
                    let text = format!("`{}` is not a limit", known.tasks[task]);
                    let d = Diagnostic::error("HQ0703", args[0].span, text);
                    return refuse(d.help("name a task that keeps a limit"));
                }
                Ok(FaultPattern::Limit(task))
            }
            (other, _) => {
                let d = Diagnostic::error("HQ0310", value.span, format!("`{other}(..)` is not a kind of fault"));
                refuse(d.help("write `stale(SIGNAL)`, `infeasible(LEVEL)`, `limit(TASK)`, or a kind alone"))
            }
        };
    }
    let Some(word) = text_of(value) else {
        if matches!(value.kind, ValueKind::Missing) {
            return Err(None);
        }
        let d = Diagnostic::error("HQ0304", value.span, "this is not a kind of fault");
        return refuse(d.help(format!("kinds are `any`, {}", list(words(), 12))));
    };
    if word == "any" {
        return Ok(FaultPattern::Any);
    }
    match FaultKind::ALL.into_iter().find(|k| k.word() == word) {
        Some(kind) => Ok(FaultPattern::Kind(kind)),
        None => {
            let d = Diagnostic::undeclared("fault", word, value.span);
            refuse(d.one_of("kinds are", word, ["any"].into_iter().chain(words())))
        }
    }
}

/// Diagnostic for a level that does not exist, or that is hard in no stack.
fn no_hard_level(name: &str, at: Span, all: &[(&str, bool)]) -> Option<Diagnostic> {
    if all.contains(&(name, true)) {
        return None;
    }
    if all.contains(&(name, false)) {
        let d = Diagnostic::error("HQ0703", at, format!("level `{name}` is soft, so it is never infeasible"));
        return Some(d.help("name a level that is `hard` in some stack"));
    }
    let mut hard: Vec<&str> = all.iter().filter(|l| l.1).map(|l| l.0).collect();
    hard.sort_unstable();
    hard.dedup();
    let d = Diagnostic::unknown_name(at, format!("no stack has a level `{name}`"));
    Some(d.help("no stack has a hard level").one_of("hard levels are", name, hard.iter().copied()))
}

/// Index of the task that a trigger names.
pub(super) fn task_of(value: Option<&Value>, at: Span, tasks: &[&str]) -> Result<usize, Box<Diagnostic>> {
    let Some((value, name)) = value.and_then(|v| Some((v, path_of(v)?))) else {
        let d = Diagnostic::error("HQ0310", at, "the name of a task is needed here");
        return Err(Box::new(match value.map(|v| &v.kind) {
            Some(ValueKind::Call(..)) => {
                d.help("declare the task, `task NAME = ..`, and write its name here and in the stack")
            }
            _ => d.help("write for instance `reached(reach, 5 mm, 2 deg)`"),
        }));
    };
    if let Some(task) = tasks.iter().position(|t| *t == name) {
        return Ok(task);
    }
    let d = Diagnostic::undeclared("task", &name, value.span);
    Err(Box::new(d.one_of("declared are", &name, tasks.iter().copied())))
}
