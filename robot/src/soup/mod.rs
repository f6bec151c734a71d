//! Many small convex elements in one body that need not be convex: the points of a cloud, the triangles of a mesh, the
//! columns under a heightfield, the convex pieces of a solid.
//!
//! Elements are the convex hulls of a few corners, with one radius around all. They lie in a tree of balls and boxes, which is
//! built once; [`Soup::spots`] finds the nearest ones of a shape in it.

mod search;
mod tree;

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::geometry::Query;
use crate::{Closest, Degenerate, Hull, Shape};
use tree::Tree;

pub use search::{Frontier, Search, Spot};

/// Largest number of elements.
pub const MOST_ELEMENTS: usize = 200_000;

/// Largest number of corners of an element.
pub const MOST_CORNERS: usize = 1 << 16;

/// Largest coordinate of a corner \[m\].
const FARTHEST: f64 = 1e4;

/// A body of many elements. Copies share them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Soup(Arc<Elements>);

#[derive(Debug)]
struct Elements {
    /// Corners of element `i`: `corners[first[i]..first[i + 1]]`, in the order of the tree.
    corners: Vec<Vector3<f64>>,
    first: Vec<u32>,
    /// Radius around each element \[m\].
    radius: f64,
    /// Of the ball about the origin that contains all \[m\].
    bounding_radius: f64,
    /// Diameter of a ball that contains all corners \[m\].
    extent: f64,
    tree: Tree,
}

impl PartialEq for Elements {
    fn eq(&self, other: &Self) -> bool {
        (&self.corners, &self.first, self.radius) == (&other.corners, &other.first, other.radius)
    }
}

/// Reason why elements are no soup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SoupError {
    /// There are none.
    #[error("it has no element")]
    Empty,
    /// There are too many.
    #[error("it has {0} elements, and {MOST_ELEMENTS} are the most")]
    TooMany(usize),
    /// An element has no corner, or too many.
    #[error("an element has {0} corners")]
    Corners(usize),
    /// A coordinate or the radius is not finite, or beyond 10 km.
    #[error("a coordinate is not finite, or farther away than 10 km")]
    NotFinite,
}

impl Soup {
    /// Builds the tree of elements, each given by its corners \[m\], with a radius around them \[m\].
    ///
    /// # Errors
    /// There are no elements or too many, or a number is not finite.
    pub fn new<E: AsRef<[Vector3<f64>]>>(elements: &[E], radius: f64) -> Result<Soup, SoupError> {
        if elements.is_empty() {
            return Err(SoupError::Empty);
        }
        if elements.len() > MOST_ELEMENTS {
            return Err(SoupError::TooMany(elements.len()));
        }
        let sizes = || elements.iter().map(|e| e.as_ref().len());
        if let Some(wrong) = sizes().find(|n| !(1..=MOST_CORNERS).contains(n)) {
            return Err(SoupError::Corners(wrong));
        }
        let near = |x: f64| x.is_finite() && x.abs() <= FARTHEST;
        if !near(radius) || radius < 0.0 || !elements.iter().flat_map(|e| e.as_ref().iter().flatten()).all(|x| near(*x))
        {
            return Err(SoupError::NotFinite);
        }
        let (tree, order) = Tree::over(elements);
        let (mut corners, mut first) = (Vec::new(), vec![0]);
        for i in order {
            corners.extend_from_slice(elements[i as usize].as_ref());
            first.push(corners.len() as u32);
        }
        let bounding_radius = corners.iter().map(|p| p.norm()).fold(0.0, f64::max) + radius;
        let wide = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let (low, high) = corners.iter().fold(wide, |(low, high), p| (low.inf(p), high.sup(p)));
        let middle = 0.5 * (low + high);
        let extent = 2.0 * corners.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        Ok(Soup(Arc::new(Elements { corners, first, radius, bounding_radius, extent, tree })))
    }

    /// Number of elements.
    #[expect(clippy::len_without_is_empty, reason = "there is none without elements")]
    pub fn len(&self) -> usize {
        self.0.first.len() - 1
    }

    /// Corners of an element \[m\]. Elements are numbered in an order of the soup's own.
    pub fn corners(&self, element: usize) -> &[Vector3<f64>] {
        let first = &self.0.first;
        &self.0.corners[first[element] as usize..first[element + 1] as usize]
    }

    /// Triangles that cover an element without its radius \[m\]; none of a point.
    pub fn faces(&self, element: usize) -> Vec<[Vector3<f64>; 3]> {
        match self.corners(element) {
            [] | [_] => Vec::new(),
            &[a, b, c] => vec![[a, b, c]],
            corners => match Hull::around(corners) {
                Ok((middle, hull)) => {
                    let faces = hull.faces().unwrap_or_default();
                    faces.into_iter().map(|t| t.map(|p| p + middle)).collect()
                }
                Err(_) => Vec::new(),
            },
        }
    }

    /// Radius around each element \[m\].
    pub fn radius(&self) -> f64 {
        self.0.radius
    }

    /// Diameter of a ball that contains all elements, without their radius \[m\].
    pub fn extent(&self) -> f64 {
        self.0.extent
    }

    /// Radius of a ball about the origin that contains all elements \[m\].
    pub fn bounding_radius(&self) -> f64 {
        self.0.bounding_radius
    }

    /// Closest points of a shape and one element, the shape being `a`; both poses are in the world. Does not allocate.
    ///
    /// # Errors
    /// The element does not exist, a pose is not finite, or the cores intersect.
    pub fn closest_to(
        &self,
        element: usize,
        shape: &Shape,
        X_Wa: &Isometry3<f64>,
        X_WS: &Isometry3<f64>,
    ) -> Result<Closest, Degenerate> {
        if element >= self.len() {
            return Err(Degenerate::Touching);
        }
        let query = Query::new(shape, X_WS.inv_mul(X_Wa));
        query.closest(self.corners(element), self.0.radius).map(|found| found.closest.moved(X_WS))
    }
}

/// A soup as it is written: corners of each element.
#[derive(Serialize, Deserialize)]
struct Written {
    radius: f64,
    elements: Vec<Vec<[f64; 3]>>,
}

impl TryFrom<Written> for Soup {
    type Error = SoupError;

    fn try_from(written: Written) -> Result<Soup, SoupError> {
        let corners = |e: Vec<[f64; 3]>| e.into_iter().map(Vector3::from).collect();
        let elements: Vec<Vec<Vector3<f64>>> = written.elements.into_iter().map(corners).collect();
        Soup::new(&elements, written.radius)
    }
}

impl From<Soup> for Written {
    fn from(soup: Soup) -> Self {
        let corners = |i| soup.corners(i).iter().map(|p| [p.x, p.y, p.z]).collect();
        Written { radius: soup.radius(), elements: (0..soup.len()).map(corners).collect() }
    }
}
