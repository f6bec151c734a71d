//! The best times and speeds of a fixed sequence: a cone program, solved exactly by Clarabel.
//!
//! With who serves whom in which order given, what is left is convex: the energy of a way is `rate D + bend / D` in its
//! duration `D`, and `u D >= 1` is a second-order cone. What the solver gives is used for the durations; the starts follow
//! from them by going through the sequence again, so that every constraint holds to the last digit.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::engine::EngineError;

use super::assistance::Assistance;
use super::instance::{Instance, Sequence};
use super::timing::{self, Durations, Order};

/// A sequence with its best times.
#[derive(Clone, Debug)]
pub(crate) struct Timed {
    pub sequence: Sequence,
    /// Durations of the three ways of each job (s).
    pub durations: Durations,
    /// What it costs.
    pub cost: f64,
    pub schedule: Vec<Assistance>,
}

impl Timed {
    fn new(instance: &Instance, sequence: &Sequence, order: &Order, durations: Durations, starts: &[f64]) -> Timed {
        let cost = timing::cost(instance, order, &durations, starts);
        let schedule = timing::schedule(instance, order, &durations, starts);
        Timed { sequence: sequence.clone(), durations, cost, schedule }
    }
}

/// The best times of this sequence; none if it contradicts the order of an agent's operations.
///
/// # Errors
///
/// Clarabel did not reach its tolerances.
pub(crate) fn retime(instance: &Instance, sequence: &Sequence) -> Result<Option<Timed>, EngineError> {
    let Some(order) = Order::of(instance, sequence) else { return Ok(None) };
    if instance.is_fixed() && instance.is_regular() {
        let only = |(job, robot): (usize, &usize)| instance.jobs[job].ways[*robot].map(|way| way.low);
        let durations: Durations = order.robot.iter().enumerate().map(only).collect();
        let starts = timing::starts(instance, &order, &durations, None);
        return Ok(Some(Timed::new(instance, sequence, &order, durations, &starts)));
    }
    let program = Program::new(instance, &order);
    let point = program.solve()?;
    let durations = program.durations(instance, &order, &point);
    let wanted: Option<Vec<f64>> = (!instance.is_regular())
        .then(|| (0..instance.jobs.len()).map(|job| instance.problem.start + program.unit * point[job]).collect());
    let starts = timing::starts(instance, &order, &durations, wanted.as_deref());
    Ok(Some(Timed::new(instance, sequence, &order, durations, &starts)))
}

/// The cone program of a sequence. Columns: the starts of the jobs and the makespan, in units of `unit` seconds from the
/// start of the plan; then for each way that may take longer or shorter its duration in units of `reference` seconds, and
/// where speed costs the reciprocal of that.
struct Program {
    unit: f64,
    cost: Vec<f64>,
    /// Rows `sum of terms <= bound`.
    rows: Vec<(Vec<(usize, f64)>, f64)>,
    /// Duration and reciprocal columns that obey `u D >= 1`.
    cones: Vec<(usize, usize)>,
    /// For each job and way: the duration's column and reference, or its fixed value.
    ways: Vec<[Duration; 3]>,
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
        program.rows.push((vec![(count, -1.0)], -(instance.busy - instance.problem.start).max(0.0) / longest));
        program
    }

    fn column(&mut self, cost: f64) -> usize {
        self.cost.push(cost);
        self.cost.len() - 1
    }

    /// `value + sum of the starts and durations <= start of job (or the makespan)`, everything in seconds.
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
        self.before(instance.serve(robot) + instance.deposit(robot), Some(index), &[back], end);
    }

    fn solve(&self) -> Result<Vec<f64>, EngineError> {
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
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&p, &self.cost, &a, &bounds, &cones, settings)
            .map_err(|error| failed(error.to_string()))?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {
                Ok(solver.solution.x.clone())
            }
            status => Err(failed(format!("{status:?} on a sequence that has times"))),
        }
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
