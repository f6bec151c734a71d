//! Safe states: positions and velocities of a robot from which it can give way for ever, whatever the person does.
//!
//! A plan relies on a prediction. Where the person turns against it, a robot in a corridor or in a corner may be caught, although each of its
//! plans kept its distance. The state of a robot and the cell of the person are safe if a motion of one period keeps out of everywhere
//! that the person can walk meanwhile, and ends in a state that is safe with each cell in which the person can be then. The largest set with
//! this property is the viability kernel of a game between the robot and the person; it is found by removing states that are not safe until none is left.
//! A robot that begins in it, and never leaves it, is never touched by a person who walks over the grid.
//!
//! The kernel is that of one robot on the lattice of plans: other robots and connections do not count. Motions between the positions
//! of the lattice could save a robot that no motion of the lattice saves.

use super::super::grid::Grid;
use super::super::polygon::{Point, dot};
use super::super::problem::Problem;
use super::MARGIN;
use super::ground::{Ground, SAME, SHARE};
use super::velocities::Velocities;

/// The most motions of a lattice, for which the kernel takes some tenths of a second.
const MOST_MOTIONS: usize = 4_000_000;

/// The safe states of a robot.
#[derive(Clone, Debug)]
pub(super) struct SafeStates {
    velocities: Velocities,
    /// Words of a set of cells.
    words: usize,
    /// By position and velocity, the cells of the person with which it is safe.
    sets: Vec<u64>,
    columns: usize,
    cell: f64,
    /// The cells beside each cell, and the cell itself; none of a blocked one.
    around: Vec<Vec<usize>>,
    low: Point,
}

/// A motion of one period: the state in which it ends, and the offsets of cells of the person that forbid it.
struct Move {
    end: usize,
    forbidden: usize,
}

impl SafeStates {
    /// The safe states of a robot; none: there are none, the person does not walk a cell in each period, or the lattice is too large.
    pub fn new(problem: &Problem, robot: usize, grid: &Grid, ground: &Ground) -> Option<SafeStates> {
        let velocities = Velocities::new(problem, robot, ground.spacing);
        let motions: usize = velocities.after.iter().map(Vec::len).sum();
        let walks = problem.person.speed * problem.period;
        if (walks - grid.cell).abs() > SAME || ground.len() * motions > MOST_MOTIONS {
            return None;
        }
        let count = grid.count();
        let words = count.div_ceil(64);
        let cells: Vec<usize> = (0..count).filter(|cell| !grid.blocked[*cell]).collect();
        let around = (0..count).map(|cell| match grid.blocked[cell] {
            true => Vec::new(),
            false => grid.neighbours(cell).chain([cell]).collect(),
        });
        let around = around.collect();
        let [low, _] = problem.area.bounds();
        let mut all = vec![0_u64; words];
        cells.iter().for_each(|cell| all[cell / 64] |= 1 << (cell % 64));
        let states = ground.len() * velocities.count();
        let sets = all.iter().copied().cycle().take(states * words).collect();
        let mut safe = SafeStates { velocities, words, sets, columns: grid.columns, cell: grid.cell, around, low };
        let forbidden = safe.forbidden(problem, robot);
        let moves = safe.moves(robot, ground);
        safe.remove(ground, &cells, &moves, &forbidden);
        safe.sets.iter().any(|set| *set != 0).then_some(safe)
    }

    /// For each pair of velocities and each place of a position in its cell, the offsets (columns, rows) of cells of the person that
    /// forbid the motion.
    fn forbidden(&self, problem: &Problem, robot: usize) -> Vec<Vec<[i32; 2]>> {
        let who = &problem.robots[robot];
        let strides = problem.strides(problem.period);
        let set = problem.person.body.sum(&who.body.reflected()).sum_with_points(&strides);
        let shares = [0.0, who.over(problem.period).middle / problem.period, 1.0];
        let spacing = SHARE * self.cell;
        let [low, high] = set.bounds();
        let widest = low.iter().chain(&high).fold(0.0, |most: f64, x| most.max(x.abs()));
        let fastest = self.velocities.of(0).iter().fold(0.0, |most: f64, v| most.max(v.abs())) * problem.period;
        let window = ((widest + fastest) / self.cell).ceil() as i32 + 1;
        let count = self.velocities.count();
        let mut lists = Vec::with_capacity(count * count * 4);
        for pair in 0..count * count * 4 {
            let (first, last) = (pair / 4 / count, pair / 4 % count);
            let parity = [(pair % 2) as i32, (pair / 2 % 2) as i32];
            let [third, end] = self.velocities.ahead(first, last);
            let points = [[0; 2], third, end];
            let clear = |offset: [i32; 2]| {
                let bits = |place: usize| {
                    // The middle of a cell is an odd number of positions from the corner of the region.
                    let near = [0, 1].map(|i| spacing * f64::from(parity[i] + points[place][i] - 1 - 2 * offset[i]));
                    set.faces().iter().enumerate().fold(0_u64, |bits, (index, face)| {
                        let far = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
                        let margin = face.outside(near) + (1.0 - shares[place]) * far;
                        bits | u64::from(margin >= MARGIN) << index
                    })
                };
                bits(0) & bits(1) & bits(2) != 0
            };
            let offsets = (-window..=window).flat_map(|c| (-window..=window).map(move |r| [c, r]));
            lists.push(offsets.filter(|offset| !clear(*offset)).collect());
        }
        lists
    }

    /// The motions from each state that stay on free ground.
    fn moves(&self, robot: usize, ground: &Ground) -> Vec<Vec<Move>> {
        let (free, count) = (&ground.free[robot], self.velocities.count());
        let from = |state: usize| {
            let (q, first) = (state / count, state % count);
            let (column, row) = ((q % ground.columns) as i32, (q / ground.columns) as i32);
            let parity = (column % 2 + 2 * (row % 2)) as usize;
            let to = |last: &usize| {
                let [third, end] = self.velocities.ahead(first, *last);
                let third = ground.index(column + third[0], row + third[1])?;
                let end = ground.index(column + end[0], row + end[1])?;
                let forbidden = (first * count + last) * 4 + parity;
                (free[q] & free[third] & free[end] != 0).then_some(Move { end: end * count + last, forbidden })
            };
            self.velocities.after[first].iter().filter_map(to).collect()
        };
        (0..ground.len() * count).map(from).collect()
    }

    /// Removes states that are not safe until none is left.
    fn remove(&mut self, ground: &Ground, cells: &[usize], moves: &[Vec<Move>], forbidden: &[Vec<[i32; 2]>]) {
        let (words, count) = (self.words, self.velocities.count());
        let rows = self.around.len() / self.columns;
        // The cells from which the person cannot get to a cell with which the state is not safe.
        let kept = |set: &[u64], around: &[Vec<usize>]| {
            let mut kept = set.to_vec();
            for cell in cells.iter().filter(|cell| set[**cell / 64] >> (**cell % 64) & 1 == 0) {
                around[*cell].iter().for_each(|beside| kept[beside / 64] &= !(1 << (beside % 64)));
            }
            kept
        };
        let mut after = self.sets.clone();
        let mut changed = true;
        while changed {
            changed = false;
            for (state, moves) in moves.iter().enumerate() {
                let own = &self.sets[state * words..(state + 1) * words];
                if own.iter().all(|word| *word == 0) {
                    continue;
                }
                let q = state / count;
                let (column, row) = ((q % ground.columns / 2) as i32, (q / ground.columns / 2) as i32);
                let mut saved = vec![0_u64; words];
                for one in moves {
                    let mut by = after[one.end * words..(one.end + 1) * words].to_vec();
                    for [c, r] in &forbidden[one.forbidden] {
                        let (c, r) = (column + c, row + r);
                        if (0..self.columns as i32).contains(&c) && (0..rows as i32).contains(&r) {
                            let cell = r as usize * self.columns + c as usize;
                            by[cell / 64] &= !(1 << (cell % 64));
                        }
                    }
                    saved.iter_mut().zip(&by).for_each(|(saved, by)| *saved |= by);
                    if own.iter().zip(&saved).all(|(own, saved)| own & !saved == 0) {
                        break;
                    }
                }
                if own.iter().zip(&saved).any(|(own, saved)| own & !saved != 0) {
                    changed = true;
                    let next: Vec<u64> = own.iter().zip(&saved).map(|(own, saved)| own & saved).collect();
                    after[state * words..(state + 1) * words].copy_from_slice(&kept(&next, &self.around));
                    self.sets[state * words..(state + 1) * words].copy_from_slice(&next);
                }
            }
        }
    }

    /// True if a state of the lattice is safe with each of these cells of the person.
    pub fn holds(&self, state: usize, cells: &[usize]) -> bool {
        cells.iter().all(|cell| self.sets[state * self.words + cell / 64] >> (cell % 64) & 1 == 1)
    }

    /// The number of a state; none: it is not one of the lattice.
    pub fn state(&self, ground: &Ground, at: Point, velocity: Point) -> Option<usize> {
        Some(ground.at(at)? * self.velocities.count() + self.velocities.code(velocity)?)
    }

    /// The cells in whose middle, or between whose middles, a point is. A point outside of the grid has none.
    pub fn cells(&self, at: Point) -> Vec<usize> {
        let rows = self.around.len() / self.columns;
        let span = |axis: usize, count: usize| {
            let place = (at[axis] - self.low[axis]) / self.cell - 0.5;
            let (first, last) = ((place + SAME).floor(), (place - SAME).ceil());
            (first.min(last).max(0.0) as usize, (last.max(0.0) as usize).min(count - 1))
        };
        let ((left, right), (low, high)) = (span(0, self.columns), span(1, rows));
        let all = (low..=high).flat_map(|row| (left..=right).map(move |column| row * self.columns + column));
        all.filter(|cell| !self.around[*cell].is_empty()).collect()
    }

    /// The cells in which the person can be a period after being at a point.
    pub fn cells_after(&self, at: Point) -> Vec<usize> {
        let mut cells: Vec<usize> = self.cells(at).iter().flat_map(|cell| &self.around[*cell]).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The cells in which the person can be two periods after being in a cell.
    pub fn cells_within_two(&self, cell: usize) -> Vec<usize> {
        let mut cells: Vec<usize> =
            self.around[cell].iter().flat_map(|beside| &self.around[*beside]).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The middle of a cell (m).
    pub fn middle(&self, cell: usize) -> Point {
        let place = [cell % self.columns, cell / self.columns];
        [0, 1].map(|i| self.low[i] + (place[i] as f64 + 0.5) * self.cell)
    }

    pub fn velocities(&self) -> &Velocities {
        &self.velocities
    }
}
