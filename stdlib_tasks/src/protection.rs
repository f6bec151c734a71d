//! The parts of the robot that a limit guards, and what it keeps them from; the joints whose positions it bounds. The
//! table of coverage is made of these.

use robot::LinkId;

use crate::expression::{BoundedPart, BoundedSide, Leaf, Operand, bounded_parts};
use crate::slot::Slot;

/// Links that a limit guards.
#[derive(Clone, Debug, PartialEq)]
pub struct Protection {
    /// The links, each once; empty for a bound of the whole robot, such as of its centre of mass.
    pub links: Vec<LinkId>,
    /// Hazard from which they are kept.
    pub hazard: Hazard,
}

/// Hazard from which a limit keeps links.
#[derive(Clone, Debug, PartialEq)]
pub enum Hazard {
    /// A plane.
    Plane,
    /// Another link.
    Link(LinkId),
    /// An obstacle in the room, by its name, with the entries of the table of values that give its position.
    Obstacle(String, Slot),
    /// Points that these entries of the table of values give; those of people move.
    Points(Vec<Slot>),
    /// A bound of a value that depends on the links, and on these entries of the table of values.
    Value(Vec<Slot>),
    /// The people of a safety field of the program, by its index.
    Field(usize),
}

/// Sides on which a limit bounds the position of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundedPosition {
    /// The degree of freedom.
    pub dof: usize,
    /// True if there is a lowest position.
    pub lower: bool,
    /// True if there is a highest position.
    pub upper: bool,
}

/// Bounds of a value that a spec writes as an expression.
#[derive(Clone, Debug, Default)]
pub struct BoundedValue {
    /// Links that the bounds guard.
    pub protections: Vec<Protection>,
    /// Joints whose positions they bound.
    pub positions: Vec<BoundedPosition>,
}

impl BoundedValue {
    /// The bounds of a value, with its smallest and its largest value if there are any.
    pub fn new(value: &Operand, min: Option<&Operand>, max: Option<&Operand>) -> BoundedValue {
        let mut all = BoundedValue::default();
        let Operand::Expression(e) = value else { return all };
        for (bound, side) in [(min, BoundedSide::Below), (max, BoundedSide::Above)] {
            let Some(bound) = bound else { continue };
            let of_bound: Vec<Slot> = match bound {
                Operand::Slot(slot) => vec![*slot],
                Operand::Expression(e) => e.slots().collect(),
            };
            for part in bounded_parts(e, side) {
                all.add(&e.leaves, &part, &of_bound);
            }
        }
        all
    }

    fn add(&mut self, leaves: &[Leaf], part: &BoundedPart, of_bound: &[Slot]) {
        let mut links: Vec<LinkId> = part.leaves.iter().filter_map(|i| leaves.get(*i)).flat_map(links).collect();
        links.sort_unstable();
        links.dedup();
        let below = part.side == BoundedSide::Below;
        let hazard = match part.leaf.and_then(|i| leaves.get(i)) {
            Some(Leaf::Joint(dof)) => return self.add_position(*dof, below),
            Some(Leaf::PlaneDistance(_)) => Hazard::Plane,
            // A largest distance keeps parts together, and away from nothing.
            Some(Leaf::Distance(_) | Leaf::PointDistance(_) | Leaf::Field(_)) if !below => return,
            Some(Leaf::Distance(pair)) => {
                let protection = Protection { links: vec![pair.0.link], hazard: Hazard::Link(pair.1.link) };
                return self.protections.push(protection);
            }
            Some(Leaf::PointDistance(_) | Leaf::Field(_)) => Hazard::Points(part.slots.clone()),
            None if part.is_size && !below => return,
            // The distance between a point of one link and a point of another one.
            None if part.is_size && part.slots.is_empty() && links.len() == 2 => Hazard::Link(links.remove(1)),
            _ => Hazard::Value(part.slots.iter().chain(of_bound).copied().collect()),
        };
        self.protections.push(Protection { links, hazard });
    }

    fn add_position(&mut self, dof: usize, below: bool) {
        let known = self.positions.iter_mut().find(|p| p.dof == dof);
        match known {
            Some(known) => {
                known.lower |= below;
                known.upper |= !below;
            }
            None => self.positions.push(BoundedPosition { dof, lower: below, upper: !below }),
        }
    }
}

/// Links on which a quantity of the state depends by name.
fn links(leaf: &Leaf) -> Vec<LinkId> {
    match leaf {
        Leaf::Point { link, .. } | Leaf::Orientation(link) => vec![*link],
        Leaf::Distance(pair) => vec![pair.0.link, pair.1.link],
        Leaf::Manipulability(of) => vec![of.link],
        Leaf::PlaneDistance(above) => vec![above.part.link],
        Leaf::PointDistance(away) => vec![away.part.link],
        Leaf::Field(field) => field.links.clone(),
        Leaf::Joint(_) | Leaf::Com => Vec::new(),
    }
}
