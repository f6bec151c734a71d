//! Limits of joints that the spec sets in place of those of the URDF. A joint that follows another one has limits of its
//! own, which bound the joint that it follows.

use blocks::{ByName, Located, Unbound};
use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Topic};
use quantities::usual::of_joint;
use robot::{Drive, JointId, JointKind, Limits};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, RATE};

use super::lookup::joints;
use super::{Binder, JointGroups};
use crate::expr::constants::joint_dimension;
use crate::expr::unusual;
use crate::sections::LimitBlock;
use crate::units;

/// Relative difference of a limit that is the rounding of a conversion.
const ROUNDING: f64 = 1e-6;

/// A joint or a degree of freedom of the base whose limits are set.
struct Limited {
    name: String,
    unit: Dimension,
    own: Limits,
}

/// Limits that the spec sets.
struct Set<'b> {
    /// The degree of freedom that they bound.
    dof: usize,
    /// Their place.
    at: Span,
    /// The limits, if they are those of the joint that the others follow.
    leader: Option<&'b LimitBlock>,
}

impl Binder<'_, '_> {
    pub(super) fn limits(&mut self, groups: &JointGroups) {
        let mut set: Vec<Set> = Vec::new();
        for ByName { name, value: limits, .. } in &self.block.limits {
            let at = self.origins.span(limits.at);
            if let Some((follower, dof)) = self.follower(&name.value) {
                let joint = self.model.joint_ref(follower);
                let unit = if joint.kind == JointKind::Prismatic { LENGTH } else { ANGLE };
                let limited = Limited { name: joint.name.clone(), unit, own: joint.limits() };
                let kept = self.limits_of(&limited, &limits.value, at);
                self.model.set_limits(follower, kept);
                set.push(Set { dof, at, leader: None });
                continue;
            }
            let key = Value { kind: ValueKind::Text(name.value.clone()), span: self.origins.span(name.at) };
            let Some(dofs) = joints(std::slice::from_ref(&key), &self.model, groups, self.diagnostics) else {
                continue;
            };
            for dof in dofs {
                self.limits_of_dof(dof, &limits.value, at);
                set.push(Set { dof, at, leader: Some(&limits.value) });
            }
        }
        for set in set {
            self.followers_fit(&set);
        }
    }

    /// The joint of this name, if it follows another one, with the degree of freedom that moves both.
    fn follower(&self, name: &str) -> Option<(JointId, usize)> {
        let joint = self.model.joint(name)?;
        match self.model.joint_ref(joint).drive {
            Drive::Mimic { dof, .. } => Some((joint, dof)),
            _ => None,
        }
    }

    fn limits_of_dof(&mut self, dof: usize, limits: &LimitBlock, at: Span) {
        let d = &self.model.dofs[dof];
        let of_base = Limits { lower: d.lower, upper: d.upper, velocity: d.velocity, acceleration: d.acceleration };
        let own = d.joint.map_or(of_base, |joint| self.model.joint_ref(joint).limits());
        let (joint, name) = (d.joint, d.name.clone());
        let limited = Limited { name, unit: joint_dimension(&self.model, dof), own };
        let kept = self.limits_of(&limited, limits, at);
        match joint {
            Some(joint) => self.model.set_limits(joint, kept),
            None => {
                let d = &mut self.model.dofs[dof];
                (d.lower, d.upper, d.velocity) = (kept.lower, kept.upper, kept.velocity);
            }
        }
    }

    /// Reports followers that leave a joint no motion, and limits of the spec that followers narrow.
    fn followers_fit(&mut self, &Set { dof, at, leader }: &Set) {
        let d = &self.model.dofs[dof];
        let Some(joint) = d.joint else { return };
        let own = self.model.joint_ref(joint).limits();
        let followers = || self.model.followers(dof).map(|f| self.model.joint_ref(f).name.clone());
        let unit = joint_dimension(&self.model, dof);
        if own.leave_no_motion() || self.diagnostics.iter().any(|d| d.primary.span == at) {
            return;
        }
        let Some(first) = followers().next() else { return };
        let narrowed = |written: &LimitBlock| {
            (written.lower.is_some() && d.lower > own.lower)
                || (written.upper.is_some() && d.upper < own.upper)
                || (written.velocity.is_some() && d.velocity < own.velocity)
        };
        let diagnostic = if d.lower >= d.upper {
            let text = format!("`{}` cannot move within these limits and those of `{first}`, which follows it", d.name);
            Diagnostic::error("HQ0308", at, text).help(format!("give `{first}` other limits, or lock `{}`", d.name))
        } else if leader.is_some_and(narrowed) {
            let speed = unit.times(RATE).unwrap_or(RATE);
            let kept = units::shown_range(d.lower, d.upper, unit);
            let mut text = format!("`{}` keeps {kept}", d.name);
            if d.velocity.is_finite() {
                text = format!("{text}, and {}", units::shown(d.velocity, speed));
            }
            Diagnostic::warning("HQ0556", at, format!("`{first}` follows `{}`, and has narrower limits", d.name))
                .here(text)
                .note("a joint that follows another one moves with it, so that both keep the limits of both")
                .help(format!(
                    "write limits that `{first}` keeps too, or limits of `{first}` if those of its URDF are wrong"
                ))
        } else {
            return;
        };
        self.diagnostics.push(diagnostic);
    }

    /// Warns of a speed limit above that of the URDF; once for an entry that gives the limits of many joints.
    fn above_the_urdf(&mut self, of: &Limited, x: f64, at: Span) {
        if self.diagnostics.iter().any(|d| d.primary.span == at) {
            return;
        }
        let speed = of.unit.times(RATE).unwrap_or(RATE);
        let own = units::shown(of.own.velocity, speed);
        let warning = Diagnostic::warning("HQ0556", at, "this speed limit is above that of the robot")
            .here(format!("{}; the URDF gives `{}` {own}", units::shown(x, speed), of.name))
            .note("a limit in the spec does not make the joint faster: the robot lags behind its reference")
            .help(format!("stay within {own}, or correct the URDF if its limit is wrong"));
        self.diagnostics.push(warning);
    }

    /// Limits of one joint, written at a place.
    fn limits_of(&mut self, of: &Limited, LimitBlock { lower, upper, velocity, .. }: &LimitBlock, at: Span) -> Limits {
        let unit = of.unit;
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
        let mut kept = of.own;
        if let Some((x, written)) =
            speed.filter(|(x, _)| of.own.velocity.is_finite() && *x > of.own.velocity * (1.0 + ROUNDING))
        {
            self.above_the_urdf(of, x, self.origins.span(written.at));
        }
        let (low, high) = (lower.unwrap_or(of.own.lower), upper.unwrap_or(of.own.upper));
        match speed {
            Some((speed, _)) if speed > 0.0 => kept.velocity = speed,
            Some((_, written)) => self.diagnostics.push(
                Diagnostic::error("HQ0308", self.origins.span(written.at), "a velocity limit is more than zero")
                    .help("to keep a joint still, name it in `lock`"),
            ),
            None => {}
        }
        if low > high {
            let text = format!(
                "`{}` would have a lower limit of {} above its upper limit of {}",
                of.name,
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
            (kept.lower, kept.upper) = (low, high);
        }
        kept
    }
}
