//! Binds the parameters of tasks to numbers, indices and places in the table of values.

mod along;
mod axes;
mod capture;
mod condition;
mod expression;
pub(crate) mod gain;
mod manipulability;
pub(crate) mod motion;
mod pairs;
mod partition;
mod parts;
mod people;
mod per;
mod postures;
mod protects;
mod robot_state;
mod scope;
pub(crate) mod settled;
mod start;
mod table;
mod value;

use std::collections::BTreeMap;

use dsl::tree::{Block, Entry, Let, TaskDefinition, Value, ValueKind};
use dsl::{Diagnostic, Fix, Help, Snippet, Span, Spanned, Syntax};
use names::{list, suggest};
use robot::LinkId;
use stdlib_tasks::bound::{Bound, BoundParams, Obstacle, Slot};
use stdlib_tasks::dimension::{Dimension, NONE, RATE};
use stdlib_tasks::params::{ParamInfo, ParamType, Presence};
use stdlib_tasks::task::TaskKind;
use stdlib_tasks::turns;

use crate::expr::constants::Params;
use crate::expr::{Axes, Frame, Graph, Kind, Lowering, Typed};
use crate::forms::{block_of, text_of, unknown_keys};
use crate::robot_binding::{BoundRobot, joints};

pub(crate) use condition::Condition;
pub(crate) use partition::whole;
use robot_state::axes_of;
pub(crate) use scope::{Known, TaskScope};
pub use table::Table;

/// State of the binding.
pub struct Binder<'a> {
    /// The robot.
    pub robot: &'a BoundRobot,
    /// All tasks with their names, for parameters that name another task.
    pub tasks: &'a [(String, TaskDefinition)],
    /// The names of safety fields, in the order of the program.
    pub fields: Vec<String>,
    /// Obstacles.
    pub obstacles: &'a [Obstacle],
    /// Declared parameters.
    pub params: &'a mut Params,
    /// The graph of the program.
    pub graph: &'a mut Graph,
    /// The table of values.
    pub table: &'a mut Table,
    /// Texts, for defaults.
    pub sources: &'a mut dsl::Sources,
    /// Parsed defaults, by their text.
    pub defaults: BTreeMap<&'static str, Value>,
    /// Numbers of the current task.
    pub numbers: Vec<Number>,
    /// Kind and dimension of the current task's parameters that determine the type of other ones.
    pub forms: BTreeMap<&'static str, (Kind, Dimension)>,
    /// Axes of the task's own values, by the name of the parameter for which they are the actual value.
    pub axes: BTreeMap<&'static str, Axes>,
    /// The same axes for tasks that were bound before, by the task's index.
    pub bound_axes: BTreeMap<usize, BTreeMap<&'static str, Axes>>,
    /// Axes of the parameter of another task that the current `deviate` block describes.
    pub deviating: Frame,
    /// Axes of the link that carries the task's plane, from its parameter `on`; the world's without one.
    pub plane: Frame,
    /// Typed values of the task's parameters that are expressions.
    pub operands: BTreeMap<&'static str, Typed>,
    /// Receives the diagnostics.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

/// A bound task, with the source spans of its parameters.
pub struct BoundTask {
    /// The task type.
    pub kind: &'static TaskKind,
    /// Parameters.
    pub params: BoundParams,
    /// Source span of each parameter, by its path. Parameters with a default value are absent.
    pub spans: BTreeMap<String, Span>,
    /// All numbers among the parameters, including those in groups.
    pub numbers: Vec<Number>,
    /// Typed values of expressions and of the values that they are compared with, by parameter.
    pub operands: BTreeMap<&'static str, Typed>,
    /// Span of the type's name in the spec.
    pub span: Span,
}

/// A number of a task: its place in the table of values, and its source span.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// Place in the table.
    pub slot: Slot,
    /// Dimension.
    pub dimension: Dimension,
    /// Source span; for a default, inside the default's own text.
    pub span: Span,
    /// False for a default.
    pub written: bool,
}

/// Factor from the unit of a joint's position to that of its acceleration.
const PER_SQUARE_SECOND: Dimension = Dimension { s: -2, ..NONE };

/// Name of the sources that hold the texts of defaults.
const DEFAULTS: &str = "a default of the task library";

/// The parameter that is bound now, and the task that it belongs to.
#[derive(Clone, Copy)]
struct Owner<'p> {
    /// The task type.
    kind: &'static TaskKind,
    /// Index of the task in the program.
    task: usize,
    /// Prefix of the groups that contain the parameter, for example `left.`.
    prefix: &'p str,
    /// Name of the parameter.
    param: &'static str,
    /// Joints of the task, if it has a parameter `joints`.
    joints: Option<&'p [usize]>,
    /// Index of the other task that the parameter `task` names.
    other: Option<usize>,
    /// True if errors of angles on the circle are taken to the nearest turn.
    nearest: bool,
    /// True if the value is an angle on the circle, whose error is taken so.
    turns: bool,
}

impl<'p> Owner<'p> {
    fn new(kind: &'static TaskKind, task: usize) -> Owner<'p> {
        Owner { kind, task, prefix: "", param: "", joints: None, other: None, nearest: true, turns: false }
    }

    /// Returns true if the task takes errors of angles on the circle to the nearest turn.
    fn takes_turns(&self) -> bool {
        self.nearest && self.kind.params.iter().any(|p| p.name == "turns")
    }
}

impl Binder<'_> {
    /// Types a named expression of the robot's state, for use in all tasks.
    pub fn named(&mut self, it: &Let) {
        let value = self.present(&it.value);
        self.params.put(&it.name, value);
    }

    /// Types an expression of the robot's state that belongs to no task. Returns `None` if it has no type, with
    /// diagnostics.
    fn present(&mut self, value: &Value) -> Option<Typed> {
        let mut scope =
            TaskScope::free(self.robot, self.params, self.table, Known { forms: &self.forms, axes: &self.axes });
        Lowering { graph: self.graph, scope: &mut scope, diagnostics: self.diagnostics }.value(value).ok()
    }

    /// Binds a task whose type is in the library. Returns `None` if a parameter is wrong, with diagnostics.
    pub fn task(&mut self, definition: &TaskDefinition, index: usize) -> Option<BoundTask> {
        let kind = stdlib_tasks::find(&definition.kind.value)?;
        self.numbers.clear();
        self.forms.clear();
        self.axes.clear();
        self.operands.clear();
        self.plane = self.carrier(kind, &definition.body);
        let mut body = definition.body.clone();
        self.positional(kind, definition, &mut body);
        let mut spans = BTreeMap::new();
        note_spans(&body, "", &mut spans);
        let what = format!("task type `{}`", kind.name);
        let word = body.get("turns").and_then(|e| text_of(&e.value)).map(str::to_string);
        let params = self.group(
            Owner { nearest: word.as_deref() != Some(turns::EXACT), ..Owner::new(kind, index) },
            kind.params,
            &body,
            &what,
            definition.kind.span,
        )?;
        let numbers = std::mem::take(&mut self.numbers);
        let operands = std::mem::take(&mut self.operands);
        self.bound_axes.insert(index, self.axes.clone());
        Some(BoundTask { kind, params, spans, numbers, operands, span: definition.kind.span })
    }

    /// Axes in which the constant vectors of a task are expressed: those of its parameter `on`, or the world's.
    fn carrier(&self, kind: &'static TaskKind, body: &Block) -> Frame {
        let on = kind.params.iter().any(|p| p.name == "on" && p.ty == ParamType::Frame);
        let link = body.get("on").filter(|_| on).and_then(|e| text_of(&e.value));
        let arm = |name: &str| self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
        match link.and_then(|name| self.robot.model.link(name).or_else(|| arm(name))) {
            Some(link) => axes_of(&self.robot.model, link),
            None => Frame::World,
        }
    }

    /// Converts arguments in parentheses to entries.
    fn positional(&mut self, kind: &'static TaskKind, definition: &TaskDefinition, body: &mut Block) {
        let names = kind.positional;
        if names.is_empty() && !definition.args.is_empty() {
            self.diagnostics.push(
                Diagnostic::error(
                    "HQ0310",
                    definition.args[0].span,
                    format!("`{}` takes nothing in parentheses", kind.name),
                )
                .help(Help::each(
                    "write its parameters in braces",
                    "write its parameters as a mapping, `{ name: value }`",
                )),
            );
            return;
        }
        let takes_list = |name: &str| {
            let info = kind.params.iter().find(|p| p.name == name);
            matches!(
                info.map(|p| p.ty),
                Some(ParamType::Frames | ParamType::Geometries | ParamType::Joints | ParamType::Obstacles)
            )
        };
        for (i, name) in names.iter().enumerate() {
            let Some(first) = definition.args.get(i) else { break };
            let value = if i + 1 == names.len() && takes_list(name) {
                let span = first.span.to(definition.args[definition.args.len() - 1].span);
                let all = definition.args[i..].iter().flat_map(Value::items).cloned().collect();
                Value { kind: ValueKind::List(all), span }
            } else {
                first.clone()
            };
            if let Some(other) = body.get(name) {
                self.diagnostics.push(
                    Diagnostic::error("HQ0207", first.span, format!("`{name}` is given in parentheses and in braces"))
                        .label(other.key.span, "here too")
                        .help("keep one of the two"),
                );
                continue;
            }
            let key = Spanned::new((*name).to_string(), first.span);
            body.entries.push(Entry { key, value, comments: dsl::tree::Comments::default() });
        }
        let last_takes_all = names.last().is_some_and(|n| takes_list(n));
        if definition.args.len() > names.len() && !last_takes_all {
            let extra = &definition.args[names.len()];
            let text = format!("`{}` takes only {} in parentheses", kind.name, list(names.iter().copied(), 4));
            self.diagnostics.push(Diagnostic::error("HQ0310", extra.span, text).help(Help::each(
                "write the other parameters in braces",
                "write the other parameters as a mapping, `{ name: value }`",
            )));
        }
    }

    fn group(
        &mut self,
        owner: Owner,
        infos: &'static [ParamInfo],
        body: &Block,
        what: &str,
        at: Span,
    ) -> Option<BoundParams> {
        let keys: Vec<&str> = infos.iter().map(|p| p.name).collect();
        let misspelt = unknown_keys(body, &keys, what, self.diagnostics);
        let mut good = !misspelt;
        let mut missing: Vec<(&ParamInfo, Option<String>)> = Vec::new();
        let mut bound = BoundParams::new();
        for info in infos {
            let written = body.get(info.name);
            let default = match (written, info.presence) {
                (None, Presence::Default(text)) => Some(self.default(info, text)),
                (None, Presence::Optional) => continue,
                (None, Presence::Required) => {
                    missing.push((info, None));
                    continue;
                }
                (Some(_), _) => None,
            };
            let Some(value) = written.map(|e| &e.value).or(default.as_ref()) else { continue };
            if matches!(value.kind, ValueKind::Missing) {
                good = false;
                continue;
            }
            let before = self.diagnostics.len();
            let joints = match bound.get("joints") {
                Some(Bound::Joints(joints)) => Some(joints.clone()),
                _ => None,
            };
            let other = match bound.get("task") {
                Some(Bound::Task(task)) => Some(*task),
                _ => owner.other,
            };
            if owner.prefix.is_empty() {
                self.own_axes(owner.kind, &bound);
            }
            let turns = match bound.get("value") {
                Some(Bound::Expression(e)) => owner.takes_turns() && e.turning(&self.robot.model).is_angle_on_circle(),
                _ => owner.turns,
            };
            match self.one(Owner { param: info.name, joints: joints.as_deref(), other, turns, ..owner }, info, value) {
                Some(b) => {
                    bound.insert(info.name.to_string(), b);
                }
                None if default.is_some() => {
                    // The default does not fit this robot, so the user has to write a value.
                    let why = self.diagnostics.drain(before..).next().map(|d| d.message);
                    missing.extend(why.map(|why| (info, Some(why))));
                    good = false;
                }
                None => good = false,
            }
        }
        for info in infos {
            if let ParamType::Pairs(unless) = info.ty
                && good
                && body.get(unless).is_none()
            {
                let pairs = pairs::unnamed(self.robot, bound.get(info.name), &bound);
                bound.insert(info.name.to_string(), Bound::Pairs(pairs));
            }
        }
        if !missing.is_empty() {
            good = false;
            // A misspelt key already explains the missing one.
            if !misspelt {
                let d = lacking(&missing, what, at);
                let neutral = neutral_values(owner, &missing);
                self.diagnostics.push(match neutral {
                    Some(entries) => d.fix(Fix::entries(at, entries)),
                    None => d,
                });
            }
        }
        good.then_some(bound)
    }

    fn one(&mut self, owner: Owner, info: &'static ParamInfo, value: &Value) -> Option<Bound> {
        let what = format!("`{}`", info.name);
        match info.ty {
            ParamType::Scalar(q) => {
                self.value(owner, value, (Kind::Scalar, q.dimension), Some(q), &what).map(Bound::Value)
            }
            ParamType::AutoScalar(q) => {
                let known = matches!(&value.kind, ValueKind::Name(n) if self.params.knows(n));
                match text_of(value) {
                    Some("auto") => return Some(Bound::Choice("auto".to_string())),
                    Some(name) if !known && !["t", "time", "pi"].contains(&name) => {
                        return self.wrong(value, info, &format!("{} or `auto`", q.dimension.describe()));
                    }
                    _ => {}
                }
                self.value(owner, value, (Kind::Scalar, q.dimension), Some(q), &what).map(Bound::Value)
            }
            ParamType::Vector(d) => self.value(owner, value, (Kind::Vector, d), None, &what).map(Bound::Value),
            ParamType::Rotation => {
                let slot = self.value(owner, value, (Kind::Rotation, NONE), None, &what);
                slot.map(Bound::Value)
            }
            ParamType::Vectors { least, most, dimension } => self.vectors(owner, value, least..=most, dimension, info),
            ParamType::PerAxis(q) => self.per_axis(owner, value, q, &what).map(Bound::Value),
            ParamType::Gains(names) => self.gains(owner, value, names, info),
            ParamType::Frame => self.frame(value, info).map(|(n, l)| Bound::Frame(n, l)),
            ParamType::Frames => {
                let frames: Vec<Option<(String, LinkId)>> = value.items().iter().map(|v| self.frame(v, info)).collect();
                frames.into_iter().collect::<Option<Vec<_>>>().map(Bound::Frames)
            }
            ParamType::Arm => self.arm(value, info).map(Bound::Arm),
            ParamType::Geometries => parts::geometries(self.robot, value, self.diagnostics).map(Bound::Geometries),
            ParamType::Pairs(_) => self.pairs(value, info).map(Bound::Pairs),
            ParamType::Expression(form) => self.expression(owner, value, form, info),
            ParamType::Task => self.task_named(owner, value, info).map(Bound::Task),
            ParamType::Field => self.field_named(value, info).map(Bound::Field),
            ParamType::Obstacles => self.obstacles_named(value, info).map(Bound::Obstacles),
            ParamType::Deviations => self.deviations(owner, value, owner.other).map(Bound::Group),
            ParamType::Joints => {
                joints(value.items(), &self.robot.model, &self.robot.joint_groups, self.diagnostics).map(Bound::Joints)
            }
            ParamType::JointPositions => self.per_joint(owner, value, info, NONE),
            ParamType::JointVelocities => self.per_joint(owner, value, info, RATE),
            ParamType::JointAccelerations => self.per_joint(owner, value, info, PER_SQUARE_SECOND),
            ParamType::PerArm(d) => self.per_arm(owner, value, info, d),
            ParamType::PerFrame(infos) => self.per_frame(owner, value, info, infos),
            ParamType::Axes => self.axes_chosen(value, info).map(Bound::Axes),
            ParamType::Choice(words) => match text_of(value) {
                Some(word) if words.contains(&word) => Some(Bound::Choice(word.to_string())),
                other => {
                    let d = Diagnostic::error(
                        "HQ0304",
                        value.span,
                        format!("{what} is one of {}", list(words.iter().copied(), 9)),
                    );
                    let near = other.and_then(|o| suggest(o, words.iter().copied()));
                    self.diagnostics.push(match near {
                        Some(near) => d.meant(near),
                        None => {
                            d.help(Help::write_for_instance(Snippet::entry(info.name, *words.first().unwrap_or(&""))))
                        }
                    });
                    None
                }
            },
            ParamType::Group(infos) => {
                let block = block_of(value, &what, self.diagnostics)?;
                let prefix = format!("{}{}.", owner.prefix, info.name);
                self.group(Owner { prefix: &prefix, ..owner }, infos, block, &what, value.span).map(Bound::Group)
            }
        }
    }

    /// Parses the text of a default. Such texts are in the task library, and a test parses all of them. The default of
    /// a group is the defaults of its members.
    fn default(&mut self, info: &ParamInfo, text: &'static str) -> Value {
        if matches!(info.ty, ParamType::Group(_)) {
            return Value { kind: ValueKind::Block(Block::default()), span: Span::default() };
        }
        if let Some(known) = self.defaults.get(text) {
            return known.clone();
        }
        let whole = format!("hierarq 1\nparam x = {text}\n");
        let source = self.sources.add(DEFAULTS, whole.clone());
        let (spec, _) = dsl::parse(source, &whole, Syntax::Native);
        let value = spec.items.into_iter().find_map(|i| match i.kind {
            dsl::tree::ItemKind::Param(p) => Some(p.value),
            _ => None,
        });
        let value = value.unwrap_or(Value { kind: ValueKind::Missing, span: Span::default() });
        self.defaults.insert(text, value.clone());
        value
    }

    fn wrong<T>(&mut self, value: &Value, info: &ParamInfo, wanted: &str) -> Option<T> {
        self.diagnostics
            .push(Diagnostic::error("HQ0304", value.span, format!("`{}` is {wanted}", info.name)).help(info.text()));
        None
    }
}

/// Notes the span of each parameter by its path, such as `feet.left_sole.points`.
fn note_spans(body: &Block, prefix: &str, spans: &mut BTreeMap<String, Span>) {
    for e in &body.entries {
        let path = format!("{prefix}{}", e.key.value);
        if let ValueKind::Block(inner) = &e.value.kind {
            note_spans(inner, &format!("{path}."), spans);
        }
        spans.entry(path).or_insert(e.value.span);
    }
}

/// Values of missing parameters of a task at which it rests: the current state, or zero velocity. `None` if one of them
/// has no such value.
fn neutral_values(owner: Owner, missing: &[(&ParamInfo, Option<String>)]) -> Option<Vec<(String, String)>> {
    let value = |info: &ParamInfo| match info.ty {
        _ if owner.kind.current_values.iter().any(|value| value.name == info.name) => {
            Some(format!("initial({})", info.name))
        }
        ParamType::JointVelocities => Some("0 rad/s".to_string()),
        _ => None,
    };
    let own = missing.iter().filter(|_| owner.prefix.is_empty());
    let values: Option<Vec<_>> = own.map(|(info, _)| Some((info.name.to_string(), value(info)?))).collect();
    values.filter(|values| !values.is_empty())
}

/// Diagnostic for missing parameters, each with the reason why its default cannot be used.
fn lacking(missing: &[(&ParamInfo, Option<String>)], what: &str, at: Span) -> Diagnostic {
    let names = list(missing.iter().map(|m| m.0.name), 8);
    // Unread text that names the owner may hold its parameters too.
    let explained = missing.iter().map(|m| m.0.name).chain(what.split('`').nth(1));
    let mut d = Diagnostic::missing_keys(explained, at, format!("{what} needs {names}"));
    for (info, why) in missing {
        if let Some(why) = why {
            d = d.note(format!("the default of `{}` does not fit: {why}", info.name));
        }
    }
    let texts: Vec<String> = missing.iter().map(|m| format!("`{}`: {}", m.0.name, m.0.text())).collect();
    d.help(texts.join("\n"))
}
