//! Rows of the program: places as expressions of its columns, and sides of half-planes on which they have to be.

use super::super::polygon::{Face, Point};

/// A linear expression: columns with factors.
pub(super) type Linear = Vec<(usize, f64)>;

/// A position as two affine expressions, with the box in which it is.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Columns of the position and of the velocity, and the factor of the velocity.
    pub at: [usize; 2],
    pub velocity: Option<([usize; 2], f64)>,
    /// Box (m) in which it is.
    pub low: Point,
    pub high: Point,
}

impl Place {
    pub(super) fn along(&self, normal: Point) -> Linear {
        let mut terms = vec![(self.at[0], normal[0]), (self.at[1], normal[1])];
        if let Some((velocity, factor)) = self.velocity {
            terms.extend([(velocity[0], normal[0] * factor), (velocity[1], normal[1] * factor)]);
        }
        terms
    }

    /// The least value of `normal . y` in the box.
    pub(super) fn least(&self, normal: Point) -> f64 {
        (0..2).map(|i| f64::min(normal[i] * self.low[i], normal[i] * self.high[i])).sum()
    }

    pub(super) fn most(&self, normal: Point) -> f64 {
        -self.least([-normal[0], -normal[1]])
    }
}

/// A row `along >= bound`, with the least and the greatest value of its left side.
#[derive(Clone, Debug)]
pub(super) struct Side {
    pub along: Linear,
    pub bound: f64,
    pub least: f64,
    pub most: f64,
}

impl Side {
    /// The same row with a reserve (m) beyond its bound, less what a variable takes of it.
    pub(super) fn with_reserve(mut self, short: usize, reserve: f64) -> Side {
        self.along.push((short, 1.0));
        self.bound += reserve;
        self.most += reserve;
        self
    }

    /// A place is on the outer side of a face, at this bound.
    pub(super) fn of(place: &Place, face: &Face, bound: f64) -> Side {
        let along = place.along(face.normal);
        Side { along, bound, least: place.least(face.normal), most: place.most(face.normal) }
    }

    /// The difference of two places is on the outer side of a face.
    pub(super) fn between(a: &Place, b: &Place, face: &Face, slack: f64) -> Side {
        let back = [-face.normal[0], -face.normal[1]];
        let mut along = a.along(face.normal);
        along.extend(b.along(back));
        let (least, most) = (a.least(face.normal) + b.least(back), a.most(face.normal) + b.most(back));
        Side { along, bound: face.bound + slack, least, most }
    }

    /// The difference of two places is on the inner side of a face.
    pub(super) fn within(a: &Place, b: &Place, face: &Face, slack: f64) -> Side {
        Side::between(a, b, &face.opposite(), slack)
    }
}
