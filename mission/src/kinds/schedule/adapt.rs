//! Adaptation of a problem to feedback of people: satisfaction, weights, speeds and waiting distances; thesis 5.4.
//!
//! Corrected: the efficiency of a person is `min phi / phi_a`, which lies in 0 to 1 (printed inverted); (5.16) and
//! (5.17) use the weighted satisfaction `eta`; the scaling of a slower robot's bounds is `mu_m / mu_m*`, as Algorithm 2
//! has it.

use serde::{Deserialize, Serialize};

pub use super::blocks::Adaptation;
use super::problem::{AgentKind, Approach, Problem, WorkingAgent};
use crate::numbers::MAX_NUMBER;
use crate::numbers::Range;

/// Feedback of a person on a service.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feedback {
    /// Index of the person among the agents.
    pub agent: usize,
    /// Number of the operation that was served, from 0.
    pub operation: usize,
    /// Index of the robot `m*` that served.
    pub robot: usize,
    /// Speed of its approach (m/s).
    pub speed: f64,
    /// `f^w`, -1 to 1: the wait was too short (-1) or too long (1).
    pub wait: f64,
    /// `f^v`, -1 to 1: the robot came too fast (-1) or too slowly (1).
    pub approach: f64,
    /// `f^l` (m): requested increase of the waiting distance.
    pub distance: f64,
}

/// Satisfaction of a person, `eta^w` and `eta^v`, each -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Satisfaction {
    /// Satisfaction with the waits: positive if they are too long.
    pub wait: f64,
    /// Satisfaction with the approaches: positive if they are too slow.
    pub approach: f64,
}

/// Reason why a feedback is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum NoFeedback {
    #[error("there is no person with number {agent}")]
    NoPerson { agent: usize },
    #[error("the person has no operation {operation}")]
    NoOperation { operation: usize },
    #[error("there is no robot with number {robot}")]
    NoRobot { robot: usize },
    #[error("a feedback must lie between -1 and 1, and is {value}")]
    Outside { value: f64 },
    #[error("a number is not finite, or a speed not more than 0")]
    NotANumber,
}

/// Computes the satisfaction `eta_i = theta f_i + (1 - theta) eta_{i-1}`; the first feedback is taken unchanged.
pub fn satisfaction(previous: Option<Satisfaction>, feedback: &Feedback, memory: f64) -> Satisfaction {
    let Some(previous) = previous else { return Satisfaction { wait: feedback.wait, approach: feedback.approach } };
    let mix = |now: f64, before: f64| memory * now + (1.0 - memory) * before;
    Satisfaction { wait: mix(feedback.wait, previous.wait), approach: mix(feedback.approach, previous.approach) }
}

/// Computes the efficiency of a person, `rho_a^e = min phi / phi_a` over people, 0 to 1; 1 for the fastest.
pub fn efficiency(problem: &Problem, agent: usize) -> f64 {
    let people = problem.agents.iter().filter(|who| who.kind == AgentKind::Human);
    let least = people.map(|who| who.duration.mean).fold(f64::INFINITY, f64::min);
    problem.agents.get(agent).map_or(0.0, |who| least / who.duration.mean)
}

/// Applies a person's feedback: returns the adapted problem and the person's new satisfaction. Changes the weights of
/// later waits and approaches by (5.16) and (5.17), the speeds by Algorithm 2, the waiting distances by (5.18), and the
/// wait limit in proportion to the feedback on the wait.
///
/// # Errors
///
/// The agent is not a person, the operation or the robot does not exist, or a value is outside its range.
pub fn adapt(
    problem: &Problem,
    previous: Option<Satisfaction>,
    feedback: &Feedback,
    constants: &Adaptation,
) -> Result<(Problem, Satisfaction), NoFeedback> {
    check(problem, feedback)?;
    let now = satisfaction(previous, feedback, constants.memory);
    let mut adapted = problem.clone();
    let priority = efficiency(problem, feedback.agent) + problem.agents[feedback.agent].severity;
    let alpha = problem.wait_weight(feedback.agent, feedback.operation) + constants.wait_gain * priority * now.wait;
    let zeta =
        problem.approach_weight(feedback.agent, feedback.operation) - constants.approach_gain * priority * now.approach;
    let declared: Vec<f64> = (0..problem.agents[feedback.agent].operations)
        .map(|operation| problem.wait_weight(feedback.agent, operation))
        .collect();
    let who = &mut adapted.agents[feedback.agent];
    limit(who, feedback.wait, declared, constants.wait_step);
    later(&mut who.wait_weights, who.operations, feedback.operation, alpha.max(0.0));
    later(&mut who.approach_weights, who.operations, feedback.operation, zeta.max(0.0));
    speeds(problem, who, feedback, now.approach, constants.margin);
    distances(problem, who, feedback);
    Ok((adapted, now))
}

fn check(problem: &Problem, feedback: &Feedback) -> Result<(), NoFeedback> {
    let Feedback { agent, operation, robot, speed, wait, approach, distance } = *feedback;
    let who = problem.agents.get(agent).filter(|who| who.kind == AgentKind::Human);
    let who = who.ok_or(NoFeedback::NoPerson { agent })?;
    if operation >= who.operations {
        return Err(NoFeedback::NoOperation { operation });
    }
    if robot >= problem.robots.len() {
        return Err(NoFeedback::NoRobot { robot });
    }
    if !distance.is_finite() || !speed.is_finite() || speed <= 0.0 {
        return Err(NoFeedback::NotANumber);
    }
    let outside = [wait, approach].into_iter().find(|value| !(-1.0..=1.0).contains(value));
    outside.map_or(Ok(()), |value| Err(NoFeedback::Outside { value }))
}

/// Our addition: moves the limit of a person's waits by up to `step`, opposite to the sign of `f^w`. The time beyond
/// the limit keeps at least the weight it had before the first feedback on waits. Without a limit, a wait of weight
/// zero would take minutes even if the person asked only for some more seconds.
fn limit(who: &mut WorkingAgent, wait: f64, declared: Vec<f64>, step: f64) {
    if wait == 0.0 {
        return;
    }
    if who.limit_weights.is_empty() {
        who.limit_weights = declared;
    }
    who.wait_limit = (who.wait_limit - step * wait).clamp(0.0, MAX_NUMBER);
}

/// Sets the weight of all operations after `operation`.
fn later(weights: &mut Vec<f64>, count: usize, operation: usize, weight: f64) {
    weights.resize(count, 1.0);
    weights.iter_mut().skip(operation + 1).for_each(|later| *later = weight);
}

/// Returns the agent's entry for one robot, and adds an empty one if there is none.
fn own(who: &mut WorkingAgent, robot: usize) -> &mut Approach {
    let place = match who.approaches.iter().position(|approach| approach.robot == robot) {
        Some(place) => place,
        None => {
            who.approaches.push(Approach { robot, speed: None, wait_distance: None });
            who.approaches.len() - 1
        }
    };
    &mut who.approaches[place]
}

/// Adapts the speed ranges by Algorithm 2. Bounds change only if weights have no effect: if the robot already
/// approached at the maximum of all robots' upper bounds for this person, or at the minimum of these.
fn speeds(problem: &Problem, who: &mut WorkingAgent, feedback: &Feedback, eta: f64, margin: f64) {
    let before: Vec<Range> = (0..problem.robots.len()).map(|m| problem.approach(who, m).0).collect();
    let highs = || before.iter().map(|range| range.high);
    let (fastest, slowest) = (highs().fold(0.0, f64::max), highs().fold(f64::INFINITY, f64::min));
    let assigned = problem.robots[feedback.robot].factor;
    let close = 1e-6;
    for (m, range) in before.iter().enumerate() {
        let (robot, cruise) = (&problem.robots[m], problem.robots[m].speed);
        let changed = if eta > 0.0 && feedback.speed >= fastest * (1.0 - close) {
            let ratio = if m == feedback.robot { 1.0 } else { (assigned / robot.factor).min(1.0) };
            let high = ((1.0 + ratio * eta) * range.high).min(cruise.high);
            let low = ((1.0 + ratio * eta) * range.low).min((1.0 - margin) * high);
            Range { low: low.max(cruise.low), high }
        } else if eta < 0.0 && feedback.speed <= slowest * (1.0 + close) {
            let ratio = if m == feedback.robot { 1.0 } else { (robot.factor / assigned).max(1.0) };
            let low = ((1.0 + ratio * eta) * range.low).max(cruise.low);
            let high = ((1.0 + ratio * eta) * range.high).max((1.0 + margin) * low);
            Range { low, high: high.min(cruise.high) }
        } else {
            continue;
        };
        own(who, m).speed = Some(changed);
    }
}

/// Adapts the waiting distances by (5.18): on a request for more distance a more massive robot moves farther away than
/// the assigned one, and on a request for less distance it comes less close.
fn distances(problem: &Problem, who: &mut WorkingAgent, feedback: &Feedback) {
    if feedback.distance == 0.0 {
        return;
    }
    let assigned = problem.robots[feedback.robot].factor;
    for (m, robot) in problem.robots.iter().enumerate() {
        let ratio = if m == feedback.robot {
            1.0
        } else if feedback.distance >= 0.0 {
            (robot.factor / assigned).max(1.0)
        } else {
            (assigned / robot.factor).min(1.0)
        };
        let (_, distance) = problem.approach(who, m);
        own(who, m).wait_distance = Some((distance + ratio * feedback.distance).max(0.0));
    }
}
