//! Optimal times and speeds of a fixed sequence: a cone program, solved exactly by Clarabel.
//!
//! With assignment and order given, the rest is convex: the energy of a leg is `rate D + bend / D` in its duration `D`,
//! and `u D >= 1` is a second-order cone. The durations are taken from the solver; the starts are computed from them by
//! a pass through the sequence, so that every constraint holds to the last digit.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::engine::{EngineError, Watch};

use super::assistance::Assistance;
use super::instance::{Instance, Sequence, Way};
use super::timing::{self, Durations, Order};

/// Costs whose relative difference is smaller are treated as equal.
const SAME: f64 = 1e-8;

/// A sequence with its optimal times.
#[derive(Clone, Debug)]
pub(crate) struct Timed {
    pub sequence: Sequence,
    /// Durations of the three legs of each job (s).
    pub durations: Durations,
    /// Cost of the schedule.
    pub cost: f64,
    pub schedule: Vec<Assistance>,
    pub prices: Prices,
}

/// Prices per second in a schedule with optimal times: the duals of its constraints.
#[derive(Clone, Debug)]
pub(crate) struct Prices {
    /// Dual of the order constraint between a job and the previous one of its agent.
    pub order: Vec<f64>,
    /// Dual of the return of each robot before the makespan.
    pub end: Vec<f64>,
}

impl Timed {
    fn new(
        instance: &Instance,
        sequence: &Sequence,
        order: &Order,
        durations: Durations,
        starts: &[f64],
        prices: Prices,
    ) -> Timed {
        let cost = timing::cost(instance, order, &durations, starts);
        let schedule = timing::schedule(instance, order, &durations, starts);
        Timed { sequence: sequence.clone(), durations, cost, schedule, prices }
    }
}

/// Computes the optimal times of this sequence; `None` if it contradicts the order of an agent's operations. Returns
/// the times at the greatest speeds if the time limit is reached before.
///
/// # Errors
///
/// Clarabel did not reach its tolerances.
pub(crate) fn retime(instance: &Instance, sequence: &Sequence, watch: &Watch) -> Result<Option<Timed>, EngineError> {
    let Some(order) = Order::of(instance, sequence) else { return Ok(None) };
    let early = instance.is_regular() && instance.limits.is_empty();
    if instance.is_fixed() && early {
        return Ok(Some(at_once(instance, sequence, &order, |way| way.low)));
    }
    let hurried = || at_once(instance, sequence, &order, |way| way.low);
    if watch.is_over() {
        return Ok(Some(hurried()));
    }
    let program = Program::new(instance, &order);
    let Some((point, dual)) = program.solve(watch)? else { return Ok(Some(hurried())) };
    let prices = program.prices(instance, &order, &dual);
    let durations = program.durations(instance, &order, &point);
    let wanted: Option<Vec<f64>> = (!early)
        .then(|| (0..instance.jobs.len()).map(|job| instance.problem.start + program.unit * point[job]).collect());
    let mut starts = timing::starts(instance, &order, &durations, wanted.as_deref());
    if instance.is_regular() && wanted.is_some() {
        // Start later because of a limit only if that saves more than a rounding error.
        let soon = timing::starts(instance, &order, &durations, None);
        let cost = |starts: &[f64]| timing::cost(instance, &order, &durations, starts);
        if cost(&soon) <= cost(&starts) + SAME * cost(&starts).abs() {
            starts = soon;
        }
    }
    Ok(Some(Timed::new(instance, sequence, &order, durations, &starts, prices)))
}

/// Times a sequence with these durations, each service as early as possible, without prices.
fn at_once(instance: &Instance, sequence: &Sequence, order: &Order, duration: impl Fn(&Way) -> f64) -> Timed {
    let ways = |(job, robot): (usize, &usize)| instance.jobs[job].ways[*robot].each_ref().map(&duration);
    let durations: Durations = order.robot.iter().enumerate().map(ways).collect();
    let starts = timing::starts(instance, order, &durations, None);
    let prices = Prices { order: vec![0.0; instance.jobs.len()], end: vec![0.0; instance.free.len()] };
    Timed::new(instance, sequence, order, durations, &starts, prices)
}

/// Values of the columns of a program, and duals of its rows.
type Point = (Vec<f64>, Vec<f64>);

/// The cone program of a sequence. Columns: the starts of the jobs and the makespan, in units of `unit` seconds from
/// the start of the plan; then for each leg of variable duration its duration in units of `reference` seconds and, if
/// speed has a cost, the reciprocal of that.
struct Program {
    unit: f64,
    cost: Vec<f64>,
    /// Rows `sum of terms <= bound`.
    rows: Vec<(Vec<(usize, f64)>, f64)>,
    /// Duration and reciprocal columns that obey `u D >= 1`.
    cones: Vec<(usize, usize)>,
    /// For each job and leg: column and reference of the duration, or its fixed value.
    ways: Vec<[Duration; 3]>,
    /// For each job the rows of its order constraint and of its end.
    limits: Vec<(usize, usize)>,
}

/// A duration in the program.
#[derive(Clone, Copy)]
enum Duration {
    Fixed(f64),
    Free { column: usize, reference: f64 },
}

impl Program {
    fn new(instance: &Instance, order: &Order) -> Program {
        let count = instance.jobs.len();
        let longest = (0..count).map(|job| instance.longest(job, order.robot[job])).fold(1.0, f64::max);
        let mut program = Program {
            unit: longest,
            cost: instance.jobs.iter().map(|job| job.start_cost * longest).collect(),
            rows: Vec::new(),
            cones: Vec::new(),
            ways: Vec::with_capacity(count),
            limits: Vec::with_capacity(count),
        };
        program.cost.push(instance.makespan_cost * longest);
        for (index, job) in instance.jobs.iter().enumerate() {
            let ways = job.ways[order.robot[index]];
            let durations = ways.map(|way| {
                if way.is_fixed() {
                    return Duration::Fixed(way.low);
                }
                let reference = (way.low * way.high).sqrt();
                let column = program.column(way.rate * reference);
                program.rows.push((vec![(column, -1.0)], -way.low / reference));
                program.rows.push((vec![(column, 1.0)], way.high / reference));
                if way.bend > 0.0 {
                    let reciprocal = program.column(way.bend / reference);
                    program.cones.push((column, reciprocal));
                }
                Duration::Free { column, reference }
            });
            program.ways.push(durations);
        }
        for index in 0..count {
            program.limit(instance, order, index);
        }
        for limited in &instance.limits {
            // At least the wait beyond its limit, and not negative.
            let excess = program.column(limited.rate * longest);
            let served: f64 = limited.serves.iter().map(|(job, c)| c * instance.serve(order.robot[*job])).sum();
            let zero: f64 = limited.starts.iter().map(|(_, c)| c * instance.problem.start).sum();
            let terms = limited.starts.iter().copied().chain([(excess, -1.0)]).collect();
            program.rows.push((terms, -(limited.constant + served + zero) / longest));
            program.rows.push((vec![(excess, -1.0)], 0.0));
        }
        program.rows.push((vec![(count, -1.0)], -(instance.busy - instance.problem.start).max(0.0) / longest));
        program
    }

    fn column(&mut self, cost: f64) -> usize {
        self.cost.push(cost);
        self.cost.len() - 1
    }

    /// Adds the row `value + sum of the starts and durations <= start of job (or the makespan)`, all in seconds.
    fn before(&mut self, value: f64, starts: Option<usize>, durations: &[Duration], later: usize) {
        let mut terms = vec![(later, -1.0)];
        let mut constant = value;
        terms.extend(starts.map(|earlier| (earlier, 1.0)));
        for duration in durations {
            match *duration {
                Duration::Fixed(time) => constant += time,
                Duration::Free { column, reference } => terms.push((column, reference / self.unit)),
            }
        }
        self.rows.push((terms, -constant / self.unit));
    }

    fn limit(&mut self, instance: &Instance, order: &Order, index: usize) {
        let (job, robot) = (&instance.jobs[index], order.robot[index]);
        let zero = instance.problem.start;
        let ordered = self.rows.len();
        match job.previous {
            Some(previous) => {
                self.before(instance.serve(order.robot[previous]) + job.nominal, Some(previous), &[], index);
            }
            None => self.before(job.release - zero, None, &[], index),
        }
        let [going, proximity, back] = self.ways[index];
        match order.before[index] {
            Some(before) => {
                let ways = [self.ways[before][2], going, proximity];
                self.before(instance.serve(robot) + instance.deposit(robot), Some(before), &ways, index);
            }
            None => self.before(instance.free[robot] - zero, None, &[going, proximity], index),
        }
        let end = instance.jobs.len();
        self.limits.push((ordered, self.rows.len()));
        self.before(instance.serve(robot) + instance.deposit(robot), Some(index), &[back], end);
    }

    /// Solves the program; returns the point and the duals of the rows, or `None` if the time limit is reached before.
    fn solve(&self, watch: &Watch) -> Result<Option<Point>, EngineError> {
        let failed = |message: String| EngineError::Failed { engine: "Clarabel".into(), message };
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        let mut bounds = Vec::new();
        for (terms, bound) in &self.rows {
            entries.extend(terms.iter().map(|(column, c)| (bounds.len(), *column, *c)));
            bounds.push(*bound);
        }
        let mut cones = vec![SupportedConeT::NonnegativeConeT(self.rows.len())];
        for (duration, reciprocal) in &self.cones {
            // (D + u, D - u, 2) lies in the second-order cone: D u >= 1.
            let row = bounds.len();
            entries.extend([(row, *duration, -1.0), (row, *reciprocal, -1.0)]);
            entries.extend([(row + 1, *duration, -1.0), (row + 1, *reciprocal, 1.0)]);
            bounds.extend([0.0, 0.0, 2.0]);
            cones.push(SupportedConeT::SecondOrderConeT(3));
        }
        let columns = self.cost.len();
        let (rows, cols): (Vec<usize>, Vec<usize>) = entries.iter().map(|(row, column, _)| (*row, *column)).unzip();
        let values: Vec<f64> = entries.iter().map(|(_, _, value)| *value).collect();
        let a = CscMatrix::new_from_triplets(bounds.len(), columns, rows, cols, values);
        let p = CscMatrix::zeros((columns, columns));
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_gap_abs: 1e-9,
            tol_gap_rel: 1e-9,
            tol_feas: 1e-9,
            time_limit: watch.left().time.as_secs_f64(),
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&p, &self.cost, &a, &bounds, &cones, settings)
            .map_err(|error| failed(error.to_string()))?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {
                Ok(Some((solver.solution.x.clone(), solver.solution.z.clone())))
            }
            SolverStatus::MaxTime => Ok(None),
            status => Err(failed(format!("{status:?} on a sequence that has times"))),
        }
    }

    fn prices(&self, instance: &Instance, order: &Order, dual: &[f64]) -> Prices {
        let price = |row: usize| (dual[row] / self.unit).max(0.0);
        let mut prices = Prices { order: vec![0.0; instance.jobs.len()], end: vec![0.0; instance.free.len()] };
        for (index, (ordered, end)) in self.limits.iter().enumerate() {
            if instance.jobs[index].previous.is_some() {
                prices.order[index] = price(*ordered);
            }
            prices.end[order.robot[index]] += price(*end);
        }
        prices
    }

    fn durations(&self, instance: &Instance, order: &Order, point: &[f64]) -> Durations {
        let of = |(index, durations): (usize, &[Duration; 3])| {
            let ways = &instance.jobs[index].ways[order.robot[index]];
            let mut times = [0.0; 3];
            for ((time, duration), way) in times.iter_mut().zip(durations).zip(ways) {
                *time = match *duration {
                    Duration::Fixed(fixed) => fixed,
                    Duration::Free { column, reference } => (point[column] * reference).clamp(way.low, way.high),
                };
            }
            times
        };
        self.ways.iter().enumerate().map(of).collect()
    }
}
