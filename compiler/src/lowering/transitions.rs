//! Transitions: trigger, target, and duration of the blend.

use dsl::tree::{Transition, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use names::{list, suggest};
use runtime::program::{FaultPattern, TransitionProgram, Trigger};
use stdlib_tasks::task::RowKind;

use super::machine::{MachineLowering, unknown_state};
use super::triggers::{self, Known};
use crate::binding::Condition;
use crate::binding::motion::MeasuredState;
use crate::forms::text_of;
use crate::sections::{TRANSITION, TransitionBlock};
use crate::source_map::TransitionPlace;

impl MachineLowering<'_, '_> {
    /// Lowers the transitions of a state, and returns them with their spans.
    pub(super) fn transitions(&mut self, i: usize) -> (Vec<TransitionProgram>, Vec<TransitionPlace>) {
        let (mut out, mut places) = (Vec::new(), Vec::new());
        for t in &self.flat[i].body.transitions {
            let TransitionBlock { blend, .. } = self.lowerer.read(&t.settings, t.span);
            let target = self.target(i, t);
            let found = self.trigger(i, t);
            let blend = self.blend(i, blend);
            let (Some(target), Some((trigger, condition, at))) = (target, found) else { continue };
            let text = super::wording::trigger(t);
            out.push(TransitionProgram { trigger, text, target, blend: blend.unwrap_or(0.0) });
            let node = condition.as_ref().map(|c| c.node);
            let (constant, demands) = condition.map_or((None, Vec::new()), |c| {
                (c.constant, c.demands.into_iter().filter_map(|at| self.lowerer.interface.signal_of(at)).collect())
            });
            places.push(TransitionPlace {
                trigger: at,
                target: t.target.span,
                blend: blend.is_some(),
                condition: node,
                constant,
                demands,
            });
        }
        (out, places)
    }

    /// Resolves the target of a transition: searched inside its state first, then in each enclosing state.
    fn target(&mut self, i: usize, t: &Transition) -> Option<usize> {
        let name = t.target.value.as_str();
        if name.is_empty() {
            return None;
        }
        let (first, rest) = name.split_once('.').map_or((name, None), |(a, b)| (a, Some(b)));
        let full = |parent: usize, name: &str| match parent {
            0 => name.to_string(),
            p => format!("{}.{name}", self.flat[p].name),
        };
        let child = |parent: usize, name: &str| {
            let wanted = full(parent, name);
            (0..self.flat.len()).find(|&k| self.flat[k].parent == Some(parent) && self.flat[k].name == wanted)
        };
        let mut around = Some(i);
        while let Some(parent) = around {
            if let Some(found) = child(parent, first) {
                let found = match rest {
                    None => Some(found),
                    Some(rest) => rest.split('.').try_fold(found, child),
                };
                if found.is_some() {
                    return found;
                }
                break;
            }
            around = self.flat[parent].parent;
        }
        let names: Vec<&str> = self.flat[1..].iter().map(|f| f.name.as_str()).collect();
        let d = unknown_state(name, t.target.span, &names);
        self.lowerer.push(d);
        None
    }

    /// Blend time (s) of the transition, else of its state or of the innermost enclosing state that sets one; `None`
    /// without any.
    fn blend(&self, i: usize, own: Option<f64>) -> Option<f64> {
        let around = std::iter::successors(Some(i), |&k| self.flat[k].parent);
        own.or_else(|| around.into_iter().find_map(|k| self.settings[k].blend))
    }

    /// Lowers the trigger of a transition of state `i`.
    fn trigger(&mut self, i: usize, t: &Transition) -> Option<(Trigger, Option<Condition>, Span)> {
        match &t.trigger {
            dsl::tree::Trigger::Missing => None,
            dsl::tree::Trigger::After(value) => {
                Some((Trigger::After(self.lowerer.read_word(&TRANSITION, "after", value)?), None, value.span))
            }
            dsl::tree::Trigger::When { condition, hold } => {
                let hold = match hold {
                    Some(value) => self.lowerer.read_word(&TRANSITION, "for", value)?,
                    None => 0.0,
                };
                let targets = self.target_flags(condition);
                let mut interface = std::mem::take(&mut self.lowerer.interface);
                let mut state = MeasuredState {
                    index: i,
                    name: &self.flat[i].name,
                    interface: &mut interface,
                    measured: &mut self.measured,
                    targets: &targets,
                };
                let found = self.lowerer.binder(self.around.robot).condition(condition, &mut state);
                self.lowerer.interface = interface;
                let found = found?;
                let trigger = Trigger::When { condition: found.expression.clone(), hold };
                Some((trigger, Some(found), condition.span))
            }
            dsl::tree::Trigger::On(value) => Some((self.on(i, value)?, None, value.span)),
        }
    }

    fn on(&mut self, i: usize, value: &Value) -> Option<Trigger> {
        match &value.kind {
            ValueKind::Call(function, args) if function.value == "fault" => {
                let pattern = self.pattern(args, value.span)?;
                Some(Trigger::Fault(pattern))
            }
            ValueKind::Call(function, args) if function.value == "reached" => {
                self.reached(args, value.span).map(Trigger::Reached)
            }
            ValueKind::Call(function, args) if function.value == "ended" => self.ended(i, args, value.span),
            ValueKind::Call(function, _) => {
                let text = format!("`{}(..)` is nothing that happens", function.value);
                let d = Diagnostic::unknown_name(function.span, text);
                self.lowerer.push(d.help(Help::with(
                    "write {}, {} or {}; for a condition write `when`",
                    ["EVENT", "reached(TASK, ..)", "fault(KIND)"].map(|trigger| Snippet::entry("on", trigger)),
                )));
                None
            }
            ValueKind::Missing => None,
            _ => {
                let Some(name) = text_of(value) else {
                    let d = Diagnostic::error("HQ0304", value.span, "`on` needs an event, and this is none");
                    self.lowerer.push(d.help("for a condition write `when`"));
                    return None;
                };
                let name = crate::forms::target(name);
                if let Some(event) = self.lowerer.interface.event(name) {
                    self.lowerer.params.used.insert(name.to_string());
                    return Some(Trigger::Event(event));
                }
                let d = Diagnostic::error("HQ0702", value.span, format!("nothing provides the event `{name}`"));
                let names: Vec<&str> = self.lowerer.interface.events.iter().map(String::as_str).collect();
                let d = d.note("a state with no other transition would never be left");
                let d = match suggest(name, names.iter().copied()) {
                    Some(near) => d.meant(near),
                    None if names.is_empty() => d.help(Help::with(
                        "declare it as an event of the host, {}, or begin an action with this outcome",
                        [Snippet::of_type("signal", name, "event")],
                    )),
                    None => d.help(Help::with(
                        &format!(
                            "events are {}; declare one that the host raises with {{}}",
                            list(names.iter().copied(), 12)
                        ),
                        [Snippet::of_type("signal", name, "event")],
                    )),
                };
                self.lowerer.push(d);
                None
            }
        }
    }

    fn pattern(&mut self, args: &[Value], at: Span) -> Option<FaultPattern> {
        let known = Known {
            signals: self.lowerer.interface.signals.iter().map(|s| s.name.as_str()).collect(),
            humans: self.lowerer.interface.humans.iter().map(|h| (h.name.as_str(), h.points.as_slice())).collect(),
            tasks: &self.around.tasks,
            levels: self.around.levels.as_deref(),
            limits: (self.around.bound.iter())
                .map(|b| b.as_ref().is_none_or(|b| b.kind.row_kind == RowKind::Inequality))
                .collect(),
        };
        triggers::pattern(args, at, &known).map_err(|d| self.lowerer.diagnostics.extend(d.map(|d| *d))).ok()
    }
}
