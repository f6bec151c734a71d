//! Warns of people whom nothing protects: a person, or a point of a person, in no limit and in no condition; a person in the
//! limits of one moving state of the machine and in none of another one.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use names::list;
use runtime::program::{HumanProgram, Program, Subject, Times};
use runtime::{Evaluator, RestInputs};
use solver::Problem;
use stdlib_tasks::task::RowKind;

use crate::checks::{Checked, readings};

/// Velocity of a row (m/s or rad/s) up to which it counts as still.
const STILL: f64 = 1e-6;

/// Times (s) at which a stack is looked at for motion.
const TIMES: [f64; 5] = [0.0, 0.3, 1.1, 2.7, 7.9];

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let known = Known::new(c);
    for human in &c.program.interface.humans {
        let Some(declared) = readings::human(c.expanded, &human.name) else { continue };
        // A person whom nothing uses is reported already.
        if out.iter().any(|d| d.code == "HQ0203" && d.primary.span == declared.name.span) {
            continue;
        }
        let open = known.unused_points(c.program, human);
        let expected = known.expected(c.program, human);
        if open.len() == human.points.len() && expected {
            continue;
        }
        if open.len() == human.points.len() {
            out.push(
                Diagnostic::warning("HQ0553", declared.name.span, format!("nothing keeps the robot away from `{}`", human.name))
                    .here("a person whose place no task and no condition uses")
                    .note("the robot moves as if the person were not there")
                    .help(format!(
                        "`keep` a distance, write a `speed_separation`, or let the machine stop when the person is near `{}`",
                        human.name
                    )),
            );
            continue;
        }
        if let Some(first) = open.first() {
            let item = declared.body.get("points").and_then(|e| e.value.items().get(*first));
            let names: Vec<&str> = open.iter().map(|&i| point(c.program, human, i)).collect();
            let at = item.map_or(declared.name.span, |v| v.span);
            out.push(
                Diagnostic::warning(
                    "HQ0554",
                    at,
                    format!("nothing keeps the robot away from {}", list(names.iter().copied(), 6)),
                )
                .here("tracked, and in no limit and no condition")
                .note("other points of the person are kept away from, and hands are ahead of the chest")
                .help(
                    "write the limit for each point with `for`, or a distance to the whole person; or remove the point",
                ),
            );
        }
        known.one_state_only(c, human, out);
    }
}

/// Name of a point.
fn point<'p>(program: &'p Program, human: &HumanProgram, index: usize) -> &'p str {
    let signal = human.points.get(index).and_then(|&s| program.interface.signals.get(s));
    signal.map_or("", |s| s.name.as_str())
}

/// Numbers that the tasks and conditions of a program read.
struct Known {
    /// Limits, with the numbers that they read.
    limits: Vec<(usize, BTreeSet<usize>)>,
    /// Numbers that tasks and conditions read.
    read: BTreeSet<usize>,
}

impl Known {
    fn new(c: &Checked) -> Known {
        let limits = readings::limits(c.program);
        let mut read = readings::of_conditions(c);
        read.extend((0..c.program.tasks.len()).flat_map(|task| readings::of_task(c.program, task)));
        read.extend(readings::of_fields(c.program));
        Known { limits, read }
    }

    /// True if an expectation of a scenario is about a person, so that the distance is at least tested.
    fn expected(&self, program: &Program, human: &HumanProgram) -> bool {
        let numbers: BTreeSet<usize> = readings::points(program, human).flat_map(|s| s.at..s.at + s.width()).collect();
        program.scenarios.iter().any(|scenario| {
            let table = scenario.table(program);
            let own: BTreeSet<usize> = numbers.iter().map(|&n| table.signal(n)).collect();
            scenario.predicates.iter().any(|p| p.value.inputs.iter().any(|input| own.contains(input)))
        })
    }

    /// Points of a person whose position nothing reads.
    fn unused_points(&self, program: &Program, human: &HumanProgram) -> Vec<usize> {
        let all = readings::points(program, human).enumerate();
        all.filter(|(_, s)| !readings::position(s).any(|n| self.read.contains(&n))).map(|(i, _)| i).collect()
    }

    /// Warns of moving stacks of the machine without a limit for a person whom the limits of another one concern.
    fn one_state_only(&self, c: &Checked, human: &HumanProgram, out: &mut Vec<Diagnostic>) {
        let (Subject::Machine, Some(machine), Some(places)) =
            (c.program.run.subject, &c.program.machine, &c.places.machine)
        else {
            return;
        };
        let positions: BTreeSet<usize> = readings::points(c.program, human).flat_map(readings::position).collect();
        let guards: Vec<usize> =
            self.limits.iter().filter(|(_, n)| !n.is_disjoint(&positions)).map(|(task, _)| *task).collect();
        let guard = |stack: usize| {
            let members = c.program.stacks[stack].levels.iter().flat_map(|l| &l.members);
            members.map(|m| m.task).find(|task| guards.contains(task))
        };
        // A limit on a hard level that is missing in another state is reported by the checks of the machine.
        let hard = |stack: usize| {
            let levels = c.program.stacks[stack].levels.iter().filter(|l| l.hard);
            levels.flat_map(|l| &l.members).any(|m| guards.contains(&m.task))
        };
        let stacks = c.program.run_stacks();
        let Some((guarded, task)) =
            stacks.iter().filter(|&&s| !hard(s) && moves(c, s)).find_map(|&s| Some((s, guard(s)?)))
        else {
            return;
        };
        // A condition on the person can end the state, or begin it.
        let own: BTreeSet<usize> = readings::points(c.program, human).flat_map(|s| s.at..s.at + s.width()).collect();
        let asks = |state: usize, transition: usize| {
            let condition = places.transitions[state].get(transition).and_then(|t| t.condition);
            condition.is_some_and(|node| !readings::of_nodes(c, &[node]).is_disjoint(&own))
        };
        let watched = |state: usize| {
            let leaves = |s: usize| (0..machine.states[s].transitions.len()).any(|t| asks(s, t));
            let enters = |s: usize| {
                let of = machine.states[s].transitions.iter().enumerate();
                of.into_iter().any(|(t, transition)| machine.leaves(transition.target).contains(&state) && asks(s, t))
            };
            machine.path(state).any(leaves) || (0..machine.states.len()).any(enters)
        };
        for &stack in stacks.iter().filter(|&&s| guard(s).is_none()) {
            let mut states = machine.naming(stack).into_iter();
            if states.any(watched) || !moves(c, stack) {
                continue;
            }
            let name = &c.program.stacks[stack].name;
            out.push(
                Diagnostic::warning(
                    "HQ0555",
                    c.places.stacks[stack].0,
                    format!("`{name}` moves the robot, and does not keep it away from `{}`", human.name),
                )
                .label(
                    c.places.stacks[guarded].0,
                    format!("`{}` does, with `{}`", c.program.stacks[guarded].name, c.program.tasks[task].name),
                )
                .note("the person can be as near in the one state of the machine as in the other")
                .help(format!("put `{}` into `{name}` too", c.program.tasks[task].name)),
            );
        }
    }
}

/// True if a target of a stack moves the robot by itself: it is not met where the stack is entered, or later. Signals are
/// absent, or present with zeros.
pub(in crate::checks) fn moves(c: &Checked, stack: usize) -> bool {
    let home = &c.program.robot.home;
    let moving = |evaluator: &mut Evaluator, problem: &mut Problem| {
        [RestInputs::new(c.program), RestInputs::present(c.program)].iter().any(|rest| {
            evaluator.enter(home, rest.at(Times::default()));
            TIMES.iter().any(|&t| {
                let inputs = rest.at(Times { t, time: t });
                if evaluator.update(home, inputs, problem).is_err() {
                    return false;
                }
                evaluator.members().iter().filter(|m| m.row_kind == RowKind::Equality).any(|m| {
                    let level = &problem.levels[m.level];
                    m.rows.clone().any(|r| level.lower[r].abs() > STILL)
                })
            })
        })
    };
    c.stacks.with(stack, moving).unwrap_or(false)
}
