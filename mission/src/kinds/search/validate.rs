//! Validator of plans: checks a plan from the problem alone, with its own geometry of ways and its own account of rewards.
//! It shares only data types with the planner.

use std::fmt;

use super::geometry::{Point, Pose, edges, inside, segments};
use super::plan::{Activity, Phase, Plan};
use super::problem::{EMPTY, Problem, Source, SourceKind, Travel};
use super::validate_looks::{Looks, Steps};
use super::validate_map::enters_blocked;

/// Tolerance for times (s), lengths (m) and rewards relative to the largest.
const TOLERANCE: f64 = 1e-6;

/// A violated constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation(pub String);

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Returns the constraints that a plan violates.
pub fn validate(problem: &Problem, plan: &Plan) -> Vec<Violation> {
    let mut found = Vec::new();
    for activity in &plan.activities {
        if activity.agent >= problem.agents.len() || activity.way.is_empty() {
            return vec![Violation("an activity is of nobody, or nowhere".into())];
        }
        if activity.source.is_some_and(|source| source >= problem.sources.len()) {
            return vec![Violation("an activity is for a source that does not exist".into())];
        }
    }
    for agent in 0..problem.agents.len() {
        sequence(problem, plan, agent, &mut found);
    }
    if found.is_empty() {
        let reward = Account::new(problem, plan).total(&mut found);
        if (reward + plan.cost).abs() > TOLERANCE * reward.abs().max(1.0) {
            let text = format!("the team collects {reward}, and the plan says {}", -plan.cost);
            found.push(Violation(text));
        }
    }
    found
}

/// The activities of an agent: one after the other without a gap or a jump, at its speed, around walls, within the horizon. One
/// that has begun takes as long as it takes.
fn sequence(problem: &Problem, plan: &Plan, agent: usize, found: &mut Vec<Violation>) {
    let who = &problem.agents[agent];
    let mut wrong = |what: String| found.push(Violation(format!("{}: {what}", who.name)));
    let (mut time, mut at, mut first) = (problem.start, who.start, true);
    for activity in plan.activities.iter().filter(|activity| activity.agent == agent) {
        if who.lost {
            return wrong("it takes no part, and has an activity".into());
        }
        let Activity { start, end, phase, way, .. } = activity;
        if !(start.is_finite() && end.is_finite()) || (start - time).abs() > TOLERANCE || *end < start - TOLERANCE {
            wrong(format!(
                "an activity from {start} s to {end} s does not follow the one before, which ends at {time} s"
            ));
        }
        if activity.begun && !first {
            wrong("an activity that has begun comes after another one".into());
        }
        // A way that was begun before the goal was told, and any that leads there, is good.
        if let Some(told) = who.told.filter(|_| first && !activity.begun) {
            let ends = way[way.len() - 1];
            if *phase != Phase::Going || f64::hypot(ends[0] - told[0], ends[1] - told[1]) > TOLERANCE {
                wrong(format!("somebody has told it to go to {told:?}, and it does something else first"));
            }
        }
        first = false;
        if *end > problem.end() + TOLERANCE {
            wrong(format!("an activity ends at {end} s, behind the time of the plan"));
        }
        if f64::hypot(way[0][0] - at[0], way[0][1] - at[1]) > TOLERANCE {
            wrong(format!("it is at {at:?}, and an activity begins at {:?}", way[0]));
        }
        match phase {
            Phase::Going => {
                let metres = length(way);
                if !activity.begun && (metres - who.speed * (end - start)).abs() > TOLERANCE * metres.max(1.0) {
                    wrong(format!("{metres} m take {} s at {} m/s", end - start, who.speed));
                }
                if let Some(wall) = way.windows(2).find_map(|w| blocked(problem, agent, w[0], w[1])) {
                    wrong(format!("a way is nearer to {wall} than its radius"));
                }
                let map = problem.occupancy.as_ref();
                if let Some(at) = map.and_then(|map| enters_blocked(map, who.radius - TOLERANCE, way)) {
                    wrong(format!(
                        "a way is nearer than its radius to a cell of the map at ({:.3}, {:.3}) m",
                        at[0], at[1]
                    ));
                }
            }
            Phase::Staying | Phase::Waiting if way.len() != 1 => wrong("it moves while it stays".into()),
            Phase::Staying | Phase::Waiting => {}
        }
        if let Some(awaited) = activity.awaits {
            let of = plan.activities.iter().filter(|other| other.agent == awaited.agent).nth(awaited.number);
            if of.is_none_or(|of| (of.end - end).abs() > TOLERANCE) {
                wrong(format!("it waits until {end} s for an activity that ends at another time"));
            }
        }
        if *phase == Phase::Staying {
            match activity.source {
                Some(source) if !problem.consumes(agent, source) => {
                    wrong("it stays at a source that it may not consume".into());
                }
                None if who.sees.is_none() || problem.objects.iter().all(|object| object.found >= object.count) => {
                    wrong("it stays to look for what is hidden, and does not see or has nothing to find".into());
                }
                _ => {}
            }
        }
        time = *end;
        at = way[way.len() - 1];
    }
}

/// The wall, or the edge of the area, that is too near to a straight motion.
fn blocked(problem: &Problem, agent: usize, a: Point, b: Point) -> Option<String> {
    let who = &problem.agents[agent];
    // A wall that is touched is not passed.
    let near = |[c, d]: [Point; 2]| {
        let gap = segments(a, b, c, d);
        gap < who.radius - TOLERANCE || gap <= 0.0
    };
    if !inside(a, &problem.area) || edges(&problem.area).any(near) {
        return Some("the edge of the area".into());
    }
    let walls = problem.walls.iter().enumerate().filter(|(index, _)| !who.passes.contains(index));
    walls.map(|(_, wall)| wall).find_map(|wall| {
        let hit = if wall.solid {
            inside(a, &wall.points) || edges(&wall.points).any(near)
        } else {
            wall.points.windows(2).any(|w| near([w[0], w[1]]))
        };
        hit.then(|| wall.name.clone())
    })
}

/// Length of a way (m).
fn length(way: &[Point]) -> f64 {
    way.windows(2).map(|w| f64::hypot(w[1][0] - w[0][0], w[1][1] - w[0][1])).sum()
}

/// The account of rewards over the intervals between the ends of activities, srs (15) to (19). In an activity the rate of a
/// source is that of the middle of a step of at most a tenth of a second; a long one has 256 steps.
struct Account<'a> {
    problem: &'a Problem,
    plan: &'a Plan,
    ends: Vec<f64>,
}

impl Account<'_> {
    fn new<'a>(problem: &'a Problem, plan: &'a Plan) -> Account<'a> {
        let mut ends: Vec<f64> = plan.activities.iter().map(|activity| activity.end).collect();
        ends.push(problem.end());
        ends.retain(|end| *end > problem.start && *end <= problem.end());
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() <= 1e-9);
        Account { problem, plan, ends }
    }

    /// The activity that an agent performs at a time.
    fn doing(&self, agent: usize, time: f64) -> Option<&Activity> {
        self.plan.activities.iter().find(|a| a.agent == agent && a.start <= time && time < a.end)
    }

    /// Pose and speed of an agent at a time.
    fn pose(&self, agent: usize, time: f64) -> (Pose, f64) {
        let who = &self.problem.agents[agent];
        let mut pose = Pose { at: who.start, heading: who.heading };
        for activity in self.plan.activities.iter().filter(|a| a.agent == agent && a.start <= time) {
            if activity.phase != Phase::Going {
                continue;
            }
            let Activity { start, end, .. } = activity;
            let mut left =
                if time < *end { length(&activity.way) * (time - start) / (end - start) } else { f64::INFINITY };
            for w in activity.way.windows(2) {
                let (x, y) = (w[1][0] - w[0][0], w[1][1] - w[0][1]);
                let step = f64::hypot(x, y);
                if step <= 0.0 || left <= 0.0 {
                    continue;
                }
                let share = (left / step).min(1.0);
                pose = Pose { at: [w[0][0] + share * x, w[0][1] + share * y], heading: y.atan2(x) };
                left -= step;
            }
            if time < activity.end {
                return (pose, who.speed);
            }
        }
        (pose, 0.0)
    }

    fn rate(&self, source: &Source, agent: usize, time: f64) -> f64 {
        let (pose, speed) = self.pose(agent, time);
        match (source.kind, source.of) {
            (SourceKind::Action, _) => source.rate_of(Travel { speed, heading: pose.heading }),
            (SourceKind::Interaction, Some(of)) => {
                let (frame, _) = self.pose(of, time);
                let [x, y] = [pose.at[0] - frame.at[0], pose.at[1] - frame.at[1]];
                let (sin, cos) = frame.heading.sin_cos();
                source.rate([x * cos + y * sin, y * cos - x * sin])
            }
            _ => source.rate(pose.at),
        }
    }

    /// Reward that a source produces for an agent between two times that no end of an activity separates.
    fn produced(&self, source: &Source, agent: usize, from: f64, to: f64) -> f64 {
        let moves = self.doing(agent, 0.5 * (from + to)).filter(|activity| activity.phase == Phase::Going);
        let relative = source.kind == SourceKind::Interaction;
        let (begin, end) = match moves {
            Some(activity) if !relative => (activity.start, activity.end),
            _ => (from, to),
        };
        // An activity that has begun has the steps of its way at the speed of the agent.
        let time = match moves {
            Some(activity) if !relative => length(&activity.way) / self.problem.agents[agent].speed,
            _ => end - begin,
        };
        let count = ((time / 0.1 - 1e-6).ceil() as usize).clamp(1, 256);
        let count = if moves.is_none() && !relative { 1 } else { count };
        let width = (end - begin) / count as f64;
        // An agent without further activities consumes nothing.
        let most = if self.doing(agent, 0.5 * (from + to)).is_some() { f64::INFINITY } else { 0.0 };
        let step = |i: usize| {
            let left = begin + i as f64 * width;
            let overlap = (left + width).min(to) - left.max(from);
            if overlap > 0.0 { overlap * self.rate(source, agent, left + 0.5 * width).min(most) } else { 0.0 }
        };
        (0..count).map(step).sum()
    }

    /// The steps of an agent between two times that no end of an activity separates.
    fn steps(&self, agent: usize, from: f64, to: f64) -> Steps {
        let Some(activity) = self.doing(agent, 0.5 * (from + to)) else { return Vec::new() };
        if activity.phase != Phase::Going {
            return vec![(self.pose(agent, 0.5 * (from + to)).0.at, [from, to])];
        }
        let time = length(&activity.way) / self.problem.agents[agent].speed;
        let count = ((time / 0.1 - 1e-6).ceil() as usize).clamp(1, 256);
        let width = (activity.end - activity.start) / count as f64;
        let step = |i: usize| {
            let begin = activity.start + i as f64 * width;
            let times = [begin.max(from), (begin + width).min(to)];
            (times[0] < times[1]).then(|| (self.pose(agent, begin + 0.5 * width).0.at, times))
        };
        (0..count).filter_map(step).collect()
    }

    /// Expected worth of the hidden objects that are detected.
    fn looks(&self) -> f64 {
        let mut looks = Looks::new(self.problem);
        let (mut total, mut from) = (0.0, self.problem.start);
        for to in self.ends.iter().copied() {
            for (agent, who) in self.problem.agents.iter().enumerate().filter(|(_, who)| !who.lost) {
                if let Some(sees) = who.sees {
                    total += looks.total(sees, &self.steps(agent, from, to));
                }
            }
            from = to;
        }
        total
    }

    /// The reward of the team. Pools are never negative, and nothing is taken from a closed source.
    fn total(&self, found: &mut Vec<Violation>) -> f64 {
        let p = self.problem;
        let mut left: Vec<Option<f64>> = p.sources.iter().map(|source| source.pool).collect();
        let (mut total, mut from) = (0.0, p.start);
        for to in self.ends.iter().copied() {
            let empty = |source: &usize| left[*source].is_some_and(|pool| pool <= EMPTY);
            let open: Vec<bool> =
                p.sources.iter().map(|s| s.after.iter().all(empty) && !s.until.iter().any(empty)).collect();
            for (index, source) in p.sources.iter().enumerate().filter(|(index, _)| open[*index]) {
                let takers = (0..p.agents.len()).filter(|agent| p.consumes(*agent, index));
                let takers = takers.filter(|agent| source.kind != SourceKind::Interaction || source.of != Some(*agent));
                let reward: f64 = takers.map(|agent| self.produced(source, agent, from, to)).sum();
                let Some(pool) = left[index] else {
                    total += reward;
                    continue;
                };
                let taken = reward.min(pool);
                total += taken;
                let mut drain = |of: usize, amount: f64| {
                    if let Some(pool) = &mut left[of] {
                        *pool = if *pool - amount <= EMPTY { 0.0 } else { *pool - amount };
                    }
                };
                drain(index, taken);
                for pair in &p.codependent {
                    match pair.of {
                        [a, b] if a == index => drain(b, pair.share * taken),
                        [a, b] if b == index => drain(a, pair.share * taken),
                        _ => {}
                    }
                }
            }
            from = to;
        }
        if p.objects.iter().any(|object| object.found < object.count) {
            let worth: f64 = p.objects.iter().map(|of| of.worth * (of.count - of.found) as f64).sum();
            let looks = self.looks();
            if looks > worth * (1.0 + TOLERANCE) {
                found.push(Violation(format!("the team expects {looks} of objects worth {worth}")));
            }
            return total + looks;
        }
        let held: f64 = p.sources.iter().filter_map(|source| source.pool).sum();
        if !total.is_finite() || (p.sources.iter().all(|s| s.pool.is_some()) && total > held * (1.0 + TOLERANCE)) {
            found.push(Violation(format!("the team collects {total} of {held}")));
        }
        total
    }
}
