//! Distance from parts of the robot to people: to their points, and to the links between these.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span};
use stdlib_tasks::bound::Geometry;
use stdlib_tasks::expression::{Leaf, PointDistance};

use super::scope::TaskScope;
use crate::diagnostics::refused::{Refused, refuse};
use crate::expr::constants::Human;
use crate::expr::{Graph, Meaning, Typed, symbol};
use crate::forms::{path_of, target, written};

/// Nodes of both ends of a person's segment; both are the same for a point.
pub(super) type Segment = [[usize; 3]; 2];

impl TaskScope<'_> {
    /// Splits the arguments of a distance into the one that names parts of the robot and the people that the other one
    /// names; `None` if neither names a person.
    pub(super) fn between<'v>(
        &mut self,
        a: &'v Value,
        b: &'v Value,
    ) -> Result<Option<(&'v Value, Vec<Segment>)>, Refused> {
        let (part, people) = match (self.names_people(a), self.names_people(b)) {
            (false, false) => return Ok(None),
            (true, true) => {
                let d =
                    Diagnostic::error("HQ0304", b.span, "a distance between two people does not depend on the robot");
                return refuse(d.label(a.span, "a person too").help("name a part of the robot on one side"));
            }
            (true, false) => (b, a),
            (false, true) => (a, b),
        };
        let mut all: Vec<Segment> = Vec::new();
        for item in people.items() {
            for segment in self.segments(item)? {
                if !all.contains(&segment) {
                    all.push(segment);
                }
            }
        }
        Ok(Some((part, all)))
    }

    /// The person that a value names, if no part of the robot has the same name.
    fn person(&mut self, value: &Value) -> Option<(String, Option<Human>)> {
        let ValueKind::Name(name) = &value.kind else { return None };
        let said = written(name);
        let robot = self.robot;
        let part = robot.geometries.iter().any(|g| g.name == said)
            || robot.groups.contains_key(said)
            || robot.model.link(said).is_some();
        match self.params.meaning(name) {
            Meaning::Human(human) if !part => Some((name.clone(), Some(human))),
            Meaning::Failed if !part => Some((name.clone(), None)),
            _ => None,
        }
    }

    /// True if an item of the value is a person or a person's point.
    fn names_people(&mut self, value: &Value) -> bool {
        value.items().iter().any(|item| match &item.kind {
            ValueKind::Field(inner, _) => {
                let part = path_of(item).is_some_and(|path| self.robot.groups.contains_key(&path));
                !part && self.person(inner).is_some()
            }
            _ => self.person(item).is_some(),
        })
    }

    /// Returns the segments of a person: links, and points without a link; for one point, the point alone.
    fn segments(&mut self, item: &Value) -> Result<Vec<Segment>, Refused> {
        let (who, point) = match &item.kind {
            ValueKind::Field(inner, point) => (inner.as_ref(), Some(point)),
            _ => (item, None),
        };
        let Some((name, human)) = self.person(who) else {
            let d = Diagnostic::error(
                "HQ0304",
                item.span,
                "all entries on this side of a distance must be people, and this is none",
            );
            return refuse(d.help("name parts of the robot on the other side"));
        };
        let Some(human) = human else { return Err(None) };
        if let Some(point) = point
            && !human.points.iter().any(|p| p.0 == point.value)
        {
            let names = || human.points.iter().map(|p| p.0.as_str());
            let text = format!("`{}` has no point `{}`", written(&name), point.value);
            let d = Diagnostic::unknown_name(point.span, text);
            return refuse(d.one_of("its points are", &point.value, names()));
        }
        let mut place = |point: &str| match self.params.meaning(&symbol(target(&name), point, false)) {
            Meaning::Value(symbol) => <[usize; 3]>::try_from(symbol.value.nodes).map_err(|_| None),
            _ => Err(None),
        };
        if let Some(point) = point {
            let at = place(&point.value)?;
            return Ok(vec![[at, at]]);
        }
        let places = human.points.iter().map(|p| place(&p.0)).collect::<Result<Vec<_>, Refused>>()?;
        let joined = |i: usize| human.links.iter().any(|l| l.0 == i || l.1 == i);
        let alone = places.iter().enumerate().filter(|(i, _)| !joined(*i)).map(|(_, at)| [*at, *at]);
        let links = human.links.iter().filter_map(|l| Some([*places.get(l.0)?, *places.get(l.1)?]));
        Ok(alone.chain(links).collect())
    }

    /// Smallest distance between parts of the robot and segments of people. Parts that cannot move are excluded: no
    /// motion takes them away from a person.
    pub(super) fn away(
        &mut self,
        graph: &mut Graph,
        parts: &[Geometry],
        people: &[Segment],
        span: Span,
    ) -> Result<Typed, Box<Diagnostic>> {
        let model = &self.robot.model;
        let moving: Vec<&Geometry> = parts.iter().filter(|part| !model.support(part.link).is_empty()).collect();
        if moving.is_empty() {
            let d =
                Diagnostic::error("HQ0313", span, "these parts cannot move, and no motion takes them away from people");
            return Err(Box::new(d.help(
                "name parts of links that move; how far a person is from a place is `norm(HUMAN.POINT - [x, y, z] m)`",
            )));
        }
        let one = |part: &Geometry, ends: &Segment| {
            Leaf::PointDistance(Box::new(PointDistance { part: part.clone(), ends: *ends }))
        };
        let leaves = moving.iter().flat_map(|&part| people.iter().map(move |ends| one(part, ends))).collect();
        self.smallest(graph, leaves, "a limit for each of them", span)
    }
}
