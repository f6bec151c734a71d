//! Outcomes of actions: a failure that no transition answers, and a time-out that leads where success leads.

use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::{Op, Trigger};

use super::Checked;
use super::one_target::ON_OBJECTS;

/// Time (s) up to which a time-out answers a failure too: nobody waits longer for an answer that was given.
const PROMPT: f64 = 10.0;

/// A time that answers a missing outcome.
struct Answer {
    time: f64,
    at: Span,
}

impl Checked<'_> {
    /// Warns of actions whose failure leaves the machine waiting, and of times that are taken for success.
    pub(super) fn outcomes(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let state = &self.machine.states[s];
            for &action in state.enter.iter().chain(&state.activities) {
                let [(success, done), (failure, failed)] = self.machine.actions[action].outcomes.as_slice() else {
                    continue;
                };
                self.unanswered(s, action, ((success, *done), (failure, *failed)), diagnostics);
                self.late_success(s, action, *done, diagnostics);
            }
        }
    }

    /// States whose transitions are examined while the machine is in `s`: `s` itself and those inside it.
    pub(super) fn own(&self, s: usize) -> Vec<usize> {
        self.reached.iter().copied().filter(|&i| i == s || self.machine.is_around(s, i)).collect()
    }

    /// Warns of an action whose success is answered in its state and whose failure is not, neither by its event nor by
    /// anything else in that state, such as a time or a condition.
    fn unanswered(
        &self,
        s: usize,
        action: usize,
        ((success, done), (failure, failed)): ((&str, usize), (&str, usize)),
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let own = self.own(s);
        let Some((at, i)) = own.iter().find_map(|&p| Some((p, self.on(p, done)?))) else { return };
        let is_success = |trigger: &Trigger| *trigger == Trigger::Event(done);
        let answers = own.iter().any(|&p| {
            let all = self.machine.states[p].transitions.iter().enumerate();
            all.into_iter().any(|(i, t)| !super::is_fault(&t.trigger) && !is_success(&t.trigger) && !self.is_dead(p, i))
        });
        if answers || self.answers_around(s, failed) {
            self.answered_late(s, action, [(success, done), (failure, failed)], diagnostics);
            return;
        }
        let name = |word: &str, event: usize| self.outcome_name(word, event);
        let text = format!("no transition answers {} of this action", name(failure, failed));
        diagnostics.push(
            Diagnostic::warning("HQ0717", self.places.actions[action], text)
                .label(self.places.transitions[at][i].trigger, format!("only {} leads on", name(success, done)))
                .note(format!("if it fails, the machine waits in `{}` for ever", self.name(s)))
                .help(Help::with(
                    "write for instance {}, or a time after which the machine goes on, {}",
                    [
                        Snippet::transition(self.program.interface.events[failed].as_str(), "STATE"),
                        Snippet::each("after 10 s -> STATE", "{ after: 10 s, to: STATE }"),
                    ],
                )),
        );
    }

    /// True if a transition around a state answers a failure: a condition or an event is for something else, such as a stop, and a
    /// time is an answer.
    fn answers_around(&self, s: usize, failed: usize) -> bool {
        self.machine.path(s).skip(1).any(|p| {
            self.machine.states[p].transitions.iter().any(|t| match &t.trigger {
                Trigger::Event(event) => *event == failed,
                Trigger::After(_) => true,
                Trigger::When { condition, .. } => self.reads_time(&condition.inputs),
                Trigger::Reached(_) | Trigger::Ended(_) | Trigger::Fault(_) => false,
            })
        }) || self.elsewhere.awaited.contains(&failed)
    }

    /// Name of an outcome, with the word for it if it has another one.
    fn outcome_name(&self, word: &str, event: usize) -> String {
        match self.program.interface.events[event].as_str() {
            event if event == word => format!("`{event}`"),
            event => format!("`{event}` ({word})"),
        }
    }

    /// Warns of an action on an object whose failure is answered by a long time-out alone.
    fn answered_late(
        &self,
        s: usize,
        action: usize,
        [(success, done), (failure, failed)]: [(&str, usize); 2],
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        if !ON_OBJECTS.contains(&self.machine.actions[action].verb.as_str()) {
            return;
        }
        let own = self.own(s);
        let Some((at, i)) = own.iter().find_map(|&p| Some((p, self.on(p, done)?))) else { return };
        let mut answer: Option<Answer> = None;
        // A time around the state is for a whole sequence.
        if self.answers_around(s, failed) {
            return;
        }
        for &p in &own {
            for (k, t) in self.machine.states[p].transitions.iter().enumerate().filter(|(k, _)| !self.is_dead(p, *k)) {
                match &t.trigger {
                    Trigger::Event(event) if *event != done => return,
                    Trigger::When { .. } | Trigger::Reached(_) | Trigger::Ended(_) => return,
                    Trigger::After(time) if answer.as_ref().is_none_or(|a| *time < a.time) => {
                        answer = Some(Answer { time: *time, at: self.places.transitions[p][k].trigger });
                    }
                    _ => {}
                }
            }
        }
        let Some(answer) = answer.filter(|a| a.time > PROMPT) else { return };
        let time = runtime::text::number(answer.time);
        let text = format!("only a time answers {} of this action", self.outcome_name(failure, failed));
        diagnostics.push(
            Diagnostic::warning("HQ0717", self.places.actions[action], text)
                .label(
                    self.places.transitions[at][i].trigger,
                    format!("only {} leads on", self.outcome_name(success, done)),
                )
                .label(answer.at, format!("if it fails, the machine waits {time} s"))
                .help(Help::with(
                    "write for instance {}",
                    [Snippet::transition(self.program.interface.events[failed].as_str(), "STATE")],
                )),
        );
    }

    /// True if an entry of the table of values depends on the time.
    fn reads_time(&self, inputs: &[usize]) -> bool {
        let tape = self.program.values.tape.only(&inputs.iter().copied().collect());
        tape.ops.iter().any(|op| matches!(op, Op::T | Op::Time))
    }

    /// Warns of a time that leads to the same state as the success of an action, for actions on objects: the next state
    /// relies on the success.
    fn late_success(&self, s: usize, action: usize, done: usize, diagnostics: &mut Vec<Diagnostic>) {
        if !ON_OBJECTS.contains(&self.machine.actions[action].verb.as_str()) {
            return;
        }
        let own = self.own(s);
        let Some((at, i)) = own.iter().find_map(|&p| Some((p, self.on(p, done)?))) else { return };
        let target = self.machine.states[at].transitions[i].target;
        // In a final state nothing relies on the success any more.
        if self.machine.ends(self.machine.leaf(target)) {
            return;
        }
        for &p in &own {
            for (k, t) in self.machine.states[p].transitions.iter().enumerate() {
                if !matches!(t.trigger, Trigger::After(_)) || self.machine.leaf(t.target) != self.machine.leaf(target) {
                    continue;
                }
                let place = &self.places.transitions[p][k];
                let name = &self.program.interface.events[done];
                let text =
                    format!("a missing answer counts as `{name}`: this time leads to `{}` too", self.name(target));
                diagnostics.push(
                    Diagnostic::warning("HQ0718", place.trigger, text)
                        .label(self.places.transitions[at][i].trigger, "success leads there")
                        .label(self.places.actions[action], "the outcome of this action is not known then")
                        .note(format!("`{}` goes on as if the action had succeeded", self.name(target)))
                        .help(
                            "let the time lead to a state that handles the missing answer; if it is meant, lead there \
                             through a state that says so, with `log`",
                        ),
                );
            }
        }
    }
}
