//! Convex pieces of a mesh: its solid, or the surface of an open one, is cut by planes across the coordinate axes until the
//! convex hull of each part exceeds the mesh by at most a distance.
//!
//! A part is what lies in a box of cut planes. Its hull is that of the triangles, clipped to the box, and of those corners of
//! the box that are inside of a closed mesh. So the pieces contain the whole mesh, whatever the planes are, and two of them
//! share at most a part of a plane. The choice of planes is that of V-HACD (Mamou, Volumetric hierarchical approximate convex
//! decomposition, Game Engine Gems 3, 2016), on triangles in place of voxels; how far a part exceeds the mesh is measured as
//! in CoACD (Wei and others, ACM Transactions on Graphics 41(4), 2022), as a distance, with a bound in place of samples.

mod clip;
mod cut;
mod file;

use nalgebra::Vector3;

use crate::excess::{Goal, Patch, greatest};
use crate::surface::Surface;
use crate::{Hull, HullError, PlacedShape};
use clip::{Plane, Sides, Triangle};

pub use file::{FEWEST_KEPT, FilePieces, MeshFile, PIECES_FOLDER};

/// Largest number of pieces of a mesh.
pub const MOST_PIECES: usize = 64;

/// Distance up to which a point is on a plane, relative to the size of the mesh.
const ON_PLANE: f64 = 1e-9;

/// Precision of the excess of a part that has to be cut, relative to it.
const PRECISION: f64 = 0.2;

/// Ways into a box from a corner, along the axes: no surface of a machine part has this direction.
const INWARD: [f64; 3] = [0.31, 0.23, 0.17];

/// Largest number of patches that are looked at for the excess of a part.
const MOST_PATCHES: usize = 8000;

/// Convex pieces that contain a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieces {
    /// Corners of the pieces, in the frame of the mesh \[m\].
    pub corners: Vec<Vec<Vector3<f64>>>,
    /// A bound of the distance of the pieces' surfaces from the mesh, outside of it \[m\].
    pub excess: f64,
}

impl Pieces {
    /// The pieces as hulls, in the frame of the mesh.
    pub fn shapes(&self) -> Vec<PlacedShape> {
        // Corners are finite, and each piece has some.
        self.corners.iter().filter_map(|corners| PlacedShape::hull(corners).ok()).collect()
    }

    /// A sentence if the pieces exceed the mesh by more than `within` \[m\].
    pub fn shortfall(&self, within: f64) -> Option<String> {
        let millimetres = |x: f64| format!("{:.3} mm", 1e3 * x);
        (self.excess > within).then(|| {
            let (n, excess, within) = (self.corners.len(), millimetres(self.excess), millimetres(within));
            format!("its {n} pieces exceed it by up to {excess}, and {within} are allowed")
        })
    }
}

/// A part of the mesh.
struct Part {
    triangles: Vec<Triangle>,
    /// Its box; infinite to a side without a cut.
    low: Vector3<f64>,
    high: Vector3<f64>,
    corners: Vec<Vector3<f64>>,
    /// Bound of the distance of its hull's surface from the mesh.
    excess: f64,
    /// True if no plane cuts it.
    is_whole: bool,
}

/// Results of both, on two threads if the system has another one to give.
fn on_two_threads<T: Send>(first: impl Fn() -> T + Sync, second: impl Fn() -> T) -> [T; 2] {
    std::thread::scope(|scope| {
        let other = std::thread::Builder::new().spawn_scoped(scope, &first);
        let second = second();
        let first = other.ok().and_then(|thread| thread.join().ok()).unwrap_or_else(&first);
        [first, second]
    })
}

impl Surface {
    /// Computes convex pieces that exceed the surface by at most `within` \[m\], as far as [`MOST_PIECES`] of them can.
    ///
    /// # Errors
    /// A point is not finite, which no surface has.
    pub fn pieces(&self, within: f64) -> Result<Pieces, HullError> {
        let endless = Vector3::repeat(f64::INFINITY);
        let tolerance = ON_PLANE * self.extent().max(1e-6);
        let make = |triangles, low, high| self.part(triangles, [low, high], within, tolerance);
        let mut parts = vec![make(self.triangles().to_vec(), -endless, endless)?];
        while parts.len() < MOST_PIECES {
            let worst = (0..parts.len())
                .filter(|i| !parts[*i].is_whole && parts[*i].excess > within)
                .max_by(|i, j| parts[*i].excess.total_cmp(&parts[*j].excess).then(j.cmp(i)));
            let Some(worst) = worst else { break };
            let part = &mut parts[worst];
            let mut sides = Sides::default();
            let plane = cut::best(&part.triangles, tolerance, part.excess);
            if let Some(plane) = plane {
                part.triangles.iter().for_each(|t| plane.split(t, &mut sides));
            }
            let Some(Plane { axis, at, .. }) = plane.filter(|_| !sides.below.is_empty() && !sides.above.is_empty())
            else {
                part.is_whole = true;
                continue;
            };
            let (low, high) = (part.low, part.high);
            let with = |mut v: Vector3<f64>| {
                v[axis] = at;
                v
            };
            let below = || make(sides.below.clone(), low, with(high));
            let [below, above] = on_two_threads(below, || make(sides.above.clone(), with(low), high));
            parts[worst] = below?;
            parts.push(above?);
        }
        let excess = parts.iter().map(|p| p.excess).fold(0.0, f64::max);
        Ok(Pieces { corners: parts.into_iter().map(|p| p.corners).collect(), excess })
    }

    fn part(
        &self,
        triangles: Vec<Triangle>,
        [low, high]: [Vector3<f64>; 2],
        within: f64,
        tolerance: f64,
    ) -> Result<Part, HullError> {
        let mut points: Vec<Vector3<f64>> = triangles.iter().flatten().copied().collect();
        for i in 0..8 {
            let is_high = |axis: usize| i >> axis & 1 == 1;
            let corner = Vector3::from_fn(|axis, _| if is_high(axis) { high[axis] } else { low[axis] });
            if !corner.iter().all(|x| x.is_finite()) {
                continue;
            }
            // A little inside of the box: a corner may be on the surface of what is beside it.
            let inward = Vector3::from_fn(|axis, _| {
                let way = INWARD[axis] * (high[axis] - low[axis]).min(1e3 * tolerance);
                if is_high(axis) { -way } else { way }
            });
            if self.contains(&(corner + inward)) {
                points.push(corner);
            }
        }
        let (middle, hull) = Hull::around(&points)?;
        let corners: Vec<Vector3<f64>> = hull.outer_corners().iter().map(|p| p + middle).collect();
        let excess = match hull.faces() {
            Some(faces) => {
                let in_cut = |t: &Triangle| {
                    let on = |axis: usize, at: f64| t.iter().all(|p| (p[axis] - at).abs() <= 8.0 * tolerance);
                    (0..3).any(|axis| on(axis, low[axis]) || on(axis, high[axis]))
                };
                let patch = |t: Triangle| Patch::Flat { corners: t, in_cut: self.is_closed() && in_cut(&t) };
                let goal = Goal { enough: within, absolute: 0.0, relative: PRECISION, most_patches: MOST_PATCHES };
                greatest(faces.into_iter().map(|t| patch(t.map(|p| p + middle))), self, goal)
            }
            None => 2.0 * hull.radius(),
        };
        Ok(Part { triangles, low, high, corners, excess, is_whole: false })
    }
}
