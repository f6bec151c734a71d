//! Parameters that name parts of the robot: frames, arms, geometries.

use std::collections::BTreeSet;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet};
use robot::LinkId;
use stdlib_tasks::bound::{Arm, Geometry};
use stdlib_tasks::params::ParamInfo;

use super::Binder;
use crate::diagnostics::examples;
use crate::forms::{path_of, text_of};
use crate::robot_binding::{BoundRobot, unknown_geometry, unknown_link};

impl Binder<'_> {
    pub(super) fn frame(&mut self, value: &Value, info: &ParamInfo) -> Option<(String, LinkId)> {
        let Some(name) = text_of(value) else { return self.wrong(value, info, "the name of a link or arm") };
        let arm = self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
        match self.robot.model.link(name).or(arm) {
            Some(link) => Some((name.to_string(), link)),
            None => {
                if !self.robot.failed.contains(name) {
                    self.diagnostics.push(unknown_link(&self.robot.model, name, value.span, &self.robot.arms));
                }
                None
            }
        }
    }

    pub(super) fn arm(&mut self, value: &Value, info: &ParamInfo) -> Option<Arm> {
        let Some(name) = text_of(value) else { return self.wrong(value, info, "the name of an arm") };
        if let Some(arm) = self.robot.arms.iter().find(|a| a.name == name) {
            return Some(arm.clone());
        }
        if self.robot.failed.contains(name) {
            return None;
        }
        let names = self.robot.arms.iter().map(|a| a.name.as_str());
        let d =
            Diagnostic::unknown_name(value.span, format!("robot `{}` declares no arm `{name}`", self.robot.name.value));
        self.diagnostics.push(d.help(Help::with("declare it in the robot: {}", [examples::arms()])).one_of(
            "it declares",
            name,
            names,
        ));
        None
    }
}

/// Name inside `frame(NAME)`.
fn frame_of(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Call(function, args) if function.value == "frame" => args.first().and_then(text_of),
        _ => None,
    }
}

/// Adds help to the diagnostic for an arm whose parts are meant.
fn of_arm(robot: &BoundRobot, arm: &Arm, d: Diagnostic) -> Diagnostic {
    let group = format!("arms.{}", arm.name);
    if robot.groups.contains_key(&group) {
        return d.meant_as("the points of the arm,", group);
    }
    let tip = robot.model.link_ref(arm.tip).name.as_str();
    let points = Snippet::block("points", [Snippet::entry(format!("{}_end", arm.name), tip)]);
    let within = Snippet::entry("points", format!("[{}_end]", arm.name));
    d.note(format!("`{}` is an arm that names none of its points", arm.name)).help(Help::with(
        &format!(
            "declare points in the robot, {{}}, and name them in the arm, {{}}: then `{group}` is the group of them"
        ),
        [points, within],
    ))
}

/// Points, segments and shapes that a value names; `None` if a name is wrong, which is reported.
pub(super) fn geometries(
    robot: &BoundRobot,
    value: &Value,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<Geometry>> {
    let mut all: Vec<Geometry> = Vec::new();
    // A part that is named twice, or that is in several groups, counts once.
    let (mut said, mut known) = (BTreeSet::new(), BTreeSet::new());
    let mut good = true;
    for item in value.items() {
        let Some(path) = path_of(item) else {
            let d =
                Diagnostic::error("HQ0304", item.span, "the name of a point, segment, group or link is needed here");
            diagnostics.push(match &item.kind {
                ValueKind::Field(inner, _) | ValueKind::In(inner, _) if frame_of(inner).is_some() => d.help(format!(
                    "name the part itself, `{}`; how far two positions are apart is `norm(a - b)`",
                    frame_of(inner).unwrap_or_default()
                )),
                ValueKind::Call(..) if frame_of(item).is_some() => {
                    d.help(format!("name the part itself, `{}`", frame_of(item).unwrap_or_default()))
                }
                _ => d.help("write its name alone; how far two positions are apart is `norm(a - b)`"),
            });
            good = false;
            continue;
        };
        if robot.failed.contains(&path) {
            good = false;
            continue;
        }
        if !said.insert(path.clone()) {
            continue;
        }
        let names = robot.groups.get(&path).cloned().unwrap_or_else(|| vec![path]);
        for name in names {
            if !known.insert(name.clone()) {
                continue;
            }
            if let Some(g) = robot.geometries.iter().find(|g| g.name == name) {
                all.push(g.clone());
            } else if let Some(link) = robot.model.link(&name) {
                let shapes = &robot.model.link_ref(link).collision;
                if shapes.is_empty() {
                    diagnostics.push(
                        Diagnostic::unknown_name(item.span, format!("link `{name}` has no collision shape")).help(
                            Help::with(
                                "declare a point on it in the robot: {}",
                                [Snippet::block("points", [Snippet::entry(format!("{name}_point"), name.as_str())])],
                            ),
                        ),
                    );
                    good = false;
                }
                all.extend(shapes.iter().enumerate().map(|(i, s)| Geometry {
                    name: if shapes.len() == 1 { name.clone() } else { format!("{name}[{i}]") },
                    link,
                    origin: s.origin,
                    shape: s.shape.clone(),
                }));
            } else {
                let d = unknown_geometry(&robot.model, &robot.geometries, &robot.groups, &name, item.span);
                diagnostics.push(match robot.arms.iter().find(|arm| name.trim_start_matches("arms.") == arm.name) {
                    Some(arm) => of_arm(robot, arm, d),
                    None => d,
                });
                good = false;
            }
        }
    }
    good.then_some(all)
}
