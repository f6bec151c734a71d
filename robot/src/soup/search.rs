//! The nearest elements of a shape, each for those behind it.
//!
//! The plane through the nearest point of an element, across the direction to the shape, has the shape on one side. Elements
//! whose nearest points are behind it, or little in front, are farther away as long as the shape does not pass it: the element
//! stands for them. A wall of thousands of points is one spot, and the wall on the other side is another one. A part can turn about a spot: one stands only for elements that are near to about the
//! same part of the shape.

use nalgebra::Isometry3;

use super::Soup;
use super::tree::{Inside, Node};
use crate::geometry::{Found, Query};
use crate::{Closest, Shape};

/// Height of an element above the plane of a spot, relative to their distance, up to which the spot stands for it: the sine
/// of 14 degrees. The points of a wall are not exactly in a plane, and the nearest one is not exactly at the foot.
const SLOPE: f64 = 0.25;

/// The same, relative to the distance of the spot: what is in front of it by a tenth of that is hardly nearer to the shape.
const RELIEF: f64 = 0.1;

/// The same, absolute \[m\]: for elements that share their nearest point.
const BEHIND: f64 = 1e-6;

/// Depth of the tree beyond that of any soup: its depth is the logarithm of the number of elements.
const DEEPEST: usize = 64;

/// A near element, with its closest points.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Number of the element.
    pub element: usize,
    /// Closest points of the shape, which is `a`, and the element, in the world.
    pub closest: Closest,
    /// Height of the nearest point of a capsule's axis \[m\].
    along: f64,
}

/// Result of a search, beside the spots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// All elements have a direction.
    Apart,
    /// The core of the shape meets elements, which are not among the spots.
    Touching,
    /// A pose is not finite, and no spot was found.
    NotFinite,
}

impl Soup {
    /// Finds spots of a shape, the nearest first, as many as there is room in `spots`; the rest becomes `None`. Both poses
    /// are in the world. Does not allocate.
    ///
    /// The first spot is the nearest element. Each further one is the nearest for which none of those before it stands: it
    /// is more than 14 degrees and a tenth of their distance in front of their planes, or it is nearest to another part of the
    /// shape: of a capsule, farther along its axis than half its length, of a box and others, farther away than half its size.
    /// It is not farther away than `range` \[m\].
    pub fn spots(
        &self,
        shape: &Shape,
        X_Wa: &Isometry3<f64>,
        X_WS: &Isometry3<f64>,
        range: f64,
        spots: &mut [Option<Spot>],
    ) -> Search {
        spots.fill(None);
        let query = Query::new(shape, X_WS.inv_mul(X_Wa));
        if !query.is_finite() {
            return Search::NotFinite;
        }
        let mut result = Search::Apart;
        for k in 0..spots.len() {
            let (taken, rest) = spots.split_at_mut(k);
            let search = Pass { soup: self, query: &query, taken, reach: query.half_length(), size: query.size() };
            rest[0] = search.nearest(range, &mut result);
            if rest[0].is_none() {
                break;
            }
        }
        for spot in spots.iter_mut().flatten() {
            spot.closest = spot.closest.moved(X_WS);
        }
        result
    }
}

/// The search for one spot.
struct Pass<'a> {
    soup: &'a Soup,
    query: &'a Query<'a>,
    /// Spots that are known.
    taken: &'a [Option<Spot>],
    /// Length of a capsule's axis to each side of a spot's point for which the spot stands \[m\].
    reach: f64,
    /// Distance between the nearest points of another shape up to which a spot stands for what is nearest there \[m\].
    size: f64,
}

/// The nearest element for which no spot stands, as far as it is known.
struct Best {
    spot: Option<Spot>,
    distance: f64,
}

impl Pass<'_> {
    /// The nearest element for which no spot stands; the first one at any distance.
    fn nearest(&self, range: f64, result: &mut Search) -> Option<Spot> {
        let nodes = &self.soup.0.tree.nodes;
        let mut best = Best { spot: None, distance: if self.taken.is_empty() { f64::INFINITY } else { range } };
        let mut waiting = [(0u32, f64::NEG_INFINITY); DEEPEST];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (at, least) = waiting[count];
            if least >= best.distance {
                continue;
            }
            match nodes.get(at as usize)?.inside {
                Inside::Halves(right) => {
                    let of = |child: u32| self.bound(nodes.get(child as usize)?);
                    let (left, right) = ((at + 1, of(at + 1)), (right, of(right)));
                    // The nearer one is looked at first.
                    let left_first = left.1.unwrap_or(f64::INFINITY) <= right.1.unwrap_or(f64::INFINITY);
                    for (child, bound) in if left_first { [right, left] } else { [left, right] } {
                        if let Some(bound) = bound.filter(|b| *b < best.distance && count < DEEPEST) {
                            waiting[count] = (child, bound);
                            count += 1;
                        }
                    }
                }
                Inside::Elements(from, to) => {
                    for element in from as usize..to as usize {
                        self.consider(element, &mut best, result);
                    }
                }
            }
        }
        best.spot
    }

    /// Takes an element if it is nearer than the best one, and no spot stands for it.
    fn consider(&self, element: usize, best: &mut Best, result: &mut Search) {
        let (corners, radius) = (self.soup.corners(element), self.soup.radius());
        if self.query.is_farther(corners, radius, best.distance) {
            return;
        }
        match self.query.closest(corners, radius) {
            Ok(Found { closest, along }) if closest.distance < best.distance => {
                let above = |s: &Spot| {
                    let away = closest.on_b - s.closest.on_b;
                    let aside = if self.size.is_finite() { (closest.on_a - s.closest.on_a).norm() } else { 0.0 };
                    Above { height: s.closest.normal.dot(&away), away: away.norm(), aside }
                };
                if !self.is_stood_for([along; 2], above) {
                    *best = Best { spot: Some(Spot { element, closest, along }), distance: closest.distance };
                }
            }
            Ok(_) => {}
            Err(_) => *result = Search::Touching,
        }
    }

    /// A distance below that of all elements of a node; `None` if spots stand for all of them.
    fn bound(&self, node: &Node) -> Option<f64> {
        let seen = self.query.see(&node.centre);
        let around = self.soup.radius();
        let radius = node.radius + around;
        if !self.taken.is_empty() {
            let along = [seen.along - radius, seen.along + radius].map(|x| x.clamp(-self.reach, self.reach));
            let above = |spot: &Spot| {
                let Closest { on_b, normal, .. } = &spot.closest;
                let away = node.centre - on_b;
                let (middle, far) = (normal.dot(&away) + around, (away.norm() - radius).max(0.0));
                // In front of the plane with its middle already, the node is not behind it.
                let height = if middle > SLOPE * far + relief(spot) { 0.0 } else { node.height(normal) };
                // Nearest points are not farther apart than the points to which they belong.
                let aside = seen.on.map_or(0.0, |on| (on - spot.closest.on_a).norm() + radius);
                Above { height: middle + height, away: far, aside }
            };
            if self.is_stood_for(along, above) {
                return None;
            }
        }
        Some(seen.distance - radius)
    }

    /// True if spots stand for all points that are nearest to a part of a capsule's axis, each for those near to its own point.
    fn is_stood_for(&self, [mut from, to]: [f64; 2], above: impl Fn(&Spot) -> Above) -> bool {
        // A bit for each spot; those beyond stand for nothing.
        let mut behind = 0u64;
        let spots = || self.taken.iter().flatten().enumerate().take(64);
        for (i, spot) in spots() {
            let Above { height, away, aside } = above(spot);
            // With what is inside, nothing is known of where it is nearest.
            if height > SLOPE * away + relief(spot) || aside.is_nan() || aside > self.size {
                continue;
            }
            if spot.along - self.reach <= from && to <= spot.along + self.reach {
                return true;
            }
            behind |= 1 << i;
        }
        if behind.count_ones() < 2 {
            return false;
        }
        // Each round finds the spot that stands for the beginning of what is left and most of what follows.
        loop {
            let mut far = f64::NEG_INFINITY;
            for (i, spot) in spots() {
                if behind >> i & 1 == 1 && (spot.along - from).abs() <= self.reach {
                    far = far.max(spot.along + self.reach);
                }
            }
            if far >= to || far.is_nan() || far <= from {
                return far >= to;
            }
            from = far;
        }
    }
}

/// Place of points against the plane of a spot: at most so high, at least so far away, and nearest to points of the shape that
/// are at most so far from that of the spot \[m\].
struct Above {
    height: f64,
    away: f64,
    aside: f64,
}

/// Height above the plane of a spot up to which it stands for everything \[m\].
fn relief(spot: &Spot) -> f64 {
    RELIEF * spot.closest.distance.max(0.0) + BEHIND
}
