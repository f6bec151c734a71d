//! Home configuration. It is read for the robot with all its joints, because it may also set positions of locked
//! joints, and then reduced to the remaining joints.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Topic};
use names::list;
use robot::Model;

use super::base_entries::{self, BaseEntry};
use super::lookup::joints;
use super::postures::Postures;
use super::{Binder, JointGroups};
use crate::expr::constants::{Constants, joint_dimension};
use crate::forms::block_of;
use crate::units;

/// Positions of joints in one entry of `home`, by name.
struct Written {
    key: Span,
    value: Span,
    joints: Vec<(String, f64, Span)>,
}

/// Home configuration as written.
#[derive(Default)]
pub(super) struct Home {
    /// Coordinates of the base, by their index in `q`.
    base: Vec<(usize, f64)>,
    entries: Vec<Written>,
    /// True if an entry could not be read.
    broken: bool,
    span: Option<Span>,
}

impl Home {
    /// Reads `home` for the robot with all its joints. Reports joints that are set twice.
    pub(super) fn read(
        value: Option<&Value>,
        (model, groups, postures): (&Model, &JointGroups, &Postures),
        constants: &mut Constants,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Home {
        let Some(value) = value else { return Home::default() };
        if let Some(name) = postures.named_by(value, None, constants.params) {
            let mut home = Home { span: Some(value.span), ..Home::default() };
            match at_posture(postures, name, None, value.span, diagnostics) {
                Some(joints) => home.entries.push(Written { key: value.span, value: value.span, joints }),
                None => home.broken = true,
            }
            return home;
        }
        let Some(block) = block_of(value, "`home`", diagnostics) else {
            return Home { broken: true, span: Some(value.span), ..Home::default() };
        };
        let mut home = Home { span: Some(block.span), ..Home::default() };
        let mut given: BTreeMap<usize, Span> = BTreeMap::new();
        for e in &block.entries {
            match BaseEntry::read(model, e, constants, diagnostics) {
                BaseEntry::Other => {}
                BaseEntry::Wrong => continue,
                BaseEntry::Coordinates { first, values } => {
                    home.base.extend(values.into_iter().enumerate().map(|(i, x)| (first + i, x)));
                    continue;
                }
            }
            let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let found = joints(std::slice::from_ref(&name), model, groups, diagnostics);
            // `all` and patterns select joints only; the coordinates of the base have names of their own.
            let dofs =
                found.map(|dofs| dofs.into_iter().filter(|&d| model.dofs[d].q_index.is_some()).collect::<Vec<_>>());
            if dofs.as_ref().is_some_and(Vec::is_empty) {
                let text = format!("`{}` belongs to the base, which has no joint position", e.key.value);
                let help = format!("write {}", list(base_entries::names(model).iter().map(String::as_str), 4));
                diagnostics.push(Diagnostic::unknown_name(e.key.span, text).help(help));
                home.broken = true;
                continue;
            }
            if let Some(posture) = postures.named_by(&e.value, Some(&e.key.value), constants.params) {
                let at = at_posture(postures, posture, Some(&e.key.value), e.value.span, diagnostics);
                home.broken |= at.is_none();
                let mut written = Written { key: e.key.span, value: e.value.span, joints: Vec::new() };
                let mut twice: Vec<(String, Span)> = Vec::new();
                for (joint, x, span) in at.into_iter().flatten() {
                    let first = model.dof(&joint).and_then(|dof| given.insert(dof, e.key.span));
                    twice.extend(first.map(|first| (joint.clone(), first)));
                    written.joints.push((joint, x, span));
                }
                let twice: Vec<(&str, Span)> = twice.iter().map(|(name, first)| (name.as_str(), *first)).collect();
                diagnostics.extend(given_twice(&twice, e.key.span));
                home.entries.push(written);
                continue;
            }
            let values = dofs.and_then(|dofs| Some((constants.per_joint(&e.value, &dofs, model, diagnostics)?, dofs)));
            let Some((values, dofs)) = values else {
                home.broken = true;
                continue;
            };
            let mut written = Written { key: e.key.span, value: e.value.span, joints: Vec::new() };
            let mut twice: Vec<(&str, Span)> = Vec::new();
            for (dof, (x, span)) in dofs.iter().zip(values) {
                let d = &model.dofs[*dof];
                twice.extend(given.insert(*dof, e.key.span).map(|first| (d.name.as_str(), first)));
                written.joints.push((d.name.clone(), x, span));
            }
            diagnostics.extend(given_twice(&twice, e.key.span));
            home.entries.push(written);
        }
        home
    }

    /// Position of a joint, with its span.
    pub(super) fn of(&self, joint: &str) -> Option<(f64, Span)> {
        self.entries.iter().flat_map(|w| &w.joints).rfind(|j| j.0 == joint).map(|j| (j.1, j.2))
    }
}

impl Binder<'_, '_> {
    /// Configuration of the remaining joints, with the span of `home`.
    pub(super) fn home(&mut self, home: &Home) -> (Vec<f64>, Span) {
        let mut q = self.model.neutral();
        let span = home.span.unwrap_or(self.robot.name.span);
        for (i, x) in &home.base {
            q[*i] = *x;
        }
        let mut given: Vec<usize> = Vec::new();
        for w in &home.entries {
            let mut outside: Vec<Outside> = Vec::new();
            for (name, x, at) in &w.joints {
                let Some(dof) = self.model.dof(name) else { continue };
                let d = &self.model.dofs[dof];
                let Some(i) = d.q_index else { continue };
                given.push(i);
                if *x < d.lower || *x > d.upper {
                    let unit = joint_dimension(&self.model, dof);
                    let text = format!("`{}` starts at {}, outside its limits", d.name, units::shown(*x, unit));
                    let range = format!("allowed are {}", units::shown_range(d.lower, d.upper, unit));
                    outside.push(Outside { at: *at, text, range, kept_by: self.kept_by(dof, *x) });
                }
                q[i] = *x;
            }
            self.outside(outside, w.key.to(w.value));
        }
        if !home.broken {
            self.elsewhere(&q, &given, span);
        }
        (q, span)
    }

    /// Reports the joints of an entry that start outside of their limits; one message per value.
    fn outside(&mut self, outside: Vec<Outside>, entry: Span) {
        // Degrees without a unit are the likely cause, not the limits.
        let of_entry = |d: &mut Diagnostic| {
            let at = d.primary.span;
            d.topic == Topic::BareAngle && at.source == entry.source && entry.start <= at.start && at.end <= entry.end
        };
        let bare = !outside.is_empty() && self.diagnostics.extract_if(.., of_entry).count() > 0;
        for (i, Outside { at, text, range, kept_by }) in outside.iter().enumerate() {
            if outside[..i].iter().any(|o| o.at == *at) {
                continue;
            }
            let more = outside.iter().filter(|o| o.at == *at).count() - 1;
            let more = if more > 0 { format!(", and so do {more} more joints") } else { String::new() };
            let mut d = Diagnostic::error("HQ0404", *at, format!("{text}{more}")).here(range.clone());
            d.notes.extend(kept_by.clone());
            self.diagnostics.push(if bare {
                d.note("angles without a unit are radians").help("if degrees are meant, write `deg` after it")
            } else {
                d.help("move the joint inside its limits, or set others under `limits`")
            });
        }
    }

    /// The reason for a limit of a joint that one of its followers sets.
    fn kept_by(&self, dof: usize, x: f64) -> Option<String> {
        let model = &self.model;
        let keeps = |follower: &robot::JointId| {
            let limits = model.limits_of_leader(*follower);
            x < limits.lower || x > limits.upper
        };
        let own = model.dofs[dof].joint.map(|joint| model.joint_ref(joint).limits());
        if own.is_some_and(|own| x < own.lower || x > own.upper) {
            return None;
        }
        let follower = model.followers(dof).find(keeps)?;
        Some(format!("`{}` follows it, and would be outside its own limits", model.joint_ref(follower).name))
    }

    /// Warns of joints that `home` omits and that cannot be at zero.
    fn elsewhere(&mut self, q: &[f64], given: &[usize], span: Span) {
        let joints = self.model.dofs.iter().enumerate().filter_map(|(i, d)| Some((i, d, d.q_index?)));
        let moved: Vec<String> = joints
            .filter(|(_, d, k)| !given.contains(k) && q[*k] != 0.0 && d.lower <= d.upper)
            .map(|(i, d, k)| format!("`{}` at {}", d.name, units::shown(q[k], joint_dimension(&self.model, i))))
            .collect();
        if !moved.is_empty() {
            let text = format!("joints whose range excludes zero are missing in home: {}", moved.join(", "));
            self.diagnostics.push(
                Diagnostic::warning("HQ0405", span, text)
                    .note("a joint that `home` does not name starts at zero, or at the limit nearest to it")
                    .help("name them in `home`"),
            );
        }
    }
}

/// Positions of the joints of a posture, those that it leaves out excepted; `None` if there is no such posture.
fn at_posture(
    postures: &Postures,
    name: &str,
    key: Option<&str>,
    at: Span,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<(String, f64, Span)>> {
    match postures.positions(name, key, at) {
        Ok(positions) => Some(positions.into_iter().filter_map(|p| Some((p.joint, p.value?, at))).collect()),
        Err(d) => {
            diagnostics.push(*d);
            None
        }
    }
}

/// Diagnostic for joints that are given twice, each with the place where it is given first.
fn given_twice(twice: &[(&str, Span)], at: Span) -> Option<Diagnostic> {
    let (name, first) = twice.first()?;
    let more = match twice.len() - 1 {
        0 => String::new(),
        1 => ", and so is 1 more".to_string(),
        n => format!(", and so are {n} more"),
    };
    let d = Diagnostic::error("HQ0207", at, format!("joint `{name}` is given twice{more}"));
    Some(d.label(*first, "first here").help("keep one of the two"))
}

/// A joint outside of its limits.
struct Outside {
    /// Its value.
    at: Span,
    /// Message.
    text: String,
    /// Permitted range.
    range: String,
    /// The reason, if a follower sets the limit.
    kept_by: Option<String>,
}
