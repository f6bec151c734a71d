//! A lower bound on the cost of every plan in a node of the search: Lagrangian relaxation of the makespan.
//!
//! The length `D_i` of a layer is at least the load of each agent in it, at least the time of each of its tasks, and at
//! least the time of its fixed steps. With multipliers (prices) on these constraints that sum to the cost of a second,
//! `D_i` drops out and the cost of each task depends only on its agent and object at the price of its time, with the
//! robots' speeds in closed form. The remaining problem is an assignment of tasks to objects, each task with its
//! cheapest agent: solved exactly by the Hungarian method. Any prices give a bound; a subgradient method improves it.

use std::rc::Rc;
use std::time::Instant;

use super::assignment::Assignment;
use super::instance::Instance;

/// Agents and objects that the jobs may still have: a node of the search.
#[derive(Clone, Debug)]
pub(super) struct Domain {
    /// By job, the agents as a bit mask.
    pub agents: Vec<u32>,
    /// By job, indices into [`super::instance::Job::objects`].
    pub objects: Vec<Rc<[u16]>>,
}

impl Domain {
    /// Returns the domain of all possible choices.
    pub fn of(instance: &Instance<'_>) -> Domain {
        let able = |job: &super::instance::Job| {
            let mut mask = 0_u32;
            for agent in 0..instance.movers.len() {
                if (0..job.objects.len()).any(|object| job.mode(object, agent).is_some()) {
                    mask |= 1 << agent;
                }
            }
            mask
        };
        Domain {
            agents: instance.jobs.iter().map(able).collect(),
            objects: instance.jobs.iter().map(|job| (0..job.objects.len() as u16).collect()).collect(),
        }
    }
}

/// An agent and an object (its index in the job's list) for each job.
pub(super) type Choices = Vec<(usize, usize)>;

/// Layout of the price vector: for each layer the agents, then the jobs, then the fixed steps.
#[derive(Clone, Debug)]
pub(super) struct Prices {
    /// Index of the first price of each layer, and the end.
    starts: Vec<usize>,
    /// By job: index of its price; unused for a job without a layer.
    of_job: Vec<usize>,
}

impl Prices {
    pub fn new(instance: &Instance<'_>) -> Prices {
        let mut starts = vec![0];
        let mut of_job = vec![0; instance.jobs.len()];
        for layer in &instance.layers {
            let start = starts[starts.len() - 1];
            for (number, job) in layer.jobs.iter().enumerate() {
                of_job[*job] = start + instance.movers.len() + number;
            }
            starts.push(start + instance.movers.len() + layer.jobs.len() + 1);
        }
        Prices { starts, of_job }
    }

    /// Returns initial prices: the same for all agents of a layer.
    pub fn even(&self, instance: &Instance<'_>) -> Vec<f64> {
        let mut prices = vec![0.0; self.starts[self.starts.len() - 1]];
        let agents = instance.movers.len();
        for start in &self.starts[..self.starts.len() - 1] {
            for price in &mut prices[*start..start + agents] {
                *price = instance.second / agents as f64;
            }
        }
        prices
    }
}

/// Computes bounds; keeps its working memory.
pub(super) struct Dual<'a> {
    instance: &'a Instance<'a>,
    places: Prices,
    columns: usize,
    rows: Vec<Vec<(usize, f64)>>,
    row_jobs: Vec<usize>,
    agent_of: Vec<Vec<usize>>,
    assignment: Assignment,
    slope: Vec<f64>,
    /// Latest end of a search for prices.
    deadline: Option<Instant>,
    /// Number of relaxed problems solved.
    pub solves: u64,
}

/// Result of a search for prices.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    /// Lower bound; infinite if there is no plan.
    pub value: f64,
    /// Prices that give the bound.
    pub prices: Vec<f64>,
    /// By job and agent, weighted share of the relaxed solutions that chose it, from 0 to 1.
    pub agents: Vec<f64>,
    /// By job, the most frequently chosen object (its index in the job's list) and its share.
    pub objects: Vec<(usize, f64)>,
}

impl<'a> Dual<'a> {
    pub fn new(instance: &'a Instance<'a>, deadline: Option<Instant>) -> Dual<'a> {
        let places = Prices::new(instance);
        let count = places.starts[places.starts.len() - 1];
        Dual {
            instance,
            places,
            columns: instance.problem.objects.len(),
            rows: vec![Vec::new(); instance.jobs.len()],
            row_jobs: Vec::new(),
            agent_of: vec![Vec::new(); instance.jobs.len()],
            assignment: Assignment::default(),
            slope: vec![0.0; count],
            deadline,
            solves: 0,
        }
    }

    pub fn even(&self) -> Vec<f64> {
        self.places.even(self.instance)
    }

    /// Computes the bound at these prices, with the choices that attain it; `None` if no choices are left. Sets the
    /// subgradient.
    fn at(&mut self, domain: &Domain, prices: &[f64]) -> Option<(f64, Choices)> {
        self.solves += 1;
        let instance = self.instance;
        let agents = instance.movers.len();
        let mut value = instance.offset;
        self.slope.fill(0.0);
        for (layer, start) in instance.layers.iter().zip(&self.places.starts) {
            for (agent, release) in layer.release.iter().enumerate() {
                value += prices[start + agent] * release;
                self.slope[start + agent] = *release;
            }
            let last = start + agents + layer.jobs.len();
            value += prices[last] * layer.floor;
            self.slope[last] = layer.floor;
        }
        let mut chosen: Choices = vec![(0, 0); instance.jobs.len()];
        self.row_jobs.clear();
        for (index, job) in instance.jobs.iter().enumerate() {
            let mut row = std::mem::take(&mut self.rows[self.row_jobs.len()]);
            row.clear();
            self.agent_of[index].clear();
            self.agent_of[index].resize(job.objects.len(), 0);
            let metres = job.layer.map(|layer| self.metres(index, layer, prices));
            for &object in domain.objects[index].iter() {
                let place = usize::from(object);
                let (agent, cost) = match &metres {
                    None => (0, 0.0),
                    Some(metres) => self.cheapest(index, place, domain.agents[index], metres, prices),
                };
                if cost < f64::INFINITY {
                    self.agent_of[index][place] = agent;
                    row.push((job.objects[place].unwrap_or(place), cost));
                }
            }
            if job.needs_object() {
                self.rows[self.row_jobs.len()] = row;
                self.row_jobs.push(index);
            } else {
                let best = row.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied();
                self.rows[self.row_jobs.len()] = row;
                let (place, cost) = best?;
                value += cost;
                chosen[index] = (self.agent_of[index][place], place);
            }
        }
        let rows = self.row_jobs.len();
        value += self.assignment.solve(&self.rows[..rows], self.columns)?;
        for (row, index) in self.row_jobs.iter().enumerate() {
            let column = Some(self.assignment.columns[row]);
            let place = instance.jobs[*index].objects.iter().position(|object| *object == column)?;
            chosen[*index] = (self.agent_of[*index][place], place);
        }
        for (index, job) in instance.jobs.iter().enumerate() {
            let Some(layer) = job.layer else { continue };
            let (agent, object) = chosen[index];
            let Some(mode) = job.mode(object, agent) else { continue };
            let (price, own) = (self.places.starts[layer] + agent, self.places.of_job[index]);
            let mover = &instance.movers[agent];
            let speed = mover.speed_at(prices[price] + prices[own]);
            let time = mode.time + if mode.way > 0.0 { mode.way / speed } else { 0.0 };
            self.slope[price] += time;
            self.slope[own] += time + instance.layers[layer].release[agent];
        }
        Some((value, chosen))
    }

    /// By agent, cost of a metre for a job at these prices.
    fn metres(&self, index: usize, layer: usize, prices: &[f64]) -> Vec<f64> {
        let movers = self.instance.movers.iter().enumerate();
        let metre = |(agent, mover): (usize, &super::instance::Mover)| {
            let second = prices[self.places.starts[layer] + agent] + prices[self.places.of_job[index]];
            mover.metre(mover.speed_at(second), second)
        };
        movers.map(metre).collect()
    }

    /// Returns the agent of minimum cost for a job with this object, and that cost.
    fn cheapest(&self, index: usize, object: usize, allowed: u32, metres: &[f64], prices: &[f64]) -> (usize, f64) {
        let job = &self.instance.jobs[index];
        let Some(layer) = job.layer else { return (0, 0.0) };
        let (start, own) = (self.places.starts[layer], prices[self.places.of_job[index]]);
        let release = &self.instance.layers[layer].release;
        let mut best = (0, f64::INFINITY);
        for (agent, metre) in metres.iter().enumerate().filter(|(agent, _)| allowed & (1 << agent) != 0) {
            let Some(mode) = job.mode(object, agent) else { continue };
            let second = prices[start + agent] + own;
            let cost = mode.cost + second * mode.time + mode.way * metre + own * release[agent];
            if cost < best.1 {
                best = (agent, cost);
            }
        }
        best
    }

    /// Maximizes the bound over prices in at most `steps` subgradient steps from `prices`; ends if the bound reaches
    /// `goal`, the cost of a known plan. Passes all choices of relaxed solutions to `see`, which may lower the goal.
    pub fn climb(
        &mut self,
        domain: &Domain,
        prices: Vec<f64>,
        steps: usize,
        mut goal: f64,
        mut see: impl FnMut(&Choices) -> f64,
    ) -> Bound {
        let instance = self.instance;
        let agents = instance.movers.len();
        let mut average = vec![0.0; instance.jobs.len() * agents];
        let mut objects: Vec<Vec<f64>> = instance.jobs.iter().map(|job| vec![0.0; job.objects.len()]).collect();
        let mut bound = Bound { value: f64::NEG_INFINITY, prices: prices.clone(), agents: vec![], objects: vec![] };
        let (mut at, mut relax, mut idle) = (prices, 1.0, 0);
        for step in 0..steps {
            if step > 0 && self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                break;
            }
            let Some((value, chosen)) = self.at(domain, &at) else {
                bound.value = f64::INFINITY;
                break;
            };
            goal = goal.min(see(&chosen));
            // Later choices have more weight, since their prices are better.
            let rate = f64::max(0.15, 1.0 / (step + 1) as f64);
            for (index, (agent, object)) in chosen.iter().enumerate() {
                for (other, share) in average[index * agents..(index + 1) * agents].iter_mut().enumerate() {
                    *share += rate * (f64::from(u8::from(other == *agent)) - *share);
                }
                for share in &mut objects[index] {
                    *share *= 1.0 - rate;
                }
                objects[index][*object] += rate;
            }
            if value > bound.value {
                idle = if value > bound.value + 1e-5 * goal.abs() { 0 } else { idle + 1 };
                bound.value = value;
                bound.prices.clone_from(&at);
            } else {
                idle += 1;
            }
            if bound.value >= goal || instance.second <= 0.0 {
                break;
            }
            if idle >= 4 {
                relax *= 0.6;
                idle = 0;
                at.clone_from(&bound.prices);
                continue;
            }
            if !self.step(&mut at, relax * (goal - value)) {
                break;
            }
        }
        bound.agents = average;
        let most = |shares: &Vec<f64>| {
            let best = shares.iter().copied().enumerate().rev().max_by(|a, b| a.1.total_cmp(&b.1));
            best.unwrap_or((0, 0.0))
        };
        bound.objects = objects.iter().map(most).collect();
        bound
    }

    /// Takes one subgradient step from `at` that would gain `gain` if the bound were linear, and projects the prices
    /// back onto those that sum to the cost of a second. Returns false if the projected subgradient is zero.
    fn step(&mut self, at: &mut [f64], gain: f64) -> bool {
        let second = self.instance.second;
        let mut square = 0.0;
        for range in self.places.starts.windows(2) {
            let (own, slope) = (&at[range[0]..range[1]], &mut self.slope[range[0]..range[1]]);
            let mean = own.iter().zip(slope.iter()).map(|(price, s)| price * s).sum::<f64>() / second;
            for (price, s) in own.iter().zip(slope.iter_mut()) {
                *s -= mean;
                if *price <= 0.0 && *s < 0.0 {
                    *s = 0.0;
                }
                square += *s * *s;
            }
        }
        if square <= 1e-18 {
            return false;
        }
        let length = gain / square;
        for range in self.places.starts.windows(2) {
            let own = &mut at[range[0]..range[1]];
            for (price, slope) in own.iter_mut().zip(&self.slope[range[0]..range[1]]) {
                *price += length * slope;
            }
            onto_simplex(own, second);
        }
        true
    }
}

/// Projects a point onto the vectors with non-negative entries of the given sum.
fn onto_simplex(point: &mut [f64], sum: f64) {
    let mut sorted = point.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let (mut total, mut shift) = (0.0, 0.0);
    for (count, value) in sorted.iter().enumerate() {
        total += value;
        let next = (total - sum) / (count + 1) as f64;
        if value - next > 0.0 {
            shift = next;
        }
    }
    for value in point {
        *value = (*value - shift).max(0.0);
    }
}
