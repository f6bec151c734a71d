//! The hard levels of a stack at sampled postures, for a robot at rest: whether they can be met. And the freedom that the
//! targets of each level leave to the levels below.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use runtime::program::{Program, Times};
use runtime::record::summary::MARGIN_TOLERANCE;
use runtime::{Evaluator, RestInputs};
use solver::contradiction::contradiction;
use solver::{Backend, HierarchicalSolver, Problem, Solution, Status};

use super::{Checked, Work, share};
use crate::checks::fixed_above::fixed_by_targets_above;
use crate::checks::limit;
use crate::sampled::{Freedom, SampledStack};

/// Number of postures at which the freedom of levels is computed, at most.
const FREEDOM: usize = 1000;

/// A stack that is evaluated by one thread, and what it has found.
struct Worker<'p> {
    program: &'p Program,
    /// `None` if the stack cannot be built, or needs signals.
    prepared: Option<Prepared>,
    found: Tally,
}

struct Prepared {
    evaluator: Evaluator,
    problem: Problem,
    /// The levels down to the last hard one, and their solver.
    hard: Problem,
    solver: Box<dyn HierarchicalSolver + Send>,
    solution: Solution,
    rest: RestInputs,
}

/// Findings of a thread.
#[derive(Default)]
struct Tally {
    inside: usize,
    /// By level and the tasks that contradict each other.
    infeasible: BTreeMap<(usize, Vec<usize>), Infeasible>,
    /// For each level, the number of postures by the freedom there.
    freedom: Vec<BTreeMap<usize, usize>>,
}

impl Tally {
    /// Number of postures at which a hard level cannot be met.
    fn infeasible(&self) -> usize {
        self.infeasible.values().map(|i| i.count).sum()
    }
}

/// Tasks that contradict each other on a level.
struct Contradiction<'t> {
    level: usize,
    tasks: &'t [usize],
    found: &'t Infeasible,
}

/// Postures at which the same tasks contradict each other.
#[derive(Default)]
struct Infeasible {
    count: usize,
    /// Number of the first posture.
    first: usize,
}

impl<'p> Worker<'p> {
    fn new(program: &'p Program, stack: usize) -> Worker<'p> {
        let found = Tally { freedom: vec![BTreeMap::new(); program.stacks[stack].levels.len()], ..Tally::default() };
        let prepared = Evaluator::new(program, stack).ok().filter(|(e, _)| e.needs().is_empty());
        let prepared = prepared.map(|(evaluator, problem)| {
            let last = problem.levels.iter().rposition(|l| l.hard).map_or(0, |k| k + 1);
            let hard = Problem { levels: problem.levels[..last].to_vec(), ..problem.clone() };
            let (solver, solution) = (Backend::ActiveSet.solver(&hard), Solution::new(&hard));
            Prepared { evaluator, hard, solver, solution, problem, rest: RestInputs::new(program) }
        });
        Worker { program, prepared, found }
    }

    fn examine(&mut self, k: usize, q: &[f64]) {
        let Some(p) = &mut self.prepared else { return };
        let mut q = q.to_vec();
        keep_locked(self.program, p.evaluator.locked(), &mut q);
        let inputs = p.rest.at(Times::default());
        p.evaluator.enter(&q, inputs);
        if p.evaluator.update(&q, inputs, &mut p.problem).is_err() {
            return;
        }
        let hard = |m: &runtime::Member| p.problem.levels[m.level].hard;
        let outside = p
            .evaluator
            .members()
            .iter()
            .filter(|m| hard(m))
            .any(|m| p.evaluator.margins()[m.margins.clone()].iter().any(|h| *h < -MARGIN_TOLERANCE));
        if outside {
            return;
        }
        self.found.inside += 1;
        if self.found.inside <= FREEDOM {
            let free = self.program.robot.model.nv() - p.evaluator.locked().len();
            let fixed = fixed_by_targets_above(&p.problem, p.evaluator.members());
            for (of_level, fixed) in self.found.freedom.iter_mut().zip(fixed.unwrap_or_default()) {
                *of_level.entry(free.saturating_sub(fixed)).or_default() += 1;
            }
        }
        for (own, level) in p.hard.levels.iter_mut().zip(&p.problem.levels) {
            own.clone_from(level);
        }
        if stands(&p.hard) {
            return;
        }
        p.solver.solve(&p.hard, &mut p.solution);
        let Status::Infeasible { level } = p.solution.status else { return };
        let owner = |level: usize, row: usize| {
            p.evaluator.members().iter().find(|m| m.level == level && m.rows.contains(&row)).map(|m| m.program_index)
        };
        let rows = contradiction(&p.hard, level, &p.solution.x);
        let tasks: BTreeSet<usize> = rows.iter().filter_map(|r| owner(r.level, r.row)).collect();
        let entry = self.found.infeasible.entry((level, tasks.into_iter().collect())).or_default();
        if entry.count == 0 {
            entry.first = k;
        }
        entry.count += 1;
    }
}

/// True if a robot that stands meets all rows, and no soft level lies above a hard one.
fn stands(hard: &Problem) -> bool {
    let met = |l: &solver::Level| l.lower.iter().all(|x| *x <= 0.0) && l.upper.iter().all(|x| *x >= 0.0);
    hard.levels.iter().all(|l| l.hard && met(l))
}

/// Locked degrees of freedom stay as they are at home.
fn keep_locked(program: &Program, locked: &[usize], q: &mut [f64]) {
    for &dof in locked {
        if let Some(i) = program.robot.model.dofs[dof].q_index {
            q[i] = program.robot.home[i];
        }
    }
}

/// Checks a stack.
pub(super) fn check(
    c: &Checked,
    work: &Work,
    stack: usize,
    told: &mut BTreeSet<Vec<usize>>,
    out: &mut Vec<Diagnostic>,
) -> SampledStack {
    let workers = work.share(c.program, || Worker::new(c.program, stack), |worker, k, q| worker.examine(k, q));
    let needs_signals = workers.iter().any(|w| w.prepared.is_none());
    let mut all = Tally { freedom: vec![BTreeMap::new(); c.program.stacks[stack].levels.len()], ..Tally::default() };
    for Worker { found, .. } in workers {
        all.inside += found.inside;
        for (key, Infeasible { count, first }) in found.infeasible {
            let sum = all.infeasible.entry(key).or_insert(Infeasible { count: 0, first });
            *sum = Infeasible { count: sum.count + count, first: sum.first.min(first) };
        }
        for (sum, of_level) in all.freedom.iter_mut().zip(found.freedom) {
            of_level.into_iter().for_each(|(freedom, count)| *sum.entry(freedom).or_default() += count);
        }
    }
    // The most frequent contradiction of the first level stands for the others; once for stacks that share it.
    let first = all.infeasible.keys().map(|(level, _)| *level).min();
    let of_first = all.infeasible.iter().filter(|((level, _), _)| Some(*level) == first);
    if let Some(((level, tasks), found)) = of_first.max_by_key(|(_, i)| (i.count, Reverse(i.first)))
        && told.insert(tasks.clone())
    {
        let worst = Contradiction { level: *level, tasks, found };
        out.push(cannot_be_met(c, stack, &worst, &all, work.deep.seed));
    }
    let infeasible = all.infeasible();
    let levels = c.program.stacks[stack].levels.iter().zip(all.freedom);
    SampledStack {
        name: c.program.stacks[stack].name.clone(),
        inside: all.inside,
        infeasible,
        needs_signals,
        freedom: levels.map(|(l, counts)| Freedom { level: l.name.clone(), counts }).collect(),
    }
}

fn cannot_be_met(c: &Checked, stack: usize, worst: &Contradiction, all: &Tally, seed: u64) -> Diagnostic {
    let Contradiction { level, tasks, found } = *worst;
    let infeasible = all.infeasible();
    let name = &c.program.stacks[stack].levels[level].name;
    let at = c.places.stacks[stack].1[level];
    let text = format!(
        "hard level `{name}` cannot be met at {} of the sampled postures inside the limits",
        share(infeasible, all.inside)
    );
    let mut d = Diagnostic::warning("HQ0590", at, text);
    for &task in tasks {
        d = d.label(limit(c.places, task), "takes part in the contradiction");
    }
    if found.count < infeasible {
        d = d.note(format!(
            "the labelled tasks contradict each other at {} of these postures",
            share(found.count, infeasible)
        ));
    }
    let q = super::posture(c.program, seed, found.first);
    let dofs = c.program.robot.model.dofs.iter().filter_map(|dof| Some((&dof.name, *q.get(dof.q_index?)?)));
    let list: Vec<String> = dofs.map(|(name, x)| format!("{name} {x:.2}")).collect();
    d.note(format!("one of these postures, in rad or m: {}", list.join(", ")))
        .note(
            "the robot is at rest there and inside all limits; the controller would stand with the fault `infeasible`",
        )
        .help("let one of these tasks give way on a soft level")
}
