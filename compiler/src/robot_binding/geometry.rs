//! Arms, points, segments, and groups of them.

use std::collections::{BTreeMap, BTreeSet};

use blocks::{ByName, Located, Origin};
use dsl::tree::{Entry, Value};
use dsl::{Diagnostic, Span};
use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Shape};
use stdlib_tasks::bound::{Arm, Geometry};

use super::Binder;
use super::joints::pattern_as_name;
use super::lookup::{is_pattern, unknown_geometry};
use crate::forms::{block_of, path_of};
use crate::sections::{ArmBlock, PointBlock, SegmentBlock};

/// Maximum number of points and segments of a robot.
const MAX_GEOMETRIES: usize = 2_000;
/// Maximum number of names in all groups of a robot, with nested groups expanded.
const MAX_GROUPED: usize = 2_000;

impl Binder<'_, '_> {
    /// Reports too many parts of a kind.
    fn too_many(&mut self, at: Span, what: &str, most: usize) {
        let d = Diagnostic::error("HQ0190", at, format!("this robot has more than {most} {what}"));
        self.diagnostics.push(d.here("read up to here").help("name the parts that tasks use"));
    }

    pub(super) fn arms(&mut self) -> Vec<Arm> {
        let mut arms: Vec<Arm> = Vec::new();
        for ByName { name, value, .. } in self.declarations("arms", &self.block.arms) {
            let ArmBlock { shoulder, elbow, wrist, tip, .. } = &value.value;
            let written = [shoulder, elbow, wrist, tip];
            let links = written.map(|link| self.link(link.as_ref()));
            self.one_chain(&name.value, written, links);
            let [shoulder, elbow, wrist, tip] = links;
            match tip {
                Some(tip) => arms.push(Arm { name: name.value.clone(), shoulder, elbow, wrist, tip }),
                None => self.fail(name),
            }
        }
        // A chain of the SRDF is an arm, of which the tip is known.
        for group in self.srdf.iter().flat_map(|of| &of.srdf.groups) {
            let taken = arms.iter().any(|arm| arm.name == group.name) || self.failed.contains(&group.name);
            if let Some(tip) = group.tip.filter(|_| !taken) {
                let name = group.name.clone();
                arms.push(Arm { name, shoulder: None, elbow: None, wrist: None, tip });
            }
        }
        arms
    }

    /// Warns of the first link of an arm that is not at or behind the one before it. `None` are links that are left out, or
    /// unknown.
    fn one_chain(&mut self, arm: &str, written: [&Option<Located<String>>; 4], links: [Option<LinkId>; 4]) {
        let words = ["shoulder", "elbow", "wrist", "tip"];
        let known: Vec<(&str, &Located<String>, LinkId)> =
            (0..4).filter_map(|i| Some((words[i], written[i].as_ref()?, links[i]?))).collect();
        let behind = |inner: LinkId, outer: LinkId| {
            std::iter::successors(Some(outer), |link| self.model.parent(*link)).any(|link| link == inner)
        };
        let broken = known.windows(2).find(|pair| !behind(pair[0].2, pair[1].2));
        let Some([(inner, first, _), (outer, second, _)]) = broken else { return };
        let text = format!("the {outer} of arm `{arm}` is not behind its {inner}");
        let d = Diagnostic::warning("HQ0407", self.origins.span(second.at), text)
            .label(self.origins.span(first.at), format!("the {inner}"))
            .note("the joints of the arm do not move this link, so the parts are not those of one arm");
        self.diagnostics.push(d.help("name links of one chain, from the shoulder to the tip"));
    }

    fn fail(&mut self, name: &Located<String>) {
        self.failed.insert(name.value.clone());
    }

    pub(super) fn geometries(&mut self) -> Vec<Geometry> {
        let mut all: Vec<Geometry> = Vec::new();
        let points = self.declarations("points", &self.block.points);
        let segments = self.declarations("segments", &self.block.segments);
        let names = || points.iter().map(|p| &p.name).chain(segments.iter().map(|s| &s.name));
        if let Some(beyond) = names().nth(MAX_GEOMETRIES) {
            self.failed.extend(names().map(|name| name.value.clone()));
            self.too_many(self.origins.span(beyond.at), "points and segments", MAX_GEOMETRIES);
            return all;
        }
        for ByName { name, value, .. } in &points {
            let PointBlock { link, offset, .. } = &value.value;
            match self.link(link.as_ref()) {
                Some(link) => all.push(Geometry::point(name.value.clone(), link, Vector3::from(*offset))),
                None => self.fail(name),
            }
        }
        let named: BTreeMap<&str, Origin> = points.iter().map(|p| (p.name.value.as_str(), p.name.at)).collect();
        for ByName { name, value, .. } in &segments {
            if let Some(point) = named.get(name.value.as_str()) {
                let text = format!("`{}` is already the name of a point", name.value);
                let d = Diagnostic::error("HQ0202", self.origins.span(name.at), text);
                let d = d.label(self.origins.span(*point), "the point");
                self.diagnostics.push(d.help("choose another name for the segment"));
                continue;
            }
            let SegmentBlock { link, from, to, .. } = &value.value;
            let link = self.link(link.as_ref());
            let (Some(link), Some(from), Some(to)) = (link, from, to) else {
                self.fail(name);
                continue;
            };
            if from.value == to.value {
                let text = "this segment has no length: both ends are one point";
                let d = Diagnostic::error("HQ0308", self.origins.span(to.at), text);
                let d = d.label(self.origins.span(from.at), "it begins here");
                self.diagnostics.push(d.help("move an end, or declare it under `points`"));
            }
            all.push(segment(&name.value, link, from.value, to.value));
        }
        all
    }

    pub(super) fn groups(&mut self, geometries: &[Geometry]) -> BTreeMap<String, Vec<String>> {
        let mut groups: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut count = 0;
        let mut of_arms: BTreeSet<String> = BTreeSet::new();
        for ByName { name: arm, value, .. } in &self.block.arms {
            let Some(points) = self.unbound(value.value.points.as_ref()) else { continue };
            let name = format!("arms.{}", arm.value);
            match self.group(points, geometries, &groups) {
                Some(names) => {
                    count += names.len();
                    let new = names.iter().filter(|n| of_arms.insert((*n).clone())).cloned();
                    groups.entry("arms".to_string()).or_default().extend(new);
                    groups.insert(name, names);
                }
                None => self.failed.extend([name, "arms".to_string()]),
            }
            if count > MAX_GROUPED {
                self.too_many(self.origins.span(arm.at), "names in the points of its arms", MAX_GROUPED);
                break;
            }
        }
        let replaceable = self.described(geometries, &mut groups);
        let block = self.unbound(self.block.groups.as_ref());
        let block = block.and_then(|value| block_of(value, "`groups`", self.diagnostics));
        let (patterns, declared): (Vec<&Entry>, Vec<&Entry>) =
            block.iter().flat_map(|b| &b.entries).partition(|e| is_pattern(&e.key.value));
        self.diagnostics.extend(patterns.into_iter().map(|e| pattern_as_name(&e.key)));
        let entries = || declared.iter().copied().enumerate();
        let last: BTreeMap<&str, usize> = entries().map(|(i, e)| (e.key.value.as_str(), i)).collect();
        let parts: BTreeSet<&str> = geometries.iter().map(|g| g.name.as_str()).collect();
        for (i, e) in entries() {
            let name = e.key.value.as_str();
            if (groups.contains_key(name) && !replaceable.contains(name)) || parts.contains(name) {
                let text = format!("`{name}` is already the name of a point, segment or group");
                self.diagnostics
                    .push(Diagnostic::error("HQ0202", e.key.span, text).help("choose another name for the group"));
                continue;
            }
            if let Some(later) = e.value.items().iter().find(|item| {
                path_of(item)
                    .is_some_and(|p| last.get(p.as_str()).is_some_and(|&l| l >= i) && !self.failed.contains(&p))
            }) {
                let d = if path_of(later).as_deref() == Some(name) {
                    Diagnostic::unknown_name(later.span, format!("group `{name}` contains itself"))
                        .help("leave it out, or choose another name for the group")
                } else {
                    Diagnostic::unknown_name(later.span, "this group is declared further down")
                        .help("declare a group before those that contain it")
                };
                self.diagnostics.push(d);
                self.failed.insert(name.to_string());
                continue;
            }
            match self.group(&e.value, geometries, &groups) {
                Some(names) => {
                    count += names.len();
                    groups.insert(name.to_string(), names);
                }
                None => {
                    groups.remove(name);
                    self.failed.insert(name.to_string());
                }
            }
            if count > MAX_GROUPED {
                self.failed.extend(entries().skip(i).map(|(_, e)| e.key.value.clone()));
                self.too_many(e.key.span, "names in its groups", MAX_GROUPED);
                break;
            }
        }
        groups
    }

    /// Adds the groups that are not declared: `all` for all links with shapes, and those of the SRDF for theirs, unless a part or
    /// a link has the name. Returns their names.
    fn described(&self, geometries: &[Geometry], groups: &mut BTreeMap<String, Vec<String>>) -> BTreeSet<String> {
        let model = &self.model;
        let with_shapes = |links: &mut dyn Iterator<Item = LinkId>| -> Vec<String> {
            let links = links.map(|link| model.link_ref(link)).filter(|link| !link.collision.is_empty());
            links.map(|link| link.name.clone()).collect()
        };
        let mut all: Vec<(String, Vec<String>)> =
            vec![("all".to_string(), with_shapes(&mut (0..model.links.len() as u32).map(LinkId)))];
        let of_srdf = self.srdf.iter().flat_map(|of| &of.srdf.groups);
        all.extend(of_srdf.map(|group| (group.name.clone(), with_shapes(&mut group.links.iter().copied()))));
        let mut added = BTreeSet::new();
        for (name, links) in all {
            let taken = groups.contains_key(&name) || geometries.iter().any(|g| g.name == name);
            if !taken && !links.is_empty() && model.link(&name).is_none() {
                groups.insert(name.clone(), links);
                added.insert(name);
            }
        }
        added
    }

    fn group(
        &mut self,
        value: &Value,
        geometries: &[Geometry],
        groups: &BTreeMap<String, Vec<String>>,
    ) -> Option<Vec<String>> {
        // A part that is named twice, or that is in several groups, counts once.
        let (mut names, mut known) = (Vec::new(), BTreeSet::new());
        let mut good = true;
        for item in value.items() {
            let Some(path) = path_of(item) else {
                let d = Diagnostic::error(
                    "HQ0304",
                    item.span,
                    "the name of a point, segment, link or group is needed here",
                );
                self.diagnostics.push(d.help("write for instance `[left_elbow, left_wrist]`"));
                good = false;
                continue;
            };
            if let Some(members) = groups.get(&path) {
                names.extend(members.iter().filter(|m| known.insert((*m).clone())).cloned());
            } else if geometries.iter().any(|g| g.name == path) || self.model.link(&path).is_some() {
                names.extend(known.insert(path.clone()).then_some(path));
            } else {
                if !self.failed.contains(&path) {
                    self.diagnostics.push(unknown_geometry(&self.model, geometries, groups, &path, item.span));
                }
                good = false;
            }
        }
        good.then_some(names)
    }
}

/// Geometry of a segment between two points of a link: a capsule without radius, or a point if both ends coincide.
fn segment(name: &str, link: LinkId, from: [f64; 3], to: [f64; 3]) -> Geometry {
    let (a, b) = (Point3::from(from), Point3::from(to));
    let along = b - a;
    let length = along.norm();
    if length < 1e-9 {
        return Geometry::point(name, link, a.coords);
    }
    let rotation = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let center = a + along * 0.5;
    let origin = Isometry3::from_parts(center.coords.into(), rotation);
    Geometry { name: name.to_string(), link, origin, shape: Shape::Capsule { radius: 0.0, half_length: length / 2.0 } }
}
