//! Outcomes of actions.
//!
//! An action whose kind has outcomes ends as the scenario defines for its first argument, or for its verb: the k-th
//! request as defined by the k-th entry, later ones by the last entry. Without a definition it ends at once with the
//! first of its outcomes. An action that is cancelled has no outcome.

use std::collections::BTreeMap;

use super::NOW;
use crate::controller::Request;
use crate::program::{ActionProgram, OutcomeProgram, OutcomeScript};
use crate::signals::Signals;

/// Action in progress.
struct Pending {
    action: usize,
    /// Time of its end, in s.
    due: f64,
    event: Option<usize>,
    sets: Vec<(usize, Vec<f64>)>,
}

/// Outcomes of all actions.
pub(super) struct Outcomes {
    scripts: BTreeMap<String, Vec<OutcomeProgram>>,
    /// Number of requests for each key.
    asked: BTreeMap<String, usize>,
    pending: Vec<Pending>,
    /// Signals that an outcome has set, with the values that they keep.
    values: BTreeMap<usize, Vec<f64>>,
}

impl Outcomes {
    pub fn new(scripts: &[OutcomeScript]) -> Outcomes {
        Outcomes {
            scripts: scripts.iter().map(|s| (s.key.clone(), s.requests.clone())).collect(),
            asked: BTreeMap::new(),
            pending: Vec::new(),
            values: BTreeMap::new(),
        }
    }

    /// Processes a request.
    pub fn ask(&mut self, request: &Request, action: &ActionProgram, time: f64) {
        self.pending.retain(|p| p.action != request.action);
        if !request.begin || action.outcomes.is_empty() {
            return;
        }
        let first = action.arguments.first().map(String::as_str);
        let key = first.into_iter().chain([action.verb.as_str()]).find(|k| self.scripts.contains_key(*k));
        let entry = key.and_then(|key| {
            let count = self.asked.entry(key.to_string()).or_insert(0);
            *count += 1;
            let requests = self.scripts.get(key)?;
            requests.get(*count - 1).or(requests.last())
        });
        let event_of = |word: &String| action.outcomes.iter().find(|o| o.0 == *word).map(|o| o.1);
        self.pending.push(match entry {
            Some(e) => Pending {
                action: request.action,
                due: if e.outcome.is_some() { time + e.after } else { f64::INFINITY },
                event: e.outcome.as_ref().and_then(event_of),
                sets: e.sets.clone(),
            },
            None => {
                let event = action.outcomes.first().map(|o| o.1);
                Pending { action: request.action, due: time, event, sets: Vec::new() }
            }
        });
    }

    /// Raises the events of actions that have ended, and sends the signals that outcomes have set.
    pub fn send(&mut self, signals: &mut Signals, time: f64) {
        let values = &mut self.values;
        self.pending.retain(|p| {
            if p.due > time + NOW {
                return true;
            }
            p.event.map(|event| signals.raise(event));
            values.extend(p.sets.iter().cloned());
            false
        });
        for (signal, value) in &self.values {
            signals.set(*signal, value, time);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Interface;

    const ASK: Request = Request { action: 0, begin: true };

    fn action() -> ActionProgram {
        ActionProgram {
            verb: "capture".into(),
            arguments: vec!["camera".into()],
            event: None,
            outcomes: vec![("found".into(), 0), ("not_found".into(), 1)],
            own: None,
        }
    }

    fn signals() -> Signals {
        Signals::new(&Interface { events: vec!["found".into(), "not_found".into()], ..Interface::default() })
    }

    fn entry(outcome: &str, after: f64) -> OutcomeProgram {
        OutcomeProgram { outcome: Some(outcome.into()), after, sets: Vec::new() }
    }

    /// Requests the action at 0 s, and returns the time and index of the event that follows.
    fn comes(outcomes: &mut Outcomes) -> Option<(f64, usize)> {
        outcomes.ask(&ASK, &action(), 0.0);
        (1..500).find_map(|k| {
            let (mut signals, time) = (signals(), f64::from(k) * 0.01);
            outcomes.send(&mut signals, time);
            signals.events().iter().position(|e| *e).map(|e| (time, e))
        })
    }

    #[test]
    fn requests_come_out_in_the_order_written_and_the_last_repeats() {
        for key in ["camera", "capture"] {
            let requests = vec![entry("not_found", 2.0), entry("found", 1.0)];
            let mut o = Outcomes::new(&[OutcomeScript { key: key.into(), requests }]);
            let all = [comes(&mut o), comes(&mut o), comes(&mut o)];
            assert_eq!(all, [Some((2.0, 1)), Some((1.0, 0)), Some((1.0, 0))]);
        }
    }

    #[test]
    fn without_a_word_the_first_outcome_comes_at_once() {
        assert_eq!(comes(&mut Outcomes::new(&[])), Some((0.01, 0)));
    }

    #[test]
    fn what_is_called_off_or_never_ends_has_no_outcome() {
        let mut o = Outcomes::new(&[OutcomeScript { key: "camera".into(), requests: vec![entry("found", 1.0)] }]);
        o.ask(&ASK, &action(), 0.0);
        o.ask(&Request { begin: false, ..ASK }, &action(), 0.5);
        assert!(o.pending.is_empty());
        let never = OutcomeProgram { outcome: None, after: 0.0, sets: Vec::new() };
        let mut o = Outcomes::new(&[OutcomeScript { key: "camera".into(), requests: vec![never] }]);
        assert_eq!(comes(&mut o), None);
    }
}
