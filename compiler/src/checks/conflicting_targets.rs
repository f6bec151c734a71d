//! Reports targets of a stack that pull two frames to the same position. A typical cause is a declaration for both
//! sides of a robot, parametrised by the side, in which the sign of the side is missing.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Span};
use robot::{Data, LinkId};
use runtime::program::Program;
use stdlib_tasks::bound::Bound;

use crate::source_map::SourceMap;

/// Frame and position of a target, if the position in the world is constant.
fn target(program: &Program, task: usize) -> Option<(LinkId, [f64; 3])> {
    let t = &program.tasks[task];
    if !matches!(t.kind.as_str(), "frame_position" | "frame_pose") {
        return None;
    }
    // Frames that share some of the coordinates only, such as their heights, are not at one place.
    if t.params.contains_key("axes") {
        return None;
    }
    let (Some(Bound::Frame(_, link)), Some(Bound::Value(slot))) = (t.params.get("frame"), t.params.get("position"))
    else {
        return None;
    };
    let moves = |at: usize| program.values.tape.outputs.iter().any(|o| o.at == at);
    if slot.len != 3 || (slot.at..slot.at + 3).any(moves) {
        return None;
    }
    let place = program.values.initial.get(slot.at..slot.at + 3)?;
    Some((*link, place.try_into().ok()?))
}

/// Warns of stacks in which two frames are pulled to the same position.
pub(crate) fn check(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for stack in &program.stacks {
        let members = stack.levels.iter().flat_map(|l| &l.members);
        let targets: Vec<(usize, LinkId, [f64; 3])> =
            members.filter_map(|m| target(program, m.task).map(|(link, place)| (m.task, link, place))).collect();
        for (i, &(task, link, place)) in targets.iter().enumerate() {
            let same = targets[..i].iter().find(|t| t.1 != link && t.2 == place);
            let Some(&(first, other, _)) = same.filter(|t| told.insert((t.0, task))) else { continue };
            if together(program, link, other) {
                continue;
            }
            let at = |task: usize| -> Span {
                let t = &places.tasks[task];
                t.spans.get("position").copied().unwrap_or(t.span)
            };
            let name = |l: LinkId| &program.robot.model.link_ref(l).name;
            let text = format!("the target of `{}` is at `{}`", name(link), name(other));
            let d = Diagnostic::warning("HQ0624", at(task), text);
            let d = if at(task) == at(first) { d } else { d.label(at(first), "the same place") };
            diagnostics.push(
                d.note(format!(
                    "tasks `{}` and `{}` of one stack",
                    program.tasks[first].name, program.tasks[task].name
                ))
                .help("two frames cannot both be there: check signs and offsets"),
            );
        }
    }
}

/// True if the origins of two frames coincide at all times.
fn together(program: &Program, a: LinkId, b: LinkId) -> bool {
    let model = &program.robot.model;
    let mut data = Data::new(model);
    model.forward(&program.robot.home, &mut data);
    let gap = data.pose(a).translation.vector - data.pose(b).translation.vector;
    !model.moves_between(a, b) && gap.norm() < 1e-9
}
