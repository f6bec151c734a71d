//! Smallest parts of a demand, each of which a stack meets or not.

use robot::LinkId;
use runtime::program::Program;

use super::table::{Guard, Hold, KeptFrom, PersonPoint, StackCoverage};
use crate::demands::{Demand, Demanded, JointQuantity};

/// Smallest part of a demand on a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Atom {
    /// A degree of freedom is limited.
    Joint(JointQuantity, usize),
    /// Two links are kept apart.
    Pair([LinkId; 2]),
    /// A link is kept from a point of a person.
    Person(LinkId, PersonPoint),
    /// A task is in the stack.
    Limit(usize),
    /// A task is in the stack and guards a link.
    Guard(usize, LinkId),
}

/// Returns the parts of a demand that concern a stack: those of joints and links that it moves.
pub(super) fn atoms(demand: &Demand, table: &StackCoverage, program: &Program) -> Vec<Atom> {
    let model = &program.robot.model;
    let moved = |links: &[LinkId]| links.iter().copied().filter(|l| table.moves_link(model, *l)).collect::<Vec<_>>();
    match &demand.of {
        Demanded::Joints(quantity, named) => {
            let is_named = |dof: usize| named.as_ref().is_none_or(|all| all.contains(&dof));
            let joints = table.joints.iter().filter(|j| j.needs(*quantity) && is_named(j.dof));
            joints.map(|j| Atom::Joint(*quantity, j.dof)).collect()
        }
        Demanded::Apart(pairs) => {
            pairs.iter().copied().filter(|p| table.moves_between(model, *p)).map(Atom::Pair).collect()
        }
        Demanded::Person { human, points, links } => {
            let of = |link| points.iter().map(move |&signal| Atom::Person(link, PersonPoint { human: *human, signal }));
            moved(links).into_iter().flat_map(of).collect()
        }
        Demanded::Limit { task, links } if links.is_empty() => vec![Atom::Limit(*task)],
        Demanded::Limit { task, links } => moved(links).into_iter().map(|link| Atom::Guard(*task, link)).collect(),
    }
}

/// Returns the firmest limit that meets a part of a demand, if there is one.
pub(super) fn held(atom: Atom, table: &StackCoverage, program: &Program) -> Option<Hold> {
    let firmest = |holds: &mut dyn Iterator<Item = Hold>| holds.max_by_key(|h| h.firmness);
    let guards =
        |keeps: &dyn Fn(&Guard) -> bool| firmest(&mut table.guards.iter().filter(|g| keeps(g)).map(|g| g.hold));
    match atom {
        Atom::Joint(quantity, dof) => table.joints.iter().find(|j| j.dof == dof)?.limit(quantity),
        Atom::Pair([a, b]) => guards(&|g| match g.from {
            KeptFrom::Link(other) => (other == b && g.links.contains(&a)) || (other == a && g.links.contains(&b)),
            _ => false,
        }),
        Atom::Person(link, point) => guards(&|g| match &g.from {
            KeptFrom::People(points) => points.contains(&point) && g.links.contains(&link),
            _ => false,
        }),
        Atom::Limit(task) => firmest(&mut table.limits.iter().copied().filter(|h| program.same_task(h.task, task))),
        Atom::Guard(task, link) => guards(&|g| {
            program.same_task(g.hold.task, task) && (g.links.contains(&link) || g.from == KeptFrom::Link(link))
        }),
    }
}
