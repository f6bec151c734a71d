//! The limits and targets of a stack whose numbers are known before the robot moves.

use std::collections::BTreeSet;

use runtime::program::{LevelProgram, MemberProgram, Op, Program, Subject, TaskProgram, Times, Trigger};
use runtime::{Evaluator, Member, RestInputs};
use solver::Problem;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::task::{RowKind, Task};

use super::super::Checked;
use crate::analysis::postures::FixedValue;
use crate::checks::entries;

/// A target of a stack.
pub(super) struct Target {
    /// The task in its level.
    pub member: MemberProgram,
    /// Index of its level.
    pub level: usize,
    /// Its parameters at the end of its trajectories, if they are constant there.
    pub goal: Option<Vec<FixedValue>>,
    /// True if it depends on time alone from the entry of the stack on, which is at home.
    pub timed: bool,
}

/// A limit of a stack whose numbers are constant.
pub(super) struct Limit {
    /// The task in its level.
    pub member: MemberProgram,
    /// Index of its level.
    pub level: usize,
    /// True if the level is hard.
    pub hard: bool,
}

/// Limits of each degree of freedom that the hard levels of a stack set.
pub(super) struct JointLimits {
    /// Speeds, in rad/s or m/s.
    pub speed: Vec<f64>,
    /// Accelerations, in rad/s^2 or m/s^2.
    pub acceleration: Vec<f64>,
}

impl JointLimits {
    /// No limits.
    fn none(nv: usize) -> JointLimits {
        JointLimits { speed: vec![f64::INFINITY; nv], acceleration: vec![f64::INFINITY; nv] }
    }

    /// Adds those of a task.
    fn add(&mut self, task: &dyn Task, values: &[f64]) {
        for (dof, x) in task.speed_limits(values) {
            self.speed[dof] = self.speed[dof].min(x);
        }
        for (dof, x) in task.acceleration_limits() {
            self.acceleration[dof] = self.acceleration[dof].min(x);
        }
    }
}

/// A target of joint velocities.
pub(super) struct VelocityTarget {
    /// The task in its level.
    pub member: MemberProgram,
    /// Degree of freedom of each row.
    pub dofs: Vec<usize>,
}

/// The targets and limits of a stack.
pub(super) struct StackParts {
    /// Targets with an error, which a posture can meet.
    pub targets: Vec<Target>,
    /// Targets of joint velocities that depend on time alone.
    pub velocities: Vec<VelocityTarget>,
    /// Limits of joints on its hard levels.
    pub joint_limits: JointLimits,
    /// Limits of positions.
    pub limits: Vec<Limit>,
    /// Limits that depend on time alone.
    pub moving_limits: Vec<MemberProgram>,
    /// True if the stack is entered at home.
    pub at_home: bool,
    /// Shortest time for which the stack runs (s).
    pub duration: f64,
}

impl StackParts {
    /// Collects the parts.
    pub fn new(c: &Checked, stack: usize) -> StackParts {
        let (program, at_home) = (c.program, entries::at_home(c.program, stack));
        let built = c.stacks.tasks(stack);
        let (mut targets, mut velocities) = (Vec::new(), Vec::new());
        let mut joint_limits = JointLimits::none(program.robot.model.nv());
        let (mut limits, mut moving_limits) = (Vec::new(), Vec::new());
        let levels = program.stacks[stack].levels.iter().enumerate();
        let members = levels.flat_map(|(k, l)| l.members.iter().map(move |m| (k, l, m)));
        for (built, (level, l, m)) in built.iter().zip(members) {
            let (Ok(task), Some(place)) = (&built.task, c.places.tasks.get(m.task)) else { continue };
            if l.hard {
                joint_limits.add(task.as_ref(), &program.values.initial);
            }
            // The target is where the stack is entered.
            if task.remembers_entry() && !at_home {
                continue;
            }
            let numbers = Numbers::of(c, &program.tasks[m.task]);
            match place.kind.row_kind {
                RowKind::Equality if !task.gains(&program.values.initial).is_empty() && numbers.plain => {
                    let timed = at_home && numbers.timed;
                    if numbers.goal.is_some() || timed {
                        targets.push(Target { member: m.clone(), level, goal: numbers.goal, timed });
                    }
                }
                RowKind::Equality if at_home && numbers.timed => {
                    let dofs = task.degrees_of_freedom();
                    velocities.extend(dofs.map(|dofs| VelocityTarget { member: m.clone(), dofs }));
                }
                RowKind::Inequality if numbers.constant && numbers.plain => {
                    limits.push(Limit { member: m.clone(), level, hard: l.hard });
                }
                RowKind::Inequality if at_home && numbers.timed && numbers.plain => moving_limits.push(m.clone()),
                _ => {}
            }
        }
        let limits = of_positions(c, stack, limits);
        StackParts {
            targets,
            velocities,
            joint_limits,
            limits,
            moving_limits,
            at_home,
            duration: duration(program, stack),
        }
    }

    /// The limits that keep a target of this level back: hard ones, and those on levels above.
    pub fn limits_of(&self, level: usize) -> Vec<MemberProgram> {
        self.limits.iter().filter(|l| l.hard || l.level < level).map(|l| l.member.clone()).collect()
    }
}

/// Limits with a margin at rest. Limits of velocities and accelerations have none, and bound no posture.
fn of_positions(c: &Checked, stack: usize, limits: Vec<Limit>) -> Vec<Limit> {
    let home = &c.program.robot.home;
    let rest = RestInputs::present(c.program);
    let bounding = |evaluator: &mut Evaluator, problem: &mut Problem| {
        evaluator.enter(home, rest.at(Times::default()));
        evaluator.update(home, rest.at(Times::default()), problem).ok()?;
        let has_margin = |m: &&Member| evaluator.margins()[m.margins.clone()].iter().any(|h| h.is_finite());
        Some(evaluator.members().iter().filter(has_margin).map(|m| m.program_index).collect())
    };
    let bounding: Option<Option<BTreeSet<usize>>> = c.stacks.with(stack, bounding);
    let bounding = bounding.flatten().unwrap_or_default();
    limits.into_iter().filter(|l| bounding.contains(&l.member.task)).collect()
}

/// Shortest time for which a stack runs (s): that of the run, or the time-out of a state. Zero if an event or a condition can
/// end the state at any time, as a contact ends a motion towards it.
fn duration(program: &Program, stack: usize) -> f64 {
    let machine = program.machine.iter().filter(|_| program.run.subject == Subject::Machine);
    let states = machine.flat_map(|m| m.naming(stack).into_iter().map(|s| &m.states[s]));
    let exits = states.flat_map(|s| &s.transitions).map(|t| match t.trigger {
        Trigger::After(d) => d,
        Trigger::Fault(_) => f64::INFINITY,
        _ => 0.0,
    });
    exits.fold(program.run.duration, f64::min)
}

/// Facts about the numbers of a task.
struct Numbers {
    /// All are constant.
    constant: bool,
    /// Their values at the end of trajectories, for those that move; none if some never stand still.
    goal: Option<Vec<FixedValue>>,
    /// They depend on time and the entry of the stack alone, or on signals that may be absent.
    timed: bool,
    /// No parameter is a safety field or another task.
    plain: bool,
}

impl Numbers {
    fn of(c: &Checked, task: &TaskProgram) -> Numbers {
        let tape = &c.program.values.tape;
        let plain = !task.params.values().any(|b| matches!(b, Bound::Task(_) | Bound::Field(_)));
        let mut numbers = Numbers { constant: true, goal: Some(Vec::new()), timed: true, plain };
        // Gains are replaced in the search.
        let slots = task.params.iter().filter(|(name, _)| *name != "gain").flat_map(|(_, b)| b.slots());
        for slot in slots {
            let places: BTreeSet<usize> = (slot.at..slot.at + slot.len).collect();
            if !tape.outputs.iter().any(|o| places.contains(&o.at)) {
                continue;
            }
            numbers.constant = false;
            let nodes = c.context.table.placed.get(slot.at..slot.at + slot.len).unwrap_or_default();
            let ends = c.context.graph.goal(nodes);
            let ends: Option<Vec<f64>> = ends.iter().map(|&n| c.context.graph.constant(n)).collect();
            numbers.goal = match (numbers.goal.take(), ends) {
                (Some(mut known), Some(ends)) if ends.len() == slot.len => {
                    known.extend(places.iter().zip(ends).map(|(&at, value)| FixedValue { at, value }));
                    Some(known)
                }
                _ => None,
            };
            let reads_state = |op: &Op| matches!(op, Op::State(_));
            numbers.timed &= !tape.only(&places).ops.iter().any(reads_state);
        }
        numbers
    }
}

/// The levels of a stack that contain several targets of one weight, none of them above the first level with targets.
pub(super) fn shared_level<'p>(levels: &'p [LevelProgram], parts: &StackParts) -> Option<(usize, &'p LevelProgram)> {
    let first = parts.targets.iter().map(|t| t.level).min()?;
    let level = &levels[first];
    let of_level: Vec<&Target> = parts.targets.iter().filter(|t| t.level == first).collect();
    let weight = of_level.first()?.member.weight;
    let alike = of_level.len() > 1 && of_level.iter().all(|t| t.member.weight == weight);
    alike.then_some((first, level))
}
