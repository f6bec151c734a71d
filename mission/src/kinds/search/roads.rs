//! Ways between lookouts: Dijkstra's algorithm over the cells of the belief where a body fits.
//!
//! Lookouts are many, and are middles of cells. A graph of neighbouring cells with clear motions between their middles, made once for a
//! body, gives the ways from each of them to all others at once; RRT* remains for what it does not connect.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::geometry::{Point, distance};
use super::ground::Ground;
use super::sight::Sight;
use super::tree::Price;

/// Farthest cells that a point is connected to, in widths of a cell.
const NEAR: f64 = 1.6;

/// The graph of the cells where a body fits.
#[derive(Debug)]
pub struct Roads<'s> {
    sight: &'s Sight,
    reach: f64,
    /// Neighbours of each cell with the prices of the motions there.
    edges: Vec<Vec<(u32, f64)>>,
}

/// A cell to be visited, the cheapest first.
#[derive(PartialEq)]
struct Open {
    price: f64,
    cell: u32,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Open) -> Ordering {
        other.price.total_cmp(&self.price).then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Open) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<'s> Roads<'s> {
    /// The graph for a body with a price of its motions; cells have this width (m).
    pub fn new(sight: &'s Sight, ground: &Ground, cell: f64, price: &Price<'_>) -> Roads<'s> {
        let reach = NEAR * cell;
        let fits: Vec<bool> = sight.middles().iter().map(|at| ground.fits(*at)).collect();
        let mut edges: Vec<Vec<(u32, f64)>> = vec![Vec::new(); sight.len()];
        for one in (0..sight.len()).filter(|one| fits[*one]) {
            let at = sight.middles()[one];
            for other in sight.around(at, reach).filter(|other| *other as usize > one && fits[*other as usize]) {
                let to = sight.middles()[other as usize];
                if ground.clear(at, to) {
                    let price = price.edge(at, to);
                    edges[one].push((other, price));
                    edges[other as usize].push((one as u32, price));
                }
            }
        }
        Roads { sight, reach, edges }
    }

    /// Cells that a body reaches straight from a point, with the prices.
    fn near(&self, ground: &Ground, at: Point, price: &Price<'_>) -> Vec<(u32, f64)> {
        let middles = self.sight.middles();
        let cells = self.sight.around(at, self.reach).filter(|cell| {
            let to = middles[*cell as usize];
            ground.fits(to) && (distance(at, to) <= 1e-9 || ground.clear(at, to))
        });
        cells.map(|cell| (cell, price.edge(at, middles[cell as usize]))).collect()
    }

    /// Ways from a root to targets; none: they are not connected.
    pub fn ways(&self, ground: &Ground, root: Point, targets: &[Point], price: &Price<'_>) -> Vec<Option<Vec<Point>>> {
        let count = self.edges.len();
        let (mut prices, mut before) = (vec![f64::INFINITY; count], vec![u32::MAX; count]);
        let mut open = BinaryHeap::new();
        for (cell, price) in self.near(ground, root, price) {
            prices[cell as usize] = price;
            open.push(Open { price, cell });
        }
        while let Some(Open { price, cell }) = open.pop() {
            if price > prices[cell as usize] {
                continue;
            }
            for (next, more) in &self.edges[cell as usize] {
                let sum = price + more;
                if sum < prices[*next as usize] {
                    prices[*next as usize] = sum;
                    before[*next as usize] = cell;
                    open.push(Open { price: sum, cell: *next });
                }
            }
        }
        let middles = self.sight.middles();
        let way = |to: &Point| {
            let near = self.near(ground, *to, price).into_iter();
            let total = |(cell, more): &(u32, f64)| prices[*cell as usize] + more;
            let last = near.filter(|end| total(end).is_finite()).min_by(|a, b| total(a).total_cmp(&total(b)))?;
            let (mut cell, mut points) = (last.0, vec![*to]);
            loop {
                points.push(middles[cell as usize]);
                match before[cell as usize] {
                    u32::MAX => break,
                    next => cell = next,
                }
            }
            points.push(root);
            points.reverse();
            points.dedup_by(|a, b| distance(*a, *b) <= 1e-9);
            Some(points)
        };
        targets.iter().map(way).collect()
    }
}
