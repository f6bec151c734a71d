//! Optimal speeds of the robots in a layer: for given agents and objects the problem is a convex program in one
//! variable, the length of the layer.
//!
//! A robot with total distance `S` (m) and moving time `T` (s) needs the least energy at one speed for all motions, `S
//! / T`: `varrho_1 T + varrho_2 S + varrho_3 S^2 / T` (6.4), convex in `T`. A layer of length `D` leaves it `T = D -
//! release - constant times`, of which it uses no more than the speed of least energy needs. The derivative with
//! respect to `D` is increasing, and concave until a robot reaches that speed: Newton's method from the shortest length
//! converges to its root from the left, if it stops at each length at which a robot drops out.

use super::instance::{Layer, Mode, Mover};

/// Load of an agent in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Load {
    /// Number of tasks.
    pub count: usize,
    /// Sum of [`Mode::time`].
    pub time: f64,
    /// Sum of the distances.
    pub way: f64,
    /// Sum of the costs.
    pub cost: f64,
}

impl Load {
    /// Returns the load with one more task.
    pub fn with(self, mode: &Mode) -> Load {
        Load {
            count: self.count + 1,
            time: self.time + mode.time,
            way: self.way + mode.way,
            cost: self.cost + mode.cost,
        }
    }

    /// Returns the load with one task less; exactly zero without tasks.
    pub fn without(self, mode: &Mode) -> Load {
        match self.count {
            0 | 1 => Load::default(),
            count => Load {
                count: count - 1,
                time: self.time - mode.time,
                way: (self.way - mode.way).max(0.0),
                cost: self.cost - mode.cost,
            },
        }
    }
}

/// A layer with its optimal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timing {
    /// Length `D` of the layer (s).
    pub length: f64,
    /// Cost of the layer: loads, energy, makespan.
    pub cost: f64,
}

impl Mover {
    /// Returns the speed of minimum cost per metre if a second costs `second`: the root of the derivative of `joule
    /// (varrho_1 / v + varrho_3 v) + second / v`, within the robot's speeds. 0 for a person.
    pub fn speed_at(&self, second: f64) -> f64 {
        let Mover::Robot { speed, energy, joule } = self else { return 0.0 };
        let drag = joule * energy.drag;
        if drag <= 0.0 {
            return speed.high;
        }
        ((joule * energy.standby + second) / drag).sqrt().clamp(speed.low, speed.high)
    }

    /// Computes the cost of a metre at this speed, without friction, if a second costs `second`. 0 for a person.
    pub fn metre(&self, at: f64, second: f64) -> f64 {
        let Mover::Robot { energy, joule, .. } = self else { return 0.0 };
        joule * (energy.standby / at + energy.drag * at) + second / at
    }

    /// Returns the longest useful time for a distance, at the speed of least energy, and the shortest (s).
    fn times(&self, way: f64) -> (f64, f64) {
        match self {
            Mover::Robot { speed, .. } if way > 0.0 => (way / self.speed_at(0.0), way / speed.high),
            _ => (0.0, 0.0),
        }
    }

    /// Returns the time (s) for a total distance `way` (m) if `most` (s) is available.
    pub fn moving(&self, way: f64, most: f64) -> f64 {
        let (slow, fast) = self.times(way);
        most.min(slow).max(fast)
    }
}

/// Computes the optimal length of a layer with these loads of the agents, and its cost.
pub(super) fn timing(movers: &[Mover], layer: &Layer, loads: &[Load], second: f64) -> Timing {
    let busy = || (0..movers.len()).filter(|agent| loads[*agent].count > 0);
    let begun = |agent: usize| layer.release[agent] + loads[agent].time;
    let mut length = layer.floor;
    for agent in busy() {
        length = length.max(begun(agent) + movers[agent].times(loads[agent].way).1);
    }
    for _ in 0..64 + movers.len() {
        let (mut slope, mut curve, mut bend) = (second, 0.0, f64::INFINITY);
        for agent in busy() {
            let (mover, way) = (&movers[agent], loads[agent].way);
            let Mover::Robot { energy, joule, .. } = mover else { continue };
            let (left, slow) = (length - begun(agent), begun(agent) + mover.times(way).0);
            if way > 0.0 && length < slow {
                let speed = way / left;
                slope -= joule * (energy.drag * speed * speed - energy.standby);
                curve += joule * energy.drag * 2.0 * speed * speed / left;
                bend = bend.min(slow);
            }
        }
        if slope >= 0.0 {
            break;
        }
        let next = length - slope / curve;
        if next <= length * (1.0 + 1e-14) {
            break;
        }
        length = if next < bend { next } else { bend };
    }
    let mut cost = second * length;
    for agent in busy() {
        let Load { way, cost: own, .. } = loads[agent];
        cost += own;
        if way > 0.0 {
            let speed = way / movers[agent].moving(way, length - begun(agent));
            cost += way * movers[agent].metre(speed, 0.0);
        }
    }
    Timing { length, cost }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]
mod tests {
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
    use proptest::prelude::*;

    use super::*;
    use crate::numbers::{Energy, Range};

    /// A task of a robot: constant time and distance.
    type Errand = (f64, f64);

    /// The same problem as a cone program in which every task has its own speed: `u >= d^2 / t` for each moving time
    /// `t`.
    fn cones(movers: &[Mover], layer: &Layer, errands: &[Vec<Errand>], second: f64) -> f64 {
        let mut cost = vec![second];
        let mut rows: Vec<(Vec<(usize, f64)>, f64)> = vec![(vec![(0, -1.0)], -layer.floor)];
        let mut bends = Vec::new();
        for ((mover, release), errands) in movers.iter().zip(&layer.release).zip(errands) {
            let mut busy = vec![(0, -1.0)];
            let constant: f64 = errands.iter().map(|(time, _)| time).sum();
            for (_, way) in errands {
                let Mover::Robot { speed, energy, joule } = mover else { continue };
                let (time, bend) = (cost.len(), cost.len() + 1);
                cost.extend([joule * energy.standby, joule * energy.drag]);
                rows.push((vec![(time, -1.0)], -way / speed.high));
                rows.push((vec![(time, 1.0)], way / speed.low));
                busy.push((time, 1.0));
                bends.push((time, bend, *way));
            }
            if !errands.is_empty() {
                rows.push((busy, -constant - release));
            }
        }
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        let mut bounds = Vec::new();
        for (terms, bound) in &rows {
            entries.extend(terms.iter().map(|(column, c)| (bounds.len(), *column, *c)));
            bounds.push(*bound);
        }
        let mut cones = vec![SupportedConeT::NonnegativeConeT(rows.len())];
        for (time, bend, way) in bends {
            let row = bounds.len();
            entries.extend([(row, time, -1.0), (row, bend, -1.0), (row + 1, time, -1.0), (row + 1, bend, 1.0)]);
            bounds.extend([0.0, 0.0, 2.0 * way]);
            cones.push(SupportedConeT::SecondOrderConeT(3));
        }
        let (r, c): (Vec<usize>, Vec<usize>) = entries.iter().map(|(row, column, _)| (*row, *column)).unzip();
        let values: Vec<f64> = entries.iter().map(|(_, _, value)| *value).collect();
        let a = CscMatrix::new_from_triplets(bounds.len(), cost.len(), r, c, values);
        let settings = DefaultSettings { verbose: false, max_threads: 1, ..DefaultSettings::default() };
        let p = CscMatrix::zeros((cost.len(), cost.len()));
        let mut solver = DefaultSolver::new(&p, &cost, &a, &bounds, &cones, settings).unwrap();
        solver.solve();
        assert!(matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved));
        solver.solution.obj_val
    }

    proptest! {
        #[test]
        fn one_speed_in_closed_form_is_the_best_of_all_speeds(
            robots in prop::collection::vec(
                (0.05_f64..0.2, 0.0_f64..0.4, 0.0_f64..8.0, 0.0_f64..400.0, 0.001_f64..0.05, 0.0_f64..10.0,
                 prop::collection::vec((0.0_f64..4.0, 0.1_f64..3.0), 0..4)), 1..4),
            person in prop::option::of(0.0_f64..30.0), floor in 0.0_f64..20.0, second in 0.001_f64..0.5,
        ) {
            let mut movers = Vec::new();
            let mut errands = Vec::new();
            let mut release = Vec::new();
            for (low, more, standby, drag, joule, busy, own) in robots {
                let energy = Energy { standby, friction: 0.0, drag };
                movers.push(Mover::Robot { speed: Range::new(low, low + more), energy, joule });
                release.push(busy);
                errands.push(own);
            }
            if let Some(time) = person {
                movers.push(Mover::Human);
                release.push(0.0);
                errands.push(vec![(time, 0.0)]);
            }
            let layer = Layer { jobs: vec![], release, floor };
            let load = |own: &Vec<Errand>| Load {
                count: own.len(),
                time: own.iter().map(|(time, _)| time).sum(),
                way: own.iter().map(|(_, way)| way).sum(),
                cost: 0.0,
            };
            let loads: Vec<Load> = errands.iter().map(load).collect();
            let found = timing(&movers, &layer, &loads, second);
            let best = cones(&movers, &layer, &errands, second);
            prop_assert!((found.cost - best).abs() <= 1e-6 * (1.0 + best.abs()), "{} and {best}", found.cost);
            // Convex in the length: neither a shorter nor a longer layer is better.
            for length in [0.99 * found.length, 1.01 * found.length] {
                let fixed = Layer { floor: length, ..layer.clone() };
                if length >= layer.floor {
                    let other = timing(&movers, &fixed, &loads, second);
                    prop_assert!(other.cost >= found.cost - 1e-9);
                }
            }
        }
    }
}
