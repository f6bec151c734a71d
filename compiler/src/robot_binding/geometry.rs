//! Arms, points, segments and groups of them.

use std::collections::BTreeMap;

use dsl::tree::{Block, Value, ValueKind};
use dsl::{Diagnostic, Span};
use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Shape};
use stdlib_tasks::bound::{Arm, Geometry};
use stdlib_tasks::dimension::LENGTH;

use super::Binder;
use super::lookup::unknown_geometry;
use crate::forms::{block_of, check_keys, items_of, path_of};
use crate::sections::{ARM, POINT, SEGMENT};

impl Binder<'_, '_> {
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
                            Diagnostic::error("HQ0206", e.key.span, format!("arm `{}` has no `tip`", e.key.value))
                                .help("name the link at its end, `tip left_tool`"),
                        );
                    }
                }
            }
        }
        arms
    }

    pub(super) fn geometries(&mut self) -> Vec<Geometry> {
        let mut all: Vec<Geometry> = Vec::new();
        for e in self.declarations("points").iter().flat_map(|b| &b.entries) {
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
        for e in self.declarations("segments").iter().flat_map(|b| &b.entries) {
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
                        Diagnostic::error("HQ0206", e.key.span, format!("this segment has no `{key}`"))
                            .help("write `{ link NAME  from [x, y, z] m  to [x, y, z] m }`"),
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
                self.diagnostics
                    .push(Diagnostic::error("HQ0206", key, "this has no `link`").help("name the link that carries it"));
                None
            }
        }
    }

    pub(super) fn groups(&mut self, geometries: &[Geometry]) -> BTreeMap<String, Vec<String>> {
        let mut groups: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for e in self.block("arms").iter().flat_map(|b| &b.entries) {
            let ValueKind::Block(inner) = &e.value.kind else { continue };
            let Some(points) = inner.get("points") else { continue };
            let name = format!("arms.{}", e.key.value);
            match self.group(&points.value, geometries, &groups) {
                Some(names) => {
                    groups.entry("arms".to_string()).or_default().extend(names.clone());
                    groups.insert(name, names);
                }
                None => self.failed.extend([name, "arms".to_string()]),
            }
        }
        let block = self.declarations("groups");
        let declared: Vec<&str> = block.iter().flat_map(|b| &b.entries).map(|e| e.key.value.as_str()).collect();
        for (i, e) in block.iter().flat_map(|b| &b.entries).enumerate() {
            let name = e.key.value.as_str();
            if groups.contains_key(name) || geometries.iter().any(|g| g.name == name) {
                let text = format!("`{name}` is already the name of a point, segment or group");
                self.diagnostics
                    .push(Diagnostic::error("HQ0202", e.key.span, text).help("choose another name for the group"));
                continue;
            }
            if let Some(later) = items_of(&e.value).iter().find(|item| {
                path_of(item).is_some_and(|p| declared[i..].contains(&p.as_str()) && !self.failed.contains(&p))
            }) {
                let d = if path_of(later).as_deref() == Some(name) {
                    Diagnostic::error("HQ0201", later.span, format!("group `{name}` contains itself"))
                        .help("leave it out, or choose another name for the group")
                } else {
                    Diagnostic::error("HQ0201", later.span, "this group is declared further down")
                        .help("declare a group before those that contain it")
                };
                self.diagnostics.push(d);
                self.failed.insert(name.to_string());
                continue;
            }
            match self.group(&e.value, geometries, &groups) {
                Some(names) => {
                    groups.insert(name.to_string(), names);
                }
                None => {
                    self.failed.insert(name.to_string());
                }
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
        let mut names = Vec::new();
        let mut good = true;
        for item in items_of(value) {
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
                names.extend(members.iter().cloned());
            } else if geometries.iter().any(|g| g.name == path) || self.model.link(&path).is_some() {
                names.push(path);
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

/// A segment between two points of a link, as a capsule without radius (a point where both ends are one).
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
