//! Parameters that are numbers, vectors or orientations, or several of these.

use std::ops::RangeInclusive;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help};
use names::list;
use runtime::program::{ValueRange, overshoots};
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::dimension::{Dimension, RATE};
use stdlib_tasks::params::{ParamInfo, Quantity};

use super::gain;
use super::scope::TaskScope;
use super::{Binder, DEFAULTS, Number, Owner, robot_state};
use crate::expr::constants::{check_dimension, misplaced_unit, one_unit, with_units};
use crate::expr::{Frame, Kind, Lowering, Typed, frames, unusual};
use crate::forms::unknown_key;
use crate::units;

impl Binder<'_> {
    /// Types a value. `moving` permits dependence on time, `state` dependence on the robot's current state.
    pub(super) fn typed(&mut self, owner: Owner, value: &Value, moving: bool, state: bool) -> Option<Typed> {
        let (robot, forms, axes) = (self.robot, &self.forms, &self.axes);
        let kind = owner.kind;
        let mut scope = TaskScope {
            robot,
            params: self.params,
            table: self.table,
            owner: Some(owner),
            moving,
            state,
            whole: Some(value.span),
            capturing: false,
            asked: false,
            forms,
            axes,
            numbers: None,
            targets: &[],
        };
        let typed =
            Lowering { graph: self.graph, scope: &mut scope, diagnostics: self.diagnostics }.value(value).ok()?;
        // A named expression of the robot's state is valid by itself, so only this check rejects it here.
        if !state && typed.nodes.iter().any(|&n| self.graph.is_state(n)) {
            self.diagnostics.push(robot_state::misplaced(Some(kind), value.span));
            return None;
        }
        Some(typed)
    }

    /// Types a value of a given kind and dimension, and stores it in the table.
    pub(super) fn value(
        &mut self,
        owner: Owner,
        value: &Value,
        wanted: (Kind, Dimension),
        quantity: Option<Quantity>,
        what: &str,
    ) -> Option<Slot> {
        let axes = self.target_axes(owner);
        self.value_in(owner, value, (wanted, quantity), &axes, what)
    }

    /// Lets trajectories of an angle on the circle move to their goals by the nearest turn.
    pub(super) fn turn_near(&mut self, owner: Owner, typed: &mut Typed) {
        if let (true, Kind::Scalar, [node]) = (owner.turns, typed.kind, typed.nodes.as_mut_slice()) {
            *node = self.graph.by_nearest_turn(*node);
        }
    }

    /// As [`Self::value`], with the axes that the value must have.
    fn value_in(
        &mut self,
        owner: Owner,
        value: &Value,
        (wanted, quantity): ((Kind, Dimension), Option<Quantity>),
        axes: &Frame,
        what: &str,
    ) -> Option<Slot> {
        let constant = quantity.is_some_and(|q| q.constant);
        let mut typed = self.typed(owner, value, !constant, false)?;
        self.turn_near(owner, &mut typed);
        let before = self.diagnostics.len();
        if self.expressed(&typed, axes, false, what).is_none() {
            let refused: Vec<Diagnostic> = self.diagnostics.drain(before..).collect();
            let refused = refused.into_iter().map(|d| self.because(owner, &typed, d)).collect::<Vec<_>>();
            self.diagnostics.extend(refused);
            return None;
        }
        self.allocate_slot(owner, value, &typed, (wanted, quantity), what)
    }

    /// Rejects a value that is not expressed in `axes`. `state` permits dependence on the robot's current state.
    pub(super) fn expressed(&mut self, typed: &Typed, axes: &Frame, state: bool, what: &str) -> Option<()> {
        let model = &self.robot.model;
        let still = |f: &Frame| match f {
            Frame::Link(name) => model.link(name).is_some_and(|l| model.support(l).is_empty()),
            _ => true,
        };
        let d = frames::wanted(typed, axes, what, state || (still(&typed.axes.to) && still(axes)));
        let good = d.is_none();
        self.diagnostics.extend(d);
        good.then_some(())
    }

    /// Rejects a typed value of a different kind or dimension.
    pub(super) fn check_type(
        &mut self,
        typed: &Typed,
        value: &Value,
        wanted: (Kind, Dimension),
        what: &str,
    ) -> Option<()> {
        if typed.kind != wanted.0 {
            let (is, needed) = (typed.kind.describe(), wanted.0.describe());
            let d = Diagnostic::error("HQ0304", value.span, format!("{what} is {needed}, and this is {is}")).here(is);
            self.diagnostics.push(d.help(match wanted.0 {
                Kind::Vector if typed.kind == Kind::Pose => "write `.position` after it".to_string(),
                Kind::Rotation if typed.kind == Kind::Pose => "write `.orientation` after it".to_string(),
                Kind::Scalar => format!("write one number{}", unit_behind(wanted.1)),
                Kind::Vector => format!("write `[x, y, z]{}`", suffix(wanted.1)),
                Kind::Rotation => {
                    "write `rpy(roll, pitch, yaw)`, `axis_angle(vector, angle)` or `quaternion(w, x, y, z)`".to_string()
                }
                Kind::Pose => "write `pose([x, y, z] m, rpy(roll, pitch, yaw))`".to_string(),
                Kind::Truth => "write a comparison, or `true` or `false`".to_string(),
            }));
            return None;
        }
        if let Some(mut d) = check_dimension(self.graph, typed, wanted.1, what) {
            d.help = misplaced_unit(value, wanted.1).map(Help::from).or(d.help);
            let error = d.severity == dsl::Severity::Error;
            self.diagnostics.push(d);
            if error {
                return None;
            }
        }
        Some(())
    }

    /// Stores a typed value that depends on time alone in the table, and checks its kind, dimension and range.
    pub(super) fn allocate_slot(
        &mut self,
        owner: Owner,
        value: &Value,
        typed: &Typed,
        (wanted, quantity): ((Kind, Dimension), Option<Quantity>),
        what: &str,
    ) -> Option<Slot> {
        let constant = quantity.is_some_and(|q| q.constant);
        let gain = wanted.1 == RATE && quantity.is_some();
        self.check_type(typed, value, wanted, what)?;
        let slot = self.table.place(&typed.nodes);
        let written = self.sources.get(value.span.source).is_some_and(|s| s.name != DEFAULTS);
        self.numbers.push(Number { slot, dimension: wanted.1, span: value.span, written });
        for (i, &n) in typed.nodes.iter().enumerate() {
            match self.graph.constant(n) {
                Some(x) if !x.is_finite() => {
                    self.diagnostics.push(
                        Diagnostic::error("HQ0309", value.span, format!("{what} is not a finite number"))
                            .help("check for a division by zero, or factors that are far too large"),
                    );
                    return None;
                }
                Some(x) => {
                    if let Some(q) = quantity.filter(|q| !q.contains(x)) {
                        self.diagnostics.push(
                            Diagnostic::error(
                                "HQ0308",
                                value.span,
                                format!("{what} is {}, and this is {x}{}", q.describe(), suffix(wanted.1)),
                            )
                            .here(format!("{x}{}", suffix(wanted.1)))
                            .help(format!(
                                "write a value that is {}{}",
                                q.describe(),
                                suffix(wanted.1)
                            )),
                        );
                        return None;
                    }
                    // Reported here, together with the other mistakes of the file; `checks` judges defaults later, in
                    // the finished program.
                    let (period, rate) = (self.robot.period, self.robot.rate_span);
                    if gain && written && overshoots(x, period) {
                        self.diagnostics.push(gain::overshoot(value.span, x, (period, rate), owner.kind.row_kind));
                        return None;
                    }
                }
                None if constant => {
                    self.diagnostics.push(
                        Diagnostic::error("HQ0307", value.span, format!("{what} must not move with time"))
                            .help("write a constant"),
                    );
                    return None;
                }
                None => {
                    let q = quantity.unwrap_or(Quantity::any(wanted.1));
                    // A moving gain obeys the bound that HQ0501 sets for a constant one: gain times period <= 1.
                    let max = if gain { q.max.min(1.0 / self.robot.period) } else { q.max };
                    let finite = |x: f64| x.is_finite().then_some(x);
                    let (at, min, max) = (slot.at + i, finite(q.min), finite(max));
                    self.table.ranges.push(ValueRange { at, min, max, gain });
                }
            }
        }
        let numbers: Option<Vec<f64>> = typed.nodes.iter().map(|&n| self.graph.constant(n)).collect();
        if let (true, Some(q), Some(numbers)) = (written, quantity, numbers) {
            self.diagnostics.extend(unusual(value, what, &numbers, &q));
        }
        Some(slot)
    }

    /// One number for all three axes, or a vector with a number for each.
    pub(super) fn per_axis(&mut self, owner: Owner, value: &Value, q: Quantity, what: &str) -> Option<Slot> {
        let mut typed = self.typed(owner, value, !q.constant, false)?;
        if let (Kind::Scalar, [one]) = (typed.kind, typed.nodes.as_slice()) {
            typed.nodes = vec![*one; 3];
            typed.kind = Kind::Vector;
        } else if typed.kind != Kind::Vector {
            let text = format!("{what} is a number or a vector, and this is {}", typed.kind.describe());
            let unit = suffix(q.dimension);
            self.diagnostics.push(
                Diagnostic::error("HQ0304", value.span, text)
                    .help(format!("write one number{} for all axes, or `[x, y, z]{unit}`", unit_behind(q.dimension))),
            );
            return None;
        }
        self.expressed(&typed, &Frame::World, false, what)?;
        self.allocate_slot(owner, value, &typed, ((Kind::Vector, q.dimension), Some(q)), what)
    }

    pub(super) fn vectors(
        &mut self,
        owner: Owner,
        value: &Value,
        count: RangeInclusive<usize>,
        d: Dimension,
        info: &ParamInfo,
    ) -> Option<Bound> {
        let items = with_units(value).unwrap_or_default();
        let number = |i: &Value| match &i.kind {
            ValueKind::Unit(inner, _) => matches!(inner.kind, ValueKind::Number(_)),
            kind => matches!(kind, ValueKind::Number(_)),
        };
        if !count.contains(&items.len()) || items.iter().any(number) {
            let (least, most) = (count.start(), count.end());
            let count = if least == most { least.to_string() } else { format!("{least} to {most}") };
            return self.wrong(value, info, &format!("a list of {count} vectors, `[[x, y, z], ..] m`"));
        }
        let quantity = Quantity::any(d).constant();
        let mut at = None;
        let what = format!("each vector of `{}`", info.name);
        for item in &items {
            let before = self.diagnostics.len();
            let plane = self.plane.clone();
            let slot = self.value_in(owner, item, ((Kind::Vector, d), Some(quantity)), &plane, &what);
            one_unit(self.diagnostics, before, value, 1);
            at.get_or_insert(slot?.at);
        }
        Some(Bound::Value(Slot { at: at?, len: 3 * items.len() }))
    }

    pub(super) fn gains(
        &mut self,
        owner: Owner,
        value: &Value,
        names: &'static [&'static str],
        info: &ParamInfo,
    ) -> Option<Bound> {
        let q = quantities::usual::GAIN;
        let ValueKind::Block(block) = &value.kind else {
            let slot = self.value(owner, value, (Kind::Scalar, RATE), Some(q), &format!("`{}`", info.name))?;
            let node = self.table.nodes[slot.at];
            let range = self.table.ranges.iter().find(|r| r.at == slot.at).copied();
            for k in 1..names.len() {
                self.table.place(&[node]);
                if let Some(range) = range {
                    self.table.ranges.push(ValueRange { at: slot.at + k, ..range });
                }
            }
            return Some(Bound::Value(Slot { at: slot.at, len: names.len() }));
        };
        for i in 0..block.entries.len() {
            if !names.contains(&block.entries[i].key.value.as_str()) {
                self.diagnostics.push(unknown_key(
                    self.diagnostics.len(),
                    block,
                    i,
                    names,
                    &format!("`{}`", info.name),
                ));
                return None;
            }
        }
        let mut at = None;
        for name in names {
            let Some(e) = block.get(name) else {
                return self.wrong(value, info, &format!("one rate, or {} together", list(names.iter().copied(), 4)));
            };
            let slot = self.value(owner, &e.value, (Kind::Scalar, RATE), Some(q), &format!("`{name}`"))?;
            at.get_or_insert(slot.at);
        }
        Some(Bound::Value(Slot { at: at?, len: names.len() }))
    }
}

/// Unit to write after a number, with a space: ` m`, ` /s`; empty for a bare number.
fn suffix(dimension: Dimension) -> String {
    let unit = units::written(dimension);
    if unit.is_empty() { unit } else { format!(" {unit}") }
}

fn unit_behind(dimension: Dimension) -> String {
    let unit = units::written(dimension);
    if unit.is_empty() { unit } else { format!(" in `{unit}`") }
}
