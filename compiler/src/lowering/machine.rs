//! Machines: flattens the tree of states and converts names to indices.

use std::collections::BTreeMap;

use blocks::Block;
use dsl::tree::{Action, Machine, Moment, StateBody, TaskDefinition};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use runtime::program::{ActionProgram, MachineProgram, MeasuredProgram, ReachedProgram, StateProgram};

use super::Lowerer;
use super::actions::{Verb, verb};
use super::declared::Declared;
use super::variables::Variables;
use crate::binding::BoundTask;
use crate::block_binding::Scope;
use crate::forms::{check_keys, text_of};
use crate::robot_binding::BoundRobot;
use crate::sections::{MACHINE, STATE, StateBlock};
use crate::source_map::MachinePlaces;

/// A flattened state.
pub(super) struct Flat<'m> {
    /// Path, `OUTER.INNER`.
    pub name: String,
    /// Span of the name.
    pub at: Span,
    /// Span of the whole state; that of the machine is the span of its name.
    pub whole: Span,
    /// Enclosing state; `None` for the machine itself.
    pub parent: Option<usize>,
    /// True for a region of the enclosing state.
    pub region: bool,
    /// True if the machine ends in this state.
    pub is_final: bool,
    /// Body.
    pub body: &'m StateBody,
}

fn flatten<'m>(body: &'m StateBody, parent: usize, out: &mut Vec<Flat<'m>>) {
    for s in &body.states {
        let above = &out[parent].name;
        let name = if parent == 0 { s.name.value.clone() } else { format!("{above}.{}", s.name.value) };
        let (at, whole, region, is_final) = (s.name.span, s.span, s.region, s.final_.is_some());
        out.push(Flat { name, at, whole, parent: Some(parent), region, is_final, body: &s.body });
        let own = out.len() - 1;
        flatten(&s.body, own, out);
    }
}

/// Everything in a spec that a machine refers to.
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

impl<'s> Surroundings<'s> {
    /// The declarations of a spec, with its tasks in the order of the program.
    pub fn new(
        declared: &Declared<'s>,
        definitions: &'s [(String, TaskDefinition)],
        bound: &'s [Option<BoundTask>],
        robot: &'s BoundRobot,
    ) -> Self {
        let levels = declared.stacks.iter().flat_map(|s| &s.levels);
        let levels = levels.map(|l| (l.name.value.as_str(), l.hard.is_some())).collect();
        Surroundings {
            stacks: declared.stacks.iter().map(|s| s.name.value.as_str()).collect(),
            tasks: definitions.iter().map(|d| d.0.as_str()).collect(),
            levels: declared.whole.then_some(levels),
            bound,
            robot,
        }
    }
}

/// Lowering of one machine.
pub(super) struct MachineLowering<'m, 'l> {
    /// Expressions, signals and diagnostics of the spec.
    pub lowerer: &'m mut Lowerer<'l>,
    /// The stacks, tasks and levels that the machine refers to.
    pub around: Surroundings<'m>,
    /// Variables that its actions set.
    pub variables: &'m mut Variables,
    /// Its states; the machine itself is the first one.
    pub flat: Vec<Flat<'m>>,
    /// The keys of each state, and of the machine.
    pub settings: Vec<StateBlock>,
    /// Measured values of its conditions so far.
    pub measured: Vec<MeasuredProgram>,
    /// Targets that its conditions ask to be reached, so far.
    pub reached: Vec<ReachedProgram>,
}

impl Lowerer<'_> {
    /// Lowers a machine. Returns `None` if a part of it is wrong, with diagnostics.
    pub(super) fn machine(
        &mut self,
        m: &Machine,
        around: Surroundings,
        variables: &mut Variables,
    ) -> Option<(MachineProgram, MachinePlaces)> {
        let (name, at) = (m.name.value.clone(), m.name.span);
        let root = Flat { name, at, whole: at, parent: None, region: false, is_final: false, body: &m.body };
        let mut flat = vec![root];
        flatten(&m.body, 0, &mut flat);
        let (settings, measured, reached) = (Vec::new(), Vec::new(), Vec::new());
        MachineLowering { lowerer: self, around, variables, flat, settings, measured, reached }.lower()
    }

    pub(super) fn errors(&self) -> usize {
        self.diagnostics.iter().filter(|d| d.severity == dsl::Severity::Error).count()
    }
}

impl MachineLowering<'_, '_> {
    fn lower(mut self) -> Option<(MachineProgram, MachinePlaces)> {
        let before = self.lowerer.errors();
        self.settings = (0..self.flat.len()).map(|i| self.settings(i)).collect();
        self.twice();
        self.misplaced_regions();
        let declared_events = self.lowerer.interface.events.len();
        let mut places = MachinePlaces { declared_events, ..MachinePlaces::default() };
        let (mut states, mut all) = (Vec::new(), Vec::new());
        // Actions come first, because transitions may refer to the events that they raise.
        let actions: Vec<[Vec<usize>; 3]> =
            (0..self.flat.len()).map(|i| self.actions(self.flat[i].body, &mut all, &mut places.actions)).collect();
        for (i, [enter, activities, exit]) in actions.into_iter().enumerate() {
            let (body, at) = (self.flat[i].body, self.flat[i].at);
            let stack = body.stack.as_ref().and_then(|c| self.around.stacks.iter().position(|s| *s == c.name.value));
            let (transitions, where_) = self.transitions(i);
            places.states.push(at);
            places.wholes.push(self.flat[i].whole);
            places.stacks.push(body.stack.as_ref().map(|c| c.name.span));
            places.transitions.push(where_);
            states.push(StateProgram {
                name: self.flat[i].name.clone(),
                parent: self.flat[i].parent,
                initial: self.initial(i),
                regions: self.regions(i),
                stack,
                is_final: self.flat[i].is_final,
                enter,
                activities,
                exit,
                transitions,
            });
        }
        let MachineLowering { measured, reached, .. } = self;
        let program = MachineProgram { states, actions: all, measured, reached, merged: Vec::new() };
        if self.lowerer.errors() == before {
            self.lowerer.region_errors(&program, &places);
        }
        (self.lowerer.errors() == before).then_some((program, places))
    }

    fn twice(&mut self) {
        let mut seen: BTreeMap<(usize, &str), Span> = BTreeMap::new();
        for f in &self.flat {
            // The machine itself has no enclosing state.
            let Some(parent) = f.parent else { continue };
            match seen.get(&(parent, f.name.as_str())) {
                Some(first) => {
                    self.lowerer.diagnostics.push(super::declared::twice(&Spanned::new(f.name.clone(), f.at), *first));
                }
                None => {
                    seen.insert((parent, &f.name), f.at);
                }
            }
        }
    }

    /// Reads the keys of a state, or of the machine. The initial state depends on the inner ones, so [`Self::initial`]
    /// reports that it is missing.
    fn settings(&mut self, i: usize) -> StateBlock {
        let (block, at) = (&self.flat[i].body.settings, self.flat[i].at);
        let schema = if i == 0 { &MACHINE } else { &STATE };
        check_keys(block, schema, self.lowerer.diagnostics);
        let wanted = |key: &str| key != "initial" || block.get(key).is_some();
        StateBlock::read(&self.lowerer.block_binder(&Scope::default()).entries(block, schema, at, wanted))
    }

    /// Initial inner state of a state or machine.
    fn initial(&mut self, i: usize) -> Option<usize> {
        let own: Vec<usize> = (0..self.flat.len()).filter(|&k| self.flat[k].parent == Some(i)).collect();
        if !self.regions(i).is_empty() {
            return own.first().copied();
        }
        let entry = self.flat[i].body.settings.get("initial");
        let short = |k: usize| self.flat[k].name.rsplit('.').next().unwrap_or(&self.flat[k].name);
        let first = own.first().map(|&k| short(k).to_string());
        match (entry, first) {
            (None, None) if i == 0 => {
                let d = Diagnostic::error("HQ0701", self.flat[0].at, "this machine has no states");
                self.lowerer.push(d.help(Help::write(Snippet::each(
                    "initial NAME  state NAME { stack NAME  .. }",
                    "initial: NAME, states: { NAME: { stack: NAME, .. } }",
                ))));
                None
            }
            (None, None) => None,
            (None, Some(first)) => {
                let text = match i {
                    0 => "this machine has no initial state",
                    _ if self.flat[i].region => "this region has no initial state",
                    _ => "this state holds others, and has several states and no initial one",
                };
                self.lowerer
                    .push(Diagnostic::error("HQ0701", self.flat[i].at, text).help(Snippet::entry("initial", first)));
                None
            }
            (Some(e), None) => {
                let d = Diagnostic::error("HQ0701", e.key.span, "there is no state in here to begin with");
                self.lowerer.push(d.help("leave it out, or write a state"));
                None
            }
            (Some(e), Some(_)) => {
                let name = &self.settings[i].initial.as_ref()?.value;
                let found = own.iter().copied().find(|&k| short(k) == name);
                if found.is_none() {
                    let names: Vec<&str> = own.iter().map(|&k| short(k)).collect();
                    let d = unknown_state(name, e.value.span, &names);
                    self.lowerer.push(d);
                }
                found
            }
        }
    }

    /// Lowers the actions of a state, on entry, during the state, and on exit, with their spans.
    fn actions(&mut self, body: &StateBody, out: &mut Vec<ActionProgram>, places: &mut Vec<Span>) -> [Vec<usize>; 3] {
        Moment::ALL.map(|moment| {
            let mut indices = Vec::new();
            for a in body.actions_at(moment) {
                let found = self.action(a, out);
                places.extend(found.map(|_| a.span));
                indices.extend(found);
            }
            indices
        })
    }

    fn action(&mut self, a: &Action, out: &mut Vec<ActionProgram>) -> Option<usize> {
        let known: &Verb = match verb(a) {
            Ok(known) => known,
            Err(d) => {
                self.lowerer.diagnostics.extend(d.map(|d| *d));
                return None;
            }
        };
        let mut texts = Vec::new();
        for value in &a.args {
            match text_of(value) {
                Some(text) => texts.push(text.to_string()),
                None => texts.push(self.lowerer.sources.snippet(value.span).to_string()),
            }
        }
        let own = match known.own {
            true => Some(self.own(a)?),
            false => None,
        };
        let event = known.raises.then(|| texts.first().map(|name| self.event_index(name))).flatten();
        let outcomes = known.outcomes.iter().map(|o| ((*o).to_string(), self.event_index(o))).collect();
        out.push(ActionProgram { verb: known.name.to_string(), arguments: texts, event, outcomes, own });
        Some(out.len() - 1)
    }

    /// Index of an event; a new event is added.
    fn event_index(&mut self, name: &str) -> usize {
        self.lowerer.interface.event(name).unwrap_or_else(|| {
            self.lowerer.interface.events.push(name.to_string());
            self.lowerer.interface.events.len() - 1
        })
    }
}

/// Diagnostic for an unknown state.
pub(super) fn unknown_state(name: &str, at: Span, names: &[&str]) -> Diagnostic {
    let d = Diagnostic::unknown_name(at, format!("there is no state `{name}` here"));
    d.one_of("states are", name, names.iter().copied())
}
