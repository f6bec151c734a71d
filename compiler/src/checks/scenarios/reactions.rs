//! Reactions of the machine that are expected sooner than its conditions permit: each transition into the state waits for a
//! condition that must hold for a time.

use dsl::{Diagnostic, Span};
use runtime::expect::Node;
use runtime::program::{Measure, Trigger};
use runtime::text::number;

use super::Scene;

/// State that is demanded after a trigger.
struct Reaction {
    state: usize,
    /// Ticks within which it is demanded.
    ticks: u32,
}

/// Transition that waits for a condition.
struct Waiting {
    hold: f64,
    at: Option<Span>,
}

impl Scene<'_> {
    /// Warns of `after A : within T : in(STATE)` where every transition into the state waits for longer than `T`.
    pub(super) fn reactions(&self, out: &mut Vec<Diagnostic>) {
        for e in 0..self.scenario.expectations.len() {
            let Some(Reaction { state, ticks }) = self.reaction(e) else { continue };
            let at = self.written.expects[e].formula.span;
            if Self::is_reported(out, &["HQ0812", "HQ0817"], at) {
                continue;
            }
            let permitted = f64::from(ticks) * self.program.robot.period;
            let Some(waiting) = self.shortest_wait(state) else { continue };
            if waiting.hold <= permitted + self.program.robot.period {
                continue;
            }
            let name = self.program.machine.as_ref().map_or("", |m| m.states[state].name.as_str());
            let text = format!("`{name}` is entered only after a condition has held for {} s", number(waiting.hold));
            let mut d = Diagnostic::warning("HQ0817", at, text);
            if let Some(at) = waiting.at {
                d = d.label(at, "the shortest of the transitions into it");
            }
            out.push(
                d.note(format!("the expectation permits {} s", number(permitted)))
                    .help("write a later end of the window, or a shorter `for` in the transition"),
            );
        }
    }

    /// The state that an expectation demands after a trigger, and the number of ticks within which.
    fn reaction(&self, expectation: usize) -> Option<Reaction> {
        let nodes = &self.scenario.expectations[expectation].formula.nodes;
        let Node::Always(_, implied) = nodes.last()? else { return None };
        let Node::Implies([trigger, then]) = nodes.get(*implied)? else { return None };
        let (Node::Rise(_), then) = (nodes.get(*trigger)?, nodes.get(*then)?) else { return None };
        let (ticks, inner) = match then {
            Node::Within(ticks, a) => (*ticks, *a),
            Node::Eventually(window, a) => (window.last?, *a),
            _ => return None,
        };
        let Node::Predicate(p) = nodes.get(inner)? else { return None };
        let alone = self.scenario.predicates.get(*p)?.value.ops.len() == 1 && self.played.is_of_machine();
        let mut measures = self.played.measures(*p).filter(|_| alone);
        let Some(Measure::In(state)) = measures.next() else { return None };
        Some(Reaction { state: *state, ticks })
    }

    /// The shortest wait of the transitions into a state; `None` if one may be taken at once.
    fn shortest_wait(&self, state: usize) -> Option<Waiting> {
        let m = self.program.machine.as_ref()?;
        let inside = |s: usize| s == state || m.is_around(state, s);
        let mut shortest: Option<Waiting> = None;
        for (s, of) in m.states.iter().enumerate().filter(|(s, _)| !inside(*s)) {
            for (i, t) in of.transitions.iter().enumerate().filter(|(_, t)| m.leaves(t.target).into_iter().any(inside))
            {
                let Trigger::When { hold, .. } = t.trigger else { return None };
                let place = self.places.machine.as_ref().and_then(|p| p.transitions.get(s)?.get(i));
                if shortest.as_ref().is_none_or(|w| hold < w.hold) {
                    shortest = Some(Waiting { hold, at: place.map(|p| p.trigger) });
                }
            }
        }
        shortest
    }
}
