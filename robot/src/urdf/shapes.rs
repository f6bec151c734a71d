//! The kinds of collision shapes that links get.

use std::collections::BTreeMap;

/// Kind of the collision shapes of a link. Spheres and boxes are exact for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShapeKind {
    /// A cylinder or mesh becomes a capsule around it: the fastest.
    #[default]
    Capsules,
    /// A cylinder is exact, and a mesh becomes its convex hull.
    Hulls,
    /// A cylinder is exact, and a mesh becomes convex pieces that contain it.
    Pieces,
}

/// Kinds of the collision shapes of all links.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// Kind for links that have none of their own.
    pub default: ShapeKind,
    /// Kinds by the name of the link.
    pub of: BTreeMap<String, ShapeKind>,
    /// Distance by which pieces may exceed their mesh \[m\].
    pub pieces_within: f64,
}

impl Shapes {
    /// Distance by which pieces exceed a mesh, unless a spec gives another one \[m\].
    pub const PIECES_WITHIN: f64 = 5e-3;

    /// Kind for a link.
    pub fn kind(&self, link: &str) -> ShapeKind {
        self.of.get(link).copied().unwrap_or(self.default)
    }
}

impl Default for Shapes {
    fn default() -> Shapes {
        Shapes { default: ShapeKind::default(), of: BTreeMap::new(), pieces_within: Shapes::PIECES_WITHIN }
    }
}
