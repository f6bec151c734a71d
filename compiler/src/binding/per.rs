//! Parameters with a number for each of some joints or arms.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span};
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE};
use stdlib_tasks::params::ParamInfo;

use super::{Binder, Owner};
use crate::constants::{fits, joint_dimension, joint_items, merge_bare};
use crate::expr::Kind;
use crate::forms::block_of;
use crate::robot_binding::joints;
use crate::units;

impl Binder<'_> {
    /// Numbers for joints: `{ name value .. }`, or one value for all joints of its unit. `per` is what the joint's own
    /// unit is multiplied with: nothing for positions, a rate for velocities.
    pub(super) fn per_joint(&mut self, owner: Owner, value: &Value, info: &ParamInfo, per: Dimension) -> Option<Bound> {
        let model = &self.robot.model;
        let dimension = |dof: usize| joint_dimension(model, dof).times(per).unwrap_or(per);
        let mut out: Vec<(usize, Slot)> = Vec::new();
        if let ValueKind::Block(block) = &value.kind {
            let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
            let mut good = true;
            for e in &block.entries {
                let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
                let found = joints(std::slice::from_ref(&name), model, &self.robot.joint_groups, self.diagnostics);
                let Some(dofs) = found else {
                    good = false;
                    continue;
                };
                for &dof in &dofs {
                    if let Some(first) = seen.insert(dof, e.key.span) {
                        let text = format!("joint `{}` is given twice", model.dofs[dof].name);
                        self.diagnostics.push(
                            Diagnostic::error("HQ0207", e.key.span, text)
                                .label(first, "first here")
                                .help("name each joint once"),
                        );
                        good = false;
                    }
                }
                match self.joint_values(owner, &e.value, &dofs, &dimension) {
                    Some(slots) => out.extend(dofs.into_iter().zip(slots)),
                    None => good = false,
                }
            }
            return good.then_some(Bound::PerJoint(out));
        }
        let typed = self.typed(owner, value, true)?;
        let revolute = ANGLE.times(per).unwrap_or(per);
        let wanted = if revolute.accepts(typed.dimension) { revolute } else { LENGTH.times(per).unwrap_or(per) };
        if typed.kind != Kind::Scalar
            || fits(self.graph, &typed, wanted, "").is_some_and(|d| d.severity == dsl::Severity::Error)
        {
            return self.wrong(value, info, "`{ joint value .. }`, or one number in the joints' unit");
        }
        if !(0..model.nv()).any(|d| dimension(d) == wanted) {
            let is = wanted.describe();
            let d = Diagnostic::error("HQ0301", value.span, format!("no joint of this robot moves with {is}")).here(is);
            self.diagnostics.push(d.help("use the joints' own unit, or name the joints: `{ joint value .. }`"));
            return None;
        }
        let slot = self.value(owner, value, (Kind::Scalar, wanted), None, &format!("`{}`", info.name))?;
        out.extend((0..model.nv()).filter(|&d| dimension(d) == wanted).map(|d| (d, slot)));
        Some(Bound::PerJoint(out))
    }

    fn joint_values(
        &mut self,
        owner: Owner,
        value: &Value,
        dofs: &[usize],
        dimension: &dyn Fn(usize) -> Dimension,
    ) -> Option<Vec<Slot>> {
        let before = self.diagnostics.len();
        let names: Vec<&str> = dofs.iter().map(|&d| self.robot.model.dofs[d].name.as_str()).collect();
        let Some(items) = joint_items(value, dofs.len(), self.diagnostics)? else {
            let Some(&first) = dofs.first() else { return Some(Vec::new()) };
            if let Some(other) = dofs.iter().position(|&d| dimension(d) != dimension(first)) {
                let typed = self.typed(owner, value, true)?;
                if typed.dimension != NONE {
                    let text = format!("`{}` and `{}` need values of different units", names[0], names[other]);
                    let (a, b) = (units::written(dimension(first)), units::written(dimension(dofs[other])));
                    self.diagnostics.push(
                        Diagnostic::error("HQ0301", value.span, text)
                            .note(format!("`{}` moves in `{a}`, `{}` in `{b}`", names[0], names[other]))
                            .help("name joints of one unit together, or give each its own value"),
                    );
                    return None;
                }
                return dofs.iter().map(|&d| self.joint(owner, value, d, dimension(d))).collect();
            }
            let slot = match names.as_slice() {
                [_] => self.joint(owner, value, first, dimension(first))?,
                _ => self.value(owner, value, (Kind::Scalar, dimension(first)), None, "the value of these joints")?,
            };
            return Some(vec![slot; dofs.len()]);
        };
        let slots: Vec<Option<Slot>> =
            items.iter().zip(dofs).map(|(item, &dof)| self.joint(owner, item, dof, dimension(dof))).collect();
        merge_bare(self.diagnostics, before, value.span);
        slots.into_iter().collect()
    }

    fn joint(&mut self, owner: Owner, value: &Value, dof: usize, dimension: Dimension) -> Option<Slot> {
        let what = format!("the value of `{}`", self.robot.model.dofs[dof].name);
        self.value(owner, value, (Kind::Scalar, dimension), None, &what)
    }

    pub(super) fn per_arm(
        &mut self,
        owner: Owner,
        value: &Value,
        info: &'static ParamInfo,
        d: Dimension,
    ) -> Option<Bound> {
        let block = block_of(value, &format!("`{}`", info.name), self.diagnostics)?;
        let prefix = format!("{}.", info.name);
        let owner = Owner { prefix: &prefix, ..owner };
        let mut out = Vec::new();
        let mut good = !block.entries.is_empty();
        if block.entries.is_empty() {
            return self.wrong(value, info, "`{ ARM value .. }`");
        }
        for e in &block.entries {
            let name = Value { kind: ValueKind::Name(e.key.value.clone()), span: e.key.span };
            let arm = self.arm(&name, info);
            let slot = self.value(owner, &e.value, (Kind::Scalar, d), None, &format!("`{}`", e.key.value));
            match (arm, slot) {
                (Some(arm), Some(slot)) => out.push((arm, slot)),
                _ => good = false,
            }
        }
        good.then_some(Bound::PerArm(out))
    }
}
