//! Search for a posture at which targets of a stack are met and limits hold.
//!
//! The search moves the robot as the controller would, with the rows of the tasks at a fixed moment, but in large steps and
//! without limits of speed: every step removes four fifths of the error if nothing is in the way. It starts at a given posture, and then at
//! random ones, always the same. Where it finds nothing, that is no proof; the messages that rest on it say so.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use runtime::program::{LevelProgram, MemberProgram, Op, Program, StackProgram, TaskProgram, Times, Values};
use runtime::{Evaluator, Member, RestInputs};
use solver::{HierarchicalSolver, Problem, Solution, Status};
use stdlib_tasks::bound::{Bound, BoundParams, Slot};
use stdlib_tasks::dimension::ANGLE;
use stdlib_tasks::task::RowKind;
use stdlib_tasks::turns;

/// Number of random postures from which the search starts anew.
pub(crate) const STARTS: usize = 24;

/// Maximum number of steps from one start.
const STEPS: usize = 80;

/// Largest change of a degree of freedom in a step (rad or m).
const LARGEST: f64 = 0.4;

/// A search ends at a posture where no degree of freedom changes by more than this (rad or m).
const SMALLEST: f64 = 1e-5;

/// Share of an error that a step removes.
const SHARE: f64 = 0.8;

/// Error up to which a target counts as met: in m, rad, or the unit of the value.
const MET: f64 = 5e-3;

/// Margin below zero up to which a limit counts as kept.
const KEPT: f64 = 1e-4;

/// Tolerance of an angle of half a turn (rad).
const HALF_TURN: f64 = 1e-4;

/// Parameter of limits that keeps a reserve against sampling in time.
const RESERVE: &str = "sampled_margin";

/// Targets and limits of a stack, prepared for a search.
pub(crate) struct PostureSearch {
    program: Program,
    evaluator: Evaluator,
    problem: Problem,
    solver: Box<dyn HierarchicalSolver + Send>,
    solution: Solution,
    rest: RestInputs,
    /// Duration of a step (s).
    step: f64,
}

/// A posture where a search ended.
#[derive(Clone, Debug)]
pub(crate) struct Posture {
    /// Configuration.
    pub q: Vec<f64>,
    /// Largest error of a target, or depth of a violated limit, in its unit.
    pub error: f64,
    /// The target or limit with this error: index among the members.
    pub member: usize,
    /// The measure of that target, or row of that limit.
    pub part: usize,
    /// True if the robot did not move at all.
    pub still: bool,
}

impl Posture {
    /// True if all targets are met and all limits hold.
    pub fn is_good(&self) -> bool {
        self.error <= MET
    }
}

/// Tasks of a stack that take part in a search.
pub(crate) struct Parts<'a> {
    /// The stack.
    pub stack: usize,
    /// Its limits.
    pub limits: &'a [MemberProgram],
    /// Its targets.
    pub targets: &'a [MemberProgram],
    /// Values of parameters that replace what the program computes.
    pub fixed: &'a [FixedValue],
}

/// A number that replaces an entry of the table of values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FixedValue {
    /// Index of the entry.
    pub at: usize,
    /// The number.
    pub value: f64,
}

impl PostureSearch {
    /// Prepares a search. `None` if the tasks cannot be built by themselves, or need a signal.
    pub fn new(program: &Program, parts: &Parts) -> Option<PostureSearch> {
        PostureSearch::of_stack(program, reduced(program, parts), parts.fixed)
    }

    /// Prepares a search that moves the robot by the tasks of a stack, with numbers that replace those of the program. `None`
    /// as for [`PostureSearch::new`].
    pub fn of_stack(program: &Program, stack: StackProgram, fixed: &[FixedValue]) -> Option<PostureSearch> {
        let tasks: Vec<usize> = stack.levels.iter().flat_map(|l| &l.members).map(|m| m.task).collect();
        let mut program = alone(program, stack);
        // Below one over the period, so that no gain overshoots.
        let gain = (SHARE / program.robot.period).min(10.0);
        let mut fixed: Vec<FixedValue> = fixed.to_vec();
        for task in tasks {
            let places = gains(&program.tasks[task].params);
            fixed.extend(places.into_iter().map(|at| FixedValue { at, value: gain }));
        }
        // A reserve for sampled time needs the speeds of a run, and keeps no posture away.
        let none = Slot { at: program.values.initial.len(), len: 1 };
        program.values.initial.push(0.0);
        for params in program.tasks.iter_mut().map(|t| &mut t.params) {
            if let Some(reserve @ Bound::Choice(_)) = params.get_mut(RESERVE) {
                *reserve = Bound::Value(none);
            }
        }
        let values = &mut program.values;
        for f in &fixed {
            *values.initial.get_mut(f.at)? = f.value;
        }
        // Targets stand still at the moment of the search.
        let zero = values.tape.ops.len();
        values.tape.ops.push(Op::Const(0.0));
        values.tape.outputs.retain(|o| !fixed.iter().any(|f| f.at == o.at));
        values.tape.outputs.iter_mut().for_each(|o| o.rate = zero);
        let (mut evaluator, problem) = Evaluator::new(&program, 0).ok()?;
        if !evaluator.needs().is_empty() {
            return None;
        }
        let rest = RestInputs::new(&program);
        evaluator.enter(&program.robot.home, rest.at(Times::default()));
        let (solver, solution) = (program.run.solver.solver(&problem), Solution::new(&problem));
        Some(PostureSearch { evaluator, problem, solver, solution, rest, step: SHARE / gain, program })
    }

    /// The tasks, limits before targets.
    pub fn members(&self) -> &[Member] {
        self.evaluator.members()
    }

    /// Searches at time `t` from `start`, and then from random postures until one is good. Returns the best posture;
    /// `None` if rows are undefined at all of them.
    pub fn from(&mut self, start: &[f64], t: f64) -> Option<Posture> {
        let mut best = self.descend(start.to_vec(), t);
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        for _ in 0..STARTS {
            if best.as_ref().is_some_and(Posture::is_good) {
                break;
            }
            let mut unit = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            let mut q = self.program.robot.model.random_configuration(&mut unit);
            self.keep_locked(&mut q);
            let found = self.descend(q, t);
            best = match (best, found) {
                (Some(a), Some(b)) => Some(if b.error < a.error { b } else { a }),
                (a, b) => a.or(b),
            };
        }
        best
    }

    /// Moves from a posture towards the targets until they are met, or nothing moves.
    pub fn descend(&mut self, mut q: Vec<f64>, t: f64) -> Option<Posture> {
        let moment = self.rest.at(Times { t, time: t });
        let mut moved = false;
        let mut end = None;
        for _ in 0..STEPS {
            self.evaluator.update(&q, moment, &mut self.problem).ok()?;
            let (error, member, part) = self.worst()?;
            end = Some(Posture { q: q.clone(), error, member, part, still: !moved });
            if error <= MET {
                break;
            }
            self.solver.solve(&self.problem, &mut self.solution);
            if self.solution.status != Status::Optimal {
                break;
            }
            let largest = self.solution.x.iter().fold(0.0, |m: f64, v| m.max(v.abs())) * self.step;
            if largest < SMALLEST {
                break;
            }
            moved = true;
            let model = &self.program.robot.model;
            model.integrate(&mut q, &self.solution.x, self.step * (LARGEST / largest).min(1.0));
            for d in &model.dofs {
                if let Some(x) = d.q_index.and_then(|i| q.get_mut(i)) {
                    *x = x.max(d.lower).min(d.upper);
                }
            }
        }
        end
    }

    /// Margins of the limits at a posture, each with the index of its member: the smallest of the member's rows.
    pub fn margins(&mut self, q: &[f64], t: f64) -> Option<Vec<f64>> {
        self.evaluator.update(q, self.rest.at(Times { t, time: t }), &mut self.problem).ok()?;
        let all = self.evaluator.margins();
        let least = |m: &Member| all[m.margins.clone()].iter().fold(f64::INFINITY, |a, b| a.min(*b));
        Some(self.evaluator.members().iter().map(least).collect())
    }

    /// Enters the stack at a posture: values of `initial(..)` are captured there.
    pub fn enter(&mut self, q: &[f64]) {
        self.evaluator.enter(q, self.rest.at(Times::default()));
    }

    /// Index of a target that is half a turn away from a posture, so that two ways to it are equally long: an orientation, or
    /// an angle whose error is taken to the nearest turn.
    pub fn half_turn(&mut self, q: &[f64], t: f64) -> Option<usize> {
        self.evaluator.update(q, self.rest.at(Times { t, time: t }), &mut self.problem).ok()?;
        let all = self.evaluator.measures();
        self.evaluator.members().iter().position(|m| {
            let params = &self.program.tasks[m.program_index].params;
            let nearest = matches!(params.get("turns"), Some(Bound::Choice(word)) if word == turns::NEAREST);
            if let Some(Bound::PerJoint(joints)) = params.get("target") {
                return nearest && self.turns_a_joint(m, joints);
            }
            let one_way = |name: &str| match params.get("value") {
                // A number that is no angle on the circle has one way to its target.
                Some(Bound::Expression(e)) if e.outputs.len() == 1 => {
                    !(nearest && e.turning(&self.program.robot.model).is_angle_on_circle())
                }
                Some(_) => false,
                None => {
                    !(name.ends_with("orientation")
                        || params.contains_key("orientation")
                        || params.contains_key("angle"))
                }
            };
            let angles = m.measure_info.iter().zip(&all[m.measures.clone()]).filter(|(i, _)| i.dimension == ANGLE);
            angles.into_iter().any(|(i, x)| (x - PI).abs() < HALF_TURN && !one_way(&i.name))
        })
    }

    /// Returns true if a row of a task that pulls joints to targets asks a joint on the circle for half a turn.
    fn turns_a_joint(&self, member: &Member, joints: &[(usize, Slot)]) -> bool {
        let (lower, gain) = (&self.problem.levels[member.level].lower, SHARE / self.step);
        let rows = member.rows.clone().zip(joints).filter(|(_, (dof, _))| self.program.robot.model.is_on_circle(*dof));
        rows.into_iter().any(|(row, _)| lower.get(row).is_some_and(|v| (v.abs() / gain - PI).abs() < HALF_TURN))
    }

    /// The largest error, or depth of a violated limit, with its member and part; `None` if one is undefined.
    fn worst(&self) -> Option<(f64, usize, usize)> {
        let mut worst = (0.0, 0, 0);
        for (i, m) in self.evaluator.members().iter().enumerate() {
            let numbers = match m.row_kind {
                RowKind::Equality => &self.evaluator.measures()[m.measures.clone()],
                RowKind::Inequality => &self.evaluator.margins()[m.margins.clone()],
            };
            for (part, &x) in numbers.iter().enumerate() {
                // A violated limit counts as far from met, since its tolerance is smaller.
                let error = match m.row_kind {
                    RowKind::Equality => x,
                    RowKind::Inequality if x < -KEPT => MET - x,
                    RowKind::Inequality => 0.0,
                };
                if !error.is_finite() {
                    return None;
                }
                if error > worst.0 {
                    worst = (error, i, part);
                }
            }
        }
        Some(worst)
    }

    /// Locked degrees of freedom stay as they are at home.
    fn keep_locked(&self, q: &mut [f64]) {
        let (robot, home) = (&self.program.robot.model, &self.program.robot.home);
        let locked = self.evaluator.locked();
        for base in robot.bases.iter().filter(|base| base.dofs().any(|dof| locked.contains(&dof))) {
            q[base.coordinates()].copy_from_slice(&home[base.coordinates()]);
        }
        for &dof in locked {
            if let Some(i) = robot.dofs[dof].q_index {
                q[i] = home[i];
            }
        }
    }
}

/// A program with one stack, and nothing that the stack does not need: copies of large programs take long.
pub(crate) fn alone(program: &Program, stack: StackProgram) -> Program {
    let used: BTreeSet<usize> = stack.levels.iter().flat_map(|l| &l.members).map(|m| m.task).collect();
    let unused = || TaskProgram { name: String::new(), kind: String::new(), params: BoundParams::new() };
    let task = |(i, t): (usize, &TaskProgram)| if used.contains(&i) { t.clone() } else { unused() };
    let tasks: Vec<TaskProgram> = program.tasks.iter().enumerate().map(task).collect();
    let slots = tasks.iter().flat_map(|t| t.params.values()).flat_map(|b| b.slots());
    let places: BTreeSet<usize> = slots.flat_map(|s| s.at..s.at + s.len).collect();
    let values = &program.values;
    Program {
        format: program.format,
        name: program.name.clone(),
        title: String::new(),
        robot: program.robot.clone(),
        interface: program.interface.clone(),
        values: Values {
            initial: values.initial.clone(),
            tape: values.tape.only(&places),
            captures: values.captures.clone(),
            ranges: values.ranges.clone(),
        },
        fields: program.fields.clone(),
        obstacles: Vec::new(),
        tasks,
        stacks: vec![stack],
        machine: None,
        run: program.run.clone(),
        scenarios: Vec::new(),
        allowed: Vec::new(),
    }
}

/// The stack of a search: limits above targets, both soft, so that a start outside of the limits moves back inside.
fn reduced(program: &Program, parts: &Parts) -> StackProgram {
    let level = |name: &str, members: &[MemberProgram]| LevelProgram {
        name: name.to_string(),
        hard: false,
        damping: 0.0,
        exact: false,
        members: members.iter().map(|m| MemberProgram { idle: Vec::new(), ..m.clone() }).collect(),
    };
    let of = &program.stacks[parts.stack];
    let mut levels = vec![level("limits", parts.limits), level("targets", parts.targets)];
    levels.retain(|l| !l.members.is_empty());
    StackProgram { levels, ..of.clone() }
}

/// Places of all gains among parameters.
pub(crate) fn gains(params: &BoundParams) -> Vec<usize> {
    let mut places = Vec::new();
    for (name, bound) in params {
        match bound {
            Bound::Expression(_) => {}
            Bound::Group(inner) if name != "gain" => places.extend(gains(inner)),
            bound if name == "gain" => places.extend(bound.slots().into_iter().flat_map(|s| s.at..s.at + s.len)),
            _ => {}
        }
    }
    places
}
