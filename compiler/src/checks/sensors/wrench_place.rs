//! Warns of wrenches that are measured at another place than the frame that yields to them: on another branch of the
//! robot, or about another point without the lever of the force.
//!
//! A sensor at `s` measures the moment about `s`; about the frame's origin `p` it is `m + (s - p) x f`.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use robot::{Data, LinkId, Model};
use runtime::program::{Op, Program, SignalProgram};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::LENGTH;

use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, readings};
use crate::units::shown;

/// Distance (m) from which a lever counts.
const LEVER: f64 = 1e-3;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let model = &c.program.robot.model;
    for task in in_stacks(c.program) {
        let t = &c.program.tasks[task];
        let Some(Bound::Group(wrench)) = t.params.get("wrench") else { continue };
        let Some(link) = (match t.params.get("frame") {
            Some(Bound::Frame(_, link)) => Some(*link),
            Some(Bound::Arm(arm)) => Some(arm.tip),
            _ => None,
        }) else {
            continue;
        };
        let places = &c.places.tasks[task];
        let at = places.spans.get("wrench").copied().unwrap_or(places.span);
        let (own, name) = (&model.link_ref(link).name, &t.name);
        let of = |part: &str| wrench.get(part).and_then(|bound| measured(c.program, bound));
        let Some(Measured { signal, frame }) = of("force").or_else(|| of("moment")) else { continue };
        let sensor = &model.link_ref(frame).name;
        if model.moves_between(link, frame) && !carries(model, frame, link) && !carries(model, link, frame) {
            out.push(
                Diagnostic::warning(
                    "HQ0546",
                    at,
                    format!("`{name}` yields to a sensor on another branch of the robot"),
                )
                .here(format!("`{}` is measured at `{sensor}`", signal.name))
                .label(places.span, format!("this moves `{own}`"))
                .note("a push at the one branch moves the other one, which does not give way to a push at itself")
                .help(format!("use the sensor that is fixed to `{own}`, or name the frame `{sensor}`")),
            );
            continue;
        }
        let Some(Measured { signal, frame }) = of("moment") else { continue };
        let mut data = Data::new(model);
        model.forward(&c.program.robot.home, &mut data);
        let lever = (data.position(frame) - data.position(link)).norm();
        if lever > LEVER && !wrench.get("moment").is_some_and(|b| reads_force(c.program, b, signal)) {
            out.push(
                Diagnostic::warning("HQ0546", at, format!("`{name}` lacks the lever between the sensor and its frame"))
                    .here(format!(
                        "`{}` is measured about `{}`, {} from `{own}`",
                        signal.name,
                        model.link_ref(frame).name,
                        shown(format!("{lever:.3}").parse().unwrap_or(lever), LENGTH)
                    ))
                    .note("a moment depends on its point: a force at the frame's origin turns the frame by `r x f`")
                    .help(format!(
                        "add the lever to the moment: `{0}.moment + cross(frame({1}).position - frame({own}).position, {0}.force)`",
                        signal.name,
                        model.link_ref(frame).name
                    )),
            );
        }
    }
}

/// True if a link is between the root and another link, or is that link.
fn carries(model: &Model, link: LinkId, other: LinkId) -> bool {
    std::iter::successors(Some(other), |&l| model.parent(l)).any(|l| l == link)
}

/// A wrench with the link at which it is measured.
struct Measured<'p> {
    signal: &'p SignalProgram,
    frame: LinkId,
}

/// The only wrench that a parameter reads, with the link at which it is measured, if its value is used.
fn measured<'p>(program: &'p Program, bound: &Bound) -> Option<Measured<'p>> {
    let signals: BTreeSet<usize> = readings::signals(program, bound);
    let mut wrenches = signals.iter().filter_map(|&s| program.interface.signals.get(s)).filter(|s| s.kind == "wrench");
    let (Some(signal), None) = (wrenches.next(), wrenches.next()) else { return None };
    Some(Measured { signal, frame: signal.conditioning.frame? })
}

/// True if a moment contains a part of the signal's force, or the state of the robot.
fn reads_force(program: &Program, bound: &Bound, signal: &SignalProgram) -> bool {
    let numbers = readings::numbers(program, bound);
    let state = matches!(bound, Bound::Expression(e) if e.ops.iter().any(|op| matches!(op, Op::State(_))));
    state || (signal.at + 1..=signal.at + 3).any(|n| numbers.contains(&n))
}
