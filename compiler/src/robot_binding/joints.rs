//! Joints of a robot: their groups, the limits that a spec sets, the home configuration.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span};
use robot::Base;
use stdlib_tasks::dimension::{ANGLE, LENGTH, RATE};

use super::lookup::{glob, joints};
use super::urdf::Locks;
use super::{Binder, JointGroups};
use crate::constants::joint_dimension;
use crate::forms::{block_of, check_keys, items_of};
use crate::units;

impl Binder<'_, '_> {
    pub(super) fn joint_groups(&mut self) -> JointGroups {
        let mut groups = JointGroups::default();
        let nv = self.model.nv();
        if self.model.base.nv() > 0 {
            groups.members.insert("base".to_string(), (0..self.model.base.nv()).collect());
        }
        groups.members.insert("all".to_string(), (0..nv).collect());
        for e in self.block("joints").iter().flat_map(|b| &b.entries) {
            let name = e.key.value.as_str();
            if self.model.dof(name).is_some() || groups.members.contains_key(name) {
                let text = format!("`{name}` is already the name of a joint or group");
                self.diagnostics
                    .push(Diagnostic::error("HQ0202", e.key.span, text).help("choose another name for the group"));
                continue;
            }
            match joints(items_of(&e.value), &self.model, &groups, self.diagnostics) {
                Some(dofs) => {
                    groups.members.insert(name.to_string(), dofs);
                }
                None => {
                    groups.failed.insert(name.to_string());
                }
            }
        }
        groups
    }

    pub(super) fn limits(&mut self, groups: &JointGroups) {
        let Some(block) = self.block("limits") else { return };
        for e in &block.entries {
            let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let Some(dofs) = joints(std::slice::from_ref(&name), &self.model, groups, self.diagnostics) else {
                continue;
            };
            let Some(inner) = block_of(&e.value, "the limits of a joint", self.diagnostics) else { continue };
            check_keys(inner, &["lower", "upper", "velocity"], "a joint limit", self.diagnostics);
            for dof in dofs {
                let unit = joint_dimension(&self.model, dof);
                let speed = unit.times(RATE).unwrap_or(RATE);
                let mut get = |key: &str, dimension| {
                    inner.get(key).and_then(|x| self.constants.scalar(&x.value, dimension, self.diagnostics))
                };
                let (lower, upper, velocity) = (get("lower", unit), get("upper", unit), get("velocity", speed));
                let d = &mut self.model.dofs[dof];
                let (low, high) = (lower.unwrap_or(d.lower), upper.unwrap_or(d.upper));
                if let Some(v) = velocity.filter(|v| *v > 0.0) {
                    d.velocity = v;
                } else if velocity.is_some() {
                    let span = inner.get("velocity").map_or(e.key.span, |x| x.value.span);
                    self.diagnostics.push(
                        Diagnostic::error("HQ0308", span, "a velocity limit is more than zero")
                            .help("to keep a joint still, name it in `lock`"),
                    );
                }
                if low > high {
                    let unit = units::written(unit);
                    let text = format!(
                        "`{}` would have a lower limit of {} {unit} above its upper limit of {} {unit}",
                        d.name, low, high
                    );
                    let help = match (lower, upper) {
                        (Some(_), Some(_)) => "swap the two",
                        (Some(_), None) => {
                            "the upper limit comes from the URDF: give `upper` too, or a smaller `lower`"
                        }
                        _ => "the lower limit comes from the URDF: give `lower` too, or a larger `upper`",
                    };
                    self.diagnostics.push(Diagnostic::error("HQ0308", e.value.span, text).help(help));
                } else {
                    (d.lower, d.upper) = (low, high);
                }
            }
        }
    }

    pub(super) fn home(&mut self, groups: &JointGroups, locks: &Locks) -> (Vec<f64>, Span) {
        let mut q = self.model.neutral();
        let Some(entry) = self.robot.body.get("home") else {
            self.elsewhere(&q, &BTreeMap::new(), self.robot.name.span);
            return (q, self.robot.name.span);
        };
        let Some(block) = self.block("home") else { return (q, entry.value.span) };
        let base_names: &[&str] = match self.model.base {
            Base::Fixed => &[],
            Base::Planar | Base::Unicycle => &["base_x", "base_y", "base_yaw"],
            Base::Floating => &["base_x", "base_y", "base_z"],
        };
        let mut given: BTreeMap<usize, Span> = BTreeMap::new();
        let mut complete = true;
        for e in &block.entries {
            if let Some(i) = base_names.iter().position(|n| *n == e.key.value) {
                let dimension = if e.key.value == "base_yaw" { ANGLE } else { LENGTH };
                if let Some(x) = self.constants.scalar(&e.value, dimension, self.diagnostics) {
                    q[i] = x;
                }
                continue;
            }
            if locks.iter().any(|(n, _)| glob(&n.value, &e.key.value)) {
                continue;
            }
            let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let before = self.diagnostics.len();
            let Some(dofs) = joints(std::slice::from_ref(&name), &self.model, groups, self.diagnostics) else {
                complete = false;
                continue;
            };
            let Some(values) = self.constants.per_joint(&e.value, &dofs, &self.model, self.diagnostics) else {
                complete = false;
                continue;
            };
            let mut outside: Vec<Outside> = Vec::new();
            for (dof, (x, span)) in dofs.iter().zip(values) {
                let d = &self.model.dofs[*dof];
                let Some(i) = d.q_index else { continue };
                if let Some(first) = given.insert(i, e.key.span) {
                    let d = Diagnostic::error("HQ0207", e.key.span, format!("joint `{}` is given twice", d.name));
                    self.diagnostics.push(d.label(first, "first here").help("keep one of the two"));
                }
                if x < d.lower || x > d.upper {
                    let unit = units::written(joint_dimension(&self.model, *dof));
                    let (lower, upper) = (rounded(d.lower), rounded(d.upper));
                    let text = format!("`{}` starts at {} {unit}, outside its limits", d.name, rounded(x));
                    outside.push((span, text, format!("allowed are {lower} to {upper} {unit}")));
                }
                q[i] = x;
            }
            self.outside(outside, before);
        }
        if complete {
            self.elsewhere(&q, &given, entry.value.span);
        }
        (q, entry.value.span)
    }

    /// Reports joints that start outside their limits, those of one value together.
    fn outside(&mut self, outside: Vec<Outside>, before: usize) {
        // Degrees without a unit: the limits are not at fault.
        let bare = !outside.is_empty() && self.diagnostics.extract_if(before.., |d| d.code == "HQ0305").count() > 0;
        for (i, (span, text, range)) in outside.iter().enumerate() {
            if outside[..i].iter().any(|o| o.0 == *span) {
                continue;
            }
            let more = outside.iter().filter(|o| o.0 == *span).count() - 1;
            let more = if more > 0 { format!(", and so do {more} more joints") } else { String::new() };
            let d = Diagnostic::error("HQ0404", *span, format!("{text}{more}")).here(range.clone());
            self.diagnostics.push(if bare {
                d.note("angles without a unit are radians").help("if degrees are meant, write `deg` behind it")
            } else {
                d.help("move the joint inside its limits, or set others under `limits`")
            });
        }
    }

    /// Warns of joints that home leaves out and that cannot stand at zero.
    fn elsewhere(&mut self, q: &[f64], given: &BTreeMap<usize, Span>, span: Span) {
        let joints = self.model.dofs.iter().enumerate().filter_map(|(i, d)| Some((i, d, d.q_index?)));
        let moved: Vec<String> = joints
            .filter(|(_, _, k)| !given.contains_key(k) && q[*k] != 0.0)
            .map(|(i, d, k)| {
                format!("`{}` at {} {}", d.name, rounded(q[k]), units::written(joint_dimension(&self.model, i)))
            })
            .collect();
        if !moved.is_empty() {
            let text = format!("joints that cannot stand at zero are left out of home: {}", moved.join(", "));
            self.diagnostics.push(
                Diagnostic::warning("HQ0405", span, text)
                    .note("a joint that `home` does not name starts at zero, or at the limit nearest to it")
                    .help("name them in `home`"),
            );
        }
    }
}

/// A joint outside its limits: where its value was written, what is wrong, what is allowed.
type Outside = (Span, String, String);

/// Six decimals at most.
fn rounded(x: f64) -> f64 {
    if x.abs() < 1e9 { (x * 1e6).round() / 1e6 } else { x }
}
