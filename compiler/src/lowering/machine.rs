//! Machines: the tree of states flattened, names become indices, triggers become data.

use dsl::tree::{Action, Machine, Moment, StateBody, Transition, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::{ActionProgram, FaultPattern, MachineProgram, StateProgram, TransitionProgram, Trigger};
use stdlib_tasks::dimension::TIME;
use stdlib_tasks::task::Nature;

use super::Lowerer;
use super::actions::{Verb, verb};
use super::triggers::{self, Known};
use crate::binding::{BoundTask, Condition};
use crate::constants::Constants;
use crate::forms::{check_keys, text_of};
use crate::names::{list, suggest};
use crate::robot_binding::BoundRobot;
use crate::sections::{MACHINE, STATE, TRANSITION};

/// Where the parts of a machine were written, and what checks want to know of them.
#[derive(Debug, Default)]
pub(crate) struct MachinePlaces {
    /// For each state its name.
    pub states: Vec<Span>,
    /// For each state the place that names its stack.
    pub stacks: Vec<Option<Span>>,
    /// For each state its transitions.
    pub transitions: Vec<Vec<TransitionPlace>>,
}

/// Where a transition was written, and what is known of it.
#[derive(Debug)]
pub(crate) struct TransitionPlace {
    /// Its trigger.
    pub trigger: Span,
    /// Its target.
    pub target: Span,
    /// Whether it, or what is around it, says how the command goes over.
    pub blend: bool,
    /// The value of a condition that never changes.
    pub constant: Option<bool>,
    /// Signals that are present when it is taken.
    pub demands: Vec<usize>,
}

/// A state of the tree, flattened.
struct Flat<'m> {
    name: String,
    at: Span,
    parent: Option<usize>,
    is_final: bool,
    body: &'m StateBody,
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

/// What a machine is lowered with.
pub(super) struct Surroundings<'s> {
    /// Names of the stacks, in the order of the program.
    pub stacks: Vec<&'s str>,
    /// Names of the tasks, in the order of the program.
    pub tasks: Vec<&'s str>,
    /// The levels of all stacks, and whether each is hard; none where some are not known.
    pub levels: Option<Vec<(&'s str, bool)>>,
    /// The tasks.
    pub bound: &'s [Option<BoundTask>],
    /// The robot.
    pub robot: &'s BoundRobot,
}

impl Lowerer<'_> {
    /// Lowers a machine. `None` where something in it is wrong; the diagnostics say what.
    pub(super) fn machine(&mut self, m: &Machine, around: &Surroundings) -> Option<(MachineProgram, MachinePlaces)> {
        let before = self.errors();
        let root = Flat { name: m.name.value.clone(), at: m.name.span, parent: None, is_final: false, body: &m.body };
        let mut flat = vec![root];
        flatten(&m.body, 0, &mut flat);
        self.twice(&flat);
        let mut places = MachinePlaces::default();
        let mut program = MachineProgram { states: Vec::new(), actions: Vec::new() };
        // Actions first: the events that they raise must be known to the transitions.
        let actions: Vec<[Vec<usize>; 3]> =
            flat.iter().map(|f| self.actions(f.body, &mut program.actions, around)).collect();
        for (i, (f, [enter, activities, exit])) in flat.iter().zip(actions).enumerate() {
            check_keys(&f.body.settings, if i == 0 { &MACHINE } else { &STATE }, self.diagnostics);
            let stack = f.body.stack.as_ref().and_then(|c| around.stacks.iter().position(|s| *s == c.name.value));
            let (transitions, where_) = self.transitions(i, &flat, around);
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
        for (i, f) in flat.iter().enumerate() {
            let same = |g: &&Flat| g.parent == f.parent && g.name == f.name;
            if let Some(first) = flat[..i].iter().find(same).filter(|_| i > 0) {
                self.diagnostics.push(super::declared::twice(&Spanned::new(f.name.clone(), f.at), first.at));
            }
        }
    }

    /// The state that is entered with a state that holds others.
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

    fn unknown_state(&mut self, name: &str, at: Span, names: &[&str]) {
        let d = Diagnostic::error("HQ0201", at, format!("there is no state `{name}` here"));
        self.push(match suggest(name, names.iter().copied()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None => d.help(format!("states are {}", list(names.iter().copied(), 12))),
        });
    }

    /// The actions of a state: on entering, while there, on leaving.
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

    /// The index of an event, which is added where it is new.
    fn event_index(&mut self, name: &str) -> usize {
        self.interface.event(name).unwrap_or_else(|| {
            self.interface.events.push(name.to_string());
            self.interface.events.len() - 1
        })
    }

    fn transitions(
        &mut self,
        i: usize,
        flat: &[Flat],
        around: &Surroundings,
    ) -> (Vec<TransitionProgram>, Vec<TransitionPlace>) {
        let (mut out, mut places) = (Vec::new(), Vec::new());
        for t in &flat[i].body.transitions {
            check_keys(&t.settings, &TRANSITION, self.diagnostics);
            let target = self.target(i, t, flat);
            let found = self.trigger(t, around);
            let blend = self.blend(i, t, flat);
            let (Some(target), Some((trigger, condition, at))) = (target, found) else { continue };
            let text = super::wording::trigger(t);
            out.push(TransitionProgram { trigger, text, target, blend: blend.unwrap_or(0.0) });
            let (constant, demands) = condition.map_or((None, Vec::new()), |c| {
                (c.constant, c.demands.into_iter().filter_map(|at| self.interface.signal_of(at)).collect())
            });
            places.push(TransitionPlace {
                trigger: at,
                target: t.target.span,
                blend: blend.is_some(),
                constant,
                demands,
            });
        }
        (out, places)
    }

    /// The state that a transition leads to: one beside the state in which it stands, or inside that, or further out.
    fn target(&mut self, i: usize, t: &Transition, flat: &[Flat]) -> Option<usize> {
        let name = t.target.value.as_str();
        if name.is_empty() {
            return None;
        }
        let (first, rest) = name.split_once('.').map_or((name, None), |(a, b)| (a, Some(b)));
        let full = |parent: usize, name: &str| match parent {
            0 => name.to_string(),
            p => format!("{}.{name}", flat[p].name),
        };
        let child = |parent: usize, name: &str| {
            let wanted = full(parent, name);
            (0..flat.len()).find(|&k| flat[k].parent == Some(parent) && flat[k].name == wanted)
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
            around = flat[parent].parent;
        }
        let names: Vec<&str> = flat[1..].iter().map(|f| f.name.as_str()).collect();
        self.unknown_state(name, t.target.span, &names);
        None
    }

    /// How long the command goes over: what the transition says, or the state that it leads from, or those around that. None where nothing does.
    fn blend(&mut self, i: usize, t: &Transition, flat: &[Flat]) -> Option<f64> {
        let mut own = t.settings.get("blend");
        let mut around = Some(i);
        while let (None, Some(k)) = (own, around) {
            own = flat[k].body.settings.get("blend");
            around = flat[k].parent;
        }
        let e = own?;
        let before = self.diagnostics.len();
        let found = self.duration(&e.value, "a blend");
        // One of a state is said once, with the first transition.
        let repeated =
            (0..before).any(|k| before < self.diagnostics.len() && self.diagnostics[k] == self.diagnostics[before]);
        if repeated {
            self.diagnostics.truncate(before);
        }
        found
    }

    /// A constant time of zero or more, in s.
    fn duration(&mut self, value: &Value, what: &str) -> Option<f64> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let x = constants.scalar(value, TIME, self.diagnostics)?;
        if x < 0.0 {
            let d =
                Diagnostic::error("HQ0308", value.span, format!("{what} takes no negative time, and this is {x} s"));
            self.push(d.help("write a time from 0 s"));
            return None;
        }
        Some(x)
    }

    fn trigger(&mut self, t: &Transition, around: &Surroundings) -> Option<(Trigger, Option<Condition>, Span)> {
        match &t.trigger {
            dsl::tree::Trigger::Missing => None,
            dsl::tree::Trigger::After(value) => {
                Some((Trigger::After(self.duration(value, "`after`")?), None, value.span))
            }
            dsl::tree::Trigger::When { condition, hold } => {
                let hold = match hold {
                    Some(value) => self.duration(value, "`for`")?,
                    None => 0.0,
                };
                let found = self.binder(around.robot).condition(condition)?;
                let trigger = Trigger::When { condition: found.expression.clone(), hold };
                Some((trigger, Some(found), condition.span))
            }
            dsl::tree::Trigger::On(value) => Some((self.on(value, around)?, None, value.span)),
        }
    }

    fn on(&mut self, value: &Value, around: &Surroundings) -> Option<Trigger> {
        match &value.kind {
            ValueKind::Call(function, args) if function.value == "fault" => {
                let pattern = self.pattern(args, value.span, around)?;
                Some(Trigger::Fault(pattern))
            }
            ValueKind::Call(function, args) if function.value == "reached" => self.reached(args, value.span, around),
            ValueKind::Call(function, _) => {
                let text = format!("`{}(..)` is nothing that happens", function.value);
                let d = Diagnostic::error("HQ0201", function.span, text);
                self.push(d.help(
                    "write `on EVENT`, `on reached(TASK, ..)` or `on fault(KIND)`; for a condition write `when`",
                ));
                None
            }
            ValueKind::Missing => None,
            _ => {
                let Some(name) = text_of(value) else {
                    let d = Diagnostic::error("HQ0304", value.span, "`on` waits for an event, and this is none");
                    self.push(d.help("for a condition write `when`"));
                    return None;
                };
                let name = crate::forms::target(name);
                if let Some(event) = self.interface.event(name) {
                    return Some(Trigger::Event(event));
                }
                let d = Diagnostic::error("HQ0702", value.span, format!("nothing provides the event `{name}`"));
                let names: Vec<&str> = self.interface.events.iter().map(String::as_str).collect();
                let d = d.note("a state that waits for it alone would wait for ever");
                let d = match suggest(name, names.iter().copied()) {
                    Some(near) => d.help(format!("did you mean `{near}`?")),
                    None if names.is_empty() => d.help(format!(
                        "declare what the host raises, `signal {name} : event`; or begin an action that has it as outcome"
                    )),
                    None => d.help(format!(
                        "events are {}; declare one that the host raises with `signal {name} : event`",
                        list(names.iter().copied(), 12)
                    )),
                };
                self.push(d);
                None
            }
        }
    }

    fn pattern(&mut self, args: &[Value], at: Span, around: &Surroundings) -> Option<FaultPattern> {
        let known = Known {
            signals: self.interface.signals.iter().map(|s| s.name.as_str()).collect(),
            humans: self.interface.humans.iter().map(|h| (h.name.as_str(), h.points.as_slice())).collect(),
            tasks: &around.tasks,
            levels: around.levels.as_deref(),
            limits: (around.bound.iter()).map(|b| b.as_ref().is_none_or(|b| b.kind.nature == Nature::Limit)).collect(),
        };
        triggers::pattern(args, at, &known).map_err(|d| self.diagnostics.extend(d.map(|d| *d))).ok()
    }

    fn reached(&mut self, args: &[Value], at: Span, around: &Surroundings) -> Option<Trigger> {
        let task = match triggers::task_of(args.first(), at, &around.tasks) {
            Ok(task) => task,
            Err(d) => {
                self.push(*d);
                return None;
            }
        };
        let bound = around.bound.get(task)?.as_ref()?;
        if bound.kind.nature == Nature::Limit {
            let text = format!("`{}` is a limit, and has no target that could be reached", around.tasks[task]);
            let d = Diagnostic::error("HQ0703", args[0].span, text).label(bound.span, "declared here");
            self.push(d.help("name a task with a target; for a limit write `on fault(limit(TASK))`"));
            return None;
        }
        let measures = self.measures(bound, around)?;
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let given: Option<Vec<_>> =
            (args[1..].iter()).map(|v| constants.constant(v, self.diagnostics).map(|typed| (typed, v))).collect();
        let given = given?;
        let numbers: Vec<_> = (given.iter())
            .map(|(typed, v)| (typed.clone(), typed.nodes.first().and_then(|&n| self.graph.constant(n)), v.span))
            .collect();
        match triggers::tolerances(&numbers, &measures, around.tasks[task], at) {
            Ok(tolerances) => Some(Trigger::Reached { task, tolerances }),
            Err(d) => {
                self.push(*d);
                None
            }
        }
    }
}
