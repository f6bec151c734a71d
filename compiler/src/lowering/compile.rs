//! From the text of a spec to its program and missions, and everything that there is to say of it.

use dsl::{Diagnostic, Spelling};

use super::missions::scenario::runs_mission;
use super::{Compiled, Input, Lowerer};
use crate::expand::{Texts, expand};
use crate::report::Report;
use crate::spelling::in_yaml;
use crate::{bounds, follow_ons, overridden, pointless};

/// Compiles a spec.
pub fn compile(input: &Input) -> Compiled {
    compile_among(input, &Texts::new())
}

/// Compiles a spec whose imports may have other texts than their files.
pub fn compile_among(input: &Input, texts: &Texts) -> Compiled {
    compile_part(input, texts, Part::Whole)
}

/// What of a spec is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Everything.
    Whole,
    /// All but its missions and their scenarios.
    Controller,
}

pub(super) fn compile_part(input: &Input, texts: &Texts, part: Part) -> Compiled {
    let mut report = Report::default();
    let source = report.sources.add(input.name, input.text);
    let (spec, mut diagnostics) = dsl::parse(source, input.text, input.spelling);
    if let Some(refusal) = bounds::spec(&spec) {
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
    let beyond = bounds::stacks(&expanded.stacks).or_else(|| bounds::machines(&expanded.machines));
    if let Some(refusal) = beyond.filter(|_| expanded.usable) {
        return refused(report, diagnostics, refusal);
    }
    let mut lowerer = Lowerer::new(input, source, &mut report.sources, &mut diagnostics);
    lowerer.controllers.texts = Some(texts);
    let program = lowerer.spec(&expanded, empty);
    let missions = std::mem::take(&mut lowerer.planned);
    let foreign = std::mem::take(&mut lowerer.controllers.foreign);
    if let Some(program) = &program {
        pointless::spec(&expanded, program, &mut diagnostics);
    }
    follow_ons::remove(&mut diagnostics, form, &whole, &report.sources);
    // What missions would use seems unused without them.
    diagnostics.retain(|d| !left_out || d.code != "HQ0203");
    for d in diagnostics.iter_mut().filter(|d| !foreign.contains(&d.primary.span.source)) {
        let spelling = expanded.spellings.get(&report.sources.text_of(d.primary.span.source));
        if *spelling.unwrap_or(&input.spelling) == Spelling::Yaml {
            d.help = d.help.as_deref().map(in_yaml);
        }
    }
    report.diagnostics = diagnostics;
    report.finish();
    if overridden::blame(input, &mut report.diagnostics, &report.sources) {
        report.finish();
    }
    if report.errors() > 0 {
        return Compiled::refused(report);
    }
    Compiled { program, missions, report }
}

/// The outcome for a spec that is too large to be looked at.
fn refused(mut report: Report, mut diagnostics: Vec<Diagnostic>, refusal: Diagnostic) -> Compiled {
    diagnostics.push(refusal);
    report.diagnostics = diagnostics;
    report.finish();
    Compiled::refused(report)
}
