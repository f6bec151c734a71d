//! A lower bound on the cost of every schedule, for any number of services.
//!
//! [`Prices`](super::lagrangian_bound) replace the order constraints of the agents' operations. Each service then has a weight
//! per second of its start, an earliest instant, and one robot, which is busy for some time before and after the start.
//! The waits have two lower bounds. First, every service starts no earlier than its earliest instant. Second, the
//! robots are replaced by one machine that is as fast as all of them together and may switch between services at any
//! time. The weighted sum of the mean instants of the services' work is then minimal if the machine always processes
//! the service of the greatest weight per time (Goemans 1997; for several machines Schulz and Skutella 2002). The
//! larger of both bounds the waits; energies are bounded leg by leg. Prices follow a subgradient of the bound.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::engine::Watch;

use super::bounds::Bounds;
use super::instance::Instance;
use super::lagrangian_bound::{Priced, even};

/// Number of rounds of the subgradient method, number of rounds without a better bound before the step is reduced, and
/// factor of the reduction.
const ROUNDS: usize = 120;
const IDLE: usize = 6;
const SHORTER: f64 = 0.6;
/// Negative costs below this share of the largest cost are rounding errors.
const ROUNDING: f64 = 1e-9;

/// Computes a lower bound on the cost of every schedule, at least that of `bounds`. `known` is the cost of a known
/// schedule.
pub(crate) fn relaxation(instance: &Instance, bounds: &Bounds, known: f64, watch: &Watch) -> f64 {
    let relaxed = Relaxed::new(instance, bounds);
    let mut prices = even(instance);
    let (mut best, mut at) = (bounds.cost, prices.clone());
    let (mut length, mut idle) = (1.0, 0);
    for _ in 0..ROUNDS {
        let Some((bound, starts)) = relaxed.solve(&Priced::new(instance, &prices)) else { break };
        if bound > best {
            idle = if bound > best + 1e-5 * known.abs() { 0 } else { idle + 1 };
            best = bound;
            at.clone_from(&prices);
        } else {
            idle += 1;
        }
        if best >= known || watch.is_over() {
            break;
        }
        if idle >= IDLE {
            (length, idle) = (SHORTER * length, 0);
            prices.clone_from(&at);
        }
        // Subgradient: time (s) by which each service starts too early.
        let early = |(job, start): (usize, &f64)| {
            let before = instance.jobs[job].previous;
            before.map_or(0.0, |before| starts[before] + relaxed.serve + instance.jobs[job].nominal - start)
        };
        let early: Vec<f64> = starts.iter().enumerate().map(early).collect();
        let square: f64 = early.iter().map(|seconds| seconds * seconds).sum();
        let step = length * (known - bound) / square;
        if !step.is_finite() {
            break;
        }
        prices.iter_mut().zip(&early).for_each(|(price, seconds)| *price = (*price + step * seconds).max(0.0));
    }
    best
}

/// A service without the order constraint of its agent.
struct Service {
    /// Earliest start (s).
    first: f64,
    /// Minimum time for which its robot is busy before its start, and after it (s).
    lead: f64,
    tail: f64,
    /// By robot: minimum energy of the legs, as a cost, and serving time (s).
    by: Vec<(f64, f64)>,
}

/// An instance without the order constraints of agents.
struct Relaxed {
    services: Vec<Service>,
    /// Services sorted by the earliest instant at which their robots may be busy with them.
    released: Vec<usize>,
    robots: f64,
    /// Minimum serving time (s).
    serve: f64,
    /// Cost of the earliest end.
    end: f64,
}

impl Relaxed {
    fn new(instance: &Instance, bounds: &Bounds) -> Relaxed {
        let robots = 0..instance.free.len();
        let least = |values: &dyn Fn(usize) -> f64| robots.clone().map(values).fold(f64::INFINITY, f64::min);
        let services = instance.jobs.iter().enumerate().map(|(index, job)| Service {
            first: bounds.first[index],
            lead: least(&|m| job.ways[m][0].low + job.ways[m][1].low),
            tail: least(&|m| instance.serve(m) + job.ways[m][2].low + instance.deposit(m)),
            by: robots
                .clone()
                .map(|m| (job.ways[m].iter().map(|way| way.cost(way.cheapest())).sum(), instance.serve(m)))
                .collect(),
        });
        let services: Vec<Service> = services.collect();
        let mut released: Vec<usize> = (0..services.len()).collect();
        let release = |service: &Service| service.first - service.lead;
        released.sort_by(|a, b| release(&services[*a]).total_cmp(&release(&services[*b])));
        let serve = least(&|m| instance.serve(m));
        let end = instance.makespan_cost * bounds.first_end;
        Relaxed { services, released, robots: instance.free.len() as f64, serve, end }
    }

    /// Returns a lower bound on the cost under prices, with the starts of the services at it; `None` if a service gains
    /// by starting late, or there are none.
    fn solve(&self, priced: &Priced) -> Option<(f64, Vec<f64>)> {
        let largest = priced.start.iter().fold(0.0_f64, |most, price| most.max(price.abs()));
        if self.services.is_empty() || priced.start.iter().any(|price| *price < -ROUNDING * largest) {
            return None;
        }
        let fixed: f64 = self.services.iter().zip(&priced.serve).map(|(service, price)| service.cheapest(*price)).sum();
        let weights: Vec<f64> = priced.start.iter().map(|price| price.max(0.0)).collect();
        let cost = |starts: &[f64]| starts.iter().zip(&weights).map(|(start, weight)| weight * start).sum::<f64>();
        let alone: Vec<f64> = self.services.iter().map(|service| service.first).collect();
        let together = self.together(&weights);
        let (one, other) = (cost(&alone), cost(&together));
        let (waits, starts) = if one >= other { (one, alone) } else { (other, together) };
        Some((priced.constant + fixed + self.end + waits, starts))
    }

    /// Starts of the services at the minimum of their weighted sum, on one machine that is as fast as all robots.
    fn together(&self, weights: &[f64]) -> Vec<f64> {
        let mut waiting: BinaryHeap<Waiting> = BinaryHeap::new();
        // Remaining work of each service, and the integral of time over its processed work.
        let length = |index: usize| self.services[index].lead + self.services[index].tail;
        let mut left: Vec<f64> = (0..self.services.len()).map(|index| length(index) / self.robots).collect();
        let mut moment = vec![0.0; self.services.len()];
        let mut time = f64::NEG_INFINITY;
        let mut coming = self.released.iter().copied().peekable();
        let release = |index: usize| self.services[index].first - self.services[index].lead;
        loop {
            if waiting.is_empty() {
                let Some(next) = coming.peek() else { break };
                time = time.max(release(*next));
            }
            while let Some(next) = coming.next_if(|next| release(*next) <= time) {
                let ratio = if length(next) > 0.0 { weights[next] / length(next) } else { f64::INFINITY };
                waiting.push(Waiting { ratio, index: next });
            }
            let Some(&Waiting { index, .. }) = waiting.peek() else { continue };
            let until = coming.peek().map_or(f64::INFINITY, |next| release(*next));
            let finishes = left[index] <= until - time;
            let done = if finishes { left[index] } else { until - time };
            moment[index] += done * (time + 0.5 * done);
            left[index] -= done;
            time = if finishes { time + done } else { until };
            if finishes {
                waiting.pop();
            }
        }
        let start = |index: usize| {
            let service = &self.services[index];
            let middle = if length(index) > 0.0 { moment[index] * self.robots / length(index) } else { service.first };
            middle - 0.5 * (service.tail - service.lead)
        };
        (0..self.services.len()).map(start).collect()
    }
}

impl Service {
    /// Minimum cost of the legs and of serving, over all robots.
    fn cheapest(&self, price: f64) -> f64 {
        self.by.iter().map(|(energy, serve)| energy + price * serve).fold(f64::INFINITY, f64::min)
    }
}

/// A service that the machine may process; the one of the greatest weight per time has priority.
struct Waiting {
    ratio: f64,
    index: usize,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Waiting) -> Ordering {
        self.ratio.total_cmp(&other.ratio).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Waiting) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Waiting) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}
