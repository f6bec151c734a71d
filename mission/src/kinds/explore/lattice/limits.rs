//! Limits of a robot in one period of the lattice, as bits of the three points of its motion.

use super::super::motion::Dynamics;
use super::super::polygon::{Convex, Point, dot, minus};
use super::{Lattice, MARGIN, Motion, PENALTY, Three};

/// Limits of a robot in one period: sides of sets as bits of the corner points, and the connections.
pub(super) struct Limits<'l, 'p> {
    lattice: &'l Lattice<'p>,
    robot: usize,
    step: usize,
    person: Convex,
    /// The set around the person by name of the point: its faces at the begin, in the middle and at the end.
    grown: [f64; 3],
    /// The other robots: the set of differences at which they touch, and their points.
    others: Vec<(usize, Convex, Three)>,
    /// In the first period the margin that the end needs beyond each face, for the motion from the known begin; see
    /// [`program`](super::program).
    needs: Option<Needs>,
    /// For each set of connections of this robot, to others in the order above and then to the person, if the team is connected.
    allowed: Vec<bool>,
    /// For a robot that goes ahead: where others can be that keep its connection, at the three points. The others themselves do
    /// not count then.
    relays: Option<[Vec<Point>; 3]>,
    /// Distance that the person can walk along the normal of each face around the person, and of the connection.
    far: [Vec<f64>; 2],
}

/// Margins (m) that the end of the first period needs: by part and face, by face of the person, by other robot and face, by face of the
/// connection to each other robot, and to the person.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    parts: Vec<Vec<f64>>,
    person: Vec<f64>,
    others: Vec<Vec<f64>>,
    links: Vec<Vec<f64>>,
    sees: Vec<f64>,
}

/// The margin that the end needs where the begin has `b0` and the third point `b1`; infinite: no end is good.
fn need(quadratic: bool, b0: f64, b1: f64) -> f64 {
    match b1 >= 0.0 {
        true => 0.0,
        false if quadratic && b0 > 0.0 => b1 * b1 / b0,
        false => f64::INFINITY,
    }
}

/// The margin that a face needs; nothing beyond the first period.
fn need_of(needs: Option<&Vec<f64>>, face: usize) -> f64 {
    needs.and_then(|needs| needs.get(face)).copied().unwrap_or(0.0)
}

/// Bits of a point in a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bits {
    pub part: u64,
    pub person: u64,
    /// Sides of the other robots, 16 bits each.
    others: u128,
    links: u8,
}

impl Bits {
    pub(super) fn both(self, other: Bits) -> Bits {
        Bits {
            part: self.part & other.part,
            person: self.person & other.person,
            others: self.others & other.others,
            links: self.links & other.links,
        }
    }
}

impl<'p> Lattice<'p> {
    /// Limits of a robot in a period, around the motions of the others.
    pub(super) fn limits<'l>(&'l self, robot: usize, step: usize, motions: &[Motion]) -> Limits<'l, 'p> {
        let problem = self.problem;
        let back = problem.robots[robot].body.reflected();
        let (stride, grown) = (self.strides(step), self.grown(robot));
        let others: Vec<usize> = (0..problem.robots.len()).filter(|other| *other != robot).collect();
        let active: Vec<usize> = others.iter().copied().filter(|other| self.present.active[*other]).collect();
        let threes: Vec<Three> = others.iter().map(|other| self.three(*other, &motions[*other], step)).collect();
        // Connections among the others, and from them to the person.
        let quadratic = problem.robots[robot].dynamics == Dynamics::Acceleration;
        let keeps = |margins: [f64; 3]| match step {
            0 => margins[2] >= MARGIN + need(quadratic, margins[0] - MARGIN, margins[1] - MARGIN),
            _ => margins.iter().all(|margin| *margin >= MARGIN),
        };
        let linked = |i: usize, j: usize| {
            let (a, b) = (threes[i], threes[j]);
            problem.connection.faces().iter().all(|face| keeps([0, 1, 2].map(|k| -face.outside(minus(a[k], b[k])))))
        };
        let from = grown.map(|share| self.person_at(step, share));
        let at_person = |points: &Three| {
            problem.connection.faces().iter().all(|face| {
                let far = stride.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
                keeps([0, 1, 2].map(|k| -face.outside(minus(points[k], from[k])) - grown[k] * far))
            })
        };
        let index: Vec<usize> = (0..others.len()).filter(|i| self.present.active[others[*i]]).collect();
        let mut allowed = vec![false; 1 << (others.len() + 1)];
        for (mask, allowed) in allowed.iter_mut().enumerate() {
            let to_person = mask >> others.len() & 1 == 1 || index.iter().any(|i| at_person(&threes[*i]));
            let own = index.iter().filter(|i| mask >> **i & 1 == 1).count();
            let degree = |i: usize| {
                index.iter().filter(|j| **j != i && linked(i.min(**j), i.max(**j))).count() + (mask >> i & 1)
            };
            let team = active.len() + 1;
            let pairs = index.iter().enumerate().all(|(place, i)| {
                let with_own = own + degree(*i) >= team;
                let with_others = index[..place].iter().all(|j| degree(*i) + degree(*j) >= team);
                with_own && with_others
            });
            *allowed = to_person && pairs;
        }
        let sets =
            others.iter().zip(&threes).map(|(other, three)| (*other, problem.robots[*other].body.sum(&back), *three));
        Limits::of(self, robot, step, sets.collect(), allowed, None)
    }
}

impl<'l, 'p> Limits<'l, 'p> {
    /// Limits around these others; see the fields.
    pub(super) fn of(
        lattice: &'l Lattice<'p>,
        robot: usize,
        step: usize,
        others: Vec<(usize, Convex, Three)>,
        allowed: Vec<bool>,
        relays: Option<[Vec<Point>; 3]>,
    ) -> Limits<'l, 'p> {
        let problem = lattice.problem;
        let near = problem.person.body.sum(&problem.robots[robot].body.reflected());
        let strides = lattice.strides(step);
        let person = near.sum_with_points(&strides);
        let grown = lattice.grown(robot);
        let far = |of: &Convex| -> Vec<f64> {
            let along = |normal: Point| strides.iter().map(|s| dot(normal, *s)).fold(0.0, f64::max);
            of.faces().iter().map(|face| along(face.normal)).collect()
        };
        let far = [far(&person), far(&problem.connection)];
        let mut limits = Limits { lattice, robot, step, person, grown, others, needs: None, allowed, relays, far };
        if step == 0 {
            limits.needs = Some(limits.needs_at_the_begin());
        }
        limits
    }
}

impl Limits<'_, '_> {
    /// Margins of a point that is the begin, the third point or the end of the motion: positive for a constraint that is met.
    pub(super) fn margins(&self, at: Point, place: usize) -> Needs {
        let (problem, lattice) = (self.lattice.problem, self.lattice);
        let inside = |of: &Convex| of.faces().iter().map(|face| -face.outside(at)).collect();
        let near = minus(at, lattice.person_at(self.step, self.grown[place]));
        let share = self.grown[place];
        let faces = problem.connection.faces();
        let apart: Vec<Point> = self.others.iter().map(|(_, _, three)| minus(at, three[place])).collect();
        let sets = self.others.iter().zip(&apart);
        Needs {
            parts: lattice.ground.parts[self.robot].iter().map(inside).collect(),
            // The part of the set that the person cannot have reached yet does not count.
            person: (self.person.faces().iter().zip(&self.far[0]))
                .map(|(face, far)| face.outside(near) + (1.0 - share) * far)
                .collect(),
            others: sets
                .map(|((_, set, _), apart)| set.faces().iter().take(16).map(|face| face.outside(*apart)).collect())
                .collect(),
            links: apart.iter().map(|apart| faces.iter().map(|face| -face.outside(*apart)).collect()).collect(),
            sees: faces.iter().zip(&self.far[1]).map(|(face, far)| -face.outside(near) - share * far).collect(),
        }
    }

    /// Margins that the end of the first period needs.
    pub(super) fn needs_at_the_begin(&self) -> Needs {
        let who = &self.lattice.problem.robots[self.robot];
        let now = self.lattice.present.states[self.robot];
        let (b0, b1) = (self.margins(now.at, 0), self.margins(who.over(self.lattice.problem.period).third(now), 1));
        let quadratic = who.dynamics == Dynamics::Acceleration;
        let each = |b0: &[f64], b1: &[f64]| -> Vec<f64> {
            b0.iter().zip(b1).map(|(b0, b1)| need(quadratic, *b0 - MARGIN, *b1 - MARGIN)).collect()
        };
        let all = |b0: &[Vec<f64>], b1: &[Vec<f64>]| -> Vec<Vec<f64>> {
            b0.iter().zip(b1).map(|(b0, b1)| each(b0, b1)).collect()
        };
        Needs {
            parts: all(&b0.parts, &b1.parts),
            person: each(&b0.person, &b1.person),
            others: all(&b0.others, &b1.others),
            links: all(&b0.links, &b1.links),
            sees: each(&b0.sees, &b1.sees),
        }
    }

    /// Length by which the end of the motion falls short of a reserve (m) to the person.
    pub(super) fn missing_reserve(&self, end: Point, reserve: f64) -> f64 {
        let near = minus(end, self.lattice.person_at(self.step, 1.0));
        (reserve - self.person.outside(near)).clamp(0.0, reserve)
    }

    /// Bits of a point that is the begin, the third point or the end of the motion. In the first period all that counts is the end.
    pub(super) fn bits(&self, at: Point, place: usize) -> Bits {
        if self.needs.is_some() && place < 2 {
            return Bits { part: u64::MAX, person: u64::MAX, others: u128::MAX, links: u8::MAX };
        }
        let part = self.part_bits(at);
        self.bits_with(at, place, part)
    }

    /// Work of a look at a point.
    pub(super) fn work(&self, place: usize) -> usize {
        1 + self.others.len() + self.relays.as_ref().map_or(0, |relays| relays[place].len())
    }

    /// The same of a point of the lattice.
    pub(super) fn bits_of(&self, index: usize, place: usize) -> Bits {
        let at = self.lattice.ground.point(index);
        match self.needs {
            Some(_) => self.bits(at, place),
            None => self.bits_with(at, place, self.lattice.ground.free[self.robot][index]),
        }
    }

    /// The parts of the free ground that hold a point.
    fn part_bits(&self, at: Point) -> u64 {
        let needs = self.needs.as_ref();
        self.lattice.ground.parts[self.robot].iter().enumerate().fold(0, |bits, (index, part)| {
            let needs = needs.and_then(|needs| needs.parts.get(index));
            let inside =
                part.faces().iter().enumerate().all(|(face, of)| -of.outside(at) >= MARGIN + need_of(needs, face));
            bits | u64::from(inside) << index
        })
    }

    fn bits_with(&self, at: Point, place: usize, part: u64) -> Bits {
        let needs = self.needs.as_ref();
        let near = minus(at, self.lattice.person_at(self.step, self.grown[place]));
        let share = self.grown[place];
        let sides = self.person.faces().iter().zip(&self.far[0]).enumerate();
        let person = sides.fold(0_u64, |bits, (face, (of, far))| {
            let margin = of.outside(near) + (1.0 - share) * far;
            let need = need_of(needs.map(|needs| &needs.person), face);
            bits | u64::from(margin >= need + MARGIN) << face
        });
        let faces = self.lattice.problem.connection.faces();
        let (mut others, mut links) = (0_u128, 0_u8);
        for (index, (other, set, three)) in self.others.iter().enumerate() {
            let apart = minus(at, three[place]);
            let own = needs.and_then(|needs| needs.others.get(index));
            let free = set.faces().iter().take(16).enumerate().fold(0_u64, |bits, (face, of)| {
                bits | u64::from(of.outside(apart) >= MARGIN + need_of(own, face)) << face
            });
            others |= u128::from(free) << (16 * index);
            let own = needs.and_then(|needs| needs.links.get(index));
            let linked =
                || faces.iter().enumerate().all(|(face, of)| -of.outside(apart) >= MARGIN + need_of(own, face));
            links |= u8::from(self.lattice.present.active[*other] && linked()) << index;
        }
        let sees = (faces.iter().zip(&self.far[1]).enumerate()).all(|(face, (of, far))| {
            let need = need_of(needs.map(|needs| &needs.sees), face);
            -of.outside(near) - share * far >= need + MARGIN
        });
        let linked = |relay: &Point| faces.iter().all(|face| -face.outside(minus(at, *relay)) >= MARGIN);
        let relayed = || self.relays.as_ref().is_some_and(|relays| relays[place].iter().any(linked));
        links |= u8::from(sees || relayed()) << self.others.len();
        Bits { part, person, others, links }
    }

    /// Penalty for what involves others.
    pub(super) fn penalty(&self, bits: Bits) -> f64 {
        let apart = (0..self.others.len()).filter(|index| bits.others >> (16 * index) & 0xffff == 0).count();
        let connected = self.allowed[usize::from(bits.links)];
        PENALTY * (apart as f64 + f64::from(u8::from(!connected)))
    }
}
