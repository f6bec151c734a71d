//! The excess of a shape over a mesh: the greatest distance of a point of its surface from the mesh, and its volume.
//!
//! The distance to the mesh changes by at most the way between two points, so that its value in the middle of a patch bounds
//! it on the whole patch. The patch with the greatest bound is divided until no bound is far above a value that was found
//! (branch and bound): the result is a bound, and nearly reached.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::{Isometry3, Point3, Vector3};

use crate::geometry::closest_point_triangle;
use crate::surface::Surface;
use crate::{PlacedShape, Shape};

/// Largest number of patches that are looked at for a bound that is shown.
const MOST_PATCHES: usize = 60_000;

/// Distance up to which a patch is in the plane of a triangle, relative to the size of the mesh.
const IN_PLANE: f64 = 1e-9;

/// Width of the rim of a patch that may touch the mesh, relative to its size.
const EDGE: f64 = 1e-4;

/// Number of edges of the polygon around the end of a cylinder.
const RIM: usize = 64;

/// Excess of shapes over a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// A bound of the distance of their surfaces from the mesh \[m\].
    pub distance: f64,
    /// Their volume \[m³\], where they overlap counted for each.
    pub volume: f64,
}

/// A part of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Patch {
    /// A triangle. If `in_cut`, it may be inside of the mesh, where nothing is exceeded.
    Flat { corners: [Vector3<f64>; 3], in_cut: bool },
    /// A triangle on a sphere, by three directions from its centre.
    Cap { centre: Vector3<f64>, radius: f64, directions: [Vector3<f64>; 3] },
    /// A triangle on a cylinder about the z axis of a pose, by three angles and heights.
    Side { pose: Isometry3<f64>, radius: f64, places: [[f64; 2]; 3] },
}

impl Patch {
    fn middle(&self) -> Vector3<f64> {
        match self {
            Patch::Flat { corners: [a, b, c], .. } => (a + b + c) / 3.0,
            Patch::Cap { centre, radius, directions: [a, b, c] } => centre + (a + b + c).normalize() * *radius,
            Patch::Side { places, .. } => {
                let mean = |i: usize| (places[0][i] + places[1][i] + places[2][i]) / 3.0;
                self.on_side([mean(0), mean(1)])
            }
        }
    }

    /// A bound of the distance of its points from its middle.
    fn reach(&self) -> f64 {
        match self {
            Patch::Flat { corners, .. } => {
                let m = self.middle();
                corners.iter().map(|p| (p - m).norm()).fold(0.0, f64::max)
            }
            // A cap of less than half a sphere that contains the corners contains the triangle.
            Patch::Cap { centre, radius, directions } => {
                let m = self.middle();
                directions.iter().map(|d| (centre + d * *radius - m).norm()).fold(0.0, f64::max)
            }
            // Along the surface, where distances are those of a plane.
            Patch::Side { radius, places, .. } => {
                let mean = |i: usize| (places[0][i] + places[1][i] + places[2][i]) / 3.0;
                let away = |p: &[f64; 2]| (radius * (p[0] - mean(0))).hypot(p[1] - mean(1));
                places.iter().map(away).fold(0.0, f64::max)
            }
        }
    }

    fn on_side(&self, [angle, z]: [f64; 2]) -> Vector3<f64> {
        match self {
            Patch::Side { pose, radius, .. } => {
                (pose * Point3::new(radius * angle.cos(), radius * angle.sin(), z)).coords
            }
            _ => Vector3::zeros(),
        }
    }

    /// Parts of it, smaller ones: halves of a flat one, which may be long and thin, and quarters of another.
    fn parts(&self) -> impl Iterator<Item = Patch> {
        fn quarters<P: Copy>([a, b, c]: [P; 3], middle: impl Fn(P, P) -> P) -> [[P; 3]; 4] {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        }
        let all = match *self {
            Patch::Flat { corners: [a, b, c], in_cut } => {
                let sides = [(a - b).norm_squared(), (b - c).norm_squared(), (c - a).norm_squared()];
                let [p, q, r] = match sides {
                    [ab, bc, ca] if ab >= bc && ab >= ca => [a, b, c],
                    [_, bc, ca] if bc >= ca => [b, c, a],
                    _ => [c, a, b],
                };
                let m = 0.5 * (p + q);
                let half = |corners| Some(Patch::Flat { corners, in_cut });
                [half([p, m, r]), half([m, q, r]), None, None]
            }
            Patch::Cap { centre, radius, directions } => quarters(directions, |p, q| (p + q).normalize())
                .map(|directions| Some(Patch::Cap { centre, radius, directions })),
            Patch::Side { pose, radius, places } => quarters(places, |p, q| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])])
                .map(|places| Some(Patch::Side { pose, radius, places })),
        };
        all.into_iter().flatten()
    }

    /// The excess in its middle, and a bound for the whole patch.
    /// An element that is near to it helps to find the nearest one.
    fn look(&self, surface: &Surface, near: Option<usize>) -> Look {
        let m = self.middle();
        let Patch::Flat { corners: [a, b, c], in_cut } = self else {
            let middle = surface.distance(&m);
            return Look { middle, bound: middle + self.reach(), triangle: None, element: None };
        };
        let seen = surface.look(&m, &(b - a).cross(&(c - a)), *in_cut, near);
        let element = seen.element;
        if seen.is_inside {
            // Inside of the mesh, and cut by none of its triangles, all but a rim is inside.
            let (middle, reach) = (-seen.distance, self.reach());
            let inner = [a, b, c].map(|p| p + (m - p) * EDGE);
            let is_clear = middle + reach > 0.0 && surface.is_clear_of(&inner);
            let bound = if is_clear { EDGE * reach } else { middle + reach };
            return Look { middle, bound, triangle: None, element };
        }
        let bound = seen.distance + self.reach();
        // The distance to one triangle is convex, and greatest at a corner: zero for a patch that is a part of it.
        let away =
            |t: &Triangle| [a, b, c].iter().map(|p| (*p - closest_point_triangle(p, t)).norm()).fold(0.0, f64::max);
        let bound = seen.triangle.as_ref().map_or(bound, |t| bound.min(away(t)));
        Look { middle: seen.distance, bound, triangle: seen.triangle, element }
    }

    /// Rest of a flat patch without a triangle of the mesh that covers its middle; `None` if they are in two planes.
    fn uncovered(&self, by: &Triangle, tolerance: f64) -> Option<Vec<Patch>> {
        let Patch::Flat { corners, in_cut } = *self else { return None };
        let [a, b, c] = by;
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        if corners.iter().any(|p| normal.dot(&(p - a)).abs() > tolerance) {
            return None;
        }
        let (mut inside, mut left) = (corners.to_vec(), Vec::new());
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let inward = normal.cross(&(q - p)).try_normalize(0.0)?;
            let height = |r: &Vector3<f64>| inward.dot(&(r - p));
            let mut outside = Vec::new();
            let mut kept = Vec::new();
            for (i, from) in inside.iter().enumerate() {
                let to = &inside[(i + 1) % inside.len()];
                let (h, k) = (height(from), height(to));
                if h >= 0.0 {
                    kept.push(*from)
                } else {
                    outside.push(*from)
                }
                if (h < 0.0) != (k < 0.0) {
                    let crossing = from + (to - from) * (h / (h - k));
                    kept.push(crossing);
                    outside.push(crossing);
                }
            }
            if let [first, rest @ ..] = outside.as_slice() {
                left.extend(rest.windows(2).map(|r| Patch::Flat { corners: [*first, r[0], r[1]], in_cut }));
            }
            inside = kept;
        }
        // Without a width, a part is covered as well as its neighbours.
        left.retain(|patch| match patch {
            Patch::Flat { corners: [a, b, c], .. } => {
                (b - a).cross(&(c - a)).norm() > tolerance * patch.reach() && patch.reach() > tolerance
            }
            _ => true,
        });
        Some(left)
    }
}

type Triangle = [Vector3<f64>; 3];

/// The excess of a patch.
struct Look {
    middle: f64,
    bound: f64,
    /// A triangle of the mesh that is nearest to the middle of a flat patch.
    triangle: Option<Triangle>,
    /// Number of the element of the mesh that is nearest to the middle of a flat patch.
    element: Option<usize>,
}

/// A patch that waits, by its bound.
struct Waiting {
    bound: f64,
    /// Patches with equal bounds are taken in the order in which they were made.
    number: usize,
    patch: Patch,
    /// An element that is near to it.
    element: Option<usize>,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.number.cmp(&self.number))
    }
}

/// The end of a search for a bound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// A bound that is low enough \[m\].
    pub enough: f64,
    /// Gap that it may leave to a value that is reached \[m\].
    pub absolute: f64,
    /// The same, relative to the value.
    pub relative: f64,
    /// Number of patches after which a wider gap is left.
    pub most_patches: usize,
}

/// A bound of the distance of patches from a mesh \[m\].
pub(crate) fn greatest(patches: impl IntoIterator<Item = Patch>, surface: &Surface, goal: Goal) -> f64 {
    let tolerance = IN_PLANE * surface.extent();
    let mut search = Search { surface, goal, tolerance, best: 0.0, number: 0, waiting: BinaryHeap::new() };
    patches.into_iter().for_each(|patch| search.look(patch, None));
    while let Some(Waiting { bound, patch, element, .. }) = search.waiting.pop() {
        let gap = goal.absolute.max(goal.relative * search.best);
        if bound <= goal.enough.max(search.best + gap) || search.number > goal.most_patches {
            return bound;
        }
        patch.parts().for_each(|part| search.look(part, element));
    }
    search.best
}

struct Search<'s> {
    surface: &'s Surface,
    goal: Goal,
    /// Distance up to which a patch is in the plane of a triangle \[m\].
    tolerance: f64,
    /// The greatest value that was found.
    best: f64,
    number: usize,
    waiting: BinaryHeap<Waiting>,
}

impl Search<'_> {
    fn look(&mut self, patch: Patch, near: Option<usize>) {
        let mut open = vec![patch];
        while let Some(patch) = open.pop() {
            let Look { middle, bound, triangle, element } = patch.look(self.surface, near);
            self.best = self.best.max(middle);
            self.number += 1;
            if bound <= self.best {
                continue;
            }
            let covered = triangle.filter(|_| middle.abs() <= self.tolerance && self.number < self.goal.most_patches);
            match covered.and_then(|t| patch.uncovered(&t, self.tolerance)) {
                Some(mut left) => open.append(&mut left),
                None => self.waiting.push(Waiting { bound, number: self.number, patch, element }),
            }
        }
    }
}

/// Patches of the surface of a shape; a cylinder's ends, which are flat, are those of a polygon around them. `None` for a hull
/// whose faces are not known.
fn patches(placed: &PlacedShape) -> Option<Vec<Patch>> {
    let pose = placed.origin;
    let at = |p: Vector3<f64>| (pose * Point3::from(p)).coords;
    let turn = |i: usize| std::f64::consts::FRAC_PI_4 * i as f64;
    let flat = |corners: [Vector3<f64>; 3]| Patch::Flat { corners, in_cut: false };
    let side = |radius: f64, half: f64| -> Vec<Patch> {
        let both = |i: usize| {
            let [a, b] = [turn(i), turn(i + 1)];
            [[[a, -half], [b, -half], [b, half]], [[a, -half], [b, half], [a, half]]]
        };
        (0..8).flat_map(both).map(|places| Patch::Side { pose, radius, places }).collect()
    };
    // Eight triangles, or the four of the half above or below.
    let ball = |z: f64, radius: f64, halves: &[f64]| -> Vec<Patch> {
        let quarter = |i: usize| Vector3::new(turn(2 * i).cos(), turn(2 * i).sin(), 0.0);
        let triangle = |up: f64, i: usize| [quarter(i), quarter(i + 1), Vector3::new(0.0, 0.0, up)];
        let centre = at(Vector3::new(0.0, 0.0, z));
        let all = halves.iter().flat_map(|up| (0..4).map(move |i| triangle(*up, i)));
        all.map(|t| Patch::Cap { centre, radius, directions: t.map(|d| pose.rotation * d) }).collect()
    };
    Some(match &placed.shape {
        Shape::Sphere { radius } => ball(0.0, *radius, &[1.0, -1.0]),
        Shape::Capsule { radius, half_length } => {
            let caps = [ball(*half_length, *radius, &[1.0]), ball(-half_length, *radius, &[-1.0])];
            caps.into_iter().flatten().chain(side(*radius, *half_length)).collect()
        }
        Shape::Cylinder { radius, half_length } => {
            let step = std::f64::consts::TAU / RIM as f64;
            let around = radius / (0.5 * step).cos();
            let rim = |i: usize, z: f64| {
                let angle = step * i as f64;
                at(Vector3::new(around * angle.cos(), around * angle.sin(), z))
            };
            let end = |z: f64| (0..RIM).map(move |i| [(i, z), (i + 1, z)]);
            let ends = end(*half_length).chain(end(-half_length));
            let ends = ends.map(|[(i, z), (j, _)]| flat([at(Vector3::new(0.0, 0.0, z)), rim(i, z), rim(j, z)]));
            ends.chain(side(*radius, *half_length)).collect()
        }
        Shape::Box { half } => {
            let half = Vector3::from(*half);
            let mut all = Vec::new();
            for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
                let corner = |u: f64, v: f64| {
                    let mut p = half;
                    p[axis] *= sign;
                    p[(axis + 1) % 3] *= u;
                    p[(axis + 2) % 3] *= v;
                    at(p)
                };
                let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                all.extend([flat([a, b, c]), flat([a, c, d])]);
            }
            all
        }
        Shape::Hull(hull) => hull.faces()?.into_iter().map(|t| flat(t.map(at))).collect(),
    })
}

impl Excess {
    /// The excess of shapes that contain a mesh together; all in one frame. The bound of the distance is at most `precision`
    /// \[m\] and a fiftieth of the distance above it.
    ///
    /// Inside of a closed mesh, nothing is exceeded: pieces meet there.
    pub fn of(shapes: &[PlacedShape], surface: &Surface, precision: f64) -> Excess {
        let may_be_inside = shapes.len() > 1 && surface.is_closed();
        let inner = |patch| match patch {
            Patch::Flat { corners, .. } => Patch::Flat { corners, in_cut: may_be_inside },
            other => other,
        };
        let goal = Goal { enough: 0.0, absolute: precision, relative: 0.02, most_patches: MOST_PATCHES };
        let (known, unknown): (Vec<_>, Vec<_>) = shapes.iter().map(|s| (s, patches(s))).partition(|(_, p)| p.is_some());
        let patches = known.into_iter().filter_map(|(_, p)| p).flatten().map(inner);
        // Points without faces are somewhere in their ball, and so is the mesh.
        let balls = unknown.iter().map(|(s, _)| 2.0 * s.shape.bounding_radius());
        let distance = balls.fold(greatest(patches, surface, goal), f64::max);
        Excess { distance, volume: shapes.iter().map(|s| s.shape.volume()).sum() }
    }
}
