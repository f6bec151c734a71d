//! People of a scenario who do not matter: those whose path stays away from the robot, and those whom the stack does not know.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Span};
use names::list;
use runtime::program::{HumanScript, Op, Subject, Trigger, Unit};
use stdlib_tasks::bound::Bound;

use super::Scene;

/// Keys of the script of a person that say where the person is.
const PLACES: [&str; 4] = ["path", "value", "points", "file"];

impl Scene<'_> {
    /// Predicates that compare a number of the robot with the position of a person, with their places.
    fn comparisons(&self, person: &HumanScript) -> Vec<crate::source_map::Atom> {
        let points = &self.program.interface.humans[person.human].points;
        let compares = |predicate: usize| {
            let of = &self.scenario.predicates[predicate];
            let Some(&node) = self.played.places.nodes.get(predicate) else { return false };
            let needed = self.played.needed(node);
            let moves = of.value.ops.iter().any(|op| matches!(op, Op::State(_)));
            matches!(of.unit, Unit::Quantity(_)) && moves && needed.iter().any(|s| points.contains(s))
        };
        self.played.places.atoms.iter().copied().filter(|atom| compares(atom.predicate)).collect()
    }

    /// Warns of people whose path decides none of the comparisons with their position.
    pub(super) fn people_out_of_reach(&self, out: &mut Vec<Diagnostic>) {
        for person in &self.scenario.world.humans {
            let atoms = self.comparisons(person);
            let truths = |predicate: usize| self.played.predicate(predicate);
            let Some(first) = atoms.first() else { continue };
            if atoms.iter().any(|atom| truths(atom.predicate).holds && truths(atom.predicate).fails) {
                continue;
            }
            let name = &self.program.interface.humans[person.human].name;
            let result = if truths(first.predicate).holds { "true" } else { "false" };
            let at = self.of_script("humans", name, &PLACES);
            let text = format!("`{name}` stays where nothing that is expected depends on it");
            out.push(
                Diagnostic::warning("HQ0813", at, text)
                    .label(first.at, format!("{result} at every tick, whatever the robot does"))
                    .note("the links of the robot are too short for another result: the scenario tests nothing of this person")
                    .help("let the person come to where the robot has to give way, or correct the comparison"),
            );
        }
    }

    /// Warns of people whose distance is expected, and whom nothing that runs takes into account although other stacks do.
    pub(super) fn unknown_people(&self, out: &mut Vec<Diagnostic>) {
        for person in &self.scenario.world.humans {
            let Some(atom) = self.comparisons(person).first().copied() else { continue };
            let points: BTreeSet<usize> = self.program.interface.humans[person.human].points.iter().copied().collect();
            let runs: Vec<usize> = match self.scenario.run.subject {
                Subject::Stack(stack) => vec![stack],
                Subject::Machine if self.is_asked_by_the_machine(&points) => continue,
                Subject::Machine => {
                    let states = self.program.machine.iter().flat_map(|m| &m.states);
                    states.filter_map(|s| s.stack).collect()
                }
            };
            if runs.iter().any(|&stack| self.knows(stack, &points)) {
                continue;
            }
            let others = (0..self.program.stacks.len()).filter(|s| !runs.contains(s) && self.knows(*s, &points));
            let others: Vec<&str> = others.map(|s| self.program.stacks[s].name.as_str()).collect();
            if others.is_empty() {
                continue;
            }
            let name = &self.program.interface.humans[person.human].name;
            let text = format!("nothing that runs in this scenario takes `{name}` into account");
            out.push(
                Diagnostic::warning("HQ0814", self.subject(), text)
                    .label(atom.at, "the robot does not react to the person that this is about")
                    .note(format!("other stacks do: {}", list(others.iter().copied(), 4)))
                    .help("run a stack with the task that keeps the distance"),
            );
        }
    }

    /// Span of the name of the stack or machine that runs.
    fn subject(&self) -> Span {
        let named = ["stack", "machine"].iter().find_map(|key| self.written.body.get(key));
        named.map_or(self.written.name.span, |e| e.value.span)
    }

    /// True if a task of a stack depends on a tracked point.
    fn knows(&self, stack: usize, points: &BTreeSet<usize>) -> bool {
        let own = self.stacks.members(stack);
        if own.is_empty() {
            return true;
        }
        let members = self.program.stacks[stack].levels.iter().flat_map(|l| &l.members);
        // Safety fields read people by themselves.
        let by_field = members
            .into_iter()
            .any(|m| self.program.tasks[m.task].params.iter().any(|(_, bound)| matches!(bound, Bound::Field(_))));
        let slots = own.iter().flat_map(|m| m.slots.iter().copied()).collect();
        by_field || self.stacks.needs(stack).iter().any(|s| points.contains(s)) || self.reads(&slots, points)
    }

    /// True if entries of the table of values depend on a tracked point.
    fn reads(&self, entries: &BTreeSet<usize>, points: &BTreeSet<usize>) -> bool {
        let signals = self.program.values.tape.only(entries).signals();
        signals.into_iter().filter_map(|k| self.program.interface.signal_of(k)).any(|s| points.contains(&s))
    }

    /// True if a condition of the machine depends on a tracked point.
    fn is_asked_by_the_machine(&self, points: &BTreeSet<usize>) -> bool {
        let all = self.program.machine.iter().flat_map(|m| &m.states).flat_map(|s| &s.transitions);
        all.into_iter().any(|t| match &t.trigger {
            Trigger::When { condition, .. } => self.reads(&condition.inputs.iter().copied().collect(), points),
            _ => false,
        })
    }
}
