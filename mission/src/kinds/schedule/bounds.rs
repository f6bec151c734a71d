//! Bounds that hold for every schedule, or for every schedule that costs no more than a known one: earliest and latest
//! starts of services, number of trips of a robot, and a first lower bound on the cost.

use super::instance::Instance;

/// Bounds on the schedules of an instance.
#[derive(Clone, Debug)]
pub(crate) struct Bounds {
    /// Earliest start of each job's service by each robot (s).
    pub earliest: Vec<Vec<f64>>,
    /// Earliest start of each job's service by any robot (s).
    pub first: Vec<f64>,
    /// Latest start of each job's service (s).
    pub latest: Vec<f64>,
    /// Maximum number of trips of each robot.
    pub trips: Vec<usize>,
    /// Upper bound on the end (s).
    pub end: f64,
    /// Lower bound on the end (s).
    pub first_end: f64,
    /// Lower bound on the cost of every schedule.
    pub cost: f64,
}

impl Bounds {
    /// Computes bounds on the schedules that cost at most `known`.
    pub fn new(instance: &Instance, known: f64) -> Bounds {
        let (count, robots) = (instance.jobs.len(), instance.free.len());
        let earliest = earliest(instance);
        let first: Vec<f64> = earliest.iter().map(|times| least(times.iter().copied())).collect();
        let shortest = |job: usize| least((0..robots).map(|m| instance.shortest(job, m)));
        let back = |job: usize, m: usize| instance.serve(m) + instance.jobs[job].ways[m][2].low + instance.deposit(m);
        let energy = |job: usize, m: usize| {
            let ways: f64 = instance.jobs[job].ways[m].iter().map(|way| way.cost(way.cheapest())).sum();
            ways + instance.jobs[job].serve_cost * instance.serve(m)
        };
        // The end is bounded below by each job's earliest end, and by the total work divided by the number of robots.
        let work: f64 = (0..count).map(shortest).sum::<f64>() + instance.free.iter().sum::<f64>();
        let alone = |job: usize| least((0..robots).map(|m| earliest[job][m] + back(job, m)));
        let end = (0..count).map(alone).fold(instance.busy.max(least(instance.free.iter().copied())), f64::max);
        let end = if robots > 0 { end.max(work / robots as f64) } else { end };
        // Jobs that gain by starting late are counted at their latest start, which bounds the saving.
        let serial: f64 = (0..count)
            .map(|job| instance.jobs[job].nominal + (0..robots).map(|m| instance.longest(job, m)).fold(0.0, f64::max))
            .sum();
        let released = instance.jobs.iter().map(|job| job.release).chain(instance.free.iter().copied());
        let horizon = released.fold(instance.problem.start, f64::max) + serial;
        let start_cost = |job: usize| {
            let cost = instance.jobs[job].start_cost;
            cost * if cost >= 0.0 { first[job] } else { horizon }
        };
        let fixed: f64 =
            (0..count).map(|job| start_cost(job) + least((0..robots).map(|m| energy(job, m)))).sum::<f64>()
                + instance.constant;
        let cost = fixed + instance.makespan_cost * end;
        let slack = (known - cost).max(0.0) + 1e-7 * known.abs().max(1.0);
        let until = |rate: f64, from: f64| if rate > 0.0 { from + slack / rate } else { f64::INFINITY };
        let last = until(instance.makespan_cost, end);
        let latest = (0..count).map(|job| {
            let ends = last - least((0..robots).map(|m| back(job, m)));
            until(instance.jobs[job].start_cost, first[job]).min(ends).min(horizon)
        });
        let mut latest: Vec<f64> = latest.collect();
        // An operation must leave time for the later ones of its agent; jobs of an agent are in order.
        let serve = least((0..robots).map(|m| instance.serve(m)));
        for (index, job) in instance.jobs.iter().enumerate().rev() {
            if let Some(previous) = job.previous {
                latest[previous] = latest[previous].min(latest[index] - serve - job.nominal);
            }
        }
        let mut bounds =
            Bounds { first: first.clone(), latest, earliest, trips: Vec::new(), end: last, first_end: end, cost };
        bounds.trips = (0..robots).map(|m| bounds.trips(instance, m, &first, fixed, known)).collect();
        bounds
    }

    /// Returns an upper bound on the return of the last robot (s); finite.
    pub fn last_end(&self, instance: &Instance) -> f64 {
        let back = |job: usize, m: usize| instance.serve(m) + instance.jobs[job].ways[m][2].high + instance.deposit(m);
        let home = |job: usize| self.latest[job] + (0..instance.free.len()).map(|m| back(job, m)).fold(0.0, f64::max);
        (0..instance.jobs.len()).map(home).fold(instance.problem.start, f64::max).min(self.end)
    }

    /// Returns the maximum number of trips of a robot in a schedule that costs at most `known`: even the shortest
    /// trips, one after the other, delay the end and the waits.
    fn trips(&self, instance: &Instance, robot: usize, first: &[f64], fixed: f64, known: f64) -> usize {
        let count = instance.jobs.len();
        if !instance.is_regular() {
            return count;
        }
        let mut blocks: Vec<f64> = (0..count).map(|job| instance.shortest(job, robot)).collect();
        blocks.sort_by(f64::total_cmp);
        let mut late = first.to_vec();
        late.sort_by(|a, b| b.total_cmp(a));
        let arrive = least(instance.jobs.iter().map(|job| job.ways[robot][0].low + job.ways[robot][1].low));
        let rate = least(instance.jobs.iter().map(|job| job.start_cost));
        let (mut home, mut starts, mut firsts) = (instance.free[robot], 0.0, 0.0);
        for (trips, (block, first)) in blocks.iter().zip(&late).enumerate() {
            starts += home + arrive;
            firsts += first;
            home += block;
            let least = fixed + rate * (starts - firsts).max(0.0) + instance.makespan_cost * home.max(instance.busy);
            if least > known + 1e-7 * known.abs().max(1.0) {
                return trips.max(1);
            }
        }
        count
    }
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

/// Computes the earliest start of each job's service by each robot, with no other jobs than the earlier ones of its
/// agent.
fn earliest(instance: &Instance) -> Vec<Vec<f64>> {
    let mut earliest: Vec<Vec<f64>> = Vec::with_capacity(instance.jobs.len());
    for job in &instance.jobs {
        let ready = match job.previous {
            Some(previous) => {
                let served = earliest[previous].iter().enumerate().map(|(m, start)| start + instance.serve(m));
                least(served) + job.nominal
            }
            None => job.release,
        };
        let arrive = |m: usize| instance.free[m] + job.ways[m][0].low + job.ways[m][1].low;
        earliest.push((0..instance.free.len()).map(|m| ready.max(arrive(m))).collect());
    }
    earliest
}
