//! A layered plan carried out: tasks take as long as they take, fail, agents are lost; where the plan no longer holds, what
//! has begun is fixed and the rest is planned anew.
//!
//! Discrete events. An agent begins its next task when it is free and all tasks of the layers before are done, so that what
//! is late only moves what comes after it. A task that fails is to be done again, its object where it was. A lost agent
//! drops what it does. What happens is told by the caller, so that the same answers give the same execution.

use super::choose::{Options, Refusal, plan};
use super::problem::{Begun, Problem};
use super::steps::{Step, from_plan};

/// How often a task may be tried.
pub const MOST_TRIES: usize = 16;

/// What becomes of a task that has begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// How long it takes (s); what is no finite number of at least 0 counts as the planned time.
    pub duration: f64,
    /// It is done then; if not, it has failed.
    pub done: bool,
}

/// An agent that takes no part any more from some time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// When (s).
    pub time: f64,
    /// Index of the agent.
    pub agent: usize,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Execution {
    /// What was done, with its true times, in the order in which it ended.
    pub done: Vec<Step>,
    /// What failed or was dropped, until then.
    pub failed: Vec<Step>,
    /// When plans were made (s); the first is the one to begin with.
    pub planned: Vec<f64>,
    /// Why it ended; none: every task is done.
    pub stuck: Option<Stuck>,
}

/// Why an execution ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Stuck {
    /// There is no plan for the rest.
    #[error("there is no plan for what is left: {0}")]
    NoPlan(Refusal),
    /// A task fails again and again.
    #[error("task {task} failed {MOST_TRIES} times")]
    Tries {
        /// Index of the task.
        task: usize,
    },
}

/// A task under way: as it was expected, and when and how it will end.
struct Running {
    step: Step,
    end: f64,
    done: bool,
}

/// Plans and carries out a problem of which nothing has begun. `happens` is asked once for each task that begins.
///
/// # Errors
///
/// There is no plan to begin with.
pub fn execute(
    problem: &Problem,
    options: &Options,
    losses: &[Loss],
    mut happens: impl FnMut(&Step) -> Outcome,
) -> Result<Execution, Refusal> {
    let mut state = State::new(problem, options, losses)?;
    while state.execution.stuck.is_none() && state.execution.done.len() < problem.tasks.len() {
        state.begin(&mut happens);
        let end = state.running.iter().map(|running| running.end).reduce(f64::min);
        let loss = state.losses.last().map(|loss| loss.time.max(state.problem.start));
        match (end, loss) {
            (None, None) => break,
            (end, Some(loss)) if end.is_none_or(|end| loss < end) => state.lose(loss),
            (Some(end), _) => state.end(end),
            (None, Some(loss)) => state.lose(loss),
        }
    }
    Ok(state.execution)
}

struct State<'a> {
    problem: Problem,
    options: &'a Options,
    /// What is planned and has not begun, by start.
    ahead: Vec<Step>,
    running: Vec<Running>,
    /// Still to come, the next one last.
    losses: Vec<Loss>,
    tries: Vec<usize>,
    execution: Execution,
}

impl<'a> State<'a> {
    fn new(problem: &Problem, options: &'a Options, losses: &[Loss]) -> Result<State<'a>, Refusal> {
        let mut losses: Vec<Loss> = losses.iter().copied().filter(|loss| loss.agent < problem.agents.len()).collect();
        losses.sort_by(|a, b| b.time.total_cmp(&a.time).then(b.agent.cmp(&a.agent)));
        let execution = Execution { done: vec![], failed: vec![], planned: vec![], stuck: None };
        let mut state = State {
            problem: problem.clone(),
            options,
            ahead: vec![],
            running: vec![],
            losses,
            tries: vec![0; problem.tasks.len()],
            execution,
        };
        state.plan()?;
        Ok(state)
    }

    /// Plans what has not begun, around what has.
    fn plan(&mut self) -> Result<(), Refusal> {
        let now = self.problem.start;
        let begun = |step: &Step, end: f64| {
            let Step { task, agent, object, speed, start, .. } = *step;
            Begun { task, agent, object, speed, start, end }
        };
        let done = self.execution.done.iter().map(|step| begun(step, step.end));
        let under_way = self.running.iter().map(|running| begun(&running.step, running.step.end.max(now)));
        self.problem.begun = done.chain(under_way).collect();
        let plan = plan(&self.problem, self.options)?;
        self.ahead = from_plan(&self.problem, &plan).into_iter().filter(|step| !step.begun).collect();
        self.ahead.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.task.cmp(&b.task)));
        self.execution.planned.push(now);
        Ok(())
    }

    fn replan(&mut self) {
        if let Err(refusal) = self.plan() {
            self.ahead.clear();
            self.execution.stuck = Some(Stuck::NoPlan(refusal));
        }
    }

    /// Begins what can begin now.
    fn begin(&mut self, happens: &mut impl FnMut(&Step) -> Outcome) {
        let now = self.problem.start;
        let layer = |step: &Step| self.problem.tasks[step.task].layer;
        // The layer under way is the first in which anything is not done.
        let open = self.ahead.iter().chain(self.running.iter().map(|running| &running.step)).map(layer).min();
        let mut next = Vec::new();
        for (index, step) in self.ahead.iter().enumerate() {
            let busy = self.running.iter().any(|running| running.step.agent == step.agent);
            let later = self.ahead[..index].iter().any(|other| other.agent == step.agent);
            if Some(layer(step)) == open && !busy && !later {
                next.push(index);
            }
        }
        for index in next.into_iter().rev() {
            let planned = self.ahead.remove(index);
            let step = Step { start: now, end: now + (planned.end - planned.start), begun: true, ..planned };
            let Outcome { duration, done } = happens(&step);
            let usual = duration.is_finite() && duration >= 0.0;
            let end = if usual { now + duration } else { step.end };
            self.tries[step.task] += 1;
            self.running.push(Running { step, end, done });
        }
    }

    /// Everything that ends at this time ends.
    fn end(&mut self, time: f64) {
        self.problem.start = time;
        let (mut ended, running): (Vec<Running>, Vec<Running>) =
            std::mem::take(&mut self.running).into_iter().partition(|running| running.end <= time);
        self.running = running;
        ended.sort_by_key(|running| running.step.task);
        let mut failed = false;
        for Running { step, end, done } in ended {
            let step = Step { end, ..step };
            if done {
                self.execution.done.push(step);
                continue;
            }
            failed = true;
            self.execution.failed.push(step);
            if self.tries[step.task] >= MOST_TRIES {
                self.execution.stuck = Some(Stuck::Tries { task: step.task });
                return;
            }
        }
        if failed {
            self.replan();
        }
    }

    /// The next agent is lost.
    fn lose(&mut self, time: f64) {
        let Some(loss) = self.losses.pop() else { return };
        self.problem.start = time;
        if self.problem.agents[loss.agent].lost {
            return;
        }
        self.problem.agents[loss.agent].lost = true;
        let (dropped, running): (Vec<Running>, Vec<Running>) =
            std::mem::take(&mut self.running).into_iter().partition(|running| running.step.agent == loss.agent);
        self.running = running;
        let concerned = !dropped.is_empty() || self.ahead.iter().any(|step| step.agent == loss.agent);
        self.execution.failed.extend(dropped.into_iter().map(|running| Step { end: time, ..running.step }));
        if concerned {
            self.replan();
        }
    }
}
