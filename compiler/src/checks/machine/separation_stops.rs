//! Stops before people: slower than the separation task assumes, or where there is room.

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Op, Trigger};
use runtime::text::number;
use stdlib_tasks::bound::Bound;

use super::Checked;
use super::fault_answers::moves;
use crate::analysis::conditions::{Formula, Key, Leaf, Relation};
use crate::expr::Graph;

/// Speed (m/s) beside people that is taken as the largest: eight times that of ISO 10218 for reduced speed.
const FAST: f64 = 2.0;

/// Comparison of a distance to a person, or of the room that is left, that triggers a transition.
struct Room {
    /// Task whose output it is.
    task: Option<usize>,
    /// True if the transition is taken where there is more of it.
    above: bool,
}

impl Checked<'_> {
    /// Warns of transitions that stop the robot before a person too slowly, or only where there is room.
    pub(super) fn separation_stops(&self, graph: &Graph, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            for i in 0..self.machine.states[s].transitions.len() {
                let Some(room) = self.room(graph, s, i).filter(|_| self.stops(s, i)) else { continue };
                if let Some(task) = room.task.filter(|_| !room.above) {
                    diagnostics.extend(self.slow_stop(s, i, task));
                }
                if room.above {
                    diagnostics.extend(self.stop_with_room(graph, s, i));
                }
            }
        }
    }

    /// Warns of a stop whose blend is longer than the time in which the separation task expects the robot to stand.
    fn slow_stop(&self, s: usize, i: usize, task: usize) -> Option<Diagnostic> {
        let constant = |param: &str| {
            let Some(Bound::Value(slot)) = self.program.tasks[task].params.get(param) else { return None };
            let moving = self.program.values.tape.outputs.iter().any(|o| o.at == slot.at);
            self.program.values.initial.get(slot.at).copied().filter(|_| !moving)
        };
        let (time, assumed) = match (constant("stopping"), constant("deceleration")) {
            (Some(time), _) => (time, format!("a stop within {} s", number(time))),
            (None, Some(a)) if a > 0.0 => {
                (FAST / a, format!("{} m/s^2, which stops {} m/s in {:.2} s", number(a), number(FAST), FAST / a))
            }
            _ => return None,
        };
        let blend = self.machine.states[s].transitions[i].blend;
        if blend <= time {
            return None;
        }
        let place = &self.places.transitions[s][i];
        let name = &self.program.tasks[task].name;
        let text = format!("this stop takes {} s, and `{name}` counts on a shorter one", number(blend));
        Some(
            Diagnostic::warning("HQ0726", place.trigger, text)
                .note(format!("`{name}` assumes {assumed}"))
                .note("a blend changes the velocity over its whole duration")
                .help(Help::with(
                    "write {} in the transition, or include the blend in {}",
                    [Snippet::entry("blend", "0 s"), Snippet::entry("stopping", format!("{} s", number(blend)))],
                )),
        )
    }

    /// Warns of a stop where there is room, from which the robot resumes where there is less.
    fn stop_with_room(&self, graph: &Graph, s: usize, i: usize) -> Option<Diagnostic> {
        let m = self.machine;
        let target = m.leaf(m.states[s].transitions[i].target);
        let (p, k) = m.path(target).filter(|&p| p != 0).find_map(|p| {
            let back = |k: &usize| {
                let to = m.leaf(m.states[p].transitions[*k].target);
                m.path(to).any(|q| q == s) && self.room(graph, p, *k).is_some_and(|room| !room.above)
            };
            Some((p, (0..m.states[p].transitions.len()).find(back)?))
        })?;
        let text =
            format!("the robot stops in `{}` where there is room, and resumes where there is none", self.name(target));
        Some(
            Diagnostic::warning("HQ0727", self.places.transitions[s][i].trigger, text)
                .here("taken while the person is far")
                .label(self.places.transitions[p][k].trigger, "resumes while the person is near")
                .help("turn both comparisons round"),
        )
    }

    /// True for a transition from a state in which the robot moves to one in which it stands.
    fn stops(&self, s: usize, i: usize) -> bool {
        let moving = |l: usize| self.machine.stack(l).is_some_and(|stack| moves(self.program, self.stacks, stack));
        let target = self.machine.leaf(self.machine.states[s].transitions[i].target);
        !self.is_dead(s, i) && !moving(target) && self.leaves(s).any(moving)
    }

    /// The comparison of a transition with the output `room` of a separation task, or with a distance to a person.
    fn room(&self, graph: &Graph, s: usize, i: usize) -> Option<Room> {
        if !matches!(self.machine.states[s].transitions[i].trigger, Trigger::When { .. }) {
            return None;
        }
        let Some(Formula::Compare(v, relation, _)) = &self.conditions.triggers[s][i] else { return None };
        let variable = &self.conditions.variables[*v];
        // The factor of the first term is one.
        let Key::Number(terms) = &variable.key else { return None };
        let [(term, _)] = terms.as_slice() else { return None };
        let above = matches!(relation, Relation::Greater | Relation::GreaterEqual);
        let interface = &self.program.interface;
        match graph.ops().get(term.node)? {
            Op::Signal(k) => {
                let signal = interface.signal_of(*k)?;
                let task = self.task_of_output(signal)?;
                let is_room = interface.signals[signal].name.ends_with(".room");
                is_room.then_some(Room { task: Some(task), above })
            }
            Op::Sqrt(_) => {
                let of_person =
                    |l: &Leaf| matches!(l, Leaf::Signal(s, _) if interface.humans.iter().any(|h| h.points.contains(s)));
                variable.leaves.all.iter().any(of_person).then_some(Room { task: None, above })
            }
            _ => None,
        }
    }
}
