//! Walls in the world so far away that no part of the robot comes near them.
//!
//! Each part stays inside a ball: the sum of the lengths of its links, around its first joint. A wall out of reach may still
//! be as near to that ball as a speed limit needs, so that its rows can act and no proof of idle rows succeeds; it limits
//! nothing that matters if it is farther away than half of the reach.

use nalgebra::Vector3;
use stdlib_tasks::bound::{Bound, Geometry, Slot};
use stdlib_tasks::kinds::virtual_wall;

use super::Checked;

/// Distance of a wall from the reach of a part, relative to that reach, from which it is certainly not meant.
const BEYOND: f64 = 0.5;

/// Smallest margin (m) of a constant wall of the world that stays far out of reach of all its parts.
pub(super) fn distant(c: &Checked, task: usize) -> Option<f64> {
    let t = &c.program.tasks[task];
    let (Some(Bound::Geometries(parts)), Some(through), Some(d_min)) =
        (t.params.get("points"), constant(c, t.params.get("through"), 9), constant(c, t.params.get("d_min"), 1))
    else {
        return None;
    };
    if t.kind != virtual_wall::KIND.name || t.params.contains_key("on") {
        return None;
    }
    let point = |i: usize| Vector3::new(through[3 * i], through[3 * i + 1], through[3 * i + 2]);
    let normal = (point(1) - point(0)).cross(&(point(2) - point(0))).normalize();
    let least = |part: &Geometry| {
        let ball = c.context.part(part)?;
        let margin = normal.dot(&(ball.centre - point(0))) - ball.radius - d_min[0];
        (margin > BEYOND * ball.radius).then_some(margin)
    };
    let margins: Option<Vec<f64>> = parts.iter().map(least).collect();
    margins?.into_iter().reduce(f64::min)
}

/// The numbers of a parameter, if they are constant.
fn constant<'p>(c: &Checked<'p>, bound: Option<&Bound>, len: usize) -> Option<&'p [f64]> {
    let Some(Bound::Value(Slot { at, len: own })) = bound else { return None };
    let moves = c.program.values.tape.outputs.iter().any(|o| (*at..at + own).contains(&o.at));
    c.program.values.initial.get(*at..at + own).filter(|_| *own == len && !moves)
}
