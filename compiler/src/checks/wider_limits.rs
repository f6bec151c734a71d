//! Warns of limits of a task that are wider than the robot's: their rows permit motions that the joint cannot perform.

use dsl::Diagnostic;
use runtime::program::Program;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, LENGTH, VELOCITY};

use super::number;
use crate::source_map::SourceMap;
use crate::units::shown;

/// Warns of each parameter that is wider than a joint's own limit, once.
pub(super) fn check(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let dofs = &program.robot.model.dofs;
    for (i, task) in program.tasks.iter().enumerate() {
        let params: &[&str] = match task.kind.as_str() {
            "joint_position_limits" => &["lower", "upper"],
            "joint_velocity_limits" => &["max"],
            _ => continue,
        };
        for param in params {
            let Some(Bound::PerJoint(list)) = task.params.get(*param) else { continue };
            let beyond = list.iter().filter_map(|(dof, slot)| {
                let (d, x) = (dofs.get(*dof)?, *program.values.initial.get(slot.at)?);
                let own = match *param {
                    "lower" => d.lower,
                    "upper" => d.upper,
                    _ => d.velocity,
                };
                let wide = if *param == "lower" { x < own } else { x > own };
                (wide && own.is_finite()).then_some((d, slot, x, own))
            });
            let beyond: Vec<_> = beyond.collect();
            let Some((d, slot, x, own)) = beyond.first() else { continue };
            let dimension = match *param {
                "max" => d.unit.select(VELOCITY, ANGULAR_VELOCITY),
                _ => d.unit.select(LENGTH, ANGLE),
            };
            let (x, own) = (shown(*x, dimension), shown(*own, dimension));
            let at = number(places, i, param, |n| n.slot.at == slot.at);
            let more = if beyond.len() > 1 { format!(", and {} more joints", beyond.len() - 1) } else { String::new() };
            diagnostics.push(
                Diagnostic::warning("HQ0506", at, format!("`{}` is wider than the limit of the robot", param))
                    .here(format!("{x}; `{}` has {own}{more}", d.name))
                    .note("the rows allow more than the joint can do, so the robot lags behind its reference")
                    .help(format!("stay within {own}, or correct the URDF if its limit is wrong")),
            );
        }
    }
}
