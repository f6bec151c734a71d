//! The nearest elements of a shape, each for those behind it.
//!
//! The plane through the nearest point of an element, across the direction to the shape, has the shape on one side. Elements
//! whose nearest points are behind it, or little in front, seen from nearly the same point of the shape, are farther away as
//! long as the shape does not pass it: the element stands for them. A wall of thousands of points is one spot or two, and the
//! wall on the other side is another one.

use nalgebra::{Isometry3, Vector3};

use super::Soup;
use super::tree::{Inside, Node};
use crate::geometry::{Found, Query};
use crate::{Closest, Shape};

/// Height of an element above the plane of a spot, relative to their distance, up to which the spot stands for it: the sine
/// of 14 degrees. The points of a wall are not exactly in a plane, and the nearest one is not exactly at the foot.
const SLOPE: f64 = 0.25;

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
    /// The nearest point of the shape's core, in the frame of the soup.
    core: Vector3<f64>,
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

/// The nearest element that no spot stands for, as far as it is known.
struct Best {
    element: usize,
    found: Option<Found>,
    distance: f64,
}

impl Soup {
    /// Finds spots of a shape, the nearest first, as many as there is room in `spots`; the rest becomes `None`. Both poses
    /// are in the world. Does not allocate.
    ///
    /// The first spot is the nearest element. Each further one is the nearest for which none of those before it stands: it
    /// is more than 14 degrees in front of their planes, or the nearest points of the shape's core are farther apart than
    /// half its size.
    pub fn spots(
        &self,
        shape: &Shape,
        X_Wa: &Isometry3<f64>,
        X_WS: &Isometry3<f64>,
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
            let Some(Best { element, found: Some(found), .. }) = self.nearest(&query, taken, &mut result) else {
                break;
            };
            rest[0] = Some(Spot { element, closest: found.closest, core: found.core });
        }
        for spot in spots.iter_mut().flatten() {
            spot.closest = spot.closest.moved(X_WS);
        }
        result
    }

    /// The nearest element for which no spot stands.
    fn nearest(&self, query: &Query, taken: &[Option<Spot>], result: &mut Search) -> Option<Best> {
        let nodes = &self.0.tree.nodes;
        let reach = query.size();
        let mut best = Best { element: 0, found: None, distance: f64::INFINITY };
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
                    let of = |child: u32| bound(query, nodes.get(child as usize)?, taken, reach);
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
                        match query.closest(self.corners(element), self.0.radius) {
                            Ok(found) if found.closest.distance < best.distance => {
                                let stands = |s: &Spot| stands_for(s, &found.closest.on_b, &found.core, 0.0, reach);
                                if !taken.iter().flatten().any(stands) {
                                    best = Best { element, distance: found.closest.distance, found: Some(found) };
                                }
                            }
                            Ok(_) => {}
                            Err(_) => *result = Search::Touching,
                        }
                    }
                }
            }
        }
        Some(best)
    }
}

/// A distance below that of all elements in a ball; `None` if a spot stands for all of them.
fn bound(query: &Query, node: &Node, taken: &[Option<Spot>], reach: f64) -> Option<f64> {
    let seen = query.see(&node.centre);
    // Nearest points of the core are not farther apart than the points of the ball to which they belong.
    if let Some(core) = seen.core
        && taken.iter().flatten().any(|spot| stands_for(spot, &node.centre, &core, node.radius, reach))
    {
        return None;
    }
    Some(seen.distance - node.radius)
}

/// True if a spot stands for all points within a radius about `at`, whose nearest points of the core are as near to `core`.
fn stands_for(spot: &Spot, at: &Vector3<f64>, core: &Vector3<f64>, radius: f64, reach: f64) -> bool {
    let Closest { on_b, normal, .. } = &spot.closest;
    let away = at - on_b;
    // A step of some length changes the left side by that length and a slope of it at most.
    normal.dot(&away) - SLOPE * away.norm() + (1.0 + SLOPE) * radius <= BEHIND
        && (core - spot.core).norm() + radius <= reach
}
