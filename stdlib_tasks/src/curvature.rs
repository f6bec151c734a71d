//! Bounds of the second derivative in time of an expression of the state, while the joints move at constant speeds: by how
//! much a value bends between two ticks.
//!
//! ```text
//! (a b)''  = a'' b + 2 a' b' + a b''        |f(a)''| <= max|f'| |a''| + max|f''| a'²
//! |x|''   >= -|x''|                          for a norm: it is convex in x
//! ```
//!
//! Values of the table count as moving at constant rates. A bound is infinite where an operation has a corner that bends
//! to its side, or where its derivative has no bound.

use nalgebra::Vector3;
use robot::{LinkId, Model};

use crate::bound::Geometry;
use crate::clearance::{Mover, acceleration_bound, base_speed, movers};
use crate::expression::{Expression, Leaf, Op};
use crate::gradient_bound;
use crate::sampled_margin::{extent, is_ball, separation_bound};

/// Bounds of a number and of its derivatives in time, in its unit, per s and per s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Smallest value.
    low: f64,
    /// Largest value.
    high: f64,
    /// Largest magnitude of its rate.
    rate: f64,
    /// Largest second derivative downwards, zero or more.
    pub down: f64,
    /// Largest second derivative upwards, zero or more.
    pub up: f64,
}

impl Bend {
    /// A number of which nothing is known.
    const ANY: Bend = Bend {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        rate: f64::INFINITY,
        down: f64::INFINITY,
        up: f64::INFINITY,
    };

    /// A number that moves at a constant rate, of which nothing else is known.
    pub const LINEAR: Bend = Bend { down: 0.0, up: 0.0, ..Bend::ANY };

    fn constant(x: f64) -> Bend {
        Bend { low: x, high: x, rate: 0.0, down: 0.0, up: 0.0 }
    }

    /// Largest magnitude of the number.
    fn size(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Smallest magnitude of the number.
    fn least(&self) -> f64 {
        self.low.max(-self.high).max(0.0)
    }

    fn second(&self) -> f64 {
        self.down.max(self.up)
    }

    fn negated(self) -> Bend {
        Bend { low: -self.high, high: -self.low, rate: self.rate, down: self.up, up: self.down }
    }

    fn plus(self, b: Bend) -> Bend {
        Bend {
            low: self.low + b.low,
            high: self.high + b.high,
            rate: self.rate + b.rate,
            down: self.down + b.down,
            up: self.up + b.up,
        }
    }

    fn times(self, b: Bend) -> Bend {
        for (factor, other) in [(self, b), (b, self)] {
            if factor.rate == 0.0 && factor.low == factor.high {
                return other.scaled(factor.low);
            }
        }
        let corners = [self.low, self.high].map(|x| [b.low, b.high].map(|y| product(x, y)));
        let all = || corners.iter().flatten().copied();
        let second =
            product(self.second(), b.size()) + 2.0 * product(self.rate, b.rate) + product(self.size(), b.second());
        Bend {
            low: all().fold(f64::INFINITY, f64::min),
            high: all().fold(f64::NEG_INFINITY, f64::max),
            rate: product(self.rate, b.size()) + product(self.size(), b.rate),
            down: second,
            up: second,
        }
    }

    fn scaled(self, x: f64) -> Bend {
        let by = |y: f64| product(x.abs(), y);
        let scaled =
            Bend { low: by(self.low), high: by(self.high), rate: by(self.rate), down: by(self.down), up: by(self.up) };
        if x < 0.0 { scaled.negated() } else { scaled }
    }

    fn squared(self) -> Bend {
        let bent = 2.0 * product(self.size(), self.second());
        Bend {
            low: self.least().powi(2),
            high: self.size().powi(2),
            rate: 2.0 * product(self.size(), self.rate),
            down: bent,
            up: bent + 2.0 * product(self.rate, self.rate),
        }
    }

    /// `f` of the number, with values within `range`, `|f'| <= slope` and `|f''| <= curve`.
    fn through(self, range: [f64; 2], slope: f64, curve: f64) -> Bend {
        let second = product(slope, self.second()) + product(curve, product(self.rate, self.rate));
        Bend { low: range[0], high: range[1], rate: product(slope, self.rate), down: second, up: second }
    }

    fn inverse(self) -> Bend {
        let m = self.least();
        if m == 0.0 {
            return Bend::ANY;
        }
        self.through([-1.0 / m, 1.0 / m], 1.0 / (m * m), 2.0 / (m * m * m))
    }

    fn root(self) -> Bend {
        let m = self.low.max(0.0).sqrt();
        if m == 0.0 {
            return Bend { low: 0.0, high: self.high.max(0.0).sqrt(), ..Bend::ANY };
        }
        self.through([m, self.high.sqrt()], 0.5 / m, 0.25 / (m * m * m))
    }

    fn magnitude(self) -> Bend {
        // The corner bends upwards.
        let up = if self.least() > 0.0 { self.second() } else { f64::INFINITY };
        Bend { low: self.least(), high: self.size(), rate: self.rate, down: self.second(), up }
    }

    /// The larger one of two numbers: its corner bends upwards.
    fn larger(self, b: Bend) -> Bend {
        Bend {
            low: self.low.max(b.low),
            high: self.high.max(b.high),
            rate: self.rate.max(b.rate),
            down: self.down.max(b.down),
            up: f64::INFINITY,
        }
    }
}

/// A product in which zero times infinity is zero: what does not move does not bend.
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// Bounds of each number of an expression, with the largest speeds of the degrees of freedom in rad/s or m/s and joints inside
/// of their position limits.
pub fn bends(e: &Expression, model: &Model, speed: &[f64]) -> Vec<Bend> {
    let bounds = Bounds { e, model, speed };
    let leaves: Vec<Bend> = e.leaves.iter().flat_map(|leaf| bounds.leaf(leaf)).collect();
    let mut found: Vec<Bend> = Vec::with_capacity(e.ops.len());
    for (i, op) in e.ops.iter().enumerate() {
        let at = |a: usize| found.get(a).copied().unwrap_or(Bend::ANY);
        found.push(match *op {
            Op::Const(x) => Bend::constant(x),
            Op::Input(_) => Bend::LINEAR,
            Op::State(k) => leaves.get(k).copied().unwrap_or(Bend::ANY),
            Op::Add(a, b) => at(a).plus(at(b)),
            Op::Sub(a, b) => at(a).plus(at(b).negated()),
            Op::Neg(a) => at(a).negated(),
            Op::Mul(a, b) if a == b => at(a).squared(),
            Op::Mul(a, b) => at(a).times(at(b)),
            Op::Powi(a, 1) => at(a),
            Op::Powi(a, 2) => at(a).squared(),
            Op::Div(a, b) if at(b).rate == 0.0 && at(b).low == at(b).high => at(a).scaled(1.0 / at(b).low),
            Op::Div(a, b) => at(a).times(at(b).inverse()),
            Op::Sin(a) | Op::Cos(a) => at(a).through([-1.0, 1.0], 1.0, 1.0),
            Op::Sqrt(a) => bounds.norm(&found, a).unwrap_or_else(|| at(a).root()),
            Op::Abs(a) => at(a).magnitude(),
            Op::Max(a, b) => at(a).larger(at(b)),
            Op::Min(a, b) => at(a).negated().larger(at(b).negated()).negated(),
            _ => Bend::ANY,
        });
        debug_assert_eq!(found.len(), i + 1);
    }
    e.outputs.iter().map(|&o| found.get(o).copied().unwrap_or(Bend::ANY)).collect()
}

struct Bounds<'e> {
    e: &'e Expression,
    model: &'e Model,
    speed: &'e [f64],
}

impl Bounds<'_> {
    /// Bounds of the numbers of a leaf.
    fn leaf(&self, leaf: &Leaf) -> Vec<Bend> {
        let Bounds { model, speed, .. } = *self;
        match leaf {
            Leaf::Point { link, offset } => self.point(*link, offset).to_vec(),
            Leaf::Com => {
                let total: f64 = model.links.iter().map(|l| l.mass).sum();
                let massive = model.links.iter().enumerate().filter(|(_, l)| l.mass > 0.0);
                let part = |(i, l): (usize, &robot::Link)| {
                    self.point(LinkId(i as u32), &l.center_of_mass).map(|b| b.scaled(l.mass / total))
                };
                massive.map(part).fold(vec![Bend::constant(0.0); 3], |sum, part| {
                    sum.into_iter().zip(part).map(|(a, b)| a.plus(b)).collect()
                })
            }
            Leaf::Orientation(link) => {
                // q' = ω q / 2, q'' = ω' q / 2 + ω q' / 2.
                let (turning, bending) = self.turning(*link);
                let second = 0.5 * bending + 0.25 * product(turning, turning);
                vec![Bend { low: -1.0, high: 1.0, rate: 0.5 * turning, down: second, up: second }; 4]
            }
            Leaf::Joint(dof) => {
                let (low, high) =
                    model.dofs.get(*dof).map_or((f64::NEG_INFINITY, f64::INFINITY), |d| (d.lower, d.upper));
                vec![Bend { low, high, rate: self.speed_of(*dof), down: 0.0, up: 0.0 }]
            }
            Leaf::Distance(pair) => {
                let slopes = gradient_bound::between(model, &pair.0, &pair.1);
                vec![Bend {
                    down: separation_bound(&pair.0, &pair.1, model, speed),
                    rate: self.rate(&slopes),
                    ..Bend::ANY
                }]
            }
            Leaf::PlaneDistance(above) => {
                let part = &above.part;
                let bound = acceleration_bound(model, above.plane.link, part.link, extent(part), speed);
                let slopes = gradient_bound::over_plane(model, above.plane.link, &above.plane.normal, part);
                // The lowest point of a shape changes at a corner, which bends downwards.
                let down = if is_ball(&part.shape) { bound } else { f64::INFINITY };
                vec![Bend { down, up: bound, rate: self.rate(&slopes), ..Bend::ANY }]
            }
            Leaf::Manipulability(_) | Leaf::Field(_) | Leaf::PointDistance(_) => vec![Bend::ANY; leaf.width()],
        }
    }

    fn speed_of(&self, dof: usize) -> f64 {
        self.speed.get(dof).copied().unwrap_or(f64::INFINITY)
    }

    fn rate(&self, slopes: &[f64]) -> f64 {
        slopes.iter().enumerate().map(|(dof, slope)| product(*slope, self.speed_of(dof))).sum()
    }

    /// Bounds of the position of a point of a link in the world.
    fn point(&self, link: LinkId, offset: &Vector3<f64>) -> [Bend; 3] {
        let second = acceleration_bound(self.model, None, link, offset.norm(), self.speed);
        let rate = self.rate(&gradient_bound::over_world(self.model, &Geometry::point("", link, *offset)));
        let (center, radius) = gradient_bound::reach(self.model, None, link, offset);
        [0, 1, 2].map(|i| Bend { low: center[i] - radius, high: center[i] + radius, rate, down: second, up: second })
    }

    /// Largest angular velocity of a link in rad/s, and its largest derivative in rad/s².
    fn turning(&self, link: LinkId) -> (f64, f64) {
        let mut parts: Vec<f64> = Vec::new();
        for mover in movers(self.model, link).into_iter().rev() {
            let joint = match mover {
                Mover::Base(base) => {
                    parts.push(base_speed(self.model, &base, self.speed).angular);
                    continue;
                }
                Mover::Joint(joint) => self.model.joint_ref(joint),
            };
            let speed = match joint.drive {
                robot::Drive::Dof(dof) => self.speed_of(dof),
                robot::Drive::Mimic { dof, multiplier, .. } => product(self.speed_of(dof), multiplier.abs()),
                robot::Drive::Fixed | robot::Drive::Locked(_) => 0.0,
            };
            let turns = !matches!(joint.kind, robot::JointKind::Prismatic | robot::JointKind::Fixed);
            parts.push(if turns { speed } else { 0.0 });
        }
        // The axis of each joint turns with all joints before it.
        let (mut turning, mut bending) = (0.0, 0.0);
        for speed in parts {
            bending += product(turning, speed);
            turning += speed;
        }
        (turning, bending)
    }

    /// Bounds of the root of a sum of squares: a norm.
    fn norm(&self, found: &[Bend], sum: usize) -> Option<Bend> {
        let mut parts = Vec::new();
        let mut open = vec![sum];
        while let Some(i) = open.pop() {
            match *self.e.ops.get(i)? {
                Op::Add(a, b) => open.extend([b, a]),
                Op::Powi(a, 2) => parts.push(a),
                Op::Mul(a, b) if a == b => parts.push(a),
                _ => return None,
            }
        }
        let of = |f: &dyn Fn(&Bend) -> f64| {
            parts.iter().filter_map(|&i| found.get(i)).map(|b| f(b).powi(2)).sum::<f64>().sqrt()
        };
        let (rate, mut down, low) = (of(&|b| b.rate), of(&Bend::second), of(&Bend::least));
        if let Some(apart) = self.between_points(&parts) {
            down = down.min(apart);
        }
        let up = if low > 0.0 { down + product(rate, rate) / low } else { f64::INFINITY };
        Some(Bend { low, high: of(&Bend::size), rate, down, up })
    }

    /// Bound of the acceleration of one point relative to the link of another, if these numbers are the difference between both:
    /// joints that carry both do not change their distance.
    fn between_points(&self, parts: &[usize]) -> Option<f64> {
        let mut both: Vec<(usize, usize)> = Vec::new();
        for &i in parts {
            let Op::Sub(a, b) = *self.e.ops.get(i)? else { return None };
            let (Op::State(a), Op::State(b)) = (*self.e.ops.get(a)?, *self.e.ops.get(b)?) else { return None };
            both.push((a, b));
        }
        let first = *both.iter().min()?;
        both.sort_unstable();
        if both.len() != 3 || (0..3).any(|i| both[i] != (first.0 + i, first.1 + i)) {
            return None;
        }
        let (Leaf::Point { link: a, offset: p }, Leaf::Point { link: b, offset: q }) =
            (self.leaf_from(first.0)?, self.leaf_from(first.1)?)
        else {
            return None;
        };
        let seen = |from: LinkId, to: LinkId, offset: &Vector3<f64>| {
            acceleration_bound(self.model, Some(from), to, offset.norm(), self.speed)
        };
        Some(seen(*a, *b, q).min(seen(*b, *a, p)))
    }

    /// Leaf whose first number this is.
    fn leaf_from(&self, first: usize) -> Option<&Leaf> {
        let mut at = 0;
        self.e.leaves.iter().find(|leaf| {
            at += leaf.width();
            at - leaf.width() == first
        })
    }
}
