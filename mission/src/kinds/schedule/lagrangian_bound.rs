//! Lagrangian relaxation of the order of an agent's operations.
//!
//! This order couples the robots: a late service delays the next one of the agent, whichever robot serves it. The order
//! is replaced by a price for each second by which a service starts too early after the previous one of its agent: the
//! start of a service then costs more by the price of the order to the next one, and less by the price of the order
//! from the previous one. For any non-negative prices the minimum cost is a lower bound on the cost of every schedule.

use crate::engine::{Halt, Watch};

use super::bounds::Bounds;
use super::instance::{Begin, Instance, Sequence};
use super::retime::retime;

/// Number of rounds of the subgradient method.
const ROUNDS: usize = 12;
/// Target of a round above the best bound, as a share of the cost.
const AIM: f64 = 0.005;

/// Costs of jobs under prices.
#[derive(Clone, Debug)]
pub(crate) struct Priced {
    /// Cost per second of the start of each job's service. Zero or more.
    pub start: Vec<f64>,
    /// Cost per second of serving.
    pub serve: Vec<f64>,
    /// Cost that is independent of all decisions.
    pub constant: f64,
}

impl Priced {
    /// Computes the costs under prices; `prices[j]` belongs to the order between `j` and the previous job of its agent.
    /// A price is lowered if job `j` would gain by starting late, and raised if an earlier job of the agent would.
    pub fn new(instance: &Instance, prices: &[f64]) -> Priced {
        let jobs = &instance.jobs;
        let mut priced = Priced {
            start: jobs.iter().map(|job| job.start_cost).collect(),
            serve: jobs.iter().map(|job| job.serve_cost).collect(),
            constant: instance.constant,
        };
        // Jobs of an agent are in order. `lacks[j]` is the minimum price of the next job so that `j` does not gain by
        // starting late.
        let mut lacks = vec![0.0_f64; jobs.len()];
        for (index, job) in jobs.iter().enumerate() {
            let before = job.previous.map_or(0.0, |previous| lacks[previous]);
            lacks[index] = (before - job.start_cost).max(0.0);
        }
        // In descending order, since the price after a job changes the cost of its start.
        for (index, job) in jobs.iter().enumerate().rev() {
            if let Some(previous) = job.previous {
                let price = prices[index].max(lacks[previous]).min(priced.start[index]).max(0.0);
                priced.start[index] -= price;
                priced.start[previous] += price;
                priced.serve[previous] += price;
                priced.constant += price * job.nominal;
            }
        }
        priced
    }

    /// Returns the problem under these prices, without order constraints; each job can start as early as in the
    /// original.
    fn instance<'a>(&self, instance: &Instance<'a>, bounds: &Bounds) -> Instance<'a> {
        let mut relaxed = instance.clone();
        for (index, job) in relaxed.jobs.iter_mut().enumerate() {
            job.previous = None;
            job.begin = Begin::Late;
            job.release = bounds.first[index];
            (job.start_cost, job.serve_cost) = (self.start[index], self.serve[index]);
        }
        relaxed.constant = self.constant;
        relaxed
    }
}

/// Initial prices that equalize the start costs of an agent's services.
pub(crate) fn even(instance: &Instance) -> Vec<f64> {
    let jobs = &instance.jobs;
    let mut prices = vec![0.0; jobs.len()];
    for agent in 0..instance.problem.agents.len() {
        let own: Vec<usize> = (0..jobs.len()).filter(|job| jobs[*job].agent == agent).collect();
        let mean = own.iter().map(|job| jobs[*job].start_cost).sum::<f64>() / own.len().max(1) as f64;
        let mut sum = 0.0;
        for job in own.into_iter().rev() {
            sum += jobs[job].start_cost - mean;
            prices[job] = sum.max(0.0);
        }
    }
    prices
}

/// Result of the subgradient method.
pub(crate) struct Raised {
    pub prices: Vec<f64>,
    /// Lower bound on the cost of every schedule.
    pub bound: f64,
}

/// Maximizes the bound over prices by some rounds of a subgradient method; stops early if `solve` reaches the time
/// limit. `solve` returns the minimum cost under prices and its sequence.
///
/// # Errors
///
/// The tables of `solve` are too large, or the cone solver failed.
pub(crate) fn raise(
    instance: &Instance,
    bounds: &Bounds,
    known: f64,
    watch: &Watch,
    mut solve: impl FnMut(&Priced) -> Result<(f64, Sequence), Halt>,
) -> Result<Raised, Halt> {
    let mut prices = even(instance);
    let mut best = Raised { prices: prices.clone(), bound: bounds.cost };
    for _ in 0..ROUNDS {
        let priced = Priced::new(instance, &prices);
        let (bound, sequence) = match solve(&priced) {
            Ok(found) => found,
            Err(Halt::Time) => break,
            Err(halt) => return Err(halt),
        };
        if bound > best.bound {
            best = Raised { prices: prices.clone(), bound };
        }
        let relaxed = priced.instance(instance, bounds);
        let Some(timed) = retime(&relaxed, &sequence, watch)? else { break };
        let times = |job: usize| {
            let target = (relaxed.jobs[job].agent, relaxed.jobs[job].operation);
            let found = timed.schedule.iter().find(|done| (done.agent, done.operation) == target);
            found.map_or((0.0, 0.0), |done| (done.times.serving, done.times.depositing))
        };
        // Subgradient: time (s) by which each service starts too early.
        let early = |job: usize| {
            let previous = instance.jobs[job].previous?;
            Some(times(previous).1 + instance.jobs[job].nominal - times(job).0)
        };
        let early: Vec<f64> = (0..instance.jobs.len()).map(|job| early(job).unwrap_or(0.0)).collect();
        let square: f64 = early.iter().map(|seconds| seconds * seconds).sum();
        let step = (best.bound + AIM * known.abs() - bound).max(0.0) / square;
        if !step.is_finite() {
            break;
        }
        prices.iter_mut().zip(&early).for_each(|(price, seconds)| *price = (*price + step * seconds).max(0.0));
    }
    Ok(best)
}
