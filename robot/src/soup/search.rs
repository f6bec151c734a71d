//! The nearest elements of a shape, each for those behind it.
//!
//! The plane through the nearest point of an element, across the direction to the shape, has the shape on one side. Elements
//! whose nearest points are behind it, or little in front, are farther away as long as the shape does not pass it: the element
//! stands for them. A wall of thousands of points is one spot, and the wall on the other side is another one. A part can turn
//! about a spot: one stands only for elements that are near to about the same part of the shape.
//!
//! Nodes and elements wait in the order of a bound of their distance. The nearest one is looked at next, so that elements come
//! in the order of their distances, and each node is looked at once for all spots.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::{Isometry3, Vector3};

use super::Soup;
use super::tree::{Inside, Node};
use crate::geometry::{Found, Query, Seen};
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

/// Rounding of a bound of an element's distance \[m\].
const ROUNDING: f64 = 1e-12;

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

/// Room for the search of spots, one search after the other.
#[derive(Clone, Debug, Default)]
pub struct Frontier(BinaryHeap<Waiting>);

impl Frontier {
    /// Makes room for spots of a soup.
    pub fn reserve(&mut self, soup: &Soup) {
        // Of a node and what is inside, only one waits: there are never more than elements.
        self.0.clear();
        self.0.reserve(soup.len());
    }
}

/// A node or an element, and a bound of its distance \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Waiting {
    least: f64,
    what: What,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Node(u32),
    /// An element whose distance is not known yet.
    Unseen(u32),
    /// An element whose distance is the bound.
    Seen(u32),
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    /// The nearest one is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(other.what.cmp(&self.what))
    }
}

impl Soup {
    /// Finds spots of a shape, the nearest first, as many as there is room in `spots`; the rest becomes `None`. Both poses
    /// are in the world. Does not allocate if the frontier has room for this soup.
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
        frontier: &mut Frontier,
    ) -> Search {
        spots.fill(None);
        let query = Query::new(shape, X_WS.inv_mul(X_Wa));
        if !query.is_finite() {
            return Search::NotFinite;
        }
        frontier.0.clear();
        let (reach, size) = (query.half_length(), query.size());
        let mut result = Search::Apart;
        let mut count = 0;
        let mut next = Some(Waiting { least: f64::NEG_INFINITY, what: What::Node(0) });
        while let Some(Waiting { least, what }) = next.filter(|w| count == 0 || w.least < range) {
            let stand = Standing { taken: &spots[..count], reach, size };
            match what {
                _ if count == spots.len() => break,
                What::Node(at) => self.open(at, &query, &stand, range, frontier),
                What::Unseen(element) | What::Seen(element) => {
                    match query.closest(self.corners(element as usize), self.radius()) {
                        Err(_) => result = Search::Touching,
                        Ok(found) if stand.is_for_element(&found) => {}
                        Ok(Found { closest, along }) => {
                            let nearer = frontier.0.peek().is_some_and(|w| w.least < closest.distance);
                            if nearer && matches!(what, What::Unseen(_)) {
                                let least = closest.distance.max(least);
                                frontier.0.push(Waiting { least, what: What::Seen(element) });
                            } else if count == 0 || closest.distance < range {
                                spots[count] = Some(Spot { element: element as usize, closest, along });
                                count += 1;
                            }
                        }
                    }
                }
            }
            next = frontier.0.pop();
        }
        for spot in spots.iter_mut().flatten() {
            spot.closest = spot.closest.moved(X_WS);
        }
        result
    }

    /// Puts what is in a node into the frontier, unless spots stand for all of it.
    fn open(&self, at: u32, query: &Query, stand: &Standing, range: f64, frontier: &mut Frontier) {
        let Some(node) = self.0.tree.nodes.get(at as usize) else { return };
        let around = self.radius();
        if !stand.taken.is_empty() && stand.is_for_node(node, around, query) {
            return;
        }
        let range = if stand.taken.is_empty() { f64::INFINITY } else { range };
        let mut wait = |least: f64, what: What| {
            if least < range {
                frontier.0.push(Waiting { least, what });
            }
        };
        match node.inside {
            Inside::Halves(right) => {
                for child in [at + 1, right] {
                    if let Some(node) = self.0.tree.nodes.get(child as usize) {
                        wait(bound(node, &query.see(&node.centre)) - around, What::Node(child));
                    }
                }
            }
            Inside::Elements(from, to) => {
                let mut seen = None;
                for element in from..to {
                    let corners = self.corners(element as usize);
                    if let Some(distance) = query.distance(corners) {
                        wait(distance - around, What::Seen(element));
                    } else {
                        let seen = seen.get_or_insert_with(|| query.see(&node.centre));
                        wait(element_bound(corners, node, seen) - around, What::Unseen(element));
                    }
                }
            }
        }
    }

    /// Finds the nearest element of a shape; both poses are in the world. Does not allocate.
    ///
    /// # Errors
    /// The core of the shape meets elements, or a pose is not finite.
    pub fn nearest(&self, shape: &Shape, X_Wa: &Isometry3<f64>, X_WS: &Isometry3<f64>) -> Result<Spot, Search> {
        self.nearest_from(None, shape, X_Wa, X_WS)
    }

    /// As [`Soup::nearest`]; an element that is near makes it faster.
    pub(crate) fn nearest_from(
        &self,
        hint: Option<usize>,
        shape: &Shape,
        X_Wa: &Isometry3<f64>,
        X_WS: &Isometry3<f64>,
    ) -> Result<Spot, Search> {
        let query = Query::new(shape, X_WS.inv_mul(X_Wa));
        if !query.is_finite() {
            return Err(Search::NotFinite);
        }
        let (nodes, around) = (&self.0.tree.nodes, self.radius());
        let mut best: Option<Spot> = None;
        let mut distance = f64::INFINITY;
        let mut consider = |element: usize, distance: &mut f64| {
            let found = query.closest(self.corners(element), around).map_err(|_| Search::Touching)?;
            if found.closest.distance < *distance {
                *distance = found.closest.distance;
                best = Some(Spot { element, closest: found.closest, along: found.along });
            }
            Ok(())
        };
        if let Some(hint) = hint.filter(|hint| *hint < self.len()) {
            consider(hint, &mut distance)?;
        }
        let mut waiting = [(0u32, f64::NEG_INFINITY); DEEPEST];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (at, least) = waiting[count];
            let Some(node) = nodes.get(at as usize).filter(|_| least < distance) else { continue };
            match node.inside {
                Inside::Halves(right) => {
                    let of = |child: u32| {
                        let node = nodes.get(child as usize);
                        (child, node.map_or(f64::INFINITY, |n| bound(n, &query.see(&n.centre)) - around))
                    };
                    let (left, right) = (of(at + 1), of(right));
                    // The nearer one is looked at first.
                    for (child, bound) in if left.1 <= right.1 { [right, left] } else { [left, right] } {
                        if bound < distance && count < DEEPEST {
                            waiting[count] = (child, bound);
                            count += 1;
                        }
                    }
                }
                Inside::Elements(from, to) => {
                    let seen = query.see(&node.centre);
                    for element in from..to {
                        let corners = self.corners(element as usize);
                        let least = query.distance(corners).unwrap_or_else(|| element_bound(corners, node, &seen));
                        if least - around < distance {
                            consider(element as usize, &mut distance)?;
                        }
                    }
                }
            }
        }
        let spot = best.ok_or(Search::NotFinite)?;
        Ok(Spot { closest: spot.closest.moved(X_WS), ..spot })
    }
}

/// A distance below that of all corners in a node \[m\].
fn bound(node: &Node, seen: &Seen) -> f64 {
    // A plane across the direction to the shape has the node on one side and the shape on the other.
    let known = seen.towards != Vector3::zeros();
    seen.distance - if known { node.height(&seen.towards).min(node.radius) } else { node.radius }
}

/// A distance below that of an element of a node \[m\].
fn element_bound(corners: &[Vector3<f64>], node: &Node, seen: &Seen) -> f64 {
    if seen.towards == Vector3::zeros() {
        return seen.distance - node.radius;
    }
    let high = corners.iter().map(|p| seen.towards.dot(&(p - node.centre))).fold(f64::NEG_INFINITY, f64::max);
    seen.distance - high - ROUNDING
}

/// Spots, and for what they stand.
struct Standing<'a> {
    taken: &'a [Option<Spot>],
    /// Length of a capsule's axis to each side of a spot's point for which the spot stands \[m\].
    reach: f64,
    /// Distance between the nearest points of another shape up to which a spot stands for what is nearest there \[m\].
    size: f64,
}

impl Standing<'_> {
    /// True if spots stand for an element.
    fn is_for_element(&self, Found { closest, along }: &Found) -> bool {
        let above = |s: &Spot| {
            let away = closest.on_b - s.closest.on_b;
            let aside = if self.size.is_finite() { (closest.on_a - s.closest.on_a).norm() } else { 0.0 };
            Above { height: s.closest.normal.dot(&away), away: away.norm(), aside }
        };
        self.is_for([*along; 2], above)
    }

    /// True if spots stand for all elements of a node with this radius around each.
    fn is_for_node(&self, node: &Node, around: f64, query: &Query) -> bool {
        let radius = node.radius + around;
        let (middle, axis) = query.along(&node.centre);
        let wide = node.height(&axis).min(node.radius) + around;
        let along = [middle - wide, middle + wide].map(|x| x.clamp(-self.reach, self.reach));
        let on = if self.size.is_finite() { query.see(&node.centre).on } else { None };
        let above = |spot: &Spot| {
            let Closest { on_b, normal, .. } = &spot.closest;
            let away = node.centre - on_b;
            let (middle, far) = (normal.dot(&away) + around, (away.norm() - radius).max(0.0));
            // In front of the plane with its middle already, the node is not behind it.
            let height = if middle > SLOPE * far + relief(spot) { 0.0 } else { node.height(normal).min(node.radius) };
            // Nearest points are not farther apart than the points to which they belong.
            let aside = on.map_or(0.0, |on| (on - spot.closest.on_a).norm() + radius);
            Above { height: middle + height, away: far, aside }
        };
        self.is_for(along, above)
    }

    /// True if spots stand for all points that are nearest to a part of a capsule's axis, each for those near to its own point.
    fn is_for(&self, [mut from, to]: [f64; 2], above: impl Fn(&Spot) -> Above) -> bool {
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
