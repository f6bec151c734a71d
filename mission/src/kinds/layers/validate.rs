//! Validation of a layered plan against a problem: checks every constraint (6.8) to (6.14) and the cost, from the
//! plan's activities alone.
//!
//! The validator shares only data types with the planners: it recomputes abilities, distances, speeds, durations and
//! the cost, so that it detects a mistake in the planners' versions.

use serde::{Deserialize, Serialize};

use crate::validate::{self, Constraint, TOLERANCE, tolerance};

use super::plan::{Activity, Plan};

use super::problem::{Agent, Body, Object, Problem, Task};

/// A constraint, with the equation of the thesis if it has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// The plan has the problem's names, finite times, and no activity that ends before it begins or has an unknown
    /// actor.
    Form,
    /// Each task occurs once (6.11).
    Once,
    /// (6.8): a task begins after all tasks of the earlier layers have ended.
    Layers,
    /// (6.9): a task has one object, with the features, and the named one if any; or none if it needs none.
    Object,
    /// (6.10): an object is used by one task.
    ObjectOnce,
    /// (6.11): the agent has the skill, reach, payload and features, and is the named one if any.
    Able,
    /// (6.12): an agent performs one task at a time.
    Overlap,
    /// (6.13): a robot's speed is within its range; a person's is (6.15).
    Speed,
    /// (6.14): a task takes at least its time at its speed.
    Duration,
    /// Tasks that have begun are unchanged.
    Begun,
    /// Tasks that have not begun begin no earlier than the plan is made.
    Past,
    /// The cost is (6.7).
    Cost,
}

impl Constraint<usize> for Rule {
    fn text(&self) -> &'static str {
        match self {
            Rule::Form => "names are those of the problem, times are finite, and each activity has an agent",
            Rule::Once => "each task is performed once (6.11)",
            Rule::Layers => "a task begins after all tasks of the layers before (6.8)",
            Rule::Object => "a task has one object with its features, if it needs one (6.9)",
            Rule::ObjectOnce => "an object is used by one task (6.10)",
            Rule::Able => "a task is performed by an agent that is able to (6.11)",
            Rule::Overlap => "an agent performs one task at a time (6.12)",
            Rule::Speed => "a speed is one that the agent has (6.13)",
            Rule::Duration => "a task takes its time (6.14)",
            Rule::Begun => "activities that have begun are unchanged",
            Rule::Past => "no other activity begins before the time of planning",
            Rule::Cost => "the cost is what the plan costs (6.7)",
        }
    }

    fn work(task: &usize) -> String {
        format!("task {task}")
    }
}

/// A constraint that a plan breaks, of tasks by index.
pub type Violation = validate::Violation<Rule, usize>;

/// Returns all violations of a plan of this problem; empty if the plan may be executed. If [`Problem::check`] reports
/// mistakes, every plan is invalid.
pub fn validate(problem: &Problem, plan: &Plan) -> Vec<Violation> {
    let mut validator = Validator { problem, plan, violations: Vec::new() };
    if !problem.check().is_empty() {
        validator.broken(Rule::Form, None, 0.0);
        return validator.violations;
    }
    let done = validator.form();
    if validator.violations.is_empty() {
        for one in &done {
            validator.one(one);
        }
        validator.pairs(&done);
        validator.cost(&done);
    }
    validator.violations
}

/// A task with its activity in the plan.
struct Done<'a> {
    index: usize,
    task: &'a Task,
    agent: usize,
    who: &'a Agent,
    object: Option<(usize, &'a Object)>,
    activity: &'a Activity,
}

struct Validator<'a> {
    problem: &'a Problem,
    plan: &'a Plan,
    violations: Vec<Violation>,
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    f64::hypot(f64::hypot(x, y), z)
}

impl<'a> Validator<'a> {
    fn broken(&mut self, rule: Rule, task: Option<usize>, by: f64) {
        self.violations.push(Violation::of(rule, task, by));
    }

    /// Checks names, and returns each activity with its task, agent and object.
    fn form(&mut self) -> Vec<Done<'a>> {
        let (problem, plan) = (self.problem, self.plan);
        if !problem.agents.iter().map(|who| &who.name).eq(&plan.members) {
            self.broken(Rule::Form, None, 0.0);
        }
        let mut done: Vec<Done<'a>> = Vec::new();
        for activity in &plan.activities {
            let Activity { agent, task: index, object, .. } = *activity;
            let found = || {
                let (task, who) = (problem.tasks.get(index)?, problem.agents.get(agent)?);
                let object = match object {
                    None => None,
                    Some(object) => Some((object, problem.objects.get(object)?)),
                };
                Some(Done { index, task, agent, who, object, activity })
            };
            let finite = activity.start.is_finite() && activity.end.is_finite();
            let ordered = activity.end >= activity.start - tolerance(activity.start);
            match found().filter(|_| finite && ordered) {
                Some(one) => done.push(one),
                None => self.broken(Rule::Form, Some(index), 0.0),
            }
        }
        for task in 0..problem.tasks.len() {
            if done.iter().filter(|one| one.index == task).count() != 1 {
                self.broken(Rule::Once, Some(task), 0.0);
            }
        }
        done
    }

    /// Computes `d_{a,tau,o}` (m).
    fn way(&self, who: &Agent, task: &Task, object: Option<(usize, &Object)>) -> f64 {
        let mut places = vec![&who.place];
        places.extend(object.map(|(_, thing)| &thing.place));
        places.extend(&task.path);
        if self.problem.returns {
            places.push(&who.place);
        }
        places.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
    }

    /// Checks (6.9), (6.11), (6.13), (6.14), and that a task that has begun is unchanged.
    fn one(&mut self, one: &Done<'a>) {
        let (task, at) = (one.task, Some(one.index));
        let (start, end) = (one.activity.start, one.activity.end);
        if let Some(begun) = self.problem.begun.iter().find(|begun| begun.task == one.index) {
            let same = begun.agent == one.agent && begun.object == one.object.map(|(object, _)| object);
            let off = (begun.start - start).abs().max((begun.end - end).abs());
            if !same || off > tolerance(end) {
                self.broken(Rule::Begun, at, off);
            }
            return;
        }
        if start < self.problem.start - tolerance(start) {
            self.broken(Rule::Past, at, self.problem.start - start);
        }
        let wanted = !task.features.is_empty() || task.object.is_some();
        let fits = match one.object {
            None => !wanted,
            Some((object, thing)) => {
                wanted
                    && task.features.iter().all(|feature| thing.features.contains(feature))
                    && task.object.is_none_or(|named| named == object)
            }
        };
        if !fits {
            self.broken(Rule::Object, at, 0.0);
        }
        let who = one.who;
        let near = |place: &[f64; 3]| who.reach.is_none_or(|reach| distance(&who.place, place) <= reach + 1e-9);
        let skill = who.skills.iter().find(|skill| skill.action == task.action);
        let able = !who.lost
            && task.agent.is_none_or(|named| named == one.agent)
            && task.path.iter().all(near)
            && one.object.is_none_or(|(_, thing)| {
                near(&thing.place)
                    && who.payload.is_none_or(|most| thing.mass <= most)
                    && !thing.features.iter().any(|feature| who.cannot.contains(feature))
            });
        let Some(skill) = skill.filter(|_| able) else {
            self.broken(Rule::Able, at, 0.0);
            return;
        };
        let way = self.way(one.who, one.task, one.object);
        let speed = one.activity.speed.unwrap_or(0.0);
        if (one.activity.speed.is_some()) != (way > 0.0) {
            self.broken(Rule::Speed, at, 0.0);
            return;
        }
        let moving = if way > 0.0 { way / speed } else { 0.0 };
        let off = skill.duration + moving - (end - start);
        let outside = match who.body {
            _ if way <= 0.0 => 0.0,
            Body::Robot { speed: range, .. } => (range.low - speed).max(speed - range.high),
            Body::Human { .. } => (speed - self.pace(who, skill.pace, one.object)).abs(),
        };
        if outside.is_nan() || outside > TOLERANCE {
            self.broken(Rule::Speed, at, outside);
        }
        if off.is_nan() || off > tolerance(end) {
            self.broken(Rule::Duration, at, off);
        }
    }

    /// Computes (6.15) (m/s).
    fn pace(&self, who: &Agent, pace: f64, object: Option<(usize, &Object)>) -> f64 {
        let Body::Human { speed, slowing } = who.body else { return 0.0 };
        let mut least = f64::INFINITY;
        for thing in &self.problem.objects {
            least = least.min(thing.mass);
        }
        let more = object.map_or(0.0, |(_, thing)| thing.mass - least);
        pace * speed / (slowing * more + 1.0)
    }

    /// Checks (6.8), (6.10) and (6.12).
    fn pairs(&mut self, done: &[Done<'a>]) {
        for (number, one) in done.iter().enumerate() {
            for other in &done[..number] {
                let mut broken = |rule, by| {
                    let (at, other) = (Some(one.index), Some(other.index));
                    self.violations.push(Violation { rule, at, other, by });
                };
                let (a, b) = (one.activity, other.activity);
                let (early, late) = if one.task.layer < other.task.layer { (a, b) } else { (b, a) };
                if one.task.layer != other.task.layer && late.start < early.end - tolerance(early.end) {
                    broken(Rule::Layers, early.end - late.start);
                }
                if one.object.is_some() && one.object.map(|(o, _)| o) == other.object.map(|(o, _)| o) {
                    broken(Rule::ObjectOnce, 0.0);
                }
                let both = a.end.min(b.end) - a.start.max(b.start);
                if one.agent == other.agent && both > tolerance(a.end) {
                    broken(Rule::Overlap, both);
                }
            }
        }
    }

    /// Checks (6.1) to (6.7).
    fn cost(&mut self, done: &[Done<'a>]) {
        let problem = self.problem;
        // Scales, over all combinations that some agent could perform.
        let (mut farthest, mut longest, mut slowest) = (0.0_f64, 0.0_f64, f64::INFINITY);
        let mut most = vec![0.0_f64; problem.agents.len()];
        let fit = |task: &Task| -> Vec<bool> {
            problem.objects.iter().map(|thing| task.features.is_subset(&thing.features)).collect()
        };
        let fits: Vec<Vec<bool>> = problem.tasks.iter().map(fit).collect();
        for (agent, who) in problem.agents.iter().enumerate() {
            let near = |place: &[f64; 3]| who.reach.is_none_or(|reach| distance(&who.place, place) <= reach);
            let grip = |thing: &Object| {
                near(&thing.place)
                    && who.payload.is_none_or(|payload| thing.mass <= payload)
                    && who.cannot.is_disjoint(&thing.features)
            };
            let grips: Vec<bool> = problem.objects.iter().map(grip).collect();
            for skill in &who.skills {
                longest = longest.max(skill.duration);
                if who.is_human() {
                    slowest = slowest.min(self.pace(who, skill.pace, None));
                    for thing in problem.objects.iter().enumerate() {
                        slowest = slowest.min(self.pace(who, skill.pace, Some(thing)));
                    }
                }
            }
            if let Body::Robot { speed, .. } = who.body {
                slowest = slowest.min(speed.low);
            }
            for (index, task) in problem.tasks.iter().enumerate() {
                let Some(skill) = who.skills.iter().find(|skill| skill.action == task.action) else { continue };
                let wanted = !task.features.is_empty() || task.object.is_some();
                let reaches = task.path.iter().all(near);
                let own = problem.begun.iter().find(|begun| begun.task == index && begun.agent == agent);
                let things = problem.objects.iter().enumerate().map(Some).chain([None]);
                for object in things.filter(|object| object.is_some() == wanted) {
                    let begun = own.is_some_and(|begun| begun.object == object.map(|(number, _)| number));
                    let could = reaches
                        && object.is_none_or(|(number, _)| {
                            let named = task.features.is_empty() && task.object != Some(number);
                            !named && fits[index][number] && grips[number]
                        });
                    if !could && !begun {
                        continue;
                    }
                    let way = self.way(who, task, object);
                    farthest = farthest.max(way);
                    if let Some((_, thing)) = object.filter(|_| who.is_human()) {
                        let time = skill.duration + way / self.pace(who, skill.pace, object);
                        most[agent] = most[agent].max(time * thing.mass);
                    }
                }
            }
        }
        let (mut work, mut energy, mut end) = (0.0, 0.0, 0.0_f64);
        for one in done {
            end = end.max(one.activity.end);
            match one.who.body {
                Body::Human { .. } => {
                    let mass = one.object.map_or(0.0, |(_, thing)| thing.mass);
                    let length = one.activity.end - one.activity.start;
                    if most[one.agent] > 0.0 {
                        work += length * mass / most[one.agent];
                    }
                }
                Body::Robot { speed, energy: of } => {
                    let way = self.way(one.who, one.task, one.object);
                    let v = one.activity.speed.unwrap_or(1.0);
                    let worst = (of.standby / speed.low + of.friction + of.drag * speed.high) * farthest;
                    if worst > 0.0 && way > 0.0 {
                        energy += (of.standby + of.friction * v + of.drag * v * v) * (way / v) / worst;
                    }
                }
            }
        }
        let whole = problem.tasks.len() as f64 * (longest + if farthest > 0.0 { farthest / slowest } else { 0.0 });
        let weights = problem.weights;
        let cost = weights.workload * work + weights.energy * energy + weights.makespan * end / whole;
        let off = (cost - self.plan.cost).abs();
        if off.is_nan() || off > TOLERANCE * cost.abs().max(1.0) {
            self.broken(Rule::Cost, None, off);
        }
    }
}
