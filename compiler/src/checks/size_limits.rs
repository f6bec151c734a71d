//! Bounds on the size of a spec. A larger spec is rejected before names are resolved, so that no text takes long.

use dsl::tree::{ItemKind, Machine, Spec, Stack, StateBody};
use dsl::{Diagnostic, Span};
use runtime::program::{Program, StackProgram};
use stdlib_tasks::bound::Bound;

use crate::expand::Expanded;
use crate::source_map::SourceMap;

/// Maximum number of declarations in a spec.
const MAX_DECLARATIONS: usize = 5_000;
/// Maximum number of stacks in a spec.
const MAX_STACKS: usize = 200;
/// Maximum number of tasks on the levels of all stacks.
const MAX_MEMBERS: usize = 5_000;
/// Maximum number of states of all machines.
const MAX_STATES: usize = 5_000;
/// Maximum number of transitions and actions of all states.
const MAX_TRANSITIONS: usize = 10_000;
/// Maximum number of rows of a stack, and of pairs of parts that a collision limit compares.
const MAX_ROWS: usize = 2_000;

fn too_many(span: Span, what: &str, most: usize) -> Diagnostic {
    Diagnostic::error("HQ0190", span, format!("this spec has more than {most} {what}"))
        .here("read up to here")
        .help("split the spec, or generate a smaller one")
}

/// Diagnostic for a spec with too many parts, before expansion.
pub(crate) fn spec(spec: &Spec) -> Option<Diagnostic> {
    if let Some(item) = spec.items.get(MAX_DECLARATIONS) {
        return Some(too_many(item.span, "declarations", MAX_DECLARATIONS));
    }
    let stacks =
        || spec.items.iter().filter_map(|item| if let ItemKind::Stack(s) = &item.kind { Some(s) } else { None });
    if let Some(stack) = past(stacks(), |s| s.levels.len() + s.changes.len(), MAX_MEMBERS) {
        return Some(too_many(stack.name.span, "levels", MAX_MEMBERS));
    }
    machines(spec.items.iter().filter_map(|item| if let ItemKind::Machine(m) = &item.kind { Some(m) } else { None }))
}

/// Returns the first item at which the total number of parts exceeds `most`.
fn past<T>(all: impl IntoIterator<Item = T>, parts: impl Fn(&T) -> usize, most: usize) -> Option<T> {
    let mut count = 0;
    all.into_iter().find(|one| {
        count += parts(one);
        count > most
    })
}

/// Diagnostic for machines with too many parts.
fn machines<'m>(machines: impl IntoIterator<Item = &'m Machine>) -> Option<Diagnostic> {
    // Bodies of the machines, each followed by the bodies of its states, in source order.
    let mut bodies: Vec<(Span, &StateBody)> = Vec::new();
    let mut open: Vec<(Span, &StateBody)> = machines.into_iter().map(|m| (m.name.span, &m.body)).collect();
    open.reverse();
    while let Some((at, body)) = open.pop() {
        open.extend(body.states.iter().rev().map(|s| (s.name.span, &s.body)));
        bodies.push((at, body));
    }
    if let Some((at, _)) = bodies.get(MAX_STATES) {
        return Some(too_many(*at, "states", MAX_STATES));
    }
    let (at, _) = past(bodies, |(_, b)| b.transitions.len() + b.actions.len(), MAX_TRANSITIONS)?;
    Some(too_many(at, "transitions and actions", MAX_TRANSITIONS))
}

/// Diagnostic for stacks with too many parts, after expansion.
fn stacks(stacks: &[Stack]) -> Option<Diagnostic> {
    if let Some(stack) = stacks.get(MAX_STACKS) {
        return Some(too_many(stack.name.span, "stacks", MAX_STACKS));
    }
    let levels = || stacks.iter().flat_map(|s| &s.levels);
    if let Some(level) = levels().nth(MAX_MEMBERS) {
        return Some(too_many(level.name.span, "levels", MAX_MEMBERS));
    }
    let member = levels().flat_map(|l| &l.members).nth(MAX_MEMBERS)?;
    Some(too_many(member.span, "tasks on its levels", MAX_MEMBERS))
}

/// Diagnostic for a spec with too many parts, after expansion.
pub(crate) fn expanded(expanded: &Expanded) -> Option<Diagnostic> {
    stacks(&expanded.stacks).or_else(|| machines(&expanded.machines))
}

/// Diagnostic for a task that compares too many pairs. Such a task is not even built.
pub(crate) fn pairs(program: &Program, stack: &StackProgram, places: &SourceMap) -> Option<Diagnostic> {
    let members = stack.levels.iter().flat_map(|l| &l.members);
    let large = members.map(|m| m.task).find(|&t| {
        let sides = ["between", "and"].map(|side| match program.tasks[t].params.get(side) {
            Some(Bound::Geometries(all)) => all.len(),
            _ => 0,
        });
        let within = !program.tasks[t].params.contains_key("and");
        let pairs = match within {
            true => sides[0].saturating_mul(sides[0].saturating_sub(1)) / 2,
            false => sides[0].saturating_mul(sides[1]),
        };
        pairs > MAX_ROWS
    })?;
    let text = format!("this task compares more than {MAX_ROWS} pairs of parts");
    Some(
        Diagnostic::error("HQ0623", places.tasks[large].span, text)
            .note("every pair is evaluated in every tick")
            .help("name the parts that can really meet, or use points and segments in the place of links"),
    )
}

/// Diagnostic for stack `i` if it has too many rows.
pub(crate) fn rows(rows: usize, i: usize, places: &SourceMap) -> Option<Diagnostic> {
    let at = places.stacks.get(i)?.0;
    (rows > MAX_ROWS).then(|| {
        Diagnostic::error("HQ0623", at, format!("this stack has {rows} rows, and {MAX_ROWS} are the most"))
            .note("all rows are solved in every tick")
            .help("move tasks to other stacks, or leave out limits that can never be reached")
    })
}
