//! The page of the supervisor of a schedule.

use mission::kinds::schedule::execution::{AgentView, Doing, Execution, RobotView, Stage};
use mission::kinds::schedule::problem::{Distances, Problem};
use mission::plan::{Plan, Status};

use super::view::diary::Diary;
use super::view::{AgentRow, RobotRow, SupervisorView, Trouble};
use super::words::{self, written};

/// Status of the plan if there is none.
pub const NO_PLAN: &str = "no plan";

/// Returns the page of the supervisor; the state of the pages is added by the server's routes.
pub fn supervisor(execution: &Execution, diary: &Diary) -> SupervisorView {
    let (plan, problem) = (execution.plan(), execution.problem());
    let outcome = execution.statistics();
    let straight = problem.distances == Distances::Straight;
    let robots = (0..problem.robots.len()).filter_map(|m| execution.robot(m)).enumerate().map(|(m, robot)| RobotRow {
        name: words::robot(problem, m).into(),
        doing: stage(problem, &robot),
        at: straight.then_some(robot.position),
        lost: robot.stage == Stage::Lost,
        trouble: match robot.stage {
            Stage::Serving => Trouble { until: robot.until, fails: true },
            _ => Trouble::default(),
        },
    });
    let agents = (0..problem.agents.len()).filter_map(|a| execution.agent(a)).enumerate().map(|(a, agent)| AgentRow {
        name: words::agent(problem, a).into(),
        doing: work(&agent),
        page: String::new(),
        paged: false,
        lost: agent.doing == Doing::Lost,
        // Its service is reported at the robot.
        trouble: match agent.doing {
            Doing::Working => Trouble { until: agent.until, fails: false },
            _ => Trouble::default(),
        },
    });
    let stands = execution.stranded().is_none();
    let ends = plan.end().filter(|_| stands).map(|end| format!("ends at {}, ", written(end))).unwrap_or_default();
    SupervisorView {
        status: if stands { status(plan) } else { NO_PLAN.into() },
        numbers: format!("{ends}moved {}, planned anew {}", times(outcome.reschedules), times(outcome.reallocations)),
        over: match execution.stranded() {
            _ if execution.done() => Some("The mission is done: everything is served that can be.".into()),
            Some(why) => Some(format!("There is no plan any more: {why}.")),
            None => None,
        },
        note: None,
        moves: true,
        agents: agents.collect(),
        robots: robots.collect(),
        events: diary.events(),
        drawing: execution.records().len(),
    }
}

/// Returns a number of repetitions in words.
pub fn times(n: usize) -> String {
    match n {
        0 => "never".to_string(),
        1 => "once".to_string(),
        n => format!("{n} times"),
    }
}

/// Returns the status of a plan in words.
pub fn status<A>(plan: &Plan<A>) -> String {
    match &plan.status {
        Status::Proven { .. } => format!("cost {:.3}, no plan costs less ({})", plan.cost, plan.engine),
        Status::Gap { gap, .. } => {
            format!("cost {:.3}, at most {:.1} % above the least ({})", plan.cost, 100.0 * gap, plan.engine)
        }
        Status::Unbounded { .. } => format!("cost {:.3} ({})", plan.cost, plan.engine),
    }
}

fn stage(problem: &Problem, robot: &RobotView) -> String {
    let whom = robot.target.map_or("?", |target| words::agent(problem, target.agent));
    match robot.stage {
        Stage::Home => {
            robot.until.map_or("at its depot".into(), |until| format!("at its depot until {}", written(until)))
        }
        Stage::Going => format!("goes to {whom}"),
        Stage::Waiting => format!("waits near {whom}"),
        Stage::Approaching => format!("comes up to {whom}"),
        Stage::Serving => format!("serves {whom}"),
        Stage::Returning => "goes back".into(),
        Stage::Unloading => "at its depot, unloading".into(),
        Stage::Recalled => "goes back, the service was broken off".into(),
        Stage::Lost => "broken down".into(),
    }
}

fn work(agent: &AgentView) -> String {
    let number = agent.operation.map_or(0, |operation| operation + 1);
    match agent.doing {
        Doing::Ready => format!("before operation {number}"),
        Doing::Working => agent.until.map_or_else(
            || format!("operation {number}"),
            |until| format!("operation {number}, until {}", written(until)),
        ),
        Doing::Waiting => format!("waits after operation {number}"),
        Doing::Served => "is served".into(),
        Doing::Finished => "finished".into(),
        Doing::Lost => "left".into(),
    }
}
