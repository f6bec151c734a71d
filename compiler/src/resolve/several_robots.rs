//! Parts of several robots: the name of the robot stands before that of the part, `left_tool`, and is a reference of its own.

use dsl::Span;

use super::symbols::{SymbolId, SymbolKind as K};
use super::walk::place_of;
use super::{Meaning, Reference, Resolver};
use crate::expand::Class;
use crate::sections::prefix;

/// Kinds of parts, in the order in which a name is looked up.
const PARTS: [K; 5] = [K::Arm, K::JointGroup, K::Group, K::Point, K::Segment];

/// A name that begins with that of a robot.
struct OfRobot<'n> {
    robot: SymbolId,
    /// Length of the robot's name.
    length: usize,
    /// The rest of the name; empty for the robot itself.
    part: &'n str,
}

impl Resolver<'_> {
    /// Records a name of a part of one of several robots, or of a whole one. Returns false if it is none.
    pub(super) fn refer_to_robot(&mut self, name: &str, span: Span) -> bool {
        let Some(OfRobot { robot, length, part }) = self.of_robot(name) else { return false };
        let known = |links: &Option<_>| {
            links.as_ref().and_then(|links: &std::collections::BTreeMap<_, _>| links.get(part).copied())
        };
        let found = known(&self.links).or_else(|| known(&self.joints));
        let found = found.or_else(|| PARTS.into_iter().find_map(|kind| self.inside(robot, kind, part)));
        let found = found.or_else(|| PARTS.into_iter().find_map(|kind| self.part(kind, part)));
        let of_all = part.is_empty() || part == "base" || self.base_names.contains(part);
        if found.is_none() && !of_all {
            return false;
        }
        let (place, exact) = place_of(self.text, name, span);
        let middle = place.start + length;
        let (of_name, of_part) = match exact {
            true => (place.start..middle, place.end - part.len()..place.end),
            false => (place.clone(), place),
        };
        let mut note = |place, id| {
            self.out.references.push(Reference { place, exact, declares: false, meaning: Meaning::Symbol(id) });
        };
        note(of_name, robot);
        if let Some(id) = found {
            note(of_part, id);
        }
        true
    }

    /// Splits a name at the name of a robot, if the spec has several.
    fn of_robot<'n>(&self, name: &'n str) -> Option<OfRobot<'n>> {
        let robots = || self.scopes[0].declared.iter().filter(|((class, _), _)| *class == Class::Robot);
        if robots().count() < 2 {
            return None;
        }
        robots().find_map(|((_, robot), &id)| {
            let of = |part| OfRobot { robot: id, length: robot.len(), part };
            if name == robot { Some(of("")) } else { name.strip_prefix(&prefix(robot)).map(of) }
        })
    }
}
