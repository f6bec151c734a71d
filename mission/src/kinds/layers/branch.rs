//! Branch and bound over the agent and object of each task: returns the best plan, proven, or the best one found with a
//! bound.
//!
//! Nodes of the search are processed in the order of their bounds ([`dual`](super::dual)); a node is split on the task
//! whose agent varies most between the relaxed problems, or else on an object. Every relaxed solution becomes a plan
//! once layers are timed, and good ones are improved ([`improve`](super::improve)).

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::rc::Rc;
use std::time::Instant;

use crate::engine::Budget;
use crate::plan::{Limit, Statistics, Status};

use super::dual::{Bound, Choices, Domain, Dual};
use super::improve::Improver;
use super::instance::Instance;

/// Number of subgradient steps at the root, and in each other node.
const ROOT_STEPS: usize = 400;
const PART_STEPS: usize = 24;
/// Limit on the number of layers that all improvements may time: initially, and increment per job for each relaxed
/// solution.
const TIMED: u64 = 200_000;
const TIMED_EACH: u64 = 40;
/// Maximum number of values that open nodes store; beyond it the search ends.
const MOST_KEPT: usize = 100_000_000;

/// Result of the search.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub choices: Choices,
    pub status: Status,
    pub statistics: Statistics,
}

struct Part {
    domain: Domain,
    bound: Bound,
    number: u64,
}

impl PartialEq for Part {
    fn eq(&self, other: &Part) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Part) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Part {
    /// The greatest node is the one with the lowest bound, then the newest.
    fn cmp(&self, other: &Part) -> Ordering {
        other.bound.value.total_cmp(&self.bound.value).then(self.number.cmp(&other.number))
    }
}

/// The best known plan.
struct Incumbent<'a> {
    instance: &'a Instance<'a>,
    best: Option<(f64, Choices)>,
    last: Option<Choices>,
    deadline: Option<Instant>,
    /// Minimum cost of the plans before improvement.
    raw: f64,
    /// Remaining number of layers that improvements may time.
    left: u64,
}

impl Incumbent<'_> {
    fn cost(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |(cost, _)| *cost)
    }

    /// Evaluates choices, and improves them if they are good; returns the cost of the best plan.
    fn see(&mut self, choices: &Choices, margin: f64) -> f64 {
        if self.last.as_ref() == Some(choices) {
            return self.cost();
        }
        self.last = Some(choices.clone());
        self.left += TIMED_EACH * choices.len() as u64;
        let mut improver = Improver::new(self.instance, choices.clone());
        let raw = improver.cost();
        if raw < self.raw || raw < self.cost() + margin * self.cost().abs() {
            self.raw = self.raw.min(raw);
            improver.improve(self.left, self.deadline);
            self.left -= improver.tried.min(self.left);
        }
        if improver.cost() < self.cost() {
            self.best = Some((improver.cost(), improver.choices));
        }
        self.cost()
    }
}

/// Returns the best choices for an instance; `None` only if it has no plan at all.
pub(super) fn branch(instance: &Instance<'_>, budget: &Budget) -> Option<Found> {
    let begun = Instant::now();
    let deadline = begun.checked_add(budget.time);
    let mut dual = Dual::new(instance, deadline);
    let mut incumbent = Incumbent { instance, best: None, last: None, deadline, raw: f64::INFINITY, left: TIMED };
    let domain = Domain::of(instance);
    let prices = dual.even();
    let root = dual.climb(&domain, prices, ROOT_STEPS, f64::INFINITY, |choices| incumbent.see(choices, 0.02));
    let size = root.prices.len() + root.agents.len() + 4 * root.objects.len();
    let mut nodes = 1_u64;
    let mut stopped = None;
    let mut waiting = BinaryHeap::new();
    let mut least = f64::INFINITY;
    waiting.push(Part { domain, bound: root, number: 0 });
    while let Some(part) = waiting.pop() {
        let cutoff = incumbent.cost() - budget.gap * incumbent.cost().abs();
        if part.bound.value >= cutoff {
            least = least.min(part.bound.value);
            break;
        }
        stopped = match () {
            () if nodes >= budget.nodes || waiting.len() * size > MOST_KEPT => Some(Limit::Work),
            () if begun.elapsed() >= budget.time => Some(Limit::Time),
            () => None,
        };
        if stopped.is_some() {
            least = least.min(part.bound.value);
            break;
        }
        // If no decision is open, the only plan has been evaluated already.
        let Some((first, second)) = split(instance, &part) else { continue };
        for domain in [first, second] {
            nodes += 1;
            let goal = incumbent.cost() - budget.gap * incumbent.cost().abs();
            let parent = &part.bound;
            let see = |choices: &Choices| {
                let cost = incumbent.see(choices, 0.003);
                cost - budget.gap * cost.abs()
            };
            let mut bound = dual.climb(&domain, parent.prices.clone(), PART_STEPS, goal, see);
            bound.value = bound.value.max(parent.value);
            let cutoff = incumbent.cost() - budget.gap * incumbent.cost().abs();
            if bound.value < cutoff {
                waiting.push(Part { domain, bound, number: nodes });
            } else if bound.value < f64::INFINITY {
                least = least.min(bound.value);
            }
        }
    }
    let (cost, choices) = incumbent.best?;
    let bound = least.min(cost);
    let gap = if cost.abs() > 0.0 { (cost - bound) / cost.abs() } else { 0.0 };
    let status = match stopped {
        Some(stopped) if gap > budget.gap => Status::Gap { bound, gap, stopped },
        _ => Status::Proven { bound },
    };
    Some(Found { choices, status, statistics: Statistics { solves: dual.solves, nodes, cuts: 0 } })
}

/// Returns a lower bound on the cost of every plan of an instance, given the cost of one.
pub(super) fn root_bound(instance: &Instance<'_>, cost: f64, budget: &Budget) -> f64 {
    let mut dual = Dual::new(instance, Instant::now().checked_add(budget.time));
    let prices = dual.even();
    dual.climb(&Domain::of(instance), prices, ROOT_STEPS, cost, |_| cost).value
}

/// Splits a node into two; `None` if no decision is open.
fn split(instance: &Instance<'_>, part: &Part) -> Option<(Domain, Domain)> {
    let agents = instance.movers.len();
    let planned = |job: &usize| instance.jobs[*job].layer.is_some();
    let mut best: Option<(f64, usize, usize)> = None;
    for job in (0..instance.jobs.len()).filter(planned) {
        if part.domain.agents[job].count_ones() < 2 {
            continue;
        }
        let shares = &part.bound.agents[job * agents..(job + 1) * agents];
        let allowed = |agent: &usize| part.domain.agents[job] & (1 << agent) != 0;
        let most = (0..agents).filter(allowed).rev().max_by(|a, b| shares[*a].total_cmp(&shares[*b]))?;
        let doubt = 1.0 - shares[most];
        if best.is_none_or(|(other, ..)| doubt > other) {
            best = Some((doubt, job, most));
        }
    }
    let mut object: Option<(f64, usize, usize)> = None;
    for job in (0..instance.jobs.len()).filter(planned) {
        let allowed = &part.domain.objects[job];
        let (most, share) = part.bound.objects[job];
        let known = allowed.iter().any(|other| usize::from(*other) == most);
        let most = if known { most } else { usize::from(*allowed.first()?) };
        if allowed.len() > 1 && object.is_none_or(|(other, ..)| 1.0 - share > other) {
            object = Some((1.0 - share, job, most));
        }
    }
    // Branch on objects only if agents are nearly decided.
    if let Some((_, job, agent)) = best.filter(|(doubt, ..)| *doubt > 0.05 || object.is_none_or(|o| o.0 < 0.05)) {
        let (mut first, mut second) = (part.domain.clone(), part.domain.clone());
        first.agents[job] = 1 << agent;
        second.agents[job] &= !(1 << agent);
        return Some((first, second));
    }
    let (_, job, most) = object?;
    let (mut first, mut second) = (part.domain.clone(), part.domain.clone());
    let others: Vec<u16> = part.domain.objects[job].iter().copied().filter(|o| usize::from(*o) != most).collect();
    first.objects[job] = Rc::from([most as u16]);
    second.objects[job] = Rc::from(others);
    Some((first, second))
}
