//! Curvature of the rows of levels, for [`solver::Smooth`]: measured once, when a stack is prepared.
//!
//! For a row `s(q)` and two joints j and k of a chain, the second derivative `d^2 s / dq_j dq_k` is a cross product of
//! the axis of the joint nearer to the root with the effect of the other joint on `s`. It is therefore at most as large
//! as the effect of either joint, `min(m_j, m_k)` with `m_j = max |ds/dq_j|`. The largest coefficients are taken from
//! the rows themselves at [`SAMPLES`] configurations within the position limits, so that this works for every task type
//! and expression alike: it estimates the magnitude and is not a proof. A row with the same coefficients at all samples
//! is linear and has no curvature. Source: ours.

use robot::{Data, LinkId, Model};
use solver::Problem;
use stdlib_tasks::task::{RowKind, Rows, State, Task};

use super::Member;
use crate::program::{Interface, Times};
use crate::sampling::{SAMPLES, SEED, Spread};
use crate::values::ValueTable;

/// Fraction of the samples whose coefficients count, from the smallest: near a singular configuration of the row itself
/// the coefficients can be arbitrarily large.
const COUNTED: f64 = 0.9;

/// Largest variation between configurations of a coefficient that counts as constant.
const CONSTANT: f64 = 1e-9;

/// Shortest time tau over which a damped level counts second derivatives, in s; two periods if these are longer. A
/// longer time is smoother, and comes to rest at the nearest point more slowly.
const HORIZON: f64 = 0.065;

/// Time tau of a program with this period, in s.
pub(super) fn horizon(period: f64) -> f64 {
    HORIZON.max(2.0 * period)
}

/// Parts of a stack that the measurement uses.
pub(super) struct Stack<'a> {
    pub model: &'a Model,
    pub members: &'a [Member],
    pub tasks: &'a mut [Box<dyn Task>],
    /// Parameter values before the first tick.
    pub values: &'a mut [ValueTable],
    pub interface: &'a Interface,
    pub locked: &'a [usize],
    pub period: f64,
}

/// Coefficients of the rows of one task, one vector of samples for each row and variable.
struct Coefficients {
    seen: Vec<Vec<f64>>,
}

impl Coefficients {
    /// Returns the largest coefficient that counts, and true if the coefficient varies. A coefficient without samples
    /// is taken to be 1 and to vary.
    fn of(&mut self, at: usize) -> (f64, bool) {
        let seen = &mut self.seen[at];
        let Some(&first) = seen.first() else { return (1.0, true) };
        let varies = seen.iter().any(|c| (c - first).abs() > CONSTANT * (1.0 + first.abs()));
        seen.iter_mut().for_each(|c| *c = c.abs());
        seen.sort_by(f64::total_cmp);
        (seen[(COUNTED * (seen.len() - 1) as f64).round() as usize], varies)
    }
}

/// Largest distance from a link of the robot, along each axis, at which points of people and of hosts are placed, in m.
const AROUND: f64 = 1.0;

impl Stack<'_> {
    /// Stores the curvature of the rows in the problem's levels.
    pub(super) fn measure(&mut self, problem: &mut Problem) {
        let of = |table: &ValueTable| (table.current.clone(), table.rates.clone());
        let before: Vec<(Vec<f64>, Vec<f64>)> = self.values.iter().map(of).collect();
        let initial = self.values.first().map(|table| table.current.clone()).unwrap_or_default();
        self.measure_each(problem, &initial);
        for (table, before) in self.values.iter_mut().zip(before) {
            (table.current, table.rates) = before;
            table.restart();
        }
    }

    /// Places external points at random around the robot. Rows that depend on these points may have curvature there and
    /// none at the values from before anybody was seen.
    fn put_points(&mut self, data: &Data, spread: &mut Spread, initial: &[f64]) {
        let mut signals = self.interface.absent();
        let links = self.model.links.len();
        let mut some = false;
        for s in self.interface.signals.iter().filter(|s| s.motion.is_some() || (s.kind == "point" && s.len == 3)) {
            let link = LinkId(((spread.next() * links as f64) as usize).min(links - 1) as u32);
            let mut at = |k: usize| data.position(link)[k] + AROUND * (2.0 * spread.next() - 1.0);
            let point = [at(0), at(1), at(2)];
            signals[s.at..s.at + s.width()].fill(0.0);
            (signals[s.at], signals[s.known_at()]) = (1.0, 1.0);
            signals[s.at + 1..s.at + 4].copy_from_slice(&point);
            if s.is_pose() {
                signals[s.at + 4] = 1.0;
            }
            some = true;
        }
        if !some {
            return;
        }
        for table in self.values.iter_mut() {
            table.evaluate(Times::default(), &signals);
            table.current.iter_mut().zip(initial).filter(|(x, _)| !x.is_finite()).for_each(|(x, i)| *x = *i);
            table.rates.fill(0.0);
        }
    }

    fn measure_each(&mut self, problem: &mut Problem, initial: &[f64]) {
        let n = self.model.nv();
        let mut curvature: Vec<Vec<f64>> = problem.levels.iter().map(|l| vec![0.0; l.rows() * n]).collect();
        for i in 0..self.members.len() {
            let m = &self.members[i];
            if m.constant || m.rows.is_empty() {
                continue;
            }
            let first = m.rows.start * n;
            let level = m.level;
            let rows = m.rows.len();
            let horizon = horizon(self.period);
            let mut found = self.coefficients(i, initial);
            for row in 0..rows {
                let of: Vec<(f64, bool)> = (0..n).map(|j| found.of(row * n + j)).collect();
                if !of.iter().any(|(_, varies)| *varies) {
                    continue;
                }
                for j in (0..n).filter(|j| !self.locked.contains(j)) {
                    let open = (0..n).filter(|k| !self.locked.contains(k));
                    let sum: f64 = open.map(|k| of[j].0.min(of[k].0)).sum();
                    curvature[level][first + row * n + j] = sum * horizon;
                }
            }
        }
        for (level, curvature) in problem.levels.iter_mut().zip(curvature) {
            level.set_curvature(curvature);
        }
    }

    /// Samples the rows of a task. Configurations at which the rows are undefined are skipped.
    fn coefficients(&mut self, task: usize, initial: &[f64]) -> Coefficients {
        let (n, m) = (self.model.nv(), &self.members[task]);
        let rows = m.rows.len();
        let limits = if m.row_kind == RowKind::Inequality { rows } else { 0 };
        let mut data = Data::new(self.model);
        let mut spread = Spread(SEED);
        let mut seen = vec![Vec::with_capacity(SAMPLES); rows * n];
        let (mut jacobian, mut lower, mut upper) = (vec![0.0; rows * n], vec![0.0; rows], vec![0.0; rows]);
        let (mut margins, mut measures) = (vec![0.0; limits], vec![0.0; m.measures.len()]);
        let velocity = vec![0.0; n];
        for _ in 0..SAMPLES {
            let q = self.model.random_configuration(&mut || spread.next());
            self.model.forward(&q, &mut data);
            self.put_points(&data, &mut spread, initial);
            jacobian.fill(0.0);
            lower.fill(f64::NEG_INFINITY);
            upper.fill(f64::INFINITY);
            margins.fill(f64::INFINITY);
            let mut undefined = false;
            let mut out = Rows {
                jacobian: &mut jacobian,
                stride: n,
                lower: &mut lower,
                upper: &mut upper,
                margins: &mut margins,
                measures: &mut measures,
                undefined: &mut undefined,
                idle: &[],
                trial: true,
            };
            let state = State {
                model: self.model,
                data: &data,
                q: &q,
                values: &self.values[self.members[task].part()].current,
                rates: &self.values[self.members[task].part()].rates,
                velocity: &velocity,
                stack_velocity: &velocity,
            };
            let fails = self.tasks[task].update(&state, &mut out).is_err() || undefined;
            if fails || jacobian.iter().any(|a| !a.is_finite()) {
                continue;
            }
            seen.iter_mut().zip(&jacobian).for_each(|(seen, a)| seen.push(*a));
        }
        Coefficients { seen }
    }
}
