//! Closest points of pairs of capsules, four pairs at once: the operations of [`closest`](super::closest) in the same order,
//! without branches, so that a processor does several at a time.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use nalgebra::{Isometry3, Vector3};

use super::{CORES_MEET, Closest, PARALLEL, ends};
use crate::Shape;

/// Number of pairs at once.
pub const CAPSULES_AT_ONCE: usize = 4;

const N: usize = CAPSULES_AT_ONCE;

/// A capsule in the world.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    /// One end of its axis \[m\].
    from: Vector3<f64>,
    /// From one end to the other \[m\].
    along: Vector3<f64>,
    /// Square of the length of the axis \[m²\].
    squared: f64,
    /// Radius \[m\].
    radius: f64,
}

impl Capsule {
    /// The shape at a pose, if it is a capsule with an axis.
    pub fn of(shape: &Shape, X_WS: &Isometry3<f64>) -> Option<Capsule> {
        match *shape {
            Shape::Capsule { radius, half_length } if half_length > 0.0 => {
                let [from, to] = ends(half_length, X_WS);
                let along = to - from;
                Some(Capsule { from, along, squared: along.norm_squared(), radius })
            }
            _ => None,
        }
    }
}

/// A number of each pair.
#[derive(Clone, Copy)]
struct Lanes([f64; N]);

macro_rules! each {
    ($($op:ident $name:ident),+) => { $(
        impl $op for Lanes {
            type Output = Lanes;

            #[inline(always)]
            fn $name(self, other: Lanes) -> Lanes {
                Lanes(from_fn(|i| self.0[i].$name(other.0[i])))
            }
        }
    )+ };
}
each!(Add add, Sub sub, Mul mul, Div div);

impl Lanes {
    #[inline(always)]
    fn within_one(self) -> Lanes {
        Lanes(self.0.map(|x| x.clamp(0.0, 1.0)))
    }
}

/// A vector of each pair.
#[derive(Clone, Copy)]
struct Vectors([Lanes; 3]);

impl Vectors {
    #[inline(always)]
    fn of(capsules: &[&Capsule; N], part: impl Fn(&Capsule) -> &Vector3<f64>) -> Vectors {
        Vectors(from_fn(|k| Lanes(from_fn(|i| part(capsules[i])[k]))))
    }

    #[inline(always)]
    fn zip(self, other: Vectors, f: impl Fn(Lanes, Lanes) -> Lanes) -> Vectors {
        Vectors(from_fn(|k| f(self.0[k], other.0[k])))
    }

    #[inline(always)]
    fn scaled(self, by: Lanes) -> Vectors {
        Vectors(self.0.map(|x| x * by))
    }

    #[inline(always)]
    fn dot(self, other: Vectors) -> Lanes {
        let [x, y, z] = self.zip(other, Mul::mul).0;
        x + y + z
    }

    #[inline(always)]
    fn cross(self, other: Vectors) -> Vectors {
        let (Vectors([x, y, z]), Vectors([u, v, w])) = (self, other);
        Vectors([y * w - z * v, z * u - x * w, x * v - y * u])
    }

    #[inline(always)]
    fn lane(&self, i: usize) -> Vector3<f64> {
        Vector3::from(self.0.map(|x| x.0[i]))
    }
}

/// Returns the closest points of each `a` and `b`, equal to the last bit to those of [`closest`](super::closest); `None` for
/// a pair that only that function can tell: its axes are nearly parallel, or meet, or a number is not finite.
///
/// Does not allocate.
pub fn closest_capsules(a: &[&Capsule; N], b: &[&Capsule; N]) -> [Option<Closest>; N] {
    let (a0, b0) = (Vectors::of(a, |c| &c.from), Vectors::of(b, |c| &c.from));
    let (da, db) = (Vectors::of(a, |c| &c.along), Vectors::of(b, |c| &c.along));
    let (aa, bb) = (Lanes(a.map(|c| c.squared)), Lanes(b.map(|c| c.squared)));
    let (radius_a, radius_b) = (Lanes(a.map(|c| c.radius)), Lanes(b.map(|c| c.radius)));
    let r = b0.zip(a0, Sub::sub);
    let n = da.cross(db);
    let n2 = n.dot(n);
    let s = (r.cross(db).dot(n) / n2).within_one();
    let free = da.scaled(s).zip(r, Sub::sub).dot(db) / bb;
    let t = free.within_one();
    let again = (r.zip(db.scaled(t), Add::add).dot(da) / aa).within_one();
    // Of a point between the ends of b, the first one is the nearest.
    let s = Lanes(from_fn(|i| if free.0[i] >= 0.0 && free.0[i] <= 1.0 { s.0[i] } else { again.0[i] }));
    let (p, q) = (a0.zip(da.scaled(s), Add::add), b0.zip(db.scaled(t), Add::add));
    let away = p.zip(q, Sub::sub);
    let apart = Lanes(away.dot(away).0.map(f64::sqrt));
    let normal = Vectors(away.0.map(|x| x / apart));
    let distance = apart - radius_a - radius_b;
    let on_a = p.zip(normal.scaled(radius_a), Sub::sub);
    let on_b = q.zip(normal.scaled(radius_b), Add::add);
    from_fn(|i| {
        let is_clear = n2.0[i] > PARALLEL * aa.0[i] * bb.0[i] && apart.0[i] > CORES_MEET && apart.0[i] < f64::INFINITY;
        is_clear.then(|| Closest {
            distance: distance.0[i],
            on_a: on_a.lane(i),
            on_b: on_b.lane(i),
            normal: normal.lane(i),
        })
    })
}
