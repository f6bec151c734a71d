//! Safety fields: the points of people, the links of the robot, and the combination of distances to one number.

use std::collections::BTreeSet;

use dsl::tree::{BlockKind, NamedBlock, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet};
use names::{list, suggest};
use robot::{Drive, LinkId, Model};
use stdlib_tasks::dimension::{Dimension, LENGTH};
use stdlib_tasks::expression::Leaf;
use stdlib_tasks::field::{DistanceProgram, FieldProgram, Over};

use super::Lowerer;
use crate::expand::{Expanded, Named};
use crate::expr::constants::{Constants, is_word};
use crate::expr::{Axes, Frame, Kind, Meaning, Symbol, Typed, field_symbol, frames, symbol};
use crate::forms::{path_of, target, text_of};
use crate::robot_binding::{BoundRobot, unknown_geometry};
use crate::sections::SafetyFieldBlock;
use crate::units::shown;

/// Maximum number of points in a field.
const MAX_POINTS: usize = 256;

/// Nodes of a point in a field.
type Point = [usize; 3];

impl Lowerer<'_> {
    /// Declares the name of a field.
    pub(super) fn declare_field(&mut self, f: &NamedBlock) {
        let name = &f.name;
        if is_word(&name.value) {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{}` is a word of the language", name.value));
            self.push(d.help("choose another name"));
            self.params.failed.insert(name.value.clone());
            return;
        }
        self.params.fields.insert(name.value.clone());
    }

    /// Binds all fields to the robot.
    pub(super) fn bind_fields(&mut self, expanded: &Expanded, robot: Option<&BoundRobot>) {
        for f in expanded.values.iter().filter_map(|v| match v {
            Named::Block(f) if f.kind == BlockKind::SafetyField => Some(f),
            _ => None,
        }) {
            if !self.params.fields.contains(&f.name.value) {
                continue;
            }
            let before = self.errors();
            let bound = self.bind_field(f, robot);
            if bound.is_none() || self.errors() > before {
                self.params.failed.insert(f.name.value.clone());
            }
        }
    }

    fn bind_field(&mut self, f: &NamedBlock, robot: Option<&BoundRobot>) -> Option<()> {
        let _: SafetyFieldBlock = self.read(&f.body, f.name.span);
        let points = f.body.get("of").and_then(|entry| self.people(&entry.value));
        let distance = match f.body.get("distance") {
            Some(entry) => self.distance(&entry.value),
            None => Some((DistanceProgram::Identity, LENGTH)),
        };
        let links = robot.and_then(|robot| match f.body.get("links") {
            Some(entry) => self.links_of(&entry.value, robot),
            None => Some(whole(&robot.model)),
        });
        let over = match (f.body.get("points"), &distance) {
            (Some(entry), Some((_, dimension))) => self.over(&entry.value, *dimension),
            (Some(_), None) => None,
            (None, _) => Some(Over::Mean),
        };
        let ((distance, dimension), points, links, over) = (distance?, points?, links?, over?);
        let field = FieldProgram { name: f.name.value.clone(), links, distance, over, points, dimension };
        let places = field.points.iter().map(|p| {
            let at = self.table.place(p).at;
            [at, at + 1, at + 2]
        });
        self.fields.push(FieldProgram { points: places.collect(), ..field.clone() });
        let read: Vec<usize> = field.points.iter().flatten().copied().collect();
        let at = self.table.leaf(Leaf::Field(Box::new(field)));
        let nodes = vec![self.graph.reading_state(at, read)];
        let span = f.name.span;
        let value = Typed { kind: Kind::Scalar, dimension, nodes, bare: false, axes: Axes::default(), span };
        let name = field_symbol(&f.name.value);
        self.params.symbols.insert(name, Symbol { value, declared: span });
        Some(())
    }

    /// Points of people.
    fn people(&mut self, value: &Value) -> Option<Vec<Point>> {
        let alone = match &value.kind {
            ValueKind::List(items) => items.first().is_some_and(|item| self.is_number(item)),
            _ => true,
        };
        let items = if alone { std::slice::from_ref(value) } else { value.items() };
        let found: Vec<Option<Vec<Point>>> = items.iter().map(|item| self.points_of(item)).collect();
        let mut points = Vec::new();
        for (item, more) in items.iter().zip(found.into_iter().collect::<Option<Vec<_>>>()?) {
            if more.iter().any(|p| points.contains(p)) {
                let d = Diagnostic::error("HQ0207", item.span, "this point is there already");
                self.push(d.note("it would count twice in the mean").help("name each point once"));
                return None;
            }
            points.extend(more);
        }
        if points.is_empty() {
            let d = Diagnostic::missing_keys(["of"], value.span, "a safety field is of at least one point");
            self.push(d.help(Help::with("name a person or points: {}", [Snippet::entry("of", "operator")])));
            return None;
        }
        if points.len() > MAX_POINTS {
            let text = format!("this field is of {} points, and {MAX_POINTS} are the most", points.len());
            self.push(Diagnostic::error("HQ0308", value.span, text).help("name the points that matter"));
            return None;
        }
        Some(points)
    }

    /// True for a value that can only be one component of a vector.
    fn is_number(&mut self, value: &Value) -> bool {
        match &value.kind {
            ValueKind::Number(_) => true,
            ValueKind::Negate(inner) | ValueKind::Unit(inner, _) => self.is_number(inner),
            ValueKind::Name(name) => {
                matches!(self.params.meaning(name), Meaning::Value(s) if s.value.kind == Kind::Scalar)
            }
            _ => false,
        }
    }

    /// Points of one item: all points of a person, or one point.
    fn points_of(&mut self, value: &Value) -> Option<Vec<Point>> {
        if let ValueKind::Name(name) = &value.kind
            && let Meaning::Human(human) = self.params.meaning(name)
        {
            let point = |s: &mut Self, point: &str| match s.params.meaning(&symbol(target(name), point, false)) {
                Meaning::Value(symbol) => Point::try_from(symbol.value.nodes).ok(),
                _ => None,
            };
            return human.points.iter().map(|p| point(self, &p.0)).collect();
        }
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let typed = constants.typed(value, self.diagnostics)?;
        if typed.kind != Kind::Vector {
            let is = typed.kind.describe();
            let d = Diagnostic::error("HQ0304", value.span, format!("a person or a position is needed here, not {is}"));
            self.push(d.help(Help::with(
                "write for instance {}, {} or {}",
                ["operator", "operator.chest", "[1, 0, 1] m"].map(|of| Snippet::entry("of", of)),
            )));
            return None;
        }
        let what = "a point of a safety field";
        let wrong = constants
            .check_dimension(&typed, LENGTH, what)
            .or_else(|| frames::wanted(&typed, &Frame::World, what, true));
        if let Some(d) = wrong {
            self.push(d);
            return None;
        }
        if self.graph.moves_along(&typed.nodes) {
            let d = Diagnostic::error("HQ0312", value.span, "a trajectory is not allowed in a safety field");
            let note = "it begins when a stack is entered, and a field belongs to no stack";
            self.push(d.note(note).help("name where the person is"));
            return None;
        }
        Some(vec![Point::try_from(typed.nodes).ok()?])
    }

    /// Links of the given names.
    fn links_of(&mut self, value: &Value, robot: &BoundRobot) -> Option<Vec<LinkId>> {
        let links = self.links_named(value, robot)?;
        if links.is_empty() {
            let d = Diagnostic::missing_keys(["links"], value.span, "no link of the robot counts in this field");
            self.push(d.help("name some, or leave `links` out for the whole robot"));
            return None;
        }
        if !links.iter().any(|l| !robot.model.support(*l).is_empty()) {
            let d = Diagnostic::error(
                "HQ0313",
                value.span,
                "none of these links moves, and neither does the field by them",
            );
            self.push(d.help("name links that move"));
            return None;
        }
        Some(links)
    }

    /// Links of names of links, arms, points, segments and groups, each once. `None` if one of the names is wrong, with
    /// diagnostics.
    pub(super) fn links_named(&mut self, value: &Value, robot: &BoundRobot) -> Option<Vec<LinkId>> {
        let mut links: Vec<LinkId> = Vec::new();
        let mut good = true;
        for item in value.items() {
            let Some(path) = path_of(item) else {
                if !matches!(item.kind, ValueKind::Missing) {
                    let d = Diagnostic::error("HQ0304", item.span, "the name of a link, arm, point or group is needed");
                    self.push(d.help(Help::write_for_instance(Snippet::entry("links", "[left, right]"))));
                }
                good = false;
                continue;
            };
            match named_links(&path, robot) {
                Some(found) => links.extend(found),
                None => {
                    good = false;
                    if !robot.failed.contains(&path) {
                        let d = unknown_geometry(&robot.model, &robot.geometries, &robot.groups, &path, item.span);
                        let arms = robot.arms.iter().map(|a| a.name.as_str());
                        self.push(match suggest(&path, arms) {
                            Some(near) => Diagnostic { fixes: Vec::new(), ..d }.meant(near),
                            None => d,
                        });
                    }
                }
            }
        }
        let mut seen = BTreeSet::new();
        links.retain(|l| seen.insert(*l));
        good.then_some(links)
    }

    /// Lowers the combination of distances to one number.
    fn over(&mut self, value: &Value, dimension: Dimension) -> Option<Over> {
        const WORDS: [&str; 3] = ["mean", "minimum", "soft_minimum"];
        let said = match &value.kind {
            ValueKind::Call(function, args) if function.value == "soft_minimum" => {
                let [sharpness] = args.as_slice() else {
                    let d = Diagnostic::error("HQ0310", value.span, "`soft_minimum` takes its sharpness");
                    self.push(d.help("write for instance `soft_minimum(8 /m)`"));
                    return None;
                };
                let wanted = dimension.power(-1)?;
                return self.positive_number(sharpness, wanted).map(|sharpness| Over::SoftLeast { sharpness });
            }
            ValueKind::Call(function, _) => function.value.as_str(),
            _ => text_of(value).unwrap_or_default(),
        };
        match said {
            "mean" if text_of(value).is_some() => Some(Over::Mean),
            "minimum" if text_of(value).is_some() => Some(Over::Least),
            _ if matches!(value.kind, ValueKind::Missing) => None,
            _ => {
                let names = list(WORDS, 3);
                let d = Diagnostic::error("HQ0304", value.span, format!("`points` is one of {names}"));
                self.push(match suggest(said, WORDS) {
                    Some("soft_minimum") => d.help("write it with its sharpness: `soft_minimum(8 /m)`"),
                    Some(near) => d.meant(near),
                    None => d.help(Help::with(
                        "write for instance {}, or {}",
                        ["mean", "soft_minimum(8 /m)"].map(|over| Snippet::entry("points", over)),
                    )),
                });
                None
            }
        }
    }

    pub(super) fn positive_number(&mut self, value: &Value, dimension: Dimension) -> Option<f64> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let x = constants.scalar(value, dimension, self.diagnostics)?;
        if x > 0.0 {
            return Some(x);
        }
        let text = format!("this is above zero, and it is {}", shown(x, dimension));
        self.push(Diagnostic::error("HQ0308", value.span, text).help("write a positive number"));
        None
    }
}

/// True for a link that is moved by a joint.
fn is_moved(model: &Model, link: LinkId) -> bool {
    let joint = model.link_ref(link).parent_joint;
    joint.is_some_and(|j| matches!(model.joint_ref(j).drive, Drive::Dof(_) | Drive::Mimic { .. }))
}

/// Links that represent the whole robot: those moved by joints, and those of bases that move.
fn whole(model: &Model) -> Vec<LinkId> {
    let all = (0..model.links.len() as u32).map(LinkId);
    model.bases.iter().map(|base| base.link).chain(all.filter(|l| is_moved(model, *l))).collect()
}

/// Links of a name: a link, the moved links of an arm, or the links that carry points and segments.
fn named_links(path: &str, robot: &BoundRobot) -> Option<Vec<LinkId>> {
    let model = &robot.model;
    if let Some(link) = model.link(path) {
        return Some(vec![link]);
    }
    let name = path.strip_prefix("arms.").unwrap_or(path);
    if path == "arms" && !robot.arms.is_empty() {
        return Some(robot.arms.iter().flat_map(|a| along(model, a.shoulder, a.tip)).collect());
    }
    if let Some(arm) = robot.arms.iter().find(|a| a.name == name) {
        return Some(along(model, arm.shoulder, arm.tip));
    }
    let names = robot.groups.get(path).cloned().unwrap_or_else(|| vec![path.to_string()]);
    let one = |name: &String| {
        let geometry = robot.geometries.iter().find(|g| g.name == *name).map(|g| g.link);
        geometry.or_else(|| model.link(name))
    };
    names.iter().map(one).collect()
}

/// Links from the shoulder, or else the root, to the tip that are moved by joints; the tip alone if there are none.
fn along(model: &Model, shoulder: Option<LinkId>, tip: LinkId) -> Vec<LinkId> {
    let mut chain = Vec::new();
    let mut link = Some(tip);
    while let Some(l) = link {
        chain.push(l);
        link = if Some(l) == shoulder { None } else { model.parent(l) };
    }
    chain.reverse();
    let moved: Vec<LinkId> = chain.iter().copied().filter(|l| is_moved(model, *l)).collect();
    if moved.is_empty() { vec![tip] } else { moved }
}
