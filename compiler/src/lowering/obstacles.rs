//! Obstacles: their pose as expressions of time and signals, and their true places in scenarios.

use dsl::tree::{Block, BlockKind, NamedBlock, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet};
use robot::LinkId;
use runtime::program::{Op, Program, TrueObstacle};
use stdlib_tasks::bound::{Obstacle, Slot};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE};

use super::Lowerer;
use crate::expand::{Expanded, Named};
use crate::expr::constants::{Constants, is_word};
use crate::expr::{Frame, Kind, Typed, frames};
use crate::forms::{block_of, text_of};
use crate::robot_binding::{BoundRobot, unknown_link};
use crate::sections::{ObstacleBlock, TrueObstacleBlock};

impl Lowerer<'_> {
    /// Declares the name of an obstacle.
    pub(super) fn declare_obstacle(&mut self, b: &NamedBlock) {
        let name = &b.name;
        if is_word(&name.value) {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{}` is a word of the language", name.value));
            self.push(d.help("choose another name"));
            self.params.failed.insert(name.value.clone());
            return;
        }
        self.params.obstacles.insert(name.value.clone());
    }

    /// Binds all obstacles.
    pub(super) fn bind_obstacles(&mut self, expanded: &Expanded, robot: Option<&BoundRobot>) {
        for b in expanded.values.iter().filter_map(|v| match v {
            Named::Block(b) if b.kind == BlockKind::Obstacle => Some(b),
            _ => None,
        }) {
            if !self.params.obstacles.contains(&b.name.value) {
                continue;
            }
            let before = self.errors();
            match self.obstacle(b, robot).filter(|_| self.errors() == before) {
                Some(obstacle) => self.obstacles.push(obstacle),
                None => {
                    self.params.failed.insert(b.name.value.clone());
                }
            }
        }
    }

    fn obstacle(&mut self, b: &NamedBlock, robot: Option<&BoundRobot>) -> Option<Obstacle> {
        let block: ObstacleBlock = self.read(&b.body, b.name.span);
        let form = self.form(b, &block);
        let link = match b.body.get("on") {
            None => Some(None),
            Some(entry) => self.carrier(&entry.value, robot?).map(Some),
        };
        let pose = self.pose(b, link.flatten());
        let (position, orientation, present) = pose?;
        Some(Obstacle { name: b.name.value.clone(), form: form?, link: link?, position, orientation, present })
    }

    /// The link that carries an obstacle.
    fn carrier(&mut self, value: &Value, robot: &BoundRobot) -> Option<LinkId> {
        let Some(name) = text_of(value) else {
            self.push(Diagnostic::error("HQ0304", value.span, "the name of a link or arm is needed here"));
            return None;
        };
        let arm = robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
        let found = robot.model.link(name).or(arm);
        if found.is_none() && !robot.failed.contains(name) {
            self.push(unknown_link(&robot.model, name, value.span, &robot.arms));
        }
        found
    }

    /// Places of position, orientation and presence in the table of values.
    fn pose(&mut self, b: &NamedBlock, link: Option<LinkId>) -> Option<(Slot, Slot, Option<Slot>)> {
        let present = match b.body.get("present") {
            None => Some(None),
            Some(entry) => self.presence(&entry.value).map(Some),
        };
        let condition = b.body.get("present").map(|e| &e.value).filter(|_| present.is_some());
        let position = self.part(b, "position", (Kind::Vector, LENGTH), condition, link);
        let orientation = self.part(b, "orientation", (Kind::Rotation, NONE), condition, link);
        Some((position?, orientation?, present?))
    }

    fn presence(&mut self, value: &Value) -> Option<Slot> {
        let typed = self.of_the_room(value)?;
        if typed.kind != Kind::Truth {
            let is = typed.kind.describe();
            let d = Diagnostic::error("HQ0304", value.span, format!("`present` is a condition, and this is {is}"));
            self.push(d.help(Help::with(
                "name a signal of the type `flag`, or write {}",
                [Snippet::entry("present", "present(SIGNAL)")],
            )));
            return None;
        }
        Some(self.table.place(&typed.nodes))
    }

    /// A part of the pose. While the obstacle is absent, its value does not count, so that a signal need not be there.
    fn part(
        &mut self,
        b: &NamedBlock,
        key: &'static str,
        (kind, dimension): (Kind, Dimension),
        condition: Option<&Value>,
        link: Option<LinkId>,
    ) -> Option<Slot> {
        let nothing: &[f64] = if kind == Kind::Vector { &[0.0; 3] } else { &[1.0, 0.0, 0.0, 0.0] };
        let Some(entry) = b.body.get(key) else {
            let nodes: Vec<usize> = nothing.iter().map(|x| self.graph.number(*x)).collect();
            return Some(self.table.place(&nodes));
        };
        let value = &entry.value;
        if matches!(value.kind, ValueKind::Missing) {
            return None;
        }
        let mut typed = self.of_the_room(value)?;
        let what = format!("`{key}` of an obstacle");
        if typed.kind != kind {
            let (is, needed) = (typed.kind.describe(), kind.describe());
            let d = Diagnostic::error("HQ0304", value.span, format!("{what} is {needed}, and this is {is}")).here(is);
            self.push(match (kind, typed.kind) {
                (Kind::Vector, Kind::Pose) => d.help("write `.position` after it"),
                (Kind::Rotation, Kind::Pose) => d.help("write `.orientation` after it"),
                (Kind::Vector, _) => d.help("write `[x, y, z] m`"),
                _ => d.help("write `rpy(roll, pitch, yaw)`, `axis_angle(vector, angle)` or `quaternion(w, x, y, z)`"),
            });
            return None;
        }
        let constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let wrong = constants.check_dimension(&typed, dimension, &what).or_else(|| {
            // The numbers of an obstacle on a link are in the axes of that link, as those of points are.
            if link.is_some() { None } else { frames::wanted(&typed, &Frame::World, &what, true) }
        });
        if let Some(d) = wrong {
            self.push(d);
            return None;
        }
        if let Some(condition) = condition.and_then(|c| self.of_the_room(c)) {
            let test = condition.nodes[0];
            for (node, x) in typed.nodes.iter_mut().zip(nothing) {
                let rest = self.graph.number(*x);
                *node = self.graph.push(Op::Select(test, *node, rest));
            }
        }
        for &node in &typed.nodes {
            if self.graph.constant(node).is_some_and(|x| !x.is_finite()) {
                let d = Diagnostic::error("HQ0309", value.span, format!("{what} is not a finite number"));
                self.push(d.help("check for a division by zero, or factors that are far too large"));
                return None;
            }
        }
        Some(self.table.place(&typed.nodes))
    }

    /// Types an expression of `time` and signals.
    fn of_the_room(&mut self, value: &Value) -> Option<Typed> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let typed = constants.moving(value, self.diagnostics)?;
        if let Some(what) = self.begins_with_a_stack(&typed) {
            let d = Diagnostic::error("HQ0583", value.span, format!("{what} cannot move an obstacle"));
            self.push(
                d.note("it begins when a stack is entered, and an obstacle belongs to no stack")
                    .help("write `time`, the time since the start of the run, or a signal"),
            );
            return None;
        }
        Some(typed)
    }

    /// True places of obstacles in a scenario.
    pub(super) fn true_obstacles(&mut self, body: &Block, program: &Program) -> Vec<TrueObstacle> {
        let names: Vec<&str> = program.obstacles.iter().map(|o| o.name.as_str()).collect();
        let mut all = Vec::new();
        for e in self.named_entries(body, "obstacles") {
            let found = self.one_of("obstacle", &e.key.value, e.key.span, &names);
            let block = block_of(&e.value, "the true place of an obstacle", self.diagnostics);
            let (Some(obstacle), Some(block)) = (found, block) else { continue };
            let TrueObstacleBlock { present, .. } = self.read(block, e.key.span);
            let mut part = |key: &str, of: (Kind, Dimension)| {
                let value = &block.get(key)?.value;
                self.constant_value(of, value, &format!("the true `{key}` of `{}`", e.key.value))
            };
            let position = part("position", (Kind::Vector, LENGTH)).and_then(|x| <[f64; 3]>::try_from(x).ok());
            let orientation = part("orientation", (Kind::Rotation, NONE)).and_then(|x| <[f64; 4]>::try_from(x).ok());
            all.push(TrueObstacle { obstacle, position, orientation, present });
        }
        all
    }

    fn begins_with_a_stack(&self, typed: &Typed) -> Option<&'static str> {
        if self.graph.moves_along(&typed.nodes) {
            return Some("a trajectory");
        }
        let (ops, _) = self.graph.extract(&typed.nodes);
        ops.iter().any(|op| matches!(op, Op::T)).then_some("`t`, the time since a stack was entered,")
    }
}
