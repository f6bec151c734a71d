//! Arms, points, segments, and groups of them.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{Block, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Shape};
use stdlib_tasks::bound::{Arm, Geometry};
use stdlib_tasks::dimension::LENGTH;

use super::Binder;
use super::lookup::unknown_geometry;
use crate::forms::{block_of, check_keys, path_of};
use crate::sections::{ARM, POINT, SEGMENT};

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
        for e in self.declarations("arms").iter().flat_map(|b| &b.entries) {
            let Some(inner) = block_of(&e.value, "an arm", self.diagnostics) else {
                self.failed.insert(e.key.value.clone());
                continue;
            };
            check_keys(inner, &ARM, self.diagnostics);
            let mut get = |key: &str| inner.get(key).and_then(|x| self.link(&x.value)).map(|l| l.1);
            let (shoulder, elbow, wrist, tip) = (get("shoulder"), get("elbow"), get("wrist"), get("tip"));
            match tip {
                Some(tip) => arms.push(Arm { name: e.key.value.clone(), shoulder, elbow, wrist, tip }),
                None => {
                    self.failed.insert(e.key.value.clone());
                    let misspelt = inner.entries.iter().any(|e| ARM.entries().all(|known| known != e.key.value));
                    if inner.get("tip").is_none() && !misspelt {
                        self.diagnostics.push(
                            Diagnostic::missing_keys(
                                ["tip"],
                                e.key.span,
                                format!("arm `{}` has no `tip`", e.key.value),
                            )
                            .help(Help::with("name the link at its end, {}", [Snippet::entry("tip", "left_tool")])),
                        );
                    }
                }
            }
        }
        arms
    }

    pub(super) fn geometries(&mut self) -> Vec<Geometry> {
        let mut all: Vec<Geometry> = Vec::new();
        let [points, segments] = ["points", "segments"].map(|key| self.declarations(key));
        let declared = || [&points, &segments].into_iter().flatten().flat_map(|b| &b.entries);
        if let Some(beyond) = declared().nth(MAX_GEOMETRIES) {
            self.failed.extend(declared().map(|e| e.key.value.clone()));
            self.too_many(beyond.key.span, "points and segments", MAX_GEOMETRIES);
            return all;
        }
        for e in points.iter().flat_map(|b| &b.entries) {
            let found = match &e.value.kind {
                ValueKind::Block(inner) => {
                    check_keys(inner, &POINT, self.diagnostics);
                    let offset = match inner.get("offset") {
                        Some(x) => self.constants.vector(&x.value, LENGTH, self.diagnostics),
                        None => Some([0.0; 3]),
                    };
                    self.required_link(inner, e.key.span).zip(offset)
                }
                _ => self.link(&e.value).map(|l| (l.1, [0.0; 3])),
            };
            match found {
                Some((link, offset)) => {
                    all.push(Geometry::point(e.key.value.clone(), link, Vector3::from(offset)));
                }
                None => {
                    self.failed.insert(e.key.value.clone());
                }
            }
        }
        for e in segments.iter().flat_map(|b| &b.entries) {
            if let Some(point) = self.robot.body.get("points").and_then(|p| match &p.value.kind {
                ValueKind::Block(b) => b.get(&e.key.value),
                _ => None,
            }) {
                let text = format!("`{}` is already the name of a point", e.key.value);
                let d = Diagnostic::error("HQ0202", e.key.span, text).label(point.key.span, "the point");
                self.diagnostics.push(d.help("choose another name for the segment"));
                continue;
            }
            let Some(inner) = block_of(&e.value, "a segment", self.diagnostics) else {
                self.failed.insert(e.key.value.clone());
                continue;
            };
            check_keys(inner, &SEGMENT, self.diagnostics);
            let mut end = |key: &str| match inner.get(key) {
                Some(x) => self.constants.vector(&x.value, LENGTH, self.diagnostics),
                None => {
                    self.diagnostics.push(
                        Diagnostic::missing_keys([key], e.key.span, format!("this segment has no `{key}`")).help(
                            Snippet::braces([
                                Snippet::entry("link", "NAME"),
                                Snippet::entry("from", "[x, y, z] m"),
                                Snippet::entry("to", "[x, y, z] m"),
                            ]),
                        ),
                    );
                    None
                }
            };
            let (from, to) = (end("from"), end("to"));
            let link = self.required_link(inner, e.key.span);
            match (link, from, to) {
                (Some(link), Some(from), Some(to)) => {
                    if from == to {
                        let (a, b) = (inner.get("from"), inner.get("to"));
                        let span = b.map_or(e.key.span, |b| b.value.span);
                        let mut d =
                            Diagnostic::error("HQ0308", span, "this segment has no length: both ends are one point");
                        if let Some(a) = a {
                            d = d.label(a.value.span, "it begins here");
                        }
                        self.diagnostics.push(d.help("move an end, or declare it under `points`"));
                    }
                    all.push(segment(&e.key.value, link, from, to));
                }
                _ => {
                    self.failed.insert(e.key.value.clone());
                }
            }
        }
        all
    }

    fn required_link(&mut self, block: &Block, key: Span) -> Option<LinkId> {
        match block.get("link") {
            Some(x) => self.link(&x.value).map(|l| l.1),
            None => {
                self.diagnostics.push(
                    Diagnostic::missing_keys(["link"], key, "this has no `link`").help("name the link that carries it"),
                );
                None
            }
        }
    }

    pub(super) fn groups(&mut self, geometries: &[Geometry]) -> BTreeMap<String, Vec<String>> {
        let mut groups: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut count = 0;
        let mut of_arms: BTreeSet<String> = BTreeSet::new();
        for e in self.block("arms").iter().flat_map(|b| &b.entries) {
            let ValueKind::Block(inner) = &e.value.kind else { continue };
            let Some(points) = inner.get("points") else { continue };
            let name = format!("arms.{}", e.key.value);
            match self.group(&points.value, geometries, &groups) {
                Some(names) => {
                    count += names.len();
                    let new = names.iter().filter(|n| of_arms.insert((*n).clone())).cloned();
                    groups.entry("arms".to_string()).or_default().extend(new);
                    groups.insert(name, names);
                }
                None => self.failed.extend([name, "arms".to_string()]),
            }
            if count > MAX_GROUPED {
                self.too_many(e.key.span, "names in the points of its arms", MAX_GROUPED);
                break;
            }
        }
        let block = self.declarations("groups");
        let entries = || block.iter().flat_map(|b| &b.entries).enumerate();
        let last: BTreeMap<&str, usize> = entries().map(|(i, e)| (e.key.value.as_str(), i)).collect();
        let parts: BTreeSet<&str> = geometries.iter().map(|g| g.name.as_str()).collect();
        for (i, e) in entries() {
            let name = e.key.value.as_str();
            if groups.contains_key(name) || parts.contains(name) {
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
