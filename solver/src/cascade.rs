//! The reference backend: solves the levels one after the other, each to a proven active set. Clarabel solves the
//! levels for which the search does not end.

use crate::certificate::{Certifier, Claim};
use crate::conic;
use crate::dense::{Matrix, axpy, dot, norm};
use crate::descent::descend;
use crate::factor::least_squares;
use crate::feasible_set::{FeasibleSet, Kind, UnitLevel};
use crate::problem::{Problem, check, nothing};
use crate::reduced_level::{ActiveSetGuess, Proven, ReducedLevel};
use crate::solution::{Active, HierarchicalSolver, LevelSolution, LevelStatus, MET, Solution, Status, refusal};

/// Solves a hierarchy level by level, each in the affine set that the levels above leave.
///
/// A level of inequalities that the current point already meets costs one pass over its rows. Otherwise the active set
/// is searched, warm-started from the last tick, with orthogonal factorisations; a result is accepted only with its
/// proof of optimality. If that search cycles, a descent along the level's cost provides a better start; if that fails
/// too, Clarabel solves the level and its point provides the start. Only if all of this fails, Clarabel's point itself
/// is used, accurate to about 1e-8 (counted in [`Statistics`]).
///
/// Allocates while solving: it is the reference, not the solver of the control loop. All iterations are bounded;
/// nothing panics. The same sequence of problems gives the same bits.
#[derive(Clone, Debug)]
pub struct ClarabelCascade {
    guesses: Vec<ActiveSetGuess>,
    searching: bool,
    /// Off only in the test of unproven points.
    proving: bool,
    statistics: Statistics,
}

/// Counters of a [`ClarabelCascade`] since it was created.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Solved problems.
    pub solves: usize,
    /// Levels without a decision: the current point met them.
    pub free_levels: usize,
    /// Descents, each started because no guess of an active set could be proven.
    pub descents: usize,
    /// Quadratic programs passed to Clarabel.
    pub conic_programs: usize,
    /// Levels whose result is Clarabel's unpolished point (about 1e-8 instead of 1e-12).
    pub unpolished: usize,
}

/// State between two levels.
#[derive(Clone)]
struct CascadeState {
    feasible: FeasibleSet,
    /// True if the point of the space may not be the nearest to the reference, so that this point has to be computed.
    inexact: bool,
}

impl ClarabelCascade {
    /// Creates a solver for problems of this shape.
    pub fn new(problem: &Problem) -> Self {
        ClarabelCascade {
            guesses: vec![ActiveSetGuess::default(); problem.levels.len()],
            searching: true,
            proving: true,
            statistics: Statistics::default(),
        }
    }

    /// With `false`, Clarabel first solves every level that needs a decision, and the search starts from Clarabel's
    /// active set: an independent route to the same result, about ten times slower. On by default.
    pub fn with_search_first(mut self, on: bool) -> Self {
        self.searching = on;
        self
    }

    /// Returns the counters since the solver was created.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Clears the memory of the last tick: the next solve starts cold.
    pub fn forget(&mut self) {
        self.guesses.iter_mut().for_each(|g| *g = ActiveSetGuess::default());
    }

    /// Solves one level: moves the state to the level's minimisers. Returns false if none were found.
    fn solve_level(&mut self, state: &mut CascadeState, problem: &Problem, l: usize, unit: &UnitLevel) -> bool {
        if state.feasible.dimension() == 0 {
            return true;
        }
        let decides = unit.damping > 0.0 || unit.kind.contains(&Kind::Equality);
        if !state.inexact && !decides && unit.is_met(&state.feasible.x0) {
            self.statistics.free_levels += 1;
            hold_own(&mut state.feasible, unit, l, &[]);
            return true;
        }
        let reduced = ReducedLevel::new(unit, &state.feasible, &problem.reference);
        let mut proven = None;
        if self.searching {
            let warm = &self.guesses[l];
            if warm.violated.iter().any(|s| *s != 0) || !warm.blocking.is_empty() {
                proven = reduced.search(warm);
            }
            proven = proven.or_else(|| reduced.search(&ActiveSetGuess::default()));
            proven = proven.or_else(|| self.descend_and_search(&reduced));
        }
        if proven.is_none() {
            let Some(conic) = conic::solve(&reduced, false) else {
                return false;
            };
            self.statistics.conic_programs += conic.solves;
            if self.proving {
                proven = reduced.search(&conic.guess);
            }
            if self.proving && !self.searching {
                proven = proven.or_else(|| self.descend_and_search(&reduced));
            }
            if proven.is_none() && conic.converged {
                self.statistics.unpolished += 1;
                proven = Some(take_as_is(&reduced, conic.y, conic.guess));
            }
        }
        let Some(proven) = proven else { return false };
        self.guesses[l] = proven.guess.clone();
        state.inexact = !proven.is_nearest;
        state.feasible = narrowed(&state.feasible, &proven);
        hold_own(&mut state.feasible, unit, l, &proven.guess.violated);
        true
    }

    fn descend_and_search(&mut self, reduced: &ReducedLevel) -> Option<Proven> {
        self.statistics.descents += 1;
        reduced.search(&descend(reduced)?)
    }

    /// Moves to the point of the remaining set that is nearest to the reference, if the last level did not find it.
    fn finish(&mut self, state: &mut CascadeState, problem: &Problem) -> bool {
        if !state.inexact || state.feasible.dimension() == 0 {
            return true;
        }
        let none = crate::Level::new(problem.n, crate::LevelShape { rows: 0, hard: false, damping: 0.0 });
        let unit = UnitLevel::new(&none, 0.0);
        let reduced = ReducedLevel::new(&unit, &state.feasible, &problem.reference);
        let proven = if self.proving { reduced.search(&ActiveSetGuess::default()) } else { None };
        let y = match proven {
            Some(proven) => proven.y,
            None => match conic::solve(&reduced, true) {
                Some(conic) if conic.converged => {
                    self.statistics.conic_programs += conic.solves;
                    conic.y
                }
                _ => return false,
            },
        };
        axpy(1.0, &state.feasible.z.apply(&y), &mut state.feasible.x0);
        true
    }
}

impl HierarchicalSolver for ClarabelCascade {
    fn name(&self) -> &'static str {
        "clarabel-cascade"
    }

    fn solve_first(&mut self, problem: &Problem, levels: usize, solution: &mut Solution) {
        solution.reset(problem);
        self.statistics.solves += 1;
        if let Err(error) = check(problem) {
            solution.status = refusal(error, problem);
            return;
        }
        self.guesses.resize(problem.levels.len(), ActiveSetGuess::default());
        let mut state = CascadeState { feasible: FeasibleSet::whole(problem), inexact: false };
        let norms = problem.levels.iter().flat_map(|level| (0..level.rows()).map(|i| norm(level.row(i))));
        let zero = nothing(norms.fold(0.0, f64::max));
        let mut done = 0;
        for (l, level) in problem.levels[..levels].iter().enumerate() {
            let unit = UnitLevel::new(level, zero);
            let before = level.hard.then(|| state.clone());
            if !self.solve_level(&mut state, problem, l, &unit) {
                solution.status = Status::Failed { level: l };
                return;
            }
            solution.levels[l].freedom = state.feasible.dimension();
            if let Some(before) = before {
                report(problem, l, &state.feasible.x0, &mut solution.levels[l]);
                if solution.levels[l].status != LevelStatus::Met {
                    solution.levels[l].status = LevelStatus::Infeasible;
                    solution.status = Status::Infeasible { level: l };
                    state = before;
                    break;
                }
            }
            done = l + 1;
        }
        if !self.finish(&mut state, problem) {
            solution.status = Status::Failed { level: done };
            return;
        }
        if done == levels {
            solution.status = Status::Optimal;
        }
        solution.x.copy_from_slice(&state.feasible.x0);
        if solution.x.iter().any(|x| !x.is_finite()) {
            solution.status = Status::Failed { level: done };
            return;
        }
        for l in 0..done {
            report(problem, l, &state.feasible.x0, &mut solution.levels[l]);
        }
        let look = Certifier::new(problem).look(problem, Claim::Optimum(done), &solution.x);
        if !look.proves(&solution.x) {
            solution.status = Status::Unproven { level: look.level };
        }
    }
}

/// Returns the set of the level's minimisers as the next space, without the higher rows that are constant on it.
fn narrowed(space: &FeasibleSet, proven: &Proven) -> FeasibleSet {
    let mut x0 = space.x0.clone();
    axpy(1.0, &space.z.apply(&proven.y), &mut x0);
    let z = space.z.times(&proven.null, None);
    let mut next =
        FeasibleSet { x0, rows: Matrix::zeros(0, space.rows.cols), z, lower: vec![], upper: vec![], names: vec![] };
    let mut image = vec![0.0; next.z.cols];
    for (j, name) in space.names.iter().enumerate() {
        next.z.apply_transposed_into(space.rows.row(j), &mut image);
        if norm(&image) > crate::dense::DEPENDENT {
            next.hold(*name, space.rows.row(j), space.lower[j], space.upper[j]);
        }
    }
    next
}

/// Adds the inequality rows of a level that are met, and not constant on the space, to the higher rows.
fn hold_own(space: &mut FeasibleSet, unit: &UnitLevel, l: usize, violated: &[i8]) {
    let mut image = vec![0.0; space.z.cols];
    for i in 0..unit.kind.len() {
        if unit.kind[i] == Kind::Inequality && violated.get(i).is_none_or(|s| *s == 0) {
            space.z.apply_transposed_into(unit.rows.row(i), &mut image);
            if norm(&image) > crate::dense::DEPENDENT {
                space.hold((l, i), unit.rows.row(i), unit.lower[i], unit.upper[i]);
            }
        }
    }
}

/// Returns Clarabel's point with the directions along which all of its active rows are constant.
fn take_as_is(reduced: &ReducedLevel, y: Vec<f64>, guess: ActiveSetGuess) -> Proven {
    let (mut rows, _, mut size) = reduced.cost_rows(&guess.violated);
    for (name, _) in &guess.blocking {
        if let Ok(j) = reduced.space.names.binary_search(name) {
            rows.push(reduced.higher.g.row(j));
            size.push(1.0);
        }
    }
    let zeros = vec![0.0; rows.rows];
    let null = least_squares(rows, zeros, size).null;
    Proven { y, null, guess, is_nearest: false }
}

/// Writes the result of level `l` at `x`.
fn report(problem: &Problem, l: usize, x: &[f64], out: &mut LevelSolution) {
    let level = &problem.levels[l];
    let mut sum = 0.0;
    let mut met = true;
    for i in 0..level.rows() {
        let slack = level.slack(i, x);
        let (lower, upper, weight) = (level.lower[i], level.upper[i], level.weight[i]);
        let value = dot(level.row(i), x);
        let finite = |b: f64| if b.is_finite() { b.abs() } else { 0.0 };
        let size = norm(level.row(i));
        let size = if size > 0.0 { size } else { 1.0 };
        let tolerance = MET * (size + finite(lower).max(finite(upper)));
        out.slack[i] = slack;
        out.multipliers[i] = weight * slack;
        sum += weight * slack * slack;
        out.active[i] = if slack.abs() > tolerance {
            met &= weight == 0.0 && !level.hard;
            Active::Violated
        } else if level.is_equality(i) {
            Active::Equality
        } else if value <= lower + tolerance {
            Active::Lower
        } else if value >= upper - tolerance {
            Active::Upper
        } else {
            Active::Free
        };
    }
    out.violation = sum.sqrt();
    out.status = if met { LevelStatus::Met } else { LevelStatus::Relaxed };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LevelShape;

    /// Conflicting limits and targets, solved without any proof: Clarabel's own points, level by level, come within its
    /// accuracy of the proven optimum.
    #[test]
    fn unproven_points_are_usable() {
        let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
        let mut problem = Problem::new(3, &[shape(2), shape(2), shape(1)]);
        problem.levels[0].set(0, &[1.0, 0.5, 0.0], f64::NEG_INFINITY, 1.0);
        problem.levels[0].set(1, &[0.0, 1.0, 1.0], -0.5, 0.5);
        problem.levels[1].set(0, &[1.0, 1.0, 0.0], 3.0, f64::INFINITY);
        problem.levels[1].set(1, &[0.0, 1.0, 0.0], f64::NEG_INFINITY, 1.0);
        problem.levels[2].set(0, &[0.0, 0.0, 1.0], 2.0, 2.0);
        let mut exact = Solution::new(&problem);
        ClarabelCascade::new(&problem).solve(&problem, &mut exact);
        assert!(exact.levels[1].violation > 0.1 && exact.levels[2].violation > 0.1);
        let mut rough = Solution::new(&problem);
        let mut solver = ClarabelCascade::new(&problem).with_search_first(false);
        solver.proving = false;
        solver.solve(&problem, &mut rough);
        assert_eq!(rough.status, Status::Optimal);
        assert!(solver.statistics().unpolished >= 2);
        for (rough, exact) in rough.x.iter().zip(&exact.x) {
            assert!((rough - exact).abs() < 1e-6, "{rough} {exact}");
        }
    }
}
