//! What the robot does now, bound to its links, joints and parts: the leaves of expressions of the state.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use robot::{Data, LinkId, Model};
use runtime::program::Op;
use stdlib_tasks::bound::Geometry;
use stdlib_tasks::dimension::{LENGTH, NONE};
use stdlib_tasks::expression::Leaf;
use stdlib_tasks::task::TaskKind;

use super::parts;
use super::scope::TaskScope;
use crate::constants::joint_dimension;
use crate::expr::{Axes, Frame, Graph, Kind, Now, Typed};
use crate::forms::text_of;
use crate::robot_binding::{unknown_joint, unknown_link};

/// Most pairs of parts whose smallest distance `distance(a, b)` gives.
const MAX_PAIRS: usize = 64;

/// The axes of a link: the world's where the two are the same for good.
pub(super) fn axes_of(model: &Model, link: LinkId) -> Frame {
    let still = model.support(link).is_empty();
    if still && *Data::new(model).pose(link) == nalgebra::Isometry3::identity() {
        return Frame::World;
    }
    Frame::Link(model.link_ref(link).name.clone())
}

/// The diagnostic for what the robot does now in a parameter that cannot follow it.
pub(super) fn misplaced(kind: Option<&TaskKind>, span: Span) -> Diagnostic {
    let place = kind.map_or_else(|| "here".to_string(), |k| format!("in this parameter of `{}`", k.name));
    Diagnostic::error("HQ0312", span, format!("what the robot does now cannot stand {place}"))
        .note("its row would lack the part by which this value follows the robot's own motion")
        .help("write the task as an expression, with `track` or `keep`; or `initial(..)` around it for its value at the moment the stack becomes active")
}

impl TaskScope<'_> {
    /// A leaf as a typed expression.
    pub(super) fn present(
        &mut self,
        graph: &mut Graph,
        what: &Now,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        let found = match what {
            Now::Frame(frame, field) => self.link(frame).and_then(|link| match field.value.as_str() {
                "position" => Ok(self.of_link(graph, Leaf::Point { link, offset: [0.0; 3].into() }, link, span)),
                "orientation" => Ok(self.of_link(graph, Leaf::Orientation(link), link, span)),
                other => Err(Some(Box::new(
                    Diagnostic::error("HQ0201", field.span, format!("a frame has no `{other}`"))
                        .help("it has `position` and `orientation`"),
                ))),
            }),
            Now::Point(frame, offset) => self
                .link(frame)
                .map(|link| self.of_link(graph, Leaf::Point { link, offset: (*offset).into() }, link, span)),
            Now::Joint(joint) => self.dof(joint).map_err(Some).map(|dof| {
                let node = self.leaf(graph, Leaf::Joint(dof));
                let dimension = joint_dimension(&self.robot.model, dof);
                Some(Typed { kind: Kind::Scalar, dimension, nodes: node, bare: false, axes: Axes::default(), span })
            }),
            Now::Distance(a, b) => {
                let (a, b) =
                    (parts::geometries(self.robot, a, diagnostics), parts::geometries(self.robot, b, diagnostics));
                let (a, b) = (a?, b?);
                self.distance(graph, &a, &b, span).map_err(Some).map(Some)
            }
        };
        let typed = match found {
            Ok(typed) => typed?,
            Err(d) => {
                diagnostics.extend(d.map(|d| *d));
                return None;
            }
        };
        if !self.state && typed.nodes.iter().any(|&n| graph.is_state(n)) {
            diagnostics.push(misplaced(self.owner.map(|o| o.kind), span));
            return None;
        }
        Some(typed)
    }

    /// A frame: a link, or an arm for its tip. An arm that failed to be bound was reported there.
    fn link(&self, value: &Value) -> Result<LinkId, Option<Box<Diagnostic>>> {
        let Some(name) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a link or arm is needed here");
            return Err(Some(Box::new(d.help("write for instance `frame(left_tool).position`"))));
        };
        let arm = self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
        let link = self.robot.model.link(name).or(arm);
        link.ok_or_else(|| {
            let told = self.robot.failed.contains(name);
            (!told).then(|| Box::new(unknown_link(&self.robot.model, name, value.span, &self.robot.arms)))
        })
    }

    /// The axes of a link.
    pub(super) fn axes_of(&self, link: LinkId) -> Frame {
        axes_of(&self.robot.model, link)
    }

    /// The axes that a name behind `in` means.
    pub(super) fn axes_named(&self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        let value = Value { kind: ValueKind::Name(name.value.clone()), span: name.span };
        match self.link(&value) {
            _ if name.value == "world" => Some(Frame::World),
            Ok(link) => Some(self.axes_of(link)),
            Err(d) => {
                diagnostics.extend(d.map(|d| *d));
                None
            }
        }
    }

    fn dof(&self, value: &Value) -> Result<usize, Box<Diagnostic>> {
        let Some(name) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a joint is needed here");
            return Err(Box::new(d.help("write `joint(NAME)`")));
        };
        let model = &self.robot.model;
        let dof = model.dof(name).filter(|&d| model.dofs[d].q_index.is_some());
        dof.ok_or_else(|| Box::new(unknown_joint(model, name, value.span, &[], &self.robot.joint_groups.locked)))
    }

    /// The nodes of a leaf; each leaf has its place among the state's numbers once.
    fn leaf(&mut self, graph: &mut Graph, leaf: Leaf) -> Vec<usize> {
        let width = leaf.width();
        let at = self.table.leaf(leaf);
        (at..at + width).map(|k| graph.push(Op::State(k))).collect()
    }

    /// What belongs to a link: constant where the link does not move.
    fn of_link(&mut self, graph: &mut Graph, leaf: Leaf, link: LinkId, span: Span) -> Option<Typed> {
        let (kind, dimension) = match leaf {
            Leaf::Orientation(_) => (Kind::Rotation, NONE),
            _ => (Kind::Vector, LENGTH),
        };
        let model = &self.robot.model;
        let nodes = if model.support(link).is_empty() {
            let data = Data::new(model);
            let pose = data.pose(link);
            let q = pose.rotation;
            let numbers = match leaf {
                Leaf::Point { offset, .. } => (pose * nalgebra::Point3::from(offset)).iter().copied().collect(),
                _ => vec![q.w, q.i, q.j, q.k],
            };
            numbers.into_iter().map(|x| graph.number(x)).collect()
        } else {
            self.leaf(graph, leaf)
        };
        let axes = match kind {
            Kind::Rotation => Axes::orientation(self.axes_of(link), Frame::World),
            _ => Axes::point(Frame::World),
        };
        Some(Typed { kind, dimension, nodes, bare: false, axes, span })
    }

    /// The smallest distance between the parts of two sides.
    fn distance(
        &mut self,
        graph: &mut Graph,
        a: &[Geometry],
        b: &[Geometry],
        span: Span,
    ) -> Result<Typed, Box<Diagnostic>> {
        let model = &self.robot.model;
        let pairs: Vec<(Geometry, Geometry)> = a
            .iter()
            .flat_map(|x| b.iter().map(move |y| (x.clone(), y.clone())))
            .filter(|(x, y)| model.moves_between(x.link, y.link))
            .collect();
        if pairs.is_empty() {
            let d = Diagnostic::error("HQ0313", span, "these parts cannot move against each other");
            return Err(Box::new(d.help("name parts of other links on one side")));
        }
        if pairs.len() > MAX_PAIRS {
            let text = format!("this is the smallest of {} distances, and {MAX_PAIRS} are the most", pairs.len());
            let d = Diagnostic::error("HQ0313", span, text);
            return Err(Box::new(d.help("name fewer parts, or use `self_collision`, which has a row for each pair")));
        }
        let nodes: Vec<usize> = pairs.into_iter().flat_map(|p| self.leaf(graph, Leaf::Distance(Box::new(p)))).collect();
        let smallest = nodes.into_iter().reduce(|x, y| graph.push(Op::Min(x, y)));
        let nodes = smallest.into_iter().collect();
        Ok(Typed { kind: Kind::Scalar, dimension: LENGTH, nodes, bare: false, axes: Axes::default(), span })
    }
}
