//! The plane at which a part is cut: the one for which the hulls of both sides have the smallest volume together.
//!
//! Of each slab between two candidates, the points that are farthest along some directions are enough for an estimate of these
//! volumes. Among planes that save as much, one that follows flat faces of the mesh is preferred, then one in the middle:
//! neither the underside of a table nor a plane through its middle saves anything at first, but the first leaves its top whole.

use nalgebra::Vector3;

use super::clip::{Plane, Sides, Triangle};
use crate::Hull;

/// Number of planes at equal distances, for each axis.
const EVEN: usize = 9;

/// Largest number of planes along flat faces, for each axis.
const MOST_FLAT: usize = 10;

/// Weights of flat faces, of the middle, and of the size of the larger side, relative to the volume that a cut saves.
const FLAT: f64 = 0.05;
const MIDDLE: f64 = 0.01;
const SIZE: f64 = 0.2;

/// Number of directions for an estimate: axes, edges and corners of a cube.
const DIRECTIONS: usize = 26;

/// Points of a set that are farthest along the directions.
#[derive(Clone)]
struct Extremes([Option<Vector3<f64>>; DIRECTIONS]);

impl Extremes {
    fn add(&mut self, p: &Vector3<f64>, directions: &[Vector3<f64>; DIRECTIONS]) {
        for (best, d) in self.0.iter_mut().zip(directions) {
            if best.is_none_or(|b| d.dot(p) > d.dot(&b)) {
                *best = Some(*p);
            }
        }
    }

    fn join(&mut self, other: &Extremes, directions: &[Vector3<f64>; DIRECTIONS]) {
        for (best, (p, d)) in self.0.iter_mut().zip(other.0.iter().zip(directions)) {
            if let Some(p) = p.filter(|p| best.is_none_or(|b| d.dot(p) > d.dot(&b))) {
                *best = Some(p);
            }
        }
    }

    /// Measures of the hull; `None` without points.
    fn hull(&self) -> Option<Side> {
        let points: Vec<Vector3<f64>> = self.0.iter().flatten().copied().collect();
        let (_, hull) = Hull::around(&points).ok()?;
        Some(Side { volume: hull.volume(), radius: hull.radius() })
    }
}

/// Measures of the hull of a side.
#[derive(Clone, Copy)]
struct Side {
    /// \[m³\]
    volume: f64,
    /// Of a ball around it \[m\].
    radius: f64,
}

fn directions() -> [Vector3<f64>; DIRECTIONS] {
    let mut all = [Vector3::zeros(); DIRECTIONS];
    let grid = (0..27).filter(|i| *i != 13).map(|i| [i % 3, i / 3 % 3, i / 9].map(|x| f64::from(x) - 1.0));
    for (d, x) in all.iter_mut().zip(grid) {
        *d = Vector3::from(x);
    }
    all
}

/// A candidate.
#[derive(Clone, Copy)]
struct Candidate {
    plane: Plane,
    /// Share of the part's cross-section that flat faces of the mesh cover.
    flat: f64,
}

/// The best plane for the triangles of a part; `None` if there is none that leaves something on both sides. Points that are
/// nearer than `tolerance` to a plane are on it \[m\]. An axis along which
/// the part is thinner than it exceeds the mesh, `excess` \[m\], is not cut: a hollow of this size stays.
pub(super) fn best(triangles: &[Triangle], tolerance: f64, excess: f64) -> Option<Plane> {
    let directions = directions();
    let mut best: Option<(f64, Plane)> = None;
    for axis in 0..3 {
        let candidates = candidates(triangles, axis, tolerance, excess);
        let slabs = slabs(triangles, &candidates, &directions);
        let above = accumulated(slabs.iter().rev(), &directions);
        let below = accumulated(slabs.iter(), &directions);
        let Some(whole) = below.last().copied().flatten() else { continue };
        for (i, c) in candidates.iter().enumerate() {
            let (Some(low), Some(high)) = (below[i], above[slabs.len() - 2 - i]) else { continue };
            let volume = |x: f64| if whole.volume > 0.0 { x / whole.volume } else { 0.0 };
            let size = low.radius.max(high.radius) / whole.radius.max(tolerance);
            let cost = volume(low.volume + high.volume) + SIZE * size * size - FLAT * c.flat
                + MIDDLE * volume((low.volume - high.volume).abs());
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, c.plane));
            }
        }
    }
    best.map(|(_, plane)| plane)
}

/// Planes across an axis, from the lowest on.
fn candidates(triangles: &[Triangle], axis: usize, tolerance: f64, excess: f64) -> Vec<Candidate> {
    let wide = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (low, high) = triangles.iter().flatten().fold(wide, |(l, h), p| (l.inf(p), h.sup(p)));
    let size = high - low;
    if size[axis] <= excess {
        return Vec::new();
    }
    let section = size[(axis + 1) % 3] * size[(axis + 2) % 3];
    let inside = |x: f64| x > low[axis] + 4.0 * tolerance && x < high[axis] - 4.0 * tolerance;
    let mut found: Vec<Candidate> = Vec::new();
    let plane = |at: f64| Plane { axis, at, tolerance };
    // Areas of flat faces by their coordinate.
    let mut faces: Vec<[f64; 2]> = Vec::new();
    for [a, b, c] in triangles {
        let at = a[axis];
        if (b[axis] - at).abs().max((c[axis] - at).abs()) <= tolerance && inside(at) {
            faces.push([at, 0.5 * (b - a).cross(&(c - a)).norm()]);
        }
    }
    faces.sort_by(|p, q| p[0].total_cmp(&q[0]));
    for [at, area] in faces {
        let share = if section > 0.0 { area / section } else { 0.0 };
        match found.last_mut() {
            Some(last) if at - last.plane.at <= 2.0 * tolerance => last.flat += share,
            _ => found.push(Candidate { plane: plane(at), flat: share }),
        }
    }
    found.sort_by(|p, q| q.flat.total_cmp(&p.flat).then(p.plane.at.total_cmp(&q.plane.at)));
    found.truncate(MOST_FLAT);
    found.iter_mut().for_each(|c| c.flat = c.flat.min(1.0));
    let flats: Vec<f64> = found.iter().map(|c| c.plane.at).collect();
    let even = (1..=EVEN).map(|i| low[axis] + size[axis] * i as f64 / (EVEN + 1) as f64);
    let near = |x: f64| flats.iter().any(|f| (f - x).abs() <= 4.0 * tolerance);
    found.extend(even.filter(|x| inside(*x) && !near(*x)).map(|x| Candidate { plane: plane(x), flat: 0.0 }));
    found.sort_by(|p, q| p.plane.at.total_cmp(&q.plane.at));
    found
}

/// Extremes of the slabs between candidates; there is one more of them.
fn slabs(triangles: &[Triangle], candidates: &[Candidate], directions: &[Vector3<f64>; DIRECTIONS]) -> Vec<Extremes> {
    let mut slabs = vec![Extremes([None; DIRECTIONS]); candidates.len() + 1];
    let mut sides = Sides::default();
    let Some(axis) = candidates.first().map(|c| c.plane.axis) else { return slabs };
    for triangle in triangles {
        let lowest = triangle.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let first = candidates.partition_point(|c| c.plane.at + c.plane.tolerance < lowest);
        let mut rest = vec![*triangle];
        for (i, c) in candidates.iter().enumerate().skip(first) {
            for t in rest.drain(..) {
                c.plane.split(&t, &mut sides);
            }
            sides.below.drain(..).flatten().for_each(|p| slabs[i].add(&p, directions));
            std::mem::swap(&mut rest, &mut sides.above);
            if rest.is_empty() {
                break;
            }
        }
        if let Some(last) = slabs.last_mut() {
            rest.iter().flatten().for_each(|p| last.add(p, directions));
        }
    }
    slabs
}

/// Hulls of the first slab, of the first two, and so on.
fn accumulated<'s>(
    slabs: impl Iterator<Item = &'s Extremes>,
    directions: &[Vector3<f64>; DIRECTIONS],
) -> Vec<Option<Side>> {
    let mut sum = Extremes([None; DIRECTIONS]);
    let hull = |slab: &Extremes| {
        sum.join(slab, directions);
        sum.hull()
    };
    slabs.map(hull).collect()
}
