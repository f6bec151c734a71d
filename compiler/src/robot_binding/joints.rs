//! Joints of a robot: groups, and limits set by the spec.

use std::collections::BTreeSet;

use blocks::{ByName, Located, Unbound};
use dsl::tree::{Block, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned, Topic};
use quantities::usual::of_joint;
use robot::srdf::Group;
use robot::{Drive, Model, Srdf};
use stdlib_tasks::dimension::RATE;

use super::lookup::{is_pattern, joints};
use super::{Binder, JointGroups};
use crate::expr::constants::joint_dimension;
use crate::expr::unusual;
use crate::sections::LimitBlock;
use crate::units;

/// Relative difference of a limit that is the rounding of a conversion.
const ROUNDING: f64 = 1e-6;

/// Groups among all joints of a robot; [`JointGroups::without`] removes locked joints.
/// Groups of the SRDF count unless the spec, or a joint, has the same name.
pub(super) fn joint_groups(
    block: Option<&Block>,
    srdf: Option<&Srdf>,
    model: &Model,
    diagnostics: &mut Vec<Diagnostic>,
) -> JointGroups {
    let mut groups = JointGroups::default();
    if model.base.nv() > 0 {
        groups.members.insert("base".to_string(), (0..model.base.nv()).collect());
    }
    groups.members.insert("all".to_string(), (0..model.nv()).collect());
    let mut replaceable: BTreeSet<&str> = BTreeSet::new();
    for group in srdf.iter().flat_map(|srdf| &srdf.groups) {
        if model.dof(&group.name).is_none() && !groups.members.contains_key(&group.name) {
            groups.members.insert(group.name.clone(), dofs_of(group, model));
            replaceable.insert(&group.name);
        }
    }
    for e in block.iter().flat_map(|b| &b.entries) {
        let name = e.key.value.as_str();
        if is_pattern(name) {
            diagnostics.push(pattern_as_name(&e.key));
            continue;
        }
        let taken = groups.members.contains_key(name) && !replaceable.remove(name);
        if model.dof(name).is_some() || taken {
            let text = format!("`{name}` is already the name of a joint or group");
            diagnostics.push(Diagnostic::error("HQ0202", e.key.span, text).help("choose another name for the group"));
            continue;
        }
        match joints(e.value.items(), model, &groups, diagnostics) {
            Some(dofs) => {
                groups.members.insert(name.to_string(), dofs);
            }
            None => {
                groups.members.remove(name);
                groups.failed.insert(name.to_string());
            }
        }
    }
    groups
}

/// Degrees of freedom of a group of the SRDF: those of the base, if its joint belongs to the group, then those of joints.
fn dofs_of(group: &Group, model: &Model) -> Vec<usize> {
    let base = if group.base { model.base.nv() } else { 0 };
    let of_joint = |joint: &robot::JointId| match model.joint_ref(*joint).drive {
        Drive::Dof(dof) => Some(dof),
        _ => None,
    };
    (0..base).chain(group.joints.iter().filter_map(of_joint)).collect()
}

/// Diagnostic for a pattern as the name of a declaration.
pub(super) fn pattern_as_name(key: &Spanned<String>) -> Diagnostic {
    Diagnostic::error("HQ0202", key.span, format!("`{}` is a pattern, and a declaration needs a name", key.value))
        .help("choose a name without `*` and `?`; its value can be a pattern")
}

impl JointGroups {
    /// Returns the groups for the robot without its locked joints.
    pub(super) fn without(self, locked: BTreeSet<String>, whole: &Model, model: &Model) -> JointGroups {
        let kept = |dofs: Vec<usize>| dofs.into_iter().filter_map(|d| model.dof(&whole.dofs[d].name)).collect();
        let members = self.members.into_iter().map(|(name, dofs)| (name, kept(dofs))).collect();
        JointGroups { members, locked, ..self }
    }
}

impl Binder<'_, '_> {
    pub(super) fn limits(&mut self, groups: &JointGroups) {
        for ByName { name, value: limits, .. } in &self.block.limits {
            let key = Value { kind: ValueKind::Text(name.value.clone()), span: self.origins.span(name.at) };
            let Some(dofs) = joints(std::slice::from_ref(&key), &self.model, groups, self.diagnostics) else {
                continue;
            };
            for dof in dofs {
                self.limits_of(dof, &limits.value, self.origins.span(limits.at));
            }
        }
    }

    /// Warns of a speed limit above that of the URDF; once for an entry that gives the limits of many joints.
    fn above_the_urdf(&mut self, dof: usize, x: f64, at: Span) {
        if self.diagnostics.iter().any(|d| d.primary.span == at) {
            return;
        }
        let d = &self.model.dofs[dof];
        let speed = joint_dimension(&self.model, dof).times(RATE).unwrap_or(RATE);
        let own = units::shown(d.velocity, speed);
        let warning = Diagnostic::warning("HQ0556", at, "this speed limit is above that of the robot")
            .here(format!("{}; the URDF gives `{}` {own}", units::shown(x, speed), d.name))
            .note("a limit in the spec does not make the joint faster: the robot lags behind its reference")
            .help(format!("stay within {own}, or correct the URDF if its limit is wrong"));
        self.diagnostics.push(warning);
    }

    /// Limits of one joint, written at a place.
    fn limits_of(&mut self, dof: usize, LimitBlock { lower, upper, velocity, .. }: &LimitBlock, at: Span) {
        let unit = joint_dimension(&self.model, dof);
        let speed = unit.times(RATE).unwrap_or(RATE);
        let mut get = |of: &Option<Located<Unbound>>, dimension| {
            let value = self.origins.unbound(of.as_ref()?)?;
            let x = self.constants.scalar(value, dimension, self.diagnostics)?;
            // One entry can give the limits of many joints.
            if !self.diagnostics.iter().any(|d| d.topic == Topic::UnusualSize && d.primary.span == value.span) {
                self.diagnostics.extend(unusual(value, "a limit", &[x], &of_joint(dimension)));
            }
            Some(x)
        };
        let (lower, upper) = (get(lower, unit), get(upper, unit));
        let speed = get(velocity, speed).zip(velocity.as_ref());
        let own = self.model.dofs[dof].velocity;
        if let Some((x, written)) = speed.filter(|(x, _)| own.is_finite() && *x > own * (1.0 + ROUNDING)) {
            self.above_the_urdf(dof, x, self.origins.span(written.at));
        }
        let d = &mut self.model.dofs[dof];
        let (low, high) = (lower.unwrap_or(d.lower), upper.unwrap_or(d.upper));
        match speed {
            Some((speed, _)) if speed > 0.0 => d.velocity = speed,
            Some((_, written)) => self.diagnostics.push(
                Diagnostic::error("HQ0308", self.origins.span(written.at), "a velocity limit is more than zero")
                    .help("to keep a joint still, name it in `lock`"),
            ),
            None => {}
        }
        if low > high {
            let text = format!(
                "`{}` would have a lower limit of {} above its upper limit of {}",
                d.name,
                units::shown(low, unit),
                units::shown(high, unit)
            );
            let help = match (lower, upper) {
                (Some(_), Some(_)) => "swap the two",
                (Some(_), None) => "the upper limit comes from the URDF: give `upper` too, or a smaller `lower`",
                _ => "the lower limit comes from the URDF: give `lower` too, or a larger `upper`",
            };
            self.diagnostics.push(Diagnostic::error("HQ0308", at, text).help(help));
        } else {
            (d.lower, d.upper) = (low, high);
        }
    }
}
