//! Checks of the current state of a mission: absent robots, and operations that have begun.

use super::check::{Checker, Item, Mistake, Reason};
use super::problem::Begun;
use crate::check::entry;
use crate::numbers::MAX_NUMBER;

impl Checker<'_> {
    pub(super) fn absent(&mut self) {
        let problem = self.problem;
        for (number, absence) in problem.absent.iter().enumerate() {
            let at = entry(Item::Robot(absence.robot));
            if absence.robot >= problem.robots.len() {
                self.refuse(at, Reason::Unknown { index: absence.robot });
            } else if problem.absent[..number].iter().any(|other| other.robot == absence.robot) {
                self.refuse(at, Reason::Twice);
            }
            self.usual(at, absence.until.unwrap_or(0.0));
        }
        let served = problem.begun.iter().filter(|begun| begun.service.is_some()).count();
        if served < problem.operations() && !(0..problem.robots.len()).any(|m| problem.ready(m).is_some()) {
            self.refuse(entry(Item::Mission), Reason::NoRobot);
        }
    }

    pub(super) fn begun(&mut self) {
        let problem = self.problem;
        for (index, begun) in problem.begun.iter().enumerate() {
            if let Some(reason) = self.wrong_begun(index, begun) {
                self.refuse(entry(Item::Begun(index)), reason);
            }
        }
        for (index, begun) in problem.begun.iter().enumerate() {
            for (other, earlier) in problem.begun[..index].iter().enumerate() {
                let (Some((m, times)), Some((n, before))) = (begun.service, earlier.service) else { continue };
                if m == n && times.going < before.end - 1e-6 && before.going < times.end - 1e-6 {
                    let at = entry(Item::Begun(index));
                    let against = Some(entry(Item::Begun(other)));
                    self.mistakes.push(Mistake { at, against, reason: Reason::Overlap });
                }
            }
        }
    }

    fn wrong_begun(&self, index: usize, begun: &Begun) -> Option<Reason> {
        let problem = self.problem;
        let same = |other: &&Begun, operation: usize| other.agent == begun.agent && other.operation == operation;
        let Some(agent) = problem.agents.get(begun.agent) else {
            return Some(Reason::Unknown { index: begun.agent });
        };
        if begun.operation >= agent.operations {
            return Some(Reason::Unknown { index: begun.operation });
        }
        if problem.begun[..index].iter().any(|other| same(&other, begun.operation)) {
            return Some(Reason::Twice);
        }
        let usual = |t: &f64| t.is_finite() && t.abs() <= MAX_NUMBER;
        if let Some(value) = [begun.start, begun.end].into_iter().find(|t| !usual(t)) {
            return Some(Reason::TooLarge { value });
        }
        if begun.end < begun.start {
            return Some(Reason::NotAscending);
        }
        // An operation is settled if a robot has left its depot for it or for a later operation of the same agent.
        let settled = |other: &Begun| {
            let left = other.service.is_some_and(|(_, times)| times.going <= problem.start);
            other.agent == begun.agent && other.operation >= begun.operation && left
        };
        let settled = problem.begun.iter().any(settled);
        if begun.start > problem.start && !settled {
            return Some(Reason::Later { begins: begun.start });
        }
        if begun.operation > 0 {
            let before = problem.begun.iter().find(|other| same(other, begun.operation - 1));
            match before.and_then(|other| other.service) {
                None => return Some(Reason::NotServed),
                Some((_, times)) if begun.start < times.depositing - 1e-6 => return Some(Reason::BeforeService),
                Some(_) => {}
            }
        }
        let (robot, times) = begun.service?;
        if robot >= problem.robots.len() {
            return Some(Reason::Unknown { index: robot });
        }
        let instants = times.instants();
        if let Some(value) = instants.into_iter().find(|t| !usual(t)) {
            return Some(Reason::TooLarge { value });
        }
        if instants.windows(2).any(|pair| pair[1] < pair[0]) {
            return Some(Reason::NotAscending);
        }
        if times.going > problem.start && !settled {
            return Some(Reason::Later { begins: times.going });
        }
        if times.serving < begun.end - 1e-6 {
            return Some(Reason::BeforeEnd);
        }
        let lengths = problem.lengths(begun.agent, robot);
        let home = times.end - problem.robots[robot].deposit;
        let moves = [
            (lengths.going, times.going, times.waiting),
            (lengths.proximity, times.proximity, times.serving),
            (lengths.depositing, times.depositing, home),
        ];
        // Legs that ended in the past are not checked: they may have had another length then.
        let still = moves.into_iter().find(|(length, from, to)| *length > 0.0 && to <= from && *to > problem.start);
        still.map(|(length, ..)| Reason::NoDuration { length })
    }
}
