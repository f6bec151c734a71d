//! Tasks and levels that may run: those of all stacks that a run can enter, each task once.

use std::ops::Range;

use crate::controller::Controller;
use crate::evaluator::Member;
use crate::tick::Tick;

/// A level of a stack.
#[derive(Clone, Debug)]
pub struct RosterLevel {
    /// Index of the stack in the program.
    pub stack: usize,
    /// Its name.
    pub name: String,
    /// True if it takes no slack.
    pub hard: bool,
    /// Number of rows.
    pub rows: usize,
    /// Degrees of freedom that the stack locks.
    pub locked: usize,
}

/// The tasks and levels of a run.
#[derive(Clone, Debug)]
pub struct Roster {
    /// Tasks; their `margins` and `measures` are numbered through all tasks.
    pub members: Vec<Member>,
    /// Levels, stack by stack.
    pub levels: Vec<RosterLevel>,
    /// For each stack, the index in `members` of each of its members.
    places: Vec<Vec<usize>>,
    /// For each stack, the range of its levels.
    stacks: Vec<Range<usize>>,
    margins: usize,
    measures: usize,
}

impl Roster {
    /// Collects the tasks and levels of a controller.
    pub fn new(controller: &Controller) -> Roster {
        let mut roster = Roster {
            members: Vec::new(),
            levels: Vec::new(),
            places: Vec::new(),
            stacks: Vec::new(),
            margins: 0,
            measures: 0,
        };
        for stack in controller.stacks() {
            let mut places = Vec::new();
            for m in stack.evaluator().members() {
                let known = roster.members.iter().position(|k| k.program_index == m.program_index);
                places.push(known.unwrap_or(roster.members.len()));
                if known.is_none() {
                    let mut m = m.clone();
                    m.margins = roster.margins..roster.margins + m.margins.len();
                    m.measures = roster.measures..roster.measures + m.measures.len();
                    (roster.margins, roster.measures) = (m.margins.end, m.measures.end);
                    roster.members.push(m);
                }
            }
            let first = roster.levels.len();
            let levels = stack.level_names().iter().zip(&stack.problem().levels);
            roster.levels.extend(levels.map(|(name, l)| RosterLevel {
                stack: stack.index(),
                name: name.clone(),
                hard: l.hard,
                rows: l.rows(),
                locked: stack.evaluator().locked().len(),
            }));
            roster.stacks.push(first..roster.levels.len());
            roster.places.push(places);
        }
        roster
    }

    /// Members that run at a tick, each with its index in [`Roster::members`].
    pub fn running<'t>(&'t self, tick: &Tick<'t>) -> impl Iterator<Item = (usize, &'t Member)> {
        self.places[tick.stack].iter().copied().zip(tick.evaluator.members())
    }

    /// Range of the levels that run at a tick.
    pub fn running_levels(&self, tick: &Tick) -> Range<usize> {
        self.stacks[tick.stack].clone()
    }

    /// Margins of all tasks at a tick; NaN for those of tasks that do not run.
    pub fn margins(&self, tick: &Tick) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.margins];
        for (i, m) in self.running(tick) {
            all[self.members[i].margins.clone()].copy_from_slice(&tick.evaluator.margins()[m.margins.clone()]);
        }
        all
    }

    /// Errors of all tasks at a tick; NaN for those of tasks that do not run.
    pub fn measures(&self, tick: &Tick) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.measures];
        for (i, m) in self.running(tick) {
            all[self.members[i].measures.clone()].copy_from_slice(&tick.evaluator.measures()[m.measures.clone()]);
        }
        all
    }

    /// Number for each level at a tick; NaN for those that do not run.
    pub fn levels(&self, tick: &Tick, number: impl Fn(&solver::LevelSolution) -> f64) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.levels.len()];
        for (x, l) in all[self.running_levels(tick)].iter_mut().zip(&tick.solution.levels) {
            *x = number(l);
        }
        all
    }
}
