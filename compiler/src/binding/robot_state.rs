//! The robot's current state, bound to links, joints and parts: the leaves of expressions of the state.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use nalgebra::Vector3;
use robot::{Data, LinkId, Model};
use runtime::program::Op;
use stdlib_tasks::bound::Geometry;
use stdlib_tasks::dimension::{LENGTH, NONE};
use stdlib_tasks::expression::{Leaf, Plane, PlaneDistance};
use stdlib_tasks::task::TaskKind;

use super::parts;
use super::scope::TaskScope;
use crate::diagnostics::examples;
use crate::diagnostics::refused::{Refused, refuse};
use crate::expr::constants::joint_dimension;
use crate::expr::{self, Axes, Frame, Graph, Kind, Meaning, RobotStateTerm, Typed, field_symbol};
use crate::forms::{target, text_of, written};
use crate::robot_binding::{unknown_joint, unknown_link};

/// Maximum number of pairs of parts in one `distance(a, b)`.
const MAX_PAIRS: usize = 64;

/// Axes of a link; the world's if the link is fixed and aligned with the world.
pub(super) fn axes_of(model: &Model, link: LinkId) -> Frame {
    let still = model.support(link).is_empty();
    if still && *Data::new(model).pose(link) == nalgebra::Isometry3::identity() {
        return Frame::World;
    }
    Frame::Link(model.link_ref(link).name.clone())
}

/// Diagnostic for the robot's current state in a parameter that cannot depend on it.
pub(super) fn misplaced(kind: Option<&TaskKind>, span: Span) -> Diagnostic {
    let place = kind.map_or_else(|| "here".to_string(), |k| format!("in this parameter of `{}`", k.name));
    Diagnostic::error("HQ0312", span, format!("the robot's state cannot be used {place}"))
        .note("its row would not include the effect of the robot's own motion on this value")
        .help("write the task as an expression, with `track` or `keep`; or `initial(..)` around it for its value at the moment the stack becomes active")
}

/// Diagnostic for a `distance` between poses.
fn of_poses(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0304", span, "`distance` is between parts of the robot, and this is a pose")
        .help("the distance between two positions is `norm(a.position - b.position)`")
}

/// Diagnostic for a `distance` between `sides` of which one is a place.
fn of_places(place: &Value, sides: [&Value; 2]) -> Diagnostic {
    let text = "`distance` is between parts of the robot, and this is a place";
    let d = Diagnostic::error("HQ0304", place.span, text);
    if let ValueKind::Call(_, args) = &place.kind {
        let link = args.first().and_then(text_of).unwrap_or("LINK");
        let point = Snippet::block("points", [Snippet::entry(format!("{link}_point"), link)]);
        return d.help(Help::with("declare the point in the robot, and write its name: {}", [point]));
    }
    let part = sides.into_iter().filter(|side| side.span != place.span).find_map(text_of).unwrap_or("LINK");
    let name = text_of(place).unwrap_or("PLACE");
    d.help(format!(
        "from the origin of a link it is `norm(frame({part}).position - {name})`; for the shape of a part declare an \
         obstacle there, a small `sphere`, and write `keep_clear({part})`"
    ))
}

/// Diagnostic for a `distance` between `sides` of which one is an obstacle.
fn of_obstacles(obstacle: &Value, sides: [&Value; 2]) -> Diagnostic {
    let part = sides.into_iter().filter(|side| side.span != obstacle.span).find_map(text_of).unwrap_or("LINK");
    let name = text_of(obstacle).unwrap_or("OBSTACLE");
    let text = format!("`distance` is between parts of the robot, and `{name}` is an obstacle");
    Diagnostic::error("HQ0304", obstacle.span, text)
        .help(format!("keep the part clear of it: `keep_clear({part}) {{ of [{name}]  d_min 5 cm }}`"))
}

impl TaskScope<'_> {
    /// Lowers a leaf to a typed expression.
    pub(super) fn present(
        &mut self,
        graph: &mut Graph,
        what: &RobotStateTerm,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        let found = match what {
            RobotStateTerm::Frame(frame, field) => self.link(frame).and_then(|link| match field.value.as_str() {
                "position" => Ok(self.of_link(graph, Leaf::Point { link, offset: [0.0; 3].into() }, link, span)),
                "orientation" => Ok(self.of_link(graph, Leaf::Orientation(link), link, span)),
                other => Err(Some(Box::new(
                    Diagnostic::unknown_name(field.span, format!("a frame has no `{other}`"))
                        .help("it has `position`, `orientation` and `pose`"),
                ))),
            }),
            RobotStateTerm::Point(frame, offset) => self
                .link(frame)
                .map(|link| self.of_link(graph, Leaf::Point { link, offset: (*offset).into() }, link, span)),
            RobotStateTerm::Joint(joint) => self.dof(joint).map_err(Some).map(|dof| {
                let node = self.leaf(graph, Leaf::Joint(dof));
                let dimension = joint_dimension(&self.robot.model, dof);
                Some(Typed { kind: Kind::Scalar, dimension, nodes: node, bare: false, axes: Axes::default(), span })
            }),
            RobotStateTerm::Distance(a, b) => {
                if let Some(pose) = [*a, *b].into_iter().find(|v| self.is_pose(v)) {
                    diagnostics.push(of_poses(pose.span));
                    return None;
                }
                if let Some(obstacle) = [*a, *b].into_iter().find(|v| self.is_obstacle(v)) {
                    diagnostics.push(of_obstacles(obstacle, [*a, *b]));
                    return None;
                }
                if let Some(place) = [*a, *b].into_iter().find(|v| self.is_place(v)) {
                    diagnostics.push(of_places(place, [*a, *b]));
                    return None;
                }
                let found = self.between(a, b).map_err(|d| diagnostics.extend(d.map(|d| *d))).ok()?;
                if let Some((part, bodies)) = found {
                    let parts = parts::geometries(self.robot, part, diagnostics)?;
                    let nearest = self.away(graph, &parts, &bodies, span);
                    return self.check_permitted(graph, nearest.map_err(Some).map(Some), span, diagnostics);
                }
                let (a, b) =
                    (parts::geometries(self.robot, a, diagnostics), parts::geometries(self.robot, b, diagnostics));
                let (a, b) = (a?, b?);
                self.distance(graph, &a, &b, span).map_err(Some).map(Some)
            }
            RobotStateTerm::Above(part, plane) => {
                let parts = parts::geometries(self.robot, part, diagnostics)?;
                self.above(graph, &parts, plane, span).map_err(Some).map(Some)
            }
            RobotStateTerm::Manipulability(frame, part, by) => {
                self.link(frame).and_then(|link| self.manipulability(graph, link, *part, *by, span)).map(Some)
            }
            RobotStateTerm::Field(field) => self.safety_field(field, span).map(Some),
            RobotStateTerm::Com => self.center_of_mass(graph, span).map_err(Some).map(Some),
        };
        self.check_permitted(graph, found, span, diagnostics)
    }

    /// Returns the lowered leaf if the robot's current state is permitted here.
    fn check_permitted(
        &mut self,
        graph: &Graph,
        found: Result<Option<Typed>, Refused>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        self.asked = true;
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

    /// Link that a frame names; for an arm, its tip. An arm that failed to bind was reported there.
    fn link(&self, value: &Value) -> Result<LinkId, Refused> {
        let Some(name) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a link or arm is needed here");
            return refuse(d.help("write for instance `frame(left_tool).position`"));
        };
        let arm = self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
        let link = self.robot.model.link(name).or(arm);
        link.ok_or_else(|| {
            let told = self.robot.failed.contains(name);
            (!told).then(|| Box::new(unknown_link(&self.robot.model, name, value.span, &self.robot.arms)))
        })
    }

    /// Axes of a link.
    pub(super) fn axes_of(&self, link: LinkId) -> Frame {
        axes_of(&self.robot.model, link)
    }

    /// Axes that the name after `in` selects.
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

    /// True if the value is a pose and not a part of the robot.
    fn is_pose(&mut self, value: &Value) -> bool {
        match &value.kind {
            ValueKind::Call(function, _) => function.value == "pose",
            ValueKind::Field(inner, field) => field.value == "pose" && matches!(inner.kind, ValueKind::Call(..)),
            ValueKind::Name(name) => {
                let part =
                    self.robot.geometries.iter().any(|g| g.name == *name) || self.robot.groups.contains_key(name);
                !part && matches!(self.params.meaning(name), Meaning::Value(v) if v.value.kind == Kind::Pose)
            }
            _ => false,
        }
    }

    /// Checks whether a value is the name of an obstacle, and of no part of the robot.
    fn is_obstacle(&mut self, value: &Value) -> bool {
        text_of(value).is_some_and(|name| !self.is_part(name) && matches!(self.params.meaning(name), Meaning::Obstacle))
    }

    /// Checks whether a name is that of a part of the robot.
    fn is_part(&self, name: &str) -> bool {
        self.robot.geometries.iter().any(|g| g.name == *name)
            || self.robot.groups.contains_key(name)
            || self.robot.model.link(name).is_some()
    }

    /// Checks whether a value is a position in the world, and no part of the robot.
    fn is_place(&mut self, value: &Value) -> bool {
        match &value.kind {
            ValueKind::Unit(inner, _) => matches!(inner.kind, ValueKind::List(_)),
            ValueKind::List(items) => {
                items.iter().all(|i| matches!(i.kind, ValueKind::Number(_) | ValueKind::Unit(..)))
            }
            ValueKind::Call(function, _) => function.value == "point",
            ValueKind::Name(name) => {
                !self.is_part(name)
                    && matches!(self.params.meaning(name), Meaning::Value(v) if v.value.kind == Kind::Vector)
            }
            _ => false,
        }
    }

    fn dof(&self, value: &Value) -> Result<usize, Box<Diagnostic>> {
        let Some(name) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a joint is needed here");
            return Err(Box::new(d.help("write `joint(NAME)`")));
        };
        let model = &self.robot.model;
        if let Some(base) = model.bases.iter().find(|base| base.has_number(model, name)) {
            let text = format!("`{name}` belongs to a base, which has no joint position");
            let (d, link) = (Diagnostic::unknown_name(value.span, text), base.link_name(model));
            let help = format!("write `frame({link}).position` or `frame({link}).orientation`");
            return Err(Box::new(d.help(help)));
        }
        model
            .dof(name)
            .ok_or_else(|| Box::new(unknown_joint(model, name, value.span, &[], &self.robot.joint_groups.locked)))
    }

    /// Nodes of a leaf. Each leaf is stored only once in the numbers of the state.
    pub(super) fn leaf(&mut self, graph: &mut Graph, leaf: Leaf) -> Vec<usize> {
        let (width, reads) = (leaf.width(), leaf.reads().as_flattened().to_vec());
        let at = self.table.leaf(leaf);
        (at..at + width)
            .map(|k| match reads.is_empty() {
                true => graph.push(Op::State(k)),
                false => graph.reading_state(k, reads.clone()),
            })
            .collect()
    }

    /// Position or orientation of a link; constant if the link does not move.
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

    /// Smallest distance between the parts of two sides.
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
        let leaves = pairs.into_iter().map(|p| Leaf::Distance(Box::new(p))).collect();
        self.smallest(graph, leaves, "`self_collision`, which has a row for each pair", span)
    }

    /// Height of the lowest of some parts above a plane.
    fn above(
        &mut self,
        graph: &mut Graph,
        parts: &[Geometry],
        plane: &expr::Plane,
        span: Span,
    ) -> Result<Typed, Box<Diagnostic>> {
        let model = &self.robot.model;
        let link = match &plane.axes {
            Frame::Link(name) => model.link(name),
            Frame::Any | Frame::World => None,
        };
        let normal = Vector3::from(plane.normal);
        let offset = normal.dot(&Vector3::from(plane.point));
        if !offset.is_finite() {
            let d = Diagnostic::error("HQ0309", plane.span, "this plane is too far away for double precision");
            return Err(Box::new(d.help("check for a factor that is far too large")));
        }
        let moves = |part: &&Geometry| match link {
            Some(link) => model.moves_between(part.link, link),
            None => !model.support(part.link).is_empty(),
        };
        let above = |part: &Geometry| PlaneDistance { part: part.clone(), plane: Plane { link, normal, offset } };
        let leaves: Vec<Leaf> =
            parts.iter().filter(moves).map(|part| Leaf::PlaneDistance(Box::new(above(part)))).collect();
        if leaves.is_empty() {
            let d = Diagnostic::error("HQ0313", span, "these parts cannot move against this plane");
            return Err(Box::new(d.help("name parts of links that move, or a plane that another link carries")));
        }
        self.smallest(graph, leaves, "`virtual_wall`, which has a row for each part", span)
    }

    /// Smallest of some distances.
    pub(super) fn smallest(
        &mut self,
        graph: &mut Graph,
        leaves: Vec<Leaf>,
        instead: &str,
        span: Span,
    ) -> Result<Typed, Box<Diagnostic>> {
        if leaves.len() > MAX_PAIRS {
            let text = format!("this is the smallest of {} distances, and {MAX_PAIRS} are the most", leaves.len());
            let d = Diagnostic::error("HQ0313", span, text);
            return Err(Box::new(d.help(format!("name fewer parts, or use {instead}"))));
        }
        let nodes: Vec<usize> = leaves.into_iter().flat_map(|leaf| self.leaf(graph, leaf)).collect();
        let smallest = nodes.into_iter().reduce(|x, y| graph.push(Op::Min(x, y)));
        let nodes = smallest.into_iter().collect();
        Ok(Typed { kind: Kind::Scalar, dimension: LENGTH, nodes, bare: false, axes: Axes::default(), span })
    }

    /// Value of a safety field. A field that failed to bind was reported there.
    fn safety_field(&mut self, field: &Value, span: Span) -> Result<Typed, Refused> {
        let ValueKind::Name(name) = &field.kind else {
            let d = Diagnostic::error("HQ0304", field.span, "the name of a safety field is needed here");
            return Err(Some(Box::new(
                d.help(Help::with("write `field(NAME)`, and declare {}", [examples::safety_field("NAME", "HUMAN")])),
            )));
        };
        let said = written(name);
        match self.params.meaning(name) {
            Meaning::Failed => Err(None),
            Meaning::Field => match self.params.meaning(&field_symbol(target(name))) {
                Meaning::Value(symbol) => Ok(Typed { span, ..symbol.value }),
                _ => Err(None),
            },
            Meaning::Human(_) => {
                let d = Diagnostic::error("HQ0304", field.span, format!("`{said}` is a person, and no safety field"));
                Err(Some(Box::new(
                    d.help(Help::with("declare one: {}, and name that", [examples::safety_field("NAME", said)])),
                )))
            }
            _ => {
                let d = Diagnostic::undeclared("safety field", said, field.span);
                let known = || self.params.fields.iter().map(String::as_str).filter(|n| !n.contains('.'));
                Err(Some(Box::new(
                    d.help(Help::with("declare it: {}", [examples::safety_field(said, "HUMAN")])).one_of(
                        "declared are",
                        said,
                        known(),
                    ),
                )))
            }
        }
    }

    /// Centre of mass; constant if no link with a mass moves.
    fn center_of_mass(&mut self, graph: &mut Graph, span: Span) -> Result<Typed, Box<Diagnostic>> {
        let model = &self.robot.model;
        if model.links.iter().all(|l| l.mass == 0.0) {
            let text =
                format!("the URDF of `{}` gives no link a mass, and there is no centre of mass", self.robot.name.value);
            let d = Diagnostic::error("HQ0406", span, text);
            return Err(Box::new(d.help("write `<inertial> <origin xyz=\"0 0 0\"/> <mass value=\"1\"/> .. </inertial>` into its links, the mass in kg")));
        }
        let moves = |i: usize| !model.support(LinkId(i as u32)).is_empty();
        let moves = model.links.iter().enumerate().any(|(i, l)| l.mass > 0.0 && moves(i));
        let nodes = if moves {
            self.leaf(graph, Leaf::Com)
        } else {
            let position = stdlib_tasks::expression::center_of_mass(model, &Data::new(model));
            position.iter().map(|&x| graph.number(x)).collect()
        };
        Ok(Typed { kind: Kind::Vector, dimension: LENGTH, nodes, bare: false, axes: Axes::point(Frame::World), span })
    }
}
