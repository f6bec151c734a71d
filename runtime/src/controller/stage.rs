//! A stack on stage: its tasks, the problem that they fill, the solver, and the way over from another stack's velocity.
//!
//! Going over. Let v be the velocity that the reference moved with at the last tick, and v_B(0) what this stack asks for at
//! its first tick. While a blend of T seconds lasts, the stack's hierarchy is solved as ever, giving v_B, and then once
//! more for
//!
//! ```text
//! v*  =  v_B + (1 - s) (v - v_B(0)),     s = x²(3 - 2x),  x = t/T
//! ```
//!
//! as the point nearest to v* among those that meet every hard level of the stack as well as can be, and every soft level
//! that the stack left has too, above the first one in which the two differ. At x = 0 that is v, up to what these levels
//! demand; at x = 1 it is v_B. A hard level therefore holds at every tick of a blend as at every other. Source: ours.
//!
//! Limits of accelerations are no part of v_B while a blend lasts: with them v_B(0) would be next to v and leave nothing to
//! blend, and the stack would go to what it asks for as fast as they let it. They are part of the problem of the point nearest
//! to v*. A stack with a safety planner keeps them, since the planner reckons with all rows above it.
//!
//! The damping of a level is part of v_B and of no other velocity: in the problem of the point nearest to v* it would pull
//! v* to rest. A soft level that was damped asks there for what its rows reached.
//!
//! A tick whose budget is spent before the hierarchy is solved. The robot then moves with the velocity nearest to v* among
//! those that meet every hard level. The solver follows a line from the last answer to this one, and v* is the point of it that
//! was reached. Where there is no such line, as at a first tick, or where it does not lead to the answer itself, since a level
//! is to be damped, v* is the velocity of the tick before; from the second such tick in a row on
//!
//! ```text
//! v*  =  exp(-T / 0.1 s) v
//! ```
//!
//! with `T` the period: the robot goes on as it did, and slower from tick to tick. The solver goes on at the next tick from what
//! it reached.
//!
//! Joints that the stack locks, and that move when it is entered, come to rest on the way: v_B lets them stand, so v* lets
//! them go from v to rest with 1 - s, and in the problem of the point nearest to v* their columns are those that they have,
//! with `0 <= v_i / v_i(last tick) <= 1` above all else. That problem has an answer whenever the stack's own has: v_B is one,
//! but for limits of acceleration, which `v_i(last tick) - a T` meets. Where these hold a joint back the way over goes on
//! until it stands; without a blend it is as short as they allow. A limit of acceleration that is not one joint's own may
//! have no answer at a switch, which is the fault `infeasible`.

use std::time::Instant;

use solver::{HierarchicalSolver, LevelShape, LevelStatus, Problem, Smooth, Solution, Status};

use crate::evaluator::{Evaluator, Moment};
use crate::fault::Fault;
use crate::program::{LevelProgram, Program, ProgramError, StackProgram};

/// The way over from another velocity.
struct Blend {
    problem: Problem,
    solution: Solution,
    solver: Box<dyn HierarchicalSolver + Send>,
    /// v - v_B(0)
    offset: Vec<f64>,
    /// How long it takes, in s; 0 while none is under way.
    duration: f64,
    /// For each level whether it holds during this blend.
    kept: Vec<bool>,
    /// The rows of limits of accelerations, by level, and their bounds at this tick; none where a planner reckons with them.
    gentle: Vec<(usize, std::ops::Range<usize>)>,
    bounds: Vec<(f64, f64)>,
    /// A locked joint moved at the last tick.
    coasting: bool,
    /// It moves at this one too.
    goes_on: bool,
    /// The offset is known: the first tick has been solved.
    begun: bool,
}

impl Blend {
    /// Whether a blend is under way at a moment, and not at its last tick.
    fn lasts(&self, moment: Moment) -> bool {
        // A sum of periods is a little off: half a microsecond counts as nothing.
        moment.times.t < self.duration - 5e-7
    }

    /// Which part of the offset is left at a moment.
    fn left(&self, moment: Moment) -> f64 {
        let x = if self.lasts(moment) { moment.times.t / self.duration } else { 1.0 };
        1.0 - x * x * (3.0 - 2.0 * x)
    }

    /// Takes the bounds of accelerations out of the problem of the stack, and keeps them.
    fn leave_out_accelerations(&mut self, problem: &mut Problem) {
        let mut bounds = self.bounds.iter_mut();
        for (level, rows) in &self.gentle {
            let (lower, upper) = problem.levels[*level].bounds_mut(rows.clone());
            for ((l, u), kept) in lower.iter_mut().zip(upper).zip(&mut bounds) {
                *kept = (*l, *u);
                (*l, *u) = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
    }

    /// Puts them into the problem of the velocity between, where their levels hold.
    fn give_back_accelerations(&mut self) {
        let mut bounds = self.bounds.iter();
        for (level, rows) in &self.gentle {
            let (lower, upper) = self.problem.levels[level + 1].bounds_mut(rows.clone());
            for ((l, u), kept) in lower.iter_mut().zip(upper).zip(&mut bounds) {
                if self.kept[*level] {
                    (*l, *u) = *kept;
                }
            }
        }
    }
}

/// A locked joint that moves slower counts as one that stands, in rad/s or m/s.
const STANDS: f64 = 1e-9;

/// A stack on stage.
pub struct Stage {
    pub(super) evaluator: Evaluator,
    problem: Problem,
    pub(super) solution: Solution,
    level_names: Vec<String>,
    pub(super) value_names: Vec<(std::ops::Range<usize>, String)>,
    solver: Smooth,
    blend: Blend,
    /// Index of the stack in the program.
    stack: usize,
    /// Ticks since it was entered.
    ticks: u64,
    /// There was no time to solve the hierarchy at the last tick.
    late: bool,
    /// The part of the velocity that is left after a tick without time.
    slowing: f64,
}

/// The parameters of a stack's tasks by their places, as `` `gain` of task `reach` ``.
fn value_names(program: &Program, stack: &StackProgram) -> Vec<(std::ops::Range<usize>, String)> {
    let tasks = stack.levels.iter().flat_map(|l| &l.members).filter_map(|m| program.tasks.get(m.task));
    let named = |task: &crate::program::TaskProgram| {
        let one = |(name, bound): (&String, &stdlib_tasks::bound::Bound)| {
            let text = format!("`{name}` of task `{}`", task.name);
            bound.slots().into_iter().map(|s| (s.at..s.at + s.len, text.clone())).collect::<Vec<_>>()
        };
        task.params.iter().flat_map(one).collect::<Vec<_>>()
    };
    tasks.flat_map(named).collect()
}

/// Whether two levels ask for the same.
fn same_level(program: &Program, a: &LevelProgram, b: &LevelProgram) -> bool {
    let members = || a.members.iter().zip(&b.members);
    a.hard == b.hard
        && a.damping == b.damping
        && a.exact == b.exact
        && a.members.len() == b.members.len()
        && members().all(|(x, y)| x.weight == y.weight && program.alike(x.task, y.task))
}

/// How many levels two stacks have in common, from the top. Soft levels that ask for something else when they are entered
/// anew do not count.
fn in_common(program: &Program, a: &StackProgram, b: &StackProgram) -> usize {
    if a.locked != b.locked {
        return 0;
    }
    let lasting = |l: &LevelProgram| l.hard || !l.members.iter().any(|m| program.depends_on_entry(m.task));
    a.levels.iter().zip(&b.levels).take_while(|(a, b)| same_level(program, a, b) && lasting(a)).count()
}

/// Time constant in s with which damping by rows above a level fades, and the velocity where there is no time.
const FADING: f64 = 0.1;

/// The solver of a stack. A planner's own level asks for the velocity that it decided on, damped where it had to be.
fn smooth(problem: &Problem, stack: &StackProgram, program: &Program) -> Smooth {
    let solver = Smooth::new(problem, program.run.solver).with_fading((-program.robot.period / FADING).exp());
    let plans = |task: usize| program.tasks.get(task).is_some_and(|t| crate::planning::protected_by(t).is_some());
    let planned = |level: &LevelProgram| level.members.iter().any(|m| plans(m.task));
    let exact = stack.levels.iter().enumerate().filter(|(_, level)| level.exact || planned(level));
    exact.fold(solver, |solver, (k, _)| solver.with_exact(k))
}

impl Stage {
    pub(super) fn new(program: &Program, stack: usize) -> Result<Stage, ProgramError> {
        let Some(stack_program) = program.stacks.get(stack) else {
            return Err(crate::program::error("stacks", "there is no such stack"));
        };
        let (mut evaluator, mut problem) = Evaluator::new(program, stack)?;
        let exact: Vec<bool> = stack_program.levels.iter().map(|level| level.exact).collect();
        evaluator.measure_curvature(program.robot.period, &program.interface, &exact, &mut problem);
        let nv = evaluator.model().nv();
        // Above the levels of the stack one for the joints that it locks.
        let mut between = problem.clone();
        let rows = evaluator.locked().len();
        between.levels.iter_mut().for_each(|level| level.damping = 0.0);
        between.levels.insert(0, Problem::new(nv, &[LevelShape { rows, hard: true, damping: 0.0 }]).levels.remove(0));
        let gentle = if evaluator.safety().count() > 0 { Vec::new() } else { evaluator.acceleration_rows() };
        let blend = Blend {
            solution: Solution::new(&between),
            solver: program.run.solver.solver(&between),
            problem: between,
            offset: vec![0.0; nv],
            duration: 0.0,
            kept: vec![false; problem.levels.len()],
            bounds: vec![(0.0, 0.0); gentle.iter().map(|(_, rows)| rows.len()).sum()],
            gentle,
            coasting: false,
            goes_on: false,
            begun: false,
        };
        Ok(Stage {
            solution: Solution::new(&problem),
            solver: smooth(&problem, stack_program, program),
            level_names: stack_program.levels.iter().map(|l| l.name.clone()).collect(),
            value_names: value_names(program, stack_program),
            blend,
            stack,
            ticks: 0,
            late: false,
            slowing: (-program.robot.period / FADING).exp(),
            evaluator,
            problem,
        })
    }

    /// Index of the stack in the program.
    pub fn stack(&self) -> usize {
        self.stack
    }

    /// The same stack made ready once more, for monitors.
    ///
    /// # Errors
    /// It cannot be executed, which was excluded when this one was made.
    pub fn again(&self, program: &Program) -> Result<(Evaluator, Problem), ProgramError> {
        match program.stacks.get(self.stack) {
            Some(_) => Evaluator::new(program, self.stack),
            None => Evaluator::new(&standing(program), self.stack),
        }
    }

    /// Its tasks.
    pub fn evaluator(&self) -> &Evaluator {
        &self.evaluator
    }

    /// What its solver was asked when it last ran.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The problem whose exact optimum the answer of the last tick is: damped levels ask for what they reached.
    pub fn settled(&self) -> &Problem {
        self.solver.settled().unwrap_or(&self.problem)
    }

    /// The solver of its hierarchy, after the last tick.
    pub fn solver(&self) -> &Smooth {
        &self.solver
    }

    /// Names of its levels.
    pub fn level_names(&self) -> &[String] {
        &self.level_names
    }

    /// Ticks since it was entered.
    pub(super) fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Whether the command is still going over from what ran before.
    pub(super) fn is_blending(&self) -> bool {
        self.blend.duration > 0.0 || self.blend.goes_on
    }

    /// True where there was no time to solve the hierarchy at the last tick.
    pub(super) fn is_late(&self) -> bool {
        self.late
    }

    /// Whether the velocity of the last tick is one between the two stacks.
    fn is_between(&self) -> bool {
        self.blend.duration > 0.0 || self.blend.coasting
    }

    pub(super) fn solver_name(&self) -> &'static str {
        self.solver.name()
    }

    /// Enters the stack. `blend` is how long the way over takes, in s; `common` how many levels, from the top, it shares
    /// with what ran before.
    pub(super) fn enter(&mut self, q: &[f64], moment: Moment, blend: f64, common: usize) {
        self.evaluator.enter(q, moment);
        self.solver.forget();
        if blend > 0.0 {
            self.evaluator.hand_over();
        }
        (self.ticks, self.late) = (0, false);
        (self.blend.duration, self.blend.begun) = (blend, false);
        for (i, (kept, level)) in self.blend.kept.iter_mut().zip(&self.problem.levels).enumerate() {
            *kept = level.hard || i < common;
        }
    }

    /// Works out the velocity of a tick at a configuration. Never allocates. Where that takes longer than until the given instant, it is
    /// the one nearest to the last that hard levels let through.
    ///
    /// # Errors
    /// There is none.
    pub(super) fn solve(&mut self, q: &[f64], moment: Moment, until: Option<Instant>) -> Result<(), Fault> {
        self.blend.coasting = self.evaluator.locked().iter().any(|&dof| moment.velocity[dof].abs() > STANDS);
        self.evaluator.coast(self.blend.coasting);
        self.evaluator.update(q, moment, &mut self.problem)?;
        if self.blend.lasts(moment) {
            self.blend.leave_out_accelerations(&mut self.problem);
        }
        self.solver.set_deadline(until);
        let before = self.late;
        self.late = !self.solve_hierarchy(q, moment)?;
        self.blend.goes_on = false;
        if self.late {
            self.make_do(moment, before)?;
        } else if self.is_between() {
            self.go_over(moment)?;
        }
        self.ticks += 1;
        Ok(())
    }

    /// Solves the hierarchy, and once more for each safety planner that decides anew. False where there was no time.
    fn solve_hierarchy(&mut self, q: &[f64], moment: Moment) -> Result<bool, Fault> {
        for k in 0..=self.evaluator.safety().count() {
            if k == 0 || self.evaluator.reconsider(k - 1, q, moment, &mut self.problem, &self.solution.x)? {
                self.solver.solve(&self.problem, &mut self.solution);
                if matches!(self.solution.status, Status::OutOfTime { .. }) {
                    return Ok(false);
                }
                usable(&self.solution, &self.evaluator)?;
            }
        }
        Ok(true)
    }

    /// The velocity where there is no time for the hierarchy, for the first time or again: see the head of the file.
    fn make_do(&mut self, moment: Moment, again: bool) -> Result<(), Fault> {
        let left = self.blend.left(moment);
        let b = &mut self.blend;
        // At the first tick of a stack its solver's last answer is of another time.
        let begun = self.ticks > 0 && (b.duration == 0.0 || b.begun);
        if begun && self.solution.status == (Status::OutOfTime { on_the_way: true }) {
            for ((r, v), offset) in b.problem.reference.iter_mut().zip(&self.solution.x).zip(&b.offset) {
                *r = v + left * offset;
            }
        } else {
            let keeps = if again { self.slowing } else { 1.0 };
            b.problem.reference.iter_mut().zip(moment.velocity).for_each(|(r, v)| *r = keeps * v);
        }
        self.nearest(moment, self.blend.lasts(moment))?;
        self.solution.x.copy_from_slice(&self.blend.solution.x);
        self.solution.measure(&self.problem);
        if begun {
            // The offset is no motion of the stack's.
            self.solution.x.iter_mut().zip(&self.blend.offset).for_each(|(x, offset)| *x -= left * offset);
        }
        Ok(())
    }

    fn go_over(&mut self, moment: Moment) -> Result<(), Fault> {
        let b = &mut self.blend;
        if !b.begun {
            b.begun = true;
            for ((offset, v), x) in b.offset.iter_mut().zip(moment.velocity).zip(&self.solution.x) {
                *offset = v - x;
            }
        }
        let (lasts, left) = (b.lasts(moment), b.left(moment));
        if !lasts {
            b.duration = 0.0;
            if !b.coasting {
                return Ok(());
            }
        }
        for ((r, v), offset) in b.problem.reference.iter_mut().zip(&self.solution.x).zip(&b.offset) {
            *r = v + left * offset;
        }
        self.nearest(moment, lasts)
    }

    /// The velocity nearest to the reference among those that meet the levels that hold between stacks, or where there was no
    /// time the hard ones. Locked joints come to rest, at once where these levels let them do nothing else.
    fn nearest(&mut self, moment: Moment, lasts: bool) -> Result<(), Fault> {
        self.between(moment, lasts, false);
        if self.blend.coasting && matches!(self.blend.solution.status, Status::Infeasible { .. }) {
            self.between(moment, lasts, true);
        }
        for &dof in self.evaluator.locked() {
            if self.blend.solution.x[dof].abs() <= STANDS {
                self.blend.solution.x[dof] = 0.0;
            } else {
                self.blend.goes_on = true;
            }
        }
        usable_between(&self.blend.solution, &self.evaluator)
    }

    /// Solves for that velocity; `stop` brings locked joints to rest at once. A row that speaks of these alone is then met: its
    /// distance stays what it is.
    fn between(&mut self, moment: Moment, lasts: bool, stop: bool) {
        let late = self.late;
        let b = &mut self.blend;
        let Some((locks, levels)) = b.problem.levels.split_first_mut() else { return };
        for (i, &dof) in self.evaluator.locked().iter().enumerate() {
            let last = moment.velocity[dof];
            locks.leave_out(i);
            if last.abs() > STANDS && !stop {
                locks.row_mut(i)[dof] = 1.0;
                (locks.lower[i], locks.upper[i]) = (last.min(0.0), last.max(0.0));
            } else {
                b.problem.reference[dof] = 0.0;
                if b.coasting {
                    locks.row_mut(i)[dof] = 1.0;
                    (locks.lower[i], locks.upper[i]) = (0.0, 0.0);
                }
            }
        }
        // A level that was damped holds what its rows reached, which the velocity between need not give up.
        let settled = self.solver.settled().filter(|_| !late).unwrap_or(&self.problem);
        for (i, ((to, from), kept)) in levels.iter_mut().zip(&settled.levels).zip(&b.kept).enumerate() {
            if from.hard || (*kept && !late) {
                to.copy_from(from);
                to.damping = 0.0;
            } else {
                (0..to.rows()).for_each(|i| to.leave_out(i));
            }
            if from.hard {
                self.evaluator.coasting().give_back(i, !stop, to);
            }
        }
        if lasts {
            b.give_back_accelerations();
        }
        b.solver.solve(&b.problem, &mut b.solution);
    }

    /// The velocity of the last tick.
    pub(super) fn velocity(&self) -> &[f64] {
        if self.is_between() || self.late { &self.blend.solution.x } else { &self.solution.x }
    }

    /// Names of the rows of a level that were not met at the last tick, as `task: row`.
    pub(super) fn unmet(&self, level: usize) -> Vec<String> {
        let Some(l) = self.solution.levels.get(level) else { return Vec::new() };
        if l.status == LevelStatus::NotSolved {
            return Vec::new();
        }
        let members = self.evaluator.members().iter().filter(|m| m.level == level);
        members
            .flat_map(|m| m.rows.clone().zip(&m.row_info).map(move |(r, info)| (r, m, info)))
            .filter(|(r, _, _)| l.active.get(*r) == Some(&solver::Active::Violated))
            .map(|(_, m, info)| format!("`{}`, {}", m.name, info.name))
            .collect()
    }
}

/// The same for the velocity between, whose problem has one more level on top.
fn usable_between(solution: &Solution, evaluator: &Evaluator) -> Result<(), Fault> {
    match solution.status {
        Status::Optimal => usable(solution, evaluator),
        Status::Infeasible { level } => Err(Fault::Infeasible { level: level.saturating_sub(1) }),
        Status::OutOfTime { .. } => Err(Fault::Solver { level: 0 }),
        Status::Failed { level } | Status::Unproven { level } | Status::NotFinite { level, .. } => {
            Err(Fault::Solver { level: level.saturating_sub(1) })
        }
    }
}

/// Whether an answer may be used.
fn usable(solution: &Solution, evaluator: &Evaluator) -> Result<(), Fault> {
    match solution.status {
        Status::Optimal if solution.x.iter().all(|v| v.is_finite()) => Ok(()),
        Status::Optimal => Err(Fault::Solver { level: 0 }),
        Status::Infeasible { level } => Err(Fault::Infeasible { level }),
        Status::OutOfTime { .. } => Err(Fault::Solver { level: 0 }),
        Status::Failed { level } | Status::Unproven { level } => Err(Fault::Solver { level }),
        Status::NotFinite { level, row } => {
            let member = evaluator.members().iter().position(|m| m.level == level && m.rows.contains(&row));
            Err(match member {
                Some(i) => Fault::NotFinite { member: i, row: row - evaluator.members()[i].rows.start },
                None => Fault::Solver { level },
            })
        }
    }
}

/// A program with one more stack, which holds nothing: the robot stands.
pub(super) fn standing(program: &Program) -> Program {
    let mut program = program.clone();
    program.stacks.push(StackProgram { name: String::new(), locked: Vec::new(), levels: Vec::new() });
    program
}

/// For each pair of stages how many levels they share, from the top: `common[from][to]`.
pub(super) fn common_levels(program: &Program, stages: &[Stage]) -> Vec<Vec<usize>> {
    let of = |s: &Stage| program.stacks.get(s.stack);
    let pair = |a: &Stage, b: &Stage| of(a).zip(of(b)).map_or(0, |(a, b)| in_common(program, a, b));
    stages.iter().map(|a| stages.iter().map(|b| pair(a, b)).collect()).collect()
}
