//! Warns of obstacles that are no bodies in the physics of a run: links go through them.

use dsl::Diagnostic;
use dsl::tree::BlockKind;
use runtime::program::{MOST_BODY_ELEMENTS, NoBody, no_body};

use super::Checked;
use crate::expand::Named;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let runs = c.program.scenarios.iter().map(|s| &s.run).chain([&c.program.run]);
    let mut plants = runs.filter_map(|run| run.simulator.plant.as_ref());
    if !plants.any(|plant| plant.contacts) {
        return;
    }
    for declared in &c.expanded.values {
        let Named::Block(b) = declared else { continue };
        let found = c.program.obstacles.iter().find(|o| b.kind == BlockKind::Obstacle && o.name == b.name.value);
        let Some(reason) = found.and_then(|o| no_body(c.program, o)) else { continue };
        let (why, help) = match reason {
            NoBody::Elements(n) => (
                format!("it has {n} elements, and physics takes {MOST_BODY_ELEMENTS} at most"),
                "take a coarser file, or `shape pieces` of a mesh; or write `contacts false` in the plant",
            ),
            NoBody::MovesOnLink => (
                "a link carries it, and it moves on that link".to_string(),
                "let it stay where it is on the link, or in the world; or write `contacts false` in the plant",
            ),
        };
        let text = format!("links go through `{}`: it is no body in physics", b.name.value);
        out.push(Diagnostic::warning("HQ0825", b.name.span, text).note(why).help(help));
    }
}
