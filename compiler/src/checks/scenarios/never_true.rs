//! Expectations that need what no run of the scenario contains: states that it never enters, values that its signals never
//! have, faults that it never causes.

use dsl::tree::{Formula, FormulaKind, Value};
use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::FaultKind;
use runtime::expect::Node;
use runtime::program::{Measure, Unit};
use runtime::text::number;

use super::Scene;
use crate::analysis::played::Missing;
use crate::units::shown;

/// Largest number of transitions that are explained.
const EXPLAINED: usize = 3;

/// Effect of a condition that never holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effect {
    /// Nothing is expected.
    Vacuous,
    /// The expectation fails in every run.
    Fails,
}

impl Scene<'_> {
    /// Warns of conditions that never hold and that an expectation needs.
    pub(super) fn never_true(&self, out: &mut Vec<Diagnostic>) {
        for (e, expect) in self.written.expects.iter().enumerate() {
            let before = out.len();
            self.needed(&expect.formula, out);
            if out.len() == before {
                out.extend(self.too_early(e));
            }
        }
    }

    /// Warning of an expectation of a state that the machine enters only later.
    fn too_early(&self, expectation: usize) -> Option<Diagnostic> {
        let formula = &self.scenario.expectations[expectation].formula;
        let (deadline, inner) = match formula.nodes.last()? {
            Node::Always(window, a) => (window.first, *a),
            Node::Eventually(window, a) => (window.last?, *a),
            Node::Within(ticks, a) => (*ticks, *a),
            _ => return None,
        };
        let Node::Predicate(p) = formula.nodes.get(inner)? else { return None };
        // A truth value that is a state alone, and not its negation.
        let is_state = self.scenario.predicates.get(*p)?.value.ops.len() == 1;
        let mut states = self.played.measures(*p).filter_map(|m| if let Measure::In(s) = m { Some(*s) } else { None });
        let state = states.next().filter(|_| is_state && self.played.is_of_machine())?;
        let (at, period) = (self.written.expects[expectation].formula.span, self.program.robot.period);
        let earliest = self.played.earliest(state)?;
        let deadline = f64::from(deadline) * period;
        if earliest <= deadline + period {
            return None;
        }
        let name = self.program.machine.as_ref().map_or("", |m| m.states[state].name.as_str());
        Some(
            Diagnostic::warning("HQ0812", at, "no run of the scenario satisfies this in time")
                .note(format!(
                    "it is judged until {} s, and the machine enters `{name}` after {} s at the earliest",
                    number(deadline),
                    number((1e3 * earliest).round() / 1e3)
                ))
                .help("write a later end of the window, or let the script lead there earlier"),
        )
    }

    /// Examines a formula that must be true at some tick.
    fn needed(&self, f: &Formula, out: &mut Vec<Diagnostic>) {
        use FormulaKind as F;
        match &f.kind {
            F::Value(value) if !self.truths(f).holds => out.extend(self.report(value, value.span, Effect::Fails, out)),
            F::Always(_, a) | F::Eventually(_, a) | F::Until(_, _, a) => self.needed(a, out),
            F::And(a, b) => {
                self.needed(a, out);
                self.needed(b, out);
            }
            F::Or(a, b) if !self.truths(a).holds && !self.truths(b).holds => self.needed(a, out),
            F::Implies(a, b) | F::After(a, b) => {
                if self.truths(a).holds {
                    self.needed(b, out);
                } else if let Some(value) = self.cause(a) {
                    out.extend(self.report(value, a.span, Effect::Vacuous, out));
                }
            }
            F::Value(_) | F::Or(..) | F::Never(..) | F::Not(_) | F::Missing => {}
        }
    }

    /// The first comparison of a conjunction that never holds.
    fn cause<'f>(&self, f: &'f Formula) -> Option<&'f Value> {
        match &f.kind {
            FormulaKind::Value(value) => (!self.truths(f).holds).then_some(value),
            FormulaKind::And(a, b) => self.cause(a).or_else(|| self.cause(b)),
            _ => None,
        }
    }

    /// Warning of a condition that never holds. `whole` is the antecedent that it is a part of.
    fn report(&self, value: &Value, whole: Span, effect: Effect, out: &[Diagnostic]) -> Option<Diagnostic> {
        if Self::is_reported(out, &["HQ0810", "HQ0811", "HQ0813", "HQ0815"], whole) {
            return None;
        }
        let predicate = self.predicate_of(value)?;
        let text = match effect {
            Effect::Vacuous => "this never holds in the scenario, so nothing is expected",
            Effect::Fails => "this never holds in the scenario, so the expectation fails in every run",
        };
        let d = || Diagnostic::warning("HQ0812", whole, text);
        for measure in self.played.measures(predicate) {
            match measure {
                Measure::In(state) if !self.played.enters(*state) => return Some(self.not_entered(d(), *state)),
                Measure::Fault(Some(FaultKind::Deadline)) if !self.played.misses_the_deadline() => {
                    return Some(self.in_time(d(), whole));
                }
                _ => {}
            }
        }
        let node = *self.played.places.nodes.get(predicate)?;
        let needed = self.played.needed(node);
        if let Some(&signal) = needed.iter().find(|&&s| !self.played.sent[s]) {
            // A script whose values are all lost is reported by itself.
            if self.scenario.world.signals.iter().any(|s| s.signal == signal) {
                return None;
            }
            let name = &self.program.interface.signals[signal].name;
            let value = Snippet::block(name, [Snippet::entry("value", ".."), Snippet::dots()]);
            return Some(
                d().note(format!("nothing sends `{name}` in this scenario, and a comparison without a value is false"))
                    .help(Help::with("send it: {}", [Snippet::block("signals", [value])])),
            );
        }
        // People who never matter are reported at their script.
        let is_person = |s: &usize| self.program.interface.signals[*s].is_of_person();
        if needed.iter().any(is_person) {
            return None;
        }
        let unit = self.scenario.predicates.get(predicate)?.unit;
        let short = -self.played.range(node).high;
        let d = match unit {
            Unit::Quantity(dimension) if short.is_finite() && short > 0.0 => {
                let by = shown(format!("{short:.4}").parse().unwrap_or(short), dimension);
                d().note(format!("at every tick it falls short of the bound by at least {by}"))
            }
            _ => d().note("with the values of this scenario it is false at every tick"),
        };
        Some(d.help("correct the bound, or let the script of the scenario reach it"))
    }

    /// Adds the reasons why a state is not entered.
    fn not_entered(&self, mut d: Diagnostic, state: usize) -> Diagnostic {
        let name = self.program.machine.as_ref().map_or("", |m| m.states[state].name.as_str());
        let places = self.places.machine.as_ref();
        let mut event = None;
        for untaken in self.played.untaken(state).into_iter().take(EXPLAINED) {
            let Some(place) = places.and_then(|p| p.transitions.get(untaken.state)?.get(untaken.index)) else {
                continue;
            };
            let why = match untaken.missing {
                Missing::Event(e) => {
                    let raised = &self.program.interface.events[e];
                    if places.is_some_and(|p| e < p.declared_events) {
                        event.get_or_insert(raised);
                    }
                    format!("nothing raises `{raised}` while the machine waits for it")
                }
                Missing::Condition => "does not hold with the values of this scenario".to_string(),
                Missing::Time => format!("the run ends before, at {} s", number(self.scenario.run.duration)),
            };
            d = d.label(place.trigger, why);
        }
        d = d.note(format!("no run of this scenario enters `{name}`"));
        match event {
            Some(event) => {
                d.help(Help::with("raise the event: {}", [Snippet::block("events", [Snippet::entry(event, "1 s")])]))
            }
            None => d.help("let the script of the scenario lead there, or expect something else"),
        }
    }

    /// Reports ticks that are not late enough for a fault, at the first of them if there is one.
    fn in_time(&self, mut d: Diagnostic, at: Span) -> Diagnostic {
        let (period, deadline) = (self.program.robot.period, self.program.robot.deadline);
        let ms = |time: f64| format!("{} ms", number(1e3 * time));
        let late = self.written.body.get("late").and_then(|e| e.value.items().first()?.block()?.get("by"));
        let Some((by, (_, delay))) = late.zip(self.scenario.world.late.first()) else {
            return d.note("no tick of this scenario is late").help(Help::write(Snippet::block(
                "late",
                [Snippet::entry("at", "1 s"), Snippet::entry("by", ms(2.0 * deadline))],
            )));
        };
        let gap = (self.played.skipped(*delay) + 1) as f64 * period;
        d.primary.span = by.value.span;
        d.message = "this tick is not late enough for the fault `deadline`".into();
        d.label(at, "never true")
            .note(format!("the next tick comes {} after the one before, and {} are permitted", ms(gap), ms(deadline)))
            .help(format!("write at least {}", ms(deadline)))
    }
}
