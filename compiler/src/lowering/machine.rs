//! Machines: flattens the tree of states and converts names to indices.

use std::collections::BTreeMap;

use dsl::tree::{Action, Machine, Moment, StateBody};
use dsl::{Diagnostic, Span, Spanned};
use names::{list, suggest};
use runtime::program::{ActionProgram, MachineProgram, StateProgram};

use super::Lowerer;
use super::actions::{Verb, verb};
use crate::binding::BoundTask;
use crate::forms::{check_keys, text_of};
use crate::robot_binding::BoundRobot;
use crate::sections::{MACHINE, STATE};
use crate::source_map::MachinePlaces;

/// A flattened state.
pub(super) struct Flat<'m> {
    /// Path, `OUTER.INNER`.
    pub name: String,
    /// Span of the name.
    pub at: Span,
    /// Enclosing state; `None` for the machine itself.
    pub parent: Option<usize>,
    /// True if the machine ends in this state.
    pub is_final: bool,
    /// Body.
    pub body: &'m StateBody,
}

fn flatten<'m>(body: &'m StateBody, parent: usize, out: &mut Vec<Flat<'m>>) {
    for s in &body.states {
        let above = &out[parent].name;
        let name = if parent == 0 { s.name.value.clone() } else { format!("{above}.{}", s.name.value) };
        out.push(Flat { name, at: s.name.span, parent: Some(parent), is_final: s.final_.is_some(), body: &s.body });
        let own = out.len() - 1;
        flatten(&s.body, own, out);
    }
}

/// Context of a machine.
pub(super) struct Surroundings<'s> {
    /// Names of the stacks, in the order of the program.
    pub stacks: Vec<&'s str>,
    /// Names of the tasks, in the order of the program.
    pub tasks: Vec<&'s str>,
    /// Names of the levels of all stacks, with `true` for hard ones; `None` if some are unknown.
    pub levels: Option<Vec<(&'s str, bool)>>,
    /// Bound tasks; `None` for tasks that failed.
    pub bound: &'s [Option<BoundTask>],
    /// The robot.
    pub robot: &'s BoundRobot,
}

impl Lowerer<'_> {
    /// Lowers a machine. Returns `None` if a part of it is wrong, with diagnostics.
    pub(super) fn machine(&mut self, m: &Machine, around: &Surroundings) -> Option<(MachineProgram, MachinePlaces)> {
        let before = self.errors();
        let root = Flat { name: m.name.value.clone(), at: m.name.span, parent: None, is_final: false, body: &m.body };
        let mut flat = vec![root];
        flatten(&m.body, 0, &mut flat);
        self.twice(&flat);
        let mut places = MachinePlaces::default();
        let mut program = MachineProgram { states: Vec::new(), actions: Vec::new(), measured: Vec::new() };
        // Actions come first, because transitions may refer to the events that they raise.
        let actions: Vec<[Vec<usize>; 3]> =
            flat.iter().map(|f| self.actions(f.body, &mut program.actions, around)).collect();
        for (i, (f, [enter, activities, exit])) in flat.iter().zip(actions).enumerate() {
            check_keys(&f.body.settings, if i == 0 { &MACHINE } else { &STATE }, self.diagnostics);
            let stack = f.body.stack.as_ref().and_then(|c| around.stacks.iter().position(|s| *s == c.name.value));
            let (transitions, where_) = self.transitions(i, &flat, around, &mut program.measured);
            places.states.push(f.at);
            places.stacks.push(f.body.stack.as_ref().map(|c| c.name.span));
            places.transitions.push(where_);
            program.states.push(StateProgram {
                name: f.name.clone(),
                parent: f.parent,
                initial: self.initial(i, &flat),
                stack,
                is_final: f.is_final,
                enter,
                activities,
                exit,
                transitions,
            });
        }
        (self.errors() == before).then_some((program, places))
    }

    pub(super) fn errors(&self) -> usize {
        self.diagnostics.iter().filter(|d| d.severity == dsl::Severity::Error).count()
    }

    fn twice(&mut self, flat: &[Flat]) {
        let mut seen: BTreeMap<(usize, &str), Span> = BTreeMap::new();
        for f in flat {
            // The machine itself has no enclosing state.
            let Some(parent) = f.parent else { continue };
            match seen.get(&(parent, f.name.as_str())) {
                Some(first) => {
                    self.diagnostics.push(super::declared::twice(&Spanned::new(f.name.clone(), f.at), *first));
                }
                None => {
                    seen.insert((parent, &f.name), f.at);
                }
            }
        }
    }

    /// Initial inner state of a state or machine.
    fn initial(&mut self, i: usize, flat: &[Flat]) -> Option<usize> {
        let own: Vec<usize> = (0..flat.len()).filter(|&k| flat[k].parent == Some(i)).collect();
        let entry = flat[i].body.settings.get("initial");
        let short = |k: usize| flat[k].name.rsplit('.').next().unwrap_or(&flat[k].name);
        let first = own.first().map(|&k| short(k).to_string());
        match (entry, first) {
            (None, None) if i == 0 => {
                let d = Diagnostic::error("HQ0701", flat[0].at, "this machine has no states");
                self.push(d.help("write `initial NAME  state NAME { stack NAME  .. }`"));
                None
            }
            (None, None) => None,
            (None, Some(first)) => {
                let what = if i == 0 { "this machine" } else { "this state holds others, and" };
                let text = match i {
                    0 => format!("{what} does not say in which state it begins"),
                    _ => format!("{what} does not say which of them is entered"),
                };
                self.push(Diagnostic::error("HQ0701", flat[i].at, text).help(format!("write `initial {first}`")));
                None
            }
            (Some(e), None) => {
                let d = Diagnostic::error("HQ0701", e.key.span, "there is no state in here to begin with");
                self.push(d.help("leave it out, or write a state"));
                None
            }
            (Some(e), Some(_)) => {
                let name = text_of(&e.value)?;
                let found = own.iter().copied().find(|&k| short(k) == name);
                if found.is_none() {
                    let names: Vec<&str> = own.iter().map(|&k| short(k)).collect();
                    self.unknown_state(name, e.value.span, &names);
                }
                found
            }
        }
    }

    /// Reports an unknown state.
    pub(super) fn unknown_state(&mut self, name: &str, at: Span, names: &[&str]) {
        let d = Diagnostic::error("HQ0201", at, format!("there is no state `{name}` here"));
        self.push(match suggest(name, names.iter().copied()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None => d.help(format!("states are {}", list(names.iter().copied(), 12))),
        });
    }

    /// Lowers the actions of a state: on entry, during the state, and on exit.
    fn actions(&mut self, body: &StateBody, out: &mut Vec<ActionProgram>, around: &Surroundings) -> [Vec<usize>; 3] {
        Moment::ALL.map(|moment| {
            let own: Vec<&Action> = body.actions_at(moment).collect();
            own.into_iter().filter_map(|a| self.action(a, out, around)).collect()
        })
    }

    fn action(&mut self, a: &Action, out: &mut Vec<ActionProgram>, around: &Surroundings) -> Option<usize> {
        let known: &Verb = match verb(a) {
            Ok(known) => known,
            Err(d) => {
                self.diagnostics.extend(d.map(|d| *d));
                return None;
            }
        };
        let mut texts = Vec::new();
        for value in &a.args {
            match text_of(value) {
                Some(text) => texts.push(text.to_string()),
                None => texts.push(self.sources.snippet(value.span).to_string()),
            }
        }
        let own = match known.own {
            true => Some(self.own(a, around)?),
            false => None,
        };
        let event = known.raises.then(|| texts.first().map(|name| self.event_index(name))).flatten();
        let outcomes = known.outcomes.iter().map(|o| ((*o).to_string(), self.event_index(o))).collect();
        out.push(ActionProgram { verb: known.name.to_string(), arguments: texts, event, outcomes, own });
        Some(out.len() - 1)
    }

    /// Index of an event; a new event is added.
    fn event_index(&mut self, name: &str) -> usize {
        self.interface.event(name).unwrap_or_else(|| {
            self.interface.events.push(name.to_string());
            self.interface.events.len() - 1
        })
    }
}
