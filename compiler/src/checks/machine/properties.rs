//! Properties of the machine, `check always FORMULA`, judged by all that the machine can do.

use std::collections::BTreeMap;

use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::{Measure, Op};

use super::Checked;
use crate::analysis::conditions::{Key, Value};
use crate::analysis::exploration::{Exploration, OfMachine, Run, Taken, Verdict};
use crate::analysis::regions::Elsewhere;
use crate::analysis::wording::described;
use crate::expr::Graph;
use crate::source_map::{MachinePlaces, PropertyPlace};

/// Largest number of transitions of a run that are shown.
const SHOWN: usize = 8;

/// Judges all properties.
pub(super) fn judge(
    exploration: &mut Exploration,
    places: &MachinePlaces,
    graph: &Graph,
    (width, elsewhere): (usize, &Elsewhere),
) -> Vec<Verdict> {
    let conditions = exploration.conditions();
    let of = |(v, variable): (usize, &crate::analysis::conditions::Variable)| {
        let Key::Flag(term) = variable.key else { return None };
        let Op::Signal(k) = *graph.ops().get(term.node)? else { return None };
        match places.measures.get(k.checked_sub(width)?)? {
            Measure::In(state) => Some((v, OfMachine::In(*state))),
            Measure::Fault(_) => Some((v, OfMachine::Fault)),
            _ => None,
        }
    };
    let of_machine: BTreeMap<usize, OfMachine> = conditions.variables.iter().enumerate().filter_map(of).collect();
    let left_out = |v: &usize| matches!(of_machine.get(v), Some(OfMachine::In(s)) if elsewhere.states.contains(s));
    let all = places.properties.iter().zip(&conditions.properties);
    all.map(|(place, formula)| {
        let Some(formula) = formula else { return Verdict::Open };
        let mut read = Vec::new();
        formula.variables(&mut read);
        match exploration.judge(formula, place.state, &of_machine) {
            _ if read.iter().any(left_out) => Verdict::Beside,
            // The regions beside it may exclude this run.
            Verdict::Violated(_) if elsewhere.has_regions => Verdict::Beside,
            verdict => verdict,
        }
    })
    .collect()
}

impl Checked<'_> {
    /// Reports properties that a run violates, and those that cannot be decided.
    pub(super) fn properties(&self, verdicts: &[Verdict], graph: &Graph, diagnostics: &mut Vec<Diagnostic>) {
        for (place, verdict) in self.places.properties.iter().zip(verdicts) {
            diagnostics.extend(match verdict {
                Verdict::Holds => None,
                Verdict::Violated(run) => Some(self.violation(place, run, graph)),
                Verdict::Beside => Some(undecided(place, "the regions of a state are explored one at a time")),
                Verdict::TooLarge => Some(undecided(place, "the machine is too large to be explored")),
                Verdict::Open => Some(match place.formula {
                    Err(at) => of_time(place, at),
                    Ok(_) => undecided(
                        place,
                        "it depends on the motion of the robot, on times, or on quantities that depend on each other",
                    ),
                }),
            });
        }
    }

    /// The run that violates a property, step by step.
    fn violation(&self, place: &PropertyPlace, run: &Run, graph: &Graph) -> Diagnostic {
        let end = self.name(run.leaf);
        let mut d = Diagnostic::error("HQ0721", place.span, format!("{} does not always hold", place.name));
        d = d.here(format!("false in `{end}`{}", self.values(&run.values, graph)));
        let left_out = run.steps.len().saturating_sub(SHOWN);
        for (k, Taken { leaf, way, values }) in run.steps.iter().enumerate().skip(left_out) {
            let transition = &self.machine.states[way.state].transitions[way.index];
            let to = self.name(self.machine.leaf(transition.target));
            let text = format!("{}. from `{}` to `{to}`{}", k + 1, self.name(*leaf), self.values(values, graph));
            d = d.label(self.places.transitions[way.state][way.index].trigger, text);
        }
        let start = self.name(self.machine.leaf(0));
        let note = match run.steps.len() {
            0 => format!("the machine is in `{start}` from the start"),
            1 => format!("the machine starts in `{start}`; this transition leads there"),
            n => format!("the machine starts in `{start}`; {n} transitions lead there, in this order"),
        };
        d.note(note).help(
            "add the condition to the transition that leads to this state, or a transition that leaves the state where it \
             is false",
        )
    }

    /// Values in words: ` for ..`.
    fn values(&self, values: &[(usize, Value)], graph: &Graph) -> String {
        let words: Vec<String> = (values.iter())
            .filter(|(v, x)| !self.follows_from(*v, *x, values))
            .filter_map(|&(v, x)| described(&self.conditions.variables[v].key, x, graph, self.program))
            .collect();
        if words.is_empty() { String::new() } else { format!(", for {}", words.join(", ")) }
    }

    /// True for the presence of a signal whose value is told.
    fn follows_from(&self, v: usize, x: Value, values: &[(usize, Value)]) -> bool {
        let Key::Present(signal) = self.conditions.variables[v].key else { return false };
        let tells = |o: usize| {
            !matches!(self.conditions.variables[o].key, Key::Present(_))
                && self.conditions.variables[o].reads.contains(&signal)
        };
        x == Value::Truth(true) && values.iter().any(|&(o, x)| x != Value::Absent && tells(o))
    }
}

/// Warning of a property in which a part has a time of its own.
fn of_time(place: &PropertyPlace, at: Span) -> Diagnostic {
    let d = undecided(place, "it speaks of more than one tick").label(at, "this part speaks of other ticks");
    // A word of time reaches as far as it is followed by parentheses.
    if at.range().start == place.span.range().start && at != place.span {
        return d.help("put all that holds always in parentheses: `check always (A implies B)`");
    }
    d
}

fn undecided(place: &PropertyPlace, why: &str) -> Diagnostic {
    let text = format!("{} cannot be decided before the run", place.name);
    Diagnostic::warning("HQ0722", place.span, text).note(why).help(Help::with(
        "expect it of a run: {}; a property is `check always FORMULA` or `check never FORMULA`, of states, signals and \
         variables",
        [Snippet::each("expect always FORMULA", "expect: [ always FORMULA ]")],
    ))
}
