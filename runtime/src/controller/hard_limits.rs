//! Limits of hard levels that the robot passes at run time: a fault, whether or not a transition asks for it.

use std::collections::BTreeSet;

use crate::evaluator::Evaluator;
use crate::fault::Fault;
use crate::program::{Program, StackProgram};

/// Margins that only the robot moves. One that a person or another signal moves can be passed although the robot gives
/// way as fast as its row requires, and it must go on to do so.
pub(super) struct HardLimits(Vec<HardLimit>);

/// A limit on a hard level.
struct HardLimit {
    /// Its index among the tasks of the stack.
    member: usize,
    /// Index of its task in the program.
    task: usize,
    /// State of each thing that it keeps a margin of; see [`Task::subject`].
    subjects: Vec<Subject>,
}

impl HardLimit {
    /// Lets the limit count only once the robot is within it.
    fn forget(&mut self) {
        for subject in &mut self.subjects {
            if matches!(subject, Subject::Within) {
                *subject = Subject::Outside;
            }
        }
    }
}

/// Thing that a limit keeps a margin of.
#[derive(Clone, Copy)]
enum Subject {
    /// A signal moves it.
    Moved,
    /// The robot has not been within the limit since the entry of the stack, or has passed it since.
    Outside,
    /// The robot was within the limit at the last tick.
    Within,
}

impl HardLimits {
    /// Finds the limits of a stack.
    pub fn new(evaluator: &Evaluator, program: &Program, stack: &StackProgram) -> HardLimits {
        let members = evaluator.members().iter().enumerate();
        let hard = members.filter(|(_, m)| !m.margins.is_empty() && stack.levels.get(m.level).is_some_and(|l| l.hard));
        let limit = |(member, m): (usize, &crate::evaluator::Member)| {
            let task = evaluator.task(member)?;
            let is_moved = |inputs: BTreeSet<usize>| !program.values.tape.only(&inputs).signals().is_empty();
            let subject = |s| {
                let inputs = task.margin_inputs(s).unwrap_or_else(|| m.slots.clone());
                if is_moved(inputs.into_iter().collect()) { Subject::Moved } else { Subject::Outside }
            };
            Some(HardLimit { member, task: m.program_index, subjects: (0..task.subjects()).map(subject).collect() })
        };
        HardLimits(hard.filter_map(limit).collect())
    }

    /// The stack is entered: limits that are violated now are restored, and count from the tick at which they hold; those
    /// of parts that go on count already.
    pub fn enter(&mut self, evaluator: &Evaluator) {
        for limit in self.0.iter_mut().filter(|l| !evaluator.goes_on(l.member)) {
            limit.forget();
        }
    }

    /// The reference was moved to the robot: limits that it is beyond are restored, and count from the tick at which they hold.
    pub fn count_anew(&mut self) {
        self.0.iter_mut().for_each(HardLimit::forget);
    }

    /// The stack is entered after another one, whose limits count already if they go on.
    pub fn take_over(&mut self, evaluator: &Evaluator, from: &HardLimits) {
        for limit in &mut self.0 {
            limit.forget();
            let same = |o: &&HardLimit| o.task == limit.task && o.subjects.len() == limit.subjects.len();
            if let Some(other) = from.0.iter().find(same).filter(|_| evaluator.goes_on(limit.member)) {
                limit.subjects.copy_from_slice(&other.subjects);
            }
        }
    }

    /// Returns the first limit that the robot passed at this tick: it was within the limit before, and its margin is now
    /// below `-tolerance`.
    pub fn passed(&mut self, evaluator: &Evaluator, tolerance: f64) -> Option<Fault> {
        let mut first = None;
        for HardLimit { member, subjects, .. } in &mut self.0 {
            let (Some(task), Some(m)) = (evaluator.task(*member), evaluator.members().get(*member)) else { continue };
            let margins = evaluator.margins().get(m.margins.clone()).unwrap_or_default();
            // Subjects without a row are further away than those that have one.
            let all_within = subjects.len() > margins.len() && margins.iter().all(|h| *h >= -tolerance);
            if all_within {
                subjects.iter_mut().filter(|s| matches!(s, Subject::Outside)).for_each(|s| *s = Subject::Within);
                continue;
            }
            for (row, h) in margins.iter().enumerate() {
                let Some(subject) = subjects.get_mut(task.subject(row)) else { continue };
                let next = if *h >= -tolerance { Subject::Within } else { Subject::Outside };
                match (*subject, next) {
                    (Subject::Moved, _) => continue,
                    (Subject::Within, Subject::Outside) if first.is_none() => {
                        first = Some(Fault::Limit { member: *member, row });
                    }
                    _ => {}
                }
                *subject = next;
            }
        }
        first
    }
}
