//! Parameters with one number per joint or per arm.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use quantities::usual::of_joint;
use stdlib_tasks::bound::{Bound, BoundParams, Slot};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE};
use stdlib_tasks::params::{ParamInfo, Quantity};
use stdlib_tasks::task::RowKind;

use super::{Binder, Owner};
use crate::expr::Kind;
use crate::expr::constants::{check_dimension, joint_dimension, joint_items, merge_bare, with_units};
use crate::expr::dimension_check::wrong_dimension;
use crate::forms::{block_of, names_of_key};
use crate::robot_binding::joints;
use crate::units;

impl Owner<'_> {
    /// Range of a number. Limits of joints are read once, when the task is built, so they must be constant.
    fn range(&self, dimension: Dimension) -> Option<Quantity> {
        let q = of_joint(dimension);
        Some(Quantity { constant: self.kind.row_kind == RowKind::Inequality, ..q })
    }
}

impl Binder<'_> {
    /// Numbers for joints: `{ name value .. }`, or one value for all of the task's joints that have its unit. `per` is
    /// the factor of the joint's own unit: none for positions, a rate for velocities, its square for accelerations.
    pub(super) fn per_joint(&mut self, owner: Owner, value: &Value, info: &ParamInfo, per: Dimension) -> Option<Bound> {
        let model = &self.robot.model;
        let dimension = |dof: usize| joint_dimension(model, dof).times(per).unwrap_or(per);
        let mut out: Vec<(usize, Slot)> = Vec::new();
        // Only positions have names.
        if per == NONE
            && let Some(posture) = self.posture(value, None)
        {
            return posture.map(Bound::PerJoint);
        }
        if let ValueKind::Block(block) = &value.kind {
            let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
            let mut good = true;
            for e in &block.entries {
                let found = joints(&names_of_key(&e.key), model, &self.robot.joint_groups, self.diagnostics);
                let Some(mut dofs) = found else {
                    good = false;
                    continue;
                };
                // For positions, `all` means the joints: a base has no joint position.
                if per == NONE && dofs.iter().any(|&d| model.dofs[d].q_index.is_some()) {
                    dofs.retain(|&d| model.dofs[d].q_index.is_some());
                }
                let posture = if per == NONE { self.posture(&e.value, Some(&e.key.value)) } else { None };
                if let Some(targets) = &posture {
                    dofs = targets.iter().flatten().map(|target| target.0).collect();
                }
                let twice: Vec<(usize, Span)> =
                    dofs.iter().filter_map(|&dof| Some((dof, seen.insert(dof, e.key.span)?))).collect();
                if let Some((dof, first)) = twice.first() {
                    let more = match twice.len() - 1 {
                        0 => String::new(),
                        1 => ", and so is 1 more".to_string(),
                        n => format!(", and so are {n} more"),
                    };
                    let text = format!("joint `{}` is given twice{more}", model.dofs[*dof].name);
                    let d = Diagnostic::error("HQ0207", e.key.span, text).label(*first, "first here");
                    self.diagnostics.push(d.help("name each joint once"));
                    good = false;
                }
                if let Some(targets) = posture {
                    good &= targets.is_some();
                    out.extend(targets.into_iter().flatten());
                    continue;
                }
                match self.joint_values(owner, &e.value, &dofs, &dimension) {
                    Some(slots) => out.extend(dofs.into_iter().zip(slots)),
                    None => good = false,
                }
            }
            return good.then_some(Bound::PerJoint(out));
        }
        // A base has velocities, but no joint position.
        let has_position = |d: usize| per != NONE || model.dofs[d].q_index.is_some();
        let own = |d: usize| owner.joints.is_none_or(|joints| joints.contains(&d));
        if let Some(items) = with_units(value) {
            let all = (0..model.nv()).filter(|&d| has_position(d)).count();
            let (count, name) = (items.len(), info.name);
            let help = if count == all {
                Help::with(
                    &format!("write {{}} for all {all} joints, in the order of the URDF"),
                    [Snippet::block(name, [Snippet::entry("all", "[..]")])],
                )
            } else {
                Help::with(
                    "write {}, with a joint, a group or a pattern before its value",
                    [Snippet::block(name, [Snippet::entry("JOINT", "value"), Snippet::dots()])],
                )
            };
            let d =
                Diagnostic::error("HQ0310", value.span, format!("`{name}` does not name the joints of these values"));
            self.diagnostics.push(d.here(format!("{count} values and no joint")).help(help));
            return None;
        }
        let typed = self.typed(owner, value, true, false)?;
        let revolute = ANGLE.times(per).unwrap_or(per);
        let mut units: Vec<Dimension> = (0..model.nv()).filter(|&d| has_position(d) && own(d)).map(dimension).collect();
        units.dedup();
        let wanted = match units.as_slice() {
            // A bare number takes the unit of the joints, if they have one.
            [only] if typed.bare => *only,
            _ if revolute.accepts(typed.dimension) => revolute,
            _ => LENGTH.times(per).unwrap_or(per),
        };
        if typed.kind != Kind::Scalar
            || check_dimension(self.graph, &typed, wanted, "").is_some_and(|d| d.severity == dsl::Severity::Error)
        {
            let joints = if units.contains(&revolute) { Some(revolute) } else { units.first().copied() };
            if let Some(unit) = joints.filter(|_| typed.kind == Kind::Scalar) {
                self.diagnostics.push(wrong_dimension(&typed, unit, &format!("`{}`", info.name)));
                return None;
            }
            return self.wrong(value, info, "`{ joint value .. }`, or one number in the joints' unit");
        }
        let meant: Vec<usize> =
            (0..model.nv()).filter(|&d| has_position(d) && own(d) && dimension(d) == wanted).collect();
        if meant.is_empty() {
            let is = wanted.describe();
            let whose = if owner.joints.is_some() { "`joints`" } else { "this robot" };
            let text = format!("no joint of {whose} moves with {is}");
            let units: Vec<String> = (0..model.nv())
                .filter(|&d| has_position(d) && own(d))
                .map(|d| format!("`{}`", units::written(dimension(d))))
                .fold(Vec::new(), |mut all, u| {
                    if !all.contains(&u) {
                        all.push(u);
                    }
                    all
                });
            let help = match units.is_empty() {
                true => "name joints that have a position".to_string(),
                false => format!("write a number in {}", units.join(" or ")),
            };
            self.diagnostics.push(Diagnostic::error("HQ0301", value.span, text).here(is).help(help));
            return None;
        }
        let what = format!("`{}`", info.name);
        let owner = self.turning(owner, &meant);
        let slot = self.value(owner, value, (Kind::Scalar, wanted), owner.range(wanted), &what)?;
        out.extend(meant.into_iter().map(|d| (d, slot)));
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
        let model = &self.robot.model;
        let names: Vec<&str> = dofs.iter().map(|&d| model.dofs[d].name.as_str()).collect();
        let Some(items) = joint_items(value, dofs.len(), self.diagnostics)? else {
            let Some(&first) = dofs.first() else { return Some(Vec::new()) };
            if let Some(other) = dofs.iter().position(|&d| dimension(d) != dimension(first)) {
                let typed = self.typed(owner, value, true, false)?;
                if typed.dimension != NONE {
                    let text = format!("`{}` and `{}` need values of different units", names[0], names[other]);
                    let (a, b) = (units::written(dimension(first)), units::written(dimension(dofs[other])));
                    let based = dofs.iter().any(|&d| model.dofs[d].q_index.is_none());
                    let rest: Vec<&str> = (dofs.iter().map(|&d| &model.dofs[d]))
                        .filter(|d| d.q_index.is_some())
                        .map(|d| d.name.as_str())
                        .collect();
                    let help = if based && !rest.is_empty() {
                        let joints = names::pattern(&rest);
                        format!(
                            "the base is among these: name the other joints alone, {joints}, and the base by its own names"
                        )
                    } else {
                        "name joints of one unit together, or give each its own value".to_string()
                    };
                    self.diagnostics.push(
                        Diagnostic::error("HQ0301", value.span, text)
                            .note(format!("`{}` moves in `{a}`, `{}` in `{b}`", names[0], names[other]))
                            .help(help),
                    );
                    return None;
                }
                return dofs.iter().map(|&d| self.joint(owner, value, d, dimension(d))).collect();
            }
            let slot = match names.as_slice() {
                [_] => self.joint(owner, value, first, dimension(first))?,
                _ => {
                    let (wanted, what) = (dimension(first), "the value of these joints");
                    let owner = self.turning(owner, dofs);
                    self.value(owner, value, (Kind::Scalar, wanted), owner.range(wanted), what)?
                }
            };
            return Some(vec![slot; dofs.len()]);
        };
        let slots: Vec<Option<Slot>> =
            items.iter().zip(dofs).map(|(item, &dof)| self.joint(owner, item, dof, dimension(dof))).collect();
        merge_bare(self.diagnostics, before, value.span);
        slots.into_iter().collect()
    }

    /// The owner of a value of some joints, which turns if all of them are on the circle and the task takes the nearest turn.
    fn turning<'o>(&self, owner: Owner<'o>, dofs: &[usize]) -> Owner<'o> {
        Owner { turns: owner.takes_turns() && dofs.iter().all(|&dof| self.robot.model.is_on_circle(dof)), ..owner }
    }

    fn joint(&mut self, owner: Owner, value: &Value, dof: usize, dimension: Dimension) -> Option<Slot> {
        let what = format!("the value of `{}`", self.robot.model.dofs[dof].name);
        let owner = self.turning(owner, &[dof]);
        self.value(owner, value, (Kind::Scalar, dimension), owner.range(dimension), &what)
    }

    /// Parameters of each of some frames, as a group of groups.
    pub(super) fn per_frame(
        &mut self,
        owner: Owner,
        value: &Value,
        info: &'static ParamInfo,
        infos: &'static [ParamInfo],
    ) -> Option<Bound> {
        let block = block_of(value, &format!("`{}`", info.name), self.diagnostics)?;
        if block.entries.is_empty() {
            return self.wrong(value, info, "`{ FRAME { .. } .. }`");
        }
        let mut out = BoundParams::new();
        let mut good = true;
        for e in &block.entries {
            let name = Value { kind: ValueKind::Name(e.key.value.clone()), span: e.key.span };
            let frame = self.frame(&name, info);
            let what = format!("`{}`", e.key.value);
            let inner = block_of(&e.value, &what, self.diagnostics);
            let (Some((name, link)), Some(inner)) = (frame, inner) else {
                good = false;
                continue;
            };
            let axes = super::axes_of(&self.robot.model, link);
            let around = std::mem::replace(&mut self.plane, axes);
            let prefix = format!("{}{}.{name}.", owner.prefix, info.name);
            let group = self.group(Owner { prefix: &prefix, ..owner }, infos, inner, &what, e.key.span);
            self.plane = around;
            match group {
                Some(mut group) => {
                    group.insert("frame".to_string(), Bound::Frame(name.clone(), link));
                    out.insert(name, Bound::Group(group));
                }
                None => good = false,
            }
        }
        good.then_some(Bound::Group(out))
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
            let turning = Owner { turns: d == ANGLE, ..owner };
            let slot =
                self.value(turning, &e.value, (Kind::Scalar, d), Some(of_joint(d)), &format!("`{}`", e.key.value));
            match (arm, slot) {
                (Some(arm), Some(slot)) => out.push((arm, slot)),
                _ => good = false,
            }
        }
        good.then_some(Bound::PerArm(out))
    }
}
