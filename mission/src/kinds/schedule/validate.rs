//! Validation of a plan against a problem: checks every constraint (5.6) to (5.14), from the plan's activities alone.
//!
//! The validator shares only data types with the planners: it recomputes lengths, speed ranges and the normal
//! distribution, so that it detects a mistake in the planners' versions.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::validate::{self, Constraint, TOLERANCE, tolerance};

use super::plan::{Activity, Actor, Phase, Plan, Target};

use super::problem::{Begun, Distances, Problem, WorkingAgent};
use crate::numbers::Range;

/// A constraint, with the equation of the thesis if it has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// The plan has the problem's names, finite times, and no activity that ends before it begins or has an unknown
    /// actor.
    Form,
    /// (5.6): each operation and each phase of its service occurs once, all by one robot.
    Assignment,
    /// (5.7): going takes as long as the robot's speeds allow.
    Going,
    /// (5.8): the approach takes as long as the speeds near the agent allow.
    Proximity,
    /// (5.9): the return and the work at the depot take as long as the robot's speeds allow.
    Depositing,
    /// (5.10): each phase begins at the end of the previous one.
    Order,
    /// (5.11a): serving takes the robot's time.
    ServiceTime,
    /// (5.11b): serving begins when the operation has ended.
    ServiceAfterOperation,
    /// (5.12a): the first operation begins when the plan is made.
    FirstOperation,
    /// (5.12b): an operation begins after the previous one has been served.
    Sequence,
    /// (5.12c), as an equality: the duration of an operation is its quantile at the required confidence.
    OperationTime,
    /// (5.14): a robot does nothing else between going and depositing.
    Overlap,
    /// Operations and services that have begun are unchanged.
    Begun,
    /// Everything that has not begun begins no earlier than the plan is made.
    Past,
    /// An absent robot does not leave for a new service.
    Absent,
    /// The speed in the plan is the length of the leg divided by its duration.
    Speed,
}

impl Constraint<Target> for Rule {
    fn text(&self) -> &'static str {
        match self {
            Rule::Form => "names are those of the problem, times are finite, and each activity has an agent",
            Rule::Assignment => "each operation is served once, by one robot (5.6)",
            Rule::Going => "going respects the robot's speeds (5.7)",
            Rule::Proximity => "the approach respects the speeds near the agent (5.8)",
            Rule::Depositing => "depositing respects the robot's speeds (5.9)",
            Rule::Order => "each phase begins where the one before ends (5.10)",
            Rule::ServiceTime => "serving takes the robot's time (5.11a)",
            Rule::ServiceAfterOperation => "serving begins after the operation (5.11b)",
            Rule::FirstOperation => "the first operation begins with the plan (5.12a)",
            Rule::Sequence => "an operation begins after the service before it (5.12b)",
            Rule::OperationTime => "an operation takes its time at the confidence (5.12c)",
            Rule::Overlap => "a robot does one service at a time (5.14)",
            Rule::Begun => "activities that have begun are unchanged",
            Rule::Past => "no other activity begins before the time of planning",
            Rule::Absent => "a robot that is absent leaves for no new service",
            Rule::Speed => "a speed is the length of the way over its time",
        }
    }

    fn work(target: &Target) -> String {
        format!("operation {} of agent {}", target.operation, target.agent)
    }
}

/// A constraint that a plan breaks, of operations.
pub type Violation = validate::Violation<Rule, Target>;

/// Returns all violations of a plan of this problem; empty if the plan may be executed. If [`Problem::check`] reports
/// mistakes, every plan is invalid.
pub fn validate(problem: &Problem, plan: &Plan) -> Vec<Violation> {
    if !problem.check().is_empty() {
        return vec![Violation::of(Rule::Form, None, 0.0)];
    }
    let mut parts: BTreeMap<Target, Vec<&Activity>> = BTreeMap::new();
    for activity in &plan.activities {
        parts.entry(activity.target).or_default().push(activity);
    }
    let mut validator = Validator { problem, plan, parts, violations: Vec::new() };
    validator.form();
    if validator.violations.is_empty() {
        let services = validator.services();
        validator.overlaps(&services);
    }
    validator.violations
}

/// The activities of one operation, in the order of [`Phase::ALL`], with the serving robot.
struct Service<'a> {
    robot: usize,
    parts: [&'a Activity; 6],
    target: Target,
}

struct Validator<'a> {
    problem: &'a Problem,
    plan: &'a Plan,
    parts: BTreeMap<Target, Vec<&'a Activity>>,
    violations: Vec<Violation>,
}

impl<'a> Validator<'a> {
    fn broken(&mut self, rule: Rule, target: Option<Target>, by: f64) {
        self.violations.push(Violation::of(rule, target, by));
    }

    /// Checks that `value` is at least `least`, both in seconds.
    fn at_least(&mut self, rule: Rule, target: Target, value: f64, least: f64) {
        if value < least - tolerance(least) {
            self.broken(rule, Some(target), least - value);
        }
    }

    /// Checks that `value` equals `wanted`, both in seconds.
    fn equal(&mut self, rule: Rule, target: Target, value: f64, wanted: f64) {
        if (value - wanted).abs() > tolerance(wanted) {
            self.broken(rule, Some(target), (value - wanted).abs());
        }
    }

    fn form(&mut self) {
        let robots = self.problem.robots.iter().map(|robot| &robot.name);
        let agents = self.problem.agents.iter().map(|agent| &agent.name);
        if !robots.chain(agents).eq(&self.plan.members) {
            self.broken(Rule::Form, None, 0.0);
        }
        for activity in &self.plan.activities {
            let target = activity.target;
            let known = self.problem.agents.get(target.agent).is_some_and(|who| target.operation < who.operations);
            let by = match activity.actor {
                Actor::Robot(m) => m < self.problem.robots.len() && activity.phase != Phase::Operation,
                Actor::Agent(a) => a == target.agent && activity.phase == Phase::Operation,
            };
            let finite = activity.start.is_finite() && activity.end.is_finite();
            if !known || !by || !finite || activity.end < activity.start - tolerance(activity.start) {
                self.broken(Rule::Form, Some(target), 0.0);
            }
        }
    }

    fn services(&mut self) -> Vec<Service<'a>> {
        let mut services: Vec<Service<'a>> = Vec::new();
        for (agent, who) in self.problem.agents.iter().enumerate() {
            let mut served: Option<f64> = None;
            for operation in 0..who.operations {
                let target = Target { agent, operation };
                let Some(service) = self.service(target) else {
                    self.broken(Rule::Assignment, Some(target), 0.0);
                    served = None;
                    continue;
                };
                self.operation(who, &service, served);
                self.phases(who, &service);
                served = Some(service.parts[4].end);
                services.push(service);
            }
        }
        services
    }

    fn service(&self, target: Target) -> Option<Service<'a>> {
        let parts = self.parts.get(&target)?;
        let only = |phase: Phase| {
            let mut of = parts.iter().copied().filter(|a| a.phase == phase);
            of.next().filter(|_| of.next().is_none())
        };
        let [a, b, c, d, e, f] = Phase::ALL.map(only);
        let parts = [a?, b?, c?, d?, e?, f?];
        let Actor::Robot(robot) = parts[1].actor else { return None };
        parts[1..].iter().all(|part| part.actor == Actor::Robot(robot)).then_some(Service { robot, parts, target })
    }

    fn begun(&self, target: Target) -> Option<&'a Begun> {
        self.problem.begun.iter().find(|b| b.agent == target.agent && b.operation == target.operation)
    }

    /// Checks (5.11b) and (5.12), and that an operation that has begun is unchanged.
    fn operation(&mut self, who: &WorkingAgent, service: &Service<'a>, served: Option<f64>) {
        let (part, target) = (service.parts[0], service.target);
        self.at_least(Rule::ServiceAfterOperation, target, service.parts[4].start, part.end);
        if let Some(served) = served {
            self.at_least(Rule::Sequence, target, part.start, served);
        }
        if let Some(begun) = self.begun(target) {
            self.equal(Rule::Begun, target, part.start, begun.start);
            self.equal(Rule::Begun, target, part.end, begun.end);
            return;
        }
        self.at_least(Rule::Past, target, part.start, self.problem.start);
        if target.operation == 0 {
            self.equal(Rule::FirstOperation, target, part.start, self.problem.start);
        }
        let (mean, sigma) = (who.duration.mean, who.duration.sigma);
        let planned = part.end - part.start;
        let off = if sigma == 0.0 {
            planned - mean
        } else {
            // Compares the probability that the operation ends too late, or in time if that is smaller, with the
            // required one, and converts the difference into seconds. The smaller probability, since the other one is 1
            // up to its last digits.
            let z = (planned - mean) / sigma;
            let confidence = self.problem.confidence;
            let off = if z > 0.0 { 1.0 - confidence - tail(z) } else { tail(-z) - confidence };
            off * sigma / density(z)
        };
        if off.is_nan() || off.abs() > tolerance(part.end) {
            self.broken(Rule::OperationTime, Some(target), off.abs());
        }
    }

    /// Checks (5.7) to (5.11a), and that a service that has begun is unchanged.
    fn phases(&mut self, who: &WorkingAgent, service: &Service<'a>) {
        let target = service.target;
        for pair in service.parts[1..].windows(2) {
            self.equal(Rule::Order, target, pair[1].start, pair[0].end);
        }
        let machine = &self.problem.robots[service.robot];
        let (range, near) = near(self.problem, who, service.robot);
        let far = match &self.problem.distances {
            Distances::Straight => {
                let (dx, dy) = (machine.depot[0] - who.place[0], machine.depot[1] - who.place[1]);
                (dx * dx + dy * dy).sqrt()
            }
            Distances::Table(table) => table[service.robot][target.agent],
        };
        let ways = [
            (Rule::Going, service.parts[1], (far - near).abs(), machine.speed, 0.0),
            (Rule::Proximity, service.parts[3], near, range, 0.0),
            (Rule::Depositing, service.parts[5], far, machine.speed, machine.deposit),
        ];
        if let Some((robot, times)) = self.begun(target).and_then(|begun| begun.service) {
            if robot != service.robot {
                self.broken(Rule::Begun, Some(target), 0.0);
            }
            let starts = service.parts[1..].iter().map(|part| part.start);
            for (is, was) in starts.chain([service.parts[5].end]).zip(times.instants()) {
                self.equal(Rule::Begun, target, is, was);
            }
        } else {
            self.at_least(Rule::Past, target, service.parts[1].start, self.problem.start);
            match self.problem.absent.iter().find(|absence| absence.robot == service.robot).map(|absence| absence.until)
            {
                Some(Some(until)) => self.at_least(Rule::Absent, target, service.parts[1].start, until),
                Some(None) => self.broken(Rule::Absent, Some(target), 0.0),
                None => {}
            }
            self.equal(Rule::ServiceTime, target, service.parts[4].end, service.parts[4].start + machine.serve);
            for (rule, part, length, speeds, rest) in ways {
                self.at_least(rule, target, part.end, part.start + length / speeds.high + rest);
                self.at_least(rule, target, part.start + length / speeds.low + rest, part.end);
            }
        }
        for (_, part, length, _, rest) in ways {
            let time = part.end - part.start - rest;
            let speed = if length > 0.0 && time > 0.0 { length / time } else { 0.0 };
            let off = (part.speed.unwrap_or(0.0) - speed).abs();
            if off.is_nan() || off > TOLERANCE * speed.max(1.0) {
                self.broken(Rule::Speed, Some(target), off);
            }
        }
    }

    /// Checks (5.14), from the start of going to the end of depositing.
    fn overlaps(&mut self, services: &[Service<'a>]) {
        for (index, service) in services.iter().enumerate() {
            for other in services[..index].iter().filter(|other| other.robot == service.robot) {
                let (from, to) = (service.parts[1].start, service.parts[5].end);
                let (other_from, other_to) = (other.parts[1].start, other.parts[5].end);
                let both = to.min(other_to) - from.max(other_from);
                if both > tolerance(to) {
                    let (at, other) = (Some(service.target), Some(other.target));
                    self.violations.push(Violation { rule: Rule::Overlap, at, other, by: both });
                }
            }
        }
    }
}

/// Returns the speeds and the distance of this robot's approach to this agent.
fn near(problem: &Problem, who: &WorkingAgent, robot: usize) -> (Range, f64) {
    let machine = &problem.robots[robot];
    let (mut speeds, mut distance) = (machine.proximity, who.wait_distance);
    for approach in &who.approaches {
        if approach.robot == robot {
            speeds = approach.speed.or(speeds);
            distance = approach.wait_distance.unwrap_or(distance);
        }
    }
    let (mut low, mut high) = (f64::MAX, 0.0_f64);
    match speeds {
        Some(range) => (low, high) = (range.low, range.high),
        None => {
            for other in &problem.robots {
                low = low.min(0.8 * other.speed.low);
                high = high.max(0.75 * other.speed.high);
            }
        }
    }
    let (least, most) = (machine.speed.low, machine.speed.high);
    (Range { low: low.clamp(least, most), high: high.clamp(least, most) }, distance)
}

/// Density of the standard normal distribution.
fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}

/// Integral of the density from `z`, zero or more, to infinity: by Simpson's rule from 0 for small `z`, and by the
/// continued fraction of Laplace for larger `z`, for which Simpson's rule would leave only rounding errors.
fn tail(z: f64) -> f64 {
    const STEPS: u32 = 4096;
    const TERMS: u32 = 200;
    if z < 2.0 {
        let step = z / f64::from(STEPS);
        let inner: f64 = (1..STEPS).map(|k| if k % 2 == 1 { 4.0 } else { 2.0 } * density(f64::from(k) * step)).sum();
        return 0.5 - step / 3.0 * (density(0.0) + inner + density(z));
    }
    density(z) / (1..=TERMS).rev().fold(z, |below, k| z + f64::from(k) / below)
}
