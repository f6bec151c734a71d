//! Driver of the compiler: from the text of a spec to its program and missions, with all diagnostics.
//!
//! [`dsl::parse`] reads the text, `expand` resolves imports, repetitions and parameters, `lowering` builds a program
//! and missions, and `checks` examines the program. Diagnostics that only follow from others are removed before the
//! report.

use std::collections::BTreeSet;

use dsl::tree::Spec;
use dsl::{Diagnostic, Fix, SourceId, Sources, Span, Syntax, Topic};
use robot::Srdf;
use runtime::program::{AllowedWarning, MissionProgram, Program};

use crate::checks::{self, size_limits};
use crate::cli_overrides;
use crate::diagnostics::allowances::Allowed;
use crate::diagnostics::report::Report;
use crate::diagnostics::{cascading_errors, codes};
use crate::expand::{Expanded, declared, expand};
use crate::input::{Compiled, Input, Part, Texts};
use crate::lowering::{self, Context, ParamValue, lower, runs_mission};
use crate::robot_binding::RobotSrdf;
use crate::sampled::Deep;

/// Compiles a spec.
pub fn compile(input: &Input) -> Compiled {
    compile_among(input, &Texts::new())
}

/// Compiles a spec; `texts` replaces the contents of imported files.
pub fn compile_among(input: &Input, texts: &Texts) -> Compiled {
    compile_part(input, texts, Part::Whole)
}

/// Compiles a spec without the contents of its files of bytes, such as trained policies: for a command that makes them.
pub fn compile_unread(input: &Input) -> Compiled {
    compile_part(input, &Texts::new(), Part::Unread)
}

/// Compiles a spec, with the checks at sampled postures, which take seconds.
pub fn compile_deep(input: &Input, deep: &Deep) -> Compiled {
    compile_with(input, &Texts::new(), Part::Whole, Some(deep))
}

/// Evaluates the params of a spec, in source order. Params with errors are left out; [`compile`] reports these. A value
/// from `Input::set` without a unit takes the unit of the param's default.
pub fn params(input: &Input) -> Vec<ParamValue> {
    let (mut sources, texts) = (Sources::default(), Texts::new());
    let source = sources.add(input.name, input.text);
    let (spec, mut diagnostics) = dsl::parse(source, input.text, input.syntax);
    let expanded = expand((input, &texts), source, spec, &mut sources, &mut diagnostics);
    let context = Context { input, texts: &texts, source, compile: compile_part, reads_bytes: false };
    lowering::params(&context, &expanded, &mut sources, &mut diagnostics)
}

fn compile_part(input: &Input, texts: &Texts, part: Part) -> Compiled {
    compile_with(input, texts, part, None)
}

fn compile_with(input: &Input, texts: &Texts, part: Part, deep: Option<&Deep>) -> Compiled {
    let mut report = Report::default();
    let source = report.sources.add(input.name, input.text);
    let (spec, mut diagnostics) = dsl::parse(source, input.text, input.syntax);
    if let Some(refusal) = size_limits::spec(&spec) {
        return refused(report, diagnostics, refusal);
    }
    let (form, whole) = (diagnostics.len(), spec.clone());
    let empty = spec.items.is_empty();

    let mut expanded = expand((input, texts), source, spec, &mut report.sources, &mut diagnostics);
    let left_out = part == Part::Controller && !expanded.missions.is_empty();
    if part == Part::Controller {
        expanded.missions.clear();
        expanded.scenarios.retain(|(s, _)| !runs_mission(s));
    }
    if let Some(refusal) = size_limits::expanded(&expanded).filter(|_| expanded.usable) {
        return refused(report, diagnostics, refusal);
    }

    let context = Context { input, texts, source, compile: compile_part, reads_bytes: part != Part::Unread };
    let lowered = lower(&context, &expanded, empty, &mut report.sources, &mut diagnostics);
    let mut sampled = None;
    if let Some(controller) = &lowered.controller {
        sampled = checks::controller(controller, &expanded, &report.sources, deep, &mut diagnostics);
    }

    cascading_errors::remove(&mut diagnostics, form, &whole, &report.sources);
    removals(&mut diagnostics, &whole);
    // Without the missions, names that only missions use would be reported as unused.
    diagnostics.retain(|d| !left_out || d.topic != Topic::Unused);
    settle(&mut diagnostics, input.syntax, &expanded, &lowered.foreign, &report.sources);
    report.diagnostics = diagnostics;
    allow(&mut report, &expanded, (input, part, source), deep.is_some());
    report.finish();
    if cli_overrides::attribute_errors(compile, input, &mut report.diagnostics, &report.sources) {
        report.finish();
    }
    if report.errors() > 0 {
        return Compiled::refused(report);
    }
    let allowed = allowed(&report);
    let srdf = lowered.controller.as_ref().and_then(|c| all_of(&c.source_map.srdf));
    let meshes = lowered.controller.as_ref().map(|c| c.source_map.meshes.clone()).unwrap_or_default();
    let program = lowered.controller.map(|c| Program { allowed: allowed.clone(), ..c.program });
    // Each warning is listed once by `hierarq compile`.
    let listed = if program.is_some() { Vec::new() } else { allowed };
    let missions = lowered.missions.into_iter().map(|m| MissionProgram { allowed: listed.clone(), ..m });
    Compiled { program, missions: missions.collect(), srdf, meshes, report, sampled }
}

/// The allowed warnings of a report, for the program.
fn allowed(report: &Report) -> Vec<AllowedWarning> {
    let one =
        |a: &Allowed| AllowedWarning { code: a.code.to_string(), message: a.message.clone(), reason: a.reason.clone() };
    report.allowed.iter().map(one).collect()
}

/// The descriptions of all robots as one; `None` without any.
fn all_of(described: &[RobotSrdf]) -> Option<Srdf> {
    let (first, rest) = described.split_first()?;
    let mut all = first.srdf.clone();
    for RobotSrdf { srdf, .. } in rest {
        all.groups.extend(srdf.groups.iter().cloned());
        all.end_effectors.extend(srdf.end_effectors.iter().cloned());
        all.postures.extend(srdf.postures.iter().cloned());
        all.passive.extend(srdf.passive.iter().cloned());
        all.virtual_joints.extend(srdf.virtual_joints.iter().cloned());
        all.disabled.extend(srdf.disabled.iter().cloned());
    }
    Some(all)
}

/// Adds the removal of the declaration to the warnings of names that nothing uses.
fn removals(diagnostics: &mut [Diagnostic], spec: &Spec) {
    for d in diagnostics.iter_mut().filter(|d| d.topic == Topic::Unused) {
        let mut items = spec.items.iter().filter_map(|item| Some((item.span, declared(&item.kind)?.1)));
        if let Some((span, name)) = items.find(|(_, name)| name.span == d.primary.span) {
            d.fixes.push(Fix::remove(&name.value, span));
        }
    }
}

/// Removes the warnings that the spec allows. Reports allowances of its own text without effect, if all warnings that it can have
/// are known: not after an error, without the missions, or with other values of its params.
fn allow(report: &mut Report, expanded: &Expanded, (input, part, own): (&Input, Part, SourceId), deep: bool) {
    let is_spec = |place: Span| expanded.syntaxes.contains_key(&place.source);
    let described =
        |key: &'static str| expanded.robots.iter().filter_map(move |robot| Some(robot.body.get(key)?.value.span));
    let urdf = described("urdf").chain(described("srdf"));
    // Findings at sampled postures are known only if these were asked for.
    let is_known = |code: &str| deep || !codes::is_deep(code);
    let without_effect = report.allow(&expanded.allowances, is_spec, is_known, &urdf.collect::<Vec<_>>());
    if report.errors() == 0 && part == Part::Whole && input.set.is_empty() {
        report.diagnostics.extend(without_effect.into_iter().filter(|d| d.primary.span.source == own));
    }
}

/// Writes helps and fixes in the syntax of their file, except in `foreign` texts, for which it is done.
fn settle(
    diagnostics: &mut [Diagnostic],
    own: Syntax,
    expanded: &Expanded,
    foreign: &BTreeSet<SourceId>,
    sources: &Sources,
) {
    for d in diagnostics.iter_mut().filter(|d| !foreign.contains(&d.primary.span.source)) {
        let syntax = expanded.syntaxes.get(&sources.text_of(d.primary.span.source));
        d.settle(sources, *syntax.unwrap_or(&own));
    }
}

/// Result for a spec that is too large to compile.
fn refused(mut report: Report, mut diagnostics: Vec<Diagnostic>, refusal: Diagnostic) -> Compiled {
    diagnostics.push(refusal);
    report.diagnostics = diagnostics;
    report.finish();
    Compiled::refused(report)
}
