//! Task parameters: what a spec says of them, bound to numbers, indices and places in the table of values.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{Block, Entry, TaskDefinition, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned, Spelling};
use robot::LinkId;
use runtime::program::{Capture, CaptureSource, Op};
use stdlib_tasks::bound::{Arm, Bound, BoundParams, Geometry, Slot};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE, RATE};
use stdlib_tasks::params::{ParamInfo, ParamType, Presence, Quantity};
use stdlib_tasks::task::{ActualType, TaskKind};

use crate::constants::{fits, joint_dimension};
use crate::expr::{Graph, Kind, Lowering, Scope, Symbol, Typed};
use crate::names::{list, suggest};
use crate::robot_binding::{
    BoundRobot, block_of, items_of, joints, path_of, text_of, unknown_geometry, unknown_key, unknown_link,
};

/// The table of values while it is being laid out: for each place the node that gives it.
#[derive(Debug, Default)]
pub struct Table {
    /// Node of each place.
    pub nodes: Vec<usize>,
    /// Captures, in the order of their inputs.
    pub captures: Vec<Capture>,
    /// Number of captured values.
    pub inputs: usize,
    /// Ranges of places that move, for the controller to watch.
    pub ranges: Vec<(usize, f64, f64)>,
}

impl Table {
    fn place(&mut self, nodes: &[usize]) -> Slot {
        let at = self.nodes.len();
        self.nodes.extend_from_slice(nodes);
        Slot { at, len: nodes.len() }
    }

    /// Captures a value once, however often it is named; gives the first input.
    fn capture(&mut self, source: CaptureSource, len: usize) -> usize {
        if let Some(c) = self.captures.iter().find(|c| c.source == source) {
            return c.at;
        }
        let at = self.inputs;
        self.captures.push(Capture { at, len, source });
        self.inputs += len;
        at
    }
}

/// What binding needs to know.
pub struct Binder<'a> {
    /// The robot.
    pub robot: &'a BoundRobot,
    /// Declared parameters.
    pub params: &'a BTreeMap<String, Symbol>,
    /// Parameters that something used.
    pub used: &'a mut BTreeSet<String>,
    /// The graph of the program.
    pub graph: &'a mut Graph,
    /// The table of values.
    pub table: &'a mut Table,
    /// Texts, for defaults.
    pub sources: &'a mut dsl::Sources,
    /// Where mistakes go.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

/// A bound task, and where each of its parameters was written.
pub struct BoundTask {
    /// The type.
    pub kind: &'static TaskKind,
    /// Parameters.
    pub params: BoundParams,
    /// Where each was written, by name; those left to their default are absent.
    pub spans: BTreeMap<String, Span>,
    /// The type's name in the spec.
    pub span: Span,
}

/// The scope of a task's parameters: declared parameters, and what `initial(..)` can capture.
struct TaskScope<'s> {
    robot: &'s BoundRobot,
    params: &'s BTreeMap<String, Symbol>,
    used: &'s mut BTreeSet<String>,
    table: &'s mut Table,
    kind: &'static TaskKind,
    task: usize,
    prefix: &'s str,
    moving: bool,
}

impl Scope for TaskScope<'_> {
    fn name(&mut self, name: &str) -> Option<Symbol> {
        let symbol = self.params.get(name).cloned();
        if symbol.is_some() {
            self.used.insert(name.to_string());
        }
        symbol
    }

    fn names(&self) -> Vec<String> {
        self.params.keys().cloned().collect()
    }

    fn initial(&mut self, graph: &mut Graph, argument: &Value, span: Span) -> Result<Typed, Box<Diagnostic>> {
        let (source, ty) = self.source(argument, span)?;
        if !self.moving {
            return Err(Box::new(
                Diagnostic::error("HQ0307", span, "this parameter is needed before anything is captured")
                    .help("write a constant"),
            ));
        }
        let len = ty.len();
        let at = self.table.capture(source, len);
        let nodes = (at..at + len).map(|k| graph.push(Op::Input(k))).collect();
        let (kind, dimension) = match ty {
            ActualType::Scalar(d) => (Kind::Scalar, d),
            ActualType::Vector(d) => (Kind::Vector, d),
            ActualType::Rotation => (Kind::Rotation, NONE),
        };
        Ok(Typed { kind, dimension, nodes, bare: false, span })
    }
}

impl TaskScope<'_> {
    fn source(&self, argument: &Value, span: Span) -> Result<(CaptureSource, ActualType), Box<Diagnostic>> {
        let model = &self.robot.model;
        if let ValueKind::Field(inner, field) = &argument.kind
            && let ValueKind::Call(function, args) = &inner.kind
            && function.value == "frame"
        {
            let link = match args.as_slice() {
                [one] => text_of(one).map(|n| (n, one.span)),
                _ => None,
            };
            let Some((name, at)) = link else {
                return Err(Box::new(Diagnostic::error("HQ0310", inner.span, "`frame` takes the name of a link")));
            };
            let arm = self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
            let Some(link) = model.link(name).or(arm) else { return Err(Box::new(unknown_link(model, name, at))) };
            return match field.value.as_str() {
                "position" => Ok((CaptureSource::FramePosition(link), ActualType::Vector(LENGTH))),
                "orientation" => Ok((CaptureSource::FrameOrientation(link), ActualType::Rotation)),
                other => Err(Box::new(
                    Diagnostic::error("HQ0201", field.span, format!("a frame has no `{other}`"))
                        .help("it has `position` and `orientation`"),
                )),
            };
        }
        if let ValueKind::Call(function, args) = &argument.kind
            && function.value == "joint"
            && let [one] = args.as_slice()
            && let Some(name) = text_of(one)
        {
            let dof = model.dof(name).filter(|&d| model.dofs[d].q_index.is_some());
            let Some(dof) = dof else {
                return Err(Box::new(crate::robot_binding::unknown_joint(model, name, one.span, &[])));
            };
            let q = model.dofs[dof].q_index.unwrap_or(0);
            return Ok((CaptureSource::Joint(q), ActualType::Scalar(joint_dimension(model, dof))));
        }
        let own: Vec<&str> = self.kind.actuals.iter().map(|a| a.name).collect();
        let Some(path) = path_of(argument) else {
            return Err(Box::new(
                Diagnostic::error("HQ0311", argument.span, "nothing can be captured from this")
                    .help("name `frame(LINK).position`, `frame(LINK).orientation`, `joint(NAME)` or a value of the task itself"),
            ));
        };
        for candidate in [format!("{}{path}", self.prefix), path.clone()] {
            let found = self.kind.actuals.iter().find(|a| {
                a.name == candidate
                    || (a.name == "*" && self.robot.arms.iter().any(|arm| candidate == format!("angle.{}", arm.name)))
            });
            if let Some(actual) = found {
                return Ok((CaptureSource::Task(self.task, candidate), actual.ty));
            }
        }
        let mut d = Diagnostic::error(
            "HQ0311",
            span,
            format!("`{}` has no value `{path}` that could be captured", self.kind.name),
        );
        if let Some(near) = suggest(&path, own.iter().copied()) {
            d = d.help(format!("did you mean `initial({near})`?"));
        } else if own.is_empty() {
            d = d.help(
                "use `initial(frame(LINK).position)`, `initial(frame(LINK).orientation)` or `initial(joint(NAME))`",
            );
        } else {
            d = d.help(format!("it has {}", list(own.iter().copied(), 8).replace("`*`", "`angle.ARM`")));
        }
        Err(Box::new(d))
    }
}

impl Binder<'_> {
    /// Binds a task. `None` where the type is unknown or a parameter is wrong; the diagnostics say why.
    pub fn task(&mut self, definition: &TaskDefinition, index: usize) -> Option<BoundTask> {
        let Some(kind) = stdlib_tasks::find(&definition.kind.value) else {
            let names = stdlib_tasks::KINDS.iter().map(|k| k.name);
            let d = Diagnostic::error(
                "HQ0204",
                definition.kind.span,
                format!("there is no task type `{}`", definition.kind.value),
            );
            self.diagnostics.push(match suggest(&definition.kind.value, names) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help("`hierarq tasks` lists all types"),
            });
            return None;
        };
        let mut body = definition.body.clone();
        self.positional(kind, definition, &mut body);
        let mut spans = BTreeMap::new();
        for e in &body.entries {
            spans.entry(e.key.value.clone()).or_insert(e.value.span);
        }
        let what = format!("task type `{}`", kind.name);
        let params = self.group(kind, index, "", kind.params, &body, &what, definition.kind.span)?;
        Some(BoundTask { kind, params, spans, span: definition.kind.span })
    }

    /// Turns arguments in parentheses into entries.
    fn positional(&mut self, kind: &'static TaskKind, definition: &TaskDefinition, body: &mut Block) {
        let names = kind.positional;
        if names.is_empty() && !definition.args.is_empty() {
            self.diagnostics.push(
                Diagnostic::error(
                    "HQ0310",
                    definition.args[0].span,
                    format!("`{}` takes nothing in parentheses", kind.name),
                )
                .help("write its parameters in braces"),
            );
            return;
        }
        let takes_list = |name: &str| {
            let info = kind.params.iter().find(|p| p.name == name);
            matches!(info.map(|p| p.ty), Some(ParamType::Frames | ParamType::Geometries | ParamType::Joints))
        };
        for (i, name) in names.iter().enumerate() {
            let Some(first) = definition.args.get(i) else { break };
            let value = if i + 1 == names.len() && takes_list(name) {
                let span = first.span.to(definition.args[definition.args.len() - 1].span);
                Value { kind: ValueKind::List(definition.args[i..].to_vec()), span }
            } else {
                first.clone()
            };
            if let Some(other) = body.get(name) {
                self.diagnostics.push(
                    Diagnostic::error("HQ0207", first.span, format!("`{name}` is given in parentheses and in braces"))
                        .label(other.key.span, "here too"),
                );
                continue;
            }
            let key = Spanned::new((*name).to_string(), first.span);
            body.entries.push(Entry { key, value, comments: dsl::tree::Comments::default() });
        }
        let last_takes_all = names.last().is_some_and(|n| takes_list(n));
        if definition.args.len() > names.len() && !last_takes_all {
            let extra = &definition.args[names.len()];
            self.diagnostics.push(Diagnostic::error(
                "HQ0310",
                extra.span,
                format!("`{}` takes {} in parentheses", kind.name, list(names.iter().copied(), 4)),
            ));
        }
    }

    #[allow(clippy::too_many_arguments, reason = "one call site each way; a struct would only rename them")]
    fn group(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        infos: &'static [ParamInfo],
        body: &Block,
        what: &str,
        owner: Span,
    ) -> Option<BoundParams> {
        let keys: Vec<&str> = infos.iter().map(|p| p.name).collect();
        let mut good = true;
        for (i, e) in body.entries.iter().enumerate() {
            if !keys.contains(&e.key.value.as_str()) {
                self.diagnostics.push(unknown_key(body, i, &keys, what));
                good = false;
            }
        }
        let mut bound = BoundParams::new();
        for info in infos {
            let written = body.get(info.name);
            let default =
                match (written, info.presence) {
                    (Some(_), _) => None,
                    (None, Presence::Default(text)) => Some(self.default(text)),
                    (None, Presence::Optional) => continue,
                    (None, Presence::Required) => {
                        let unknown = body.entries.iter().any(|e| !keys.contains(&e.key.value.as_str()));
                        let d = Diagnostic::error("HQ0206", owner, format!("{what} needs `{}`", info.name))
                            .help(format!("`{}`: {}", info.name, info.text()));
                        // A misspelt key explains the missing one already.
                        if !unknown {
                            self.diagnostics.push(d);
                        }
                        good = false;
                        continue;
                    }
                };
            let value = match (written, &default) {
                (Some(e), _) => &e.value,
                (None, Some(v)) => v,
                (None, None) => continue,
            };
            if matches!(value.kind, ValueKind::Missing) {
                good = false;
                continue;
            }
            let before = self.diagnostics.len();
            match self.one(kind, task, prefix, info, value) {
                Some(b) => {
                    bound.insert(info.name.to_string(), b);
                }
                None => {
                    if default.is_some() {
                        // The default does not fit this robot: say that it has to be written.
                        let rest: Vec<Diagnostic> = self.diagnostics.drain(before..).collect();
                        let why = rest.first().map(|d| d.message.clone()).unwrap_or_default();
                        self.diagnostics.push(
                            Diagnostic::error("HQ0206", owner, format!("{what} needs `{}` here", info.name))
                                .note(format!("its default does not fit: {why}"))
                                .help(info.text()),
                        );
                    }
                    good = false;
                }
            }
        }
        good.then_some(bound)
    }

    /// The value that a default's text means. Texts are those of the task library; a test reads them all.
    fn default(&mut self, text: &str) -> Value {
        let whole = format!("hierarq 1\nparam x = {text}\n");
        let source = self.sources.add("a default of the task library", whole.clone());
        let (spec, _) = dsl::parse(source, &whole, Spelling::Hq);
        let value = spec.items.into_iter().find_map(|i| match i.kind {
            dsl::tree::ItemKind::Param(p) => Some(p.value),
            _ => None,
        });
        value.unwrap_or(Value { kind: ValueKind::Missing, span: Span::default() })
    }

    fn wrong<T>(&mut self, value: &Value, info: &ParamInfo, wanted: &str) -> Option<T> {
        self.diagnostics
            .push(Diagnostic::error("HQ0304", value.span, format!("`{}` is {wanted}", info.name)).help(info.text()));
        None
    }

    fn typed(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        value: &Value,
        moving: bool,
    ) -> Option<Typed> {
        let mut scope = TaskScope {
            robot: self.robot,
            params: self.params,
            used: self.used,
            table: self.table,
            kind,
            task,
            prefix,
            moving,
        };
        Lowering { graph: self.graph, scope: &mut scope, diagnostics: self.diagnostics }.value(value).ok()
    }

    /// A typed value of a kind and dimension, placed in the table.
    #[allow(clippy::too_many_arguments, reason = "see `group`")]
    fn value(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        value: &Value,
        wanted: (Kind, Dimension),
        quantity: Option<Quantity>,
        what: &str,
    ) -> Option<Slot> {
        let constant = quantity.is_some_and(|q| q.constant);
        let typed = self.typed(kind, task, prefix, value, !constant)?;
        if typed.kind != wanted.0 {
            let text = format!("{what} is {}, and this is {}", wanted.0.describe(), typed.kind.describe());
            self.diagnostics.push(Diagnostic::error("HQ0304", value.span, text));
            return None;
        }
        if let Some(d) = fits(self.graph, &typed, wanted.1, what) {
            let error = d.severity == dsl::Severity::Error;
            self.diagnostics.push(d);
            if error {
                return None;
            }
        }
        let slot = self.table.place(&typed.nodes);
        for (i, &n) in typed.nodes.iter().enumerate() {
            match self.graph.constant(n) {
                Some(x) if !x.is_finite() => {
                    self.diagnostics.push(Diagnostic::error(
                        "HQ0309",
                        value.span,
                        format!("{what} is not a finite number"),
                    ));
                    return None;
                }
                Some(x) => {
                    if let Some(q) = quantity.filter(|q| !q.contains(x)) {
                        self.diagnostics.push(
                            Diagnostic::error(
                                "HQ0308",
                                value.span,
                                format!("{what} is {}, and this is {x}", q.describe()),
                            )
                            .here(format!("{x} {}", wanted.1).replace(" 1", "")),
                        );
                        return None;
                    }
                }
                None if constant => {
                    self.diagnostics.push(
                        Diagnostic::error("HQ0307", value.span, format!("{what} must not move with time"))
                            .help("write a constant"),
                    );
                    return None;
                }
                None => {
                    let q = quantity.unwrap_or(Quantity::any(wanted.1));
                    self.table.ranges.push((slot.at + i, q.min, q.max));
                }
            }
        }
        Some(slot)
    }

    fn one(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        info: &'static ParamInfo,
        value: &Value,
    ) -> Option<Bound> {
        let what = format!("`{}`", info.name);
        match info.ty {
            ParamType::Scalar(q) => {
                self.value(kind, task, prefix, value, (Kind::Scalar, q.dimension), Some(q), &what).map(Bound::Value)
            }
            ParamType::AutoScalar(q) => {
                if text_of(value) == Some("auto") {
                    return Some(Bound::Choice("auto".to_string()));
                }
                self.value(kind, task, prefix, value, (Kind::Scalar, q.dimension), Some(q), &what).map(Bound::Value)
            }
            ParamType::Vector(d) => {
                self.value(kind, task, prefix, value, (Kind::Vector, d), None, &what).map(Bound::Value)
            }
            ParamType::Rotation => {
                let slot = self.value(kind, task, prefix, value, (Kind::Rotation, NONE), None, &what);
                slot.map(Bound::Value)
            }
            ParamType::Vectors(count, d) => self.vectors(kind, task, prefix, value, count, d, info),
            ParamType::Gains(names) => self.gains(kind, task, prefix, value, names, info),
            ParamType::Frame => self.frame(value, info).map(|(n, l)| Bound::Frame(n, l)),
            ParamType::Frames => {
                let frames: Vec<Option<(String, LinkId)>> =
                    items_of(value).iter().map(|v| self.frame(v, info)).collect();
                frames.into_iter().collect::<Option<Vec<_>>>().map(Bound::Frames)
            }
            ParamType::Arm => self.arm(value, info).map(Bound::Arm),
            ParamType::Geometries => self.geometries(value).map(Bound::Geometries),
            ParamType::Joints => joints(items_of(value), &self.robot.model, &self.robot.joint_groups, self.diagnostics)
                .map(Bound::Joints),
            ParamType::JointPositions => self.per_joint(kind, task, prefix, value, info, NONE),
            ParamType::JointVelocities => self.per_joint(kind, task, prefix, value, info, RATE),
            ParamType::PerArm(d) => self.per_arm(kind, task, value, info, d),
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
                        Some(near) => d.help(format!("did you mean `{near}`?")),
                        None => d,
                    });
                    None
                }
            },
            ParamType::Group(infos) => {
                let block = block_of(value, &what, self.diagnostics)?;
                let prefix = format!("{prefix}{}.", info.name);
                self.group(kind, task, &prefix, infos, block, &what, value.span).map(Bound::Group)
            }
        }
    }

    #[allow(clippy::too_many_arguments, reason = "see `group`")]
    fn vectors(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        value: &Value,
        count: usize,
        d: Dimension,
        info: &ParamInfo,
    ) -> Option<Bound> {
        let (items, unit) = match &value.kind {
            ValueKind::Unit(inner, unit) => (items_of(inner), Some(unit)),
            _ => (items_of(value), None),
        };
        if items.len() != count || !items.iter().all(|i| !matches!(i.kind, ValueKind::Number(_))) {
            return self.wrong(value, info, &format!("a list of {count} vectors, `[[x, y, z], ..] m`"));
        }
        let quantity = Quantity::any(d).constant();
        let mut at = None;
        for item in items {
            let item = match unit {
                Some(u) => Value { kind: ValueKind::Unit(Box::new(item.clone()), u.clone()), span: item.span },
                None => item.clone(),
            };
            let slot = self.value(kind, task, prefix, &item, (Kind::Vector, d), Some(quantity), "each of them")?;
            at.get_or_insert(slot.at);
        }
        Some(Bound::Value(Slot { at: at?, len: 3 * count }))
    }

    fn gains(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        value: &Value,
        names: &'static [&'static str],
        info: &ParamInfo,
    ) -> Option<Bound> {
        let q = Quantity::at_least(RATE, 0.0);
        let ValueKind::Block(block) = &value.kind else {
            let slot =
                self.value(kind, task, prefix, value, (Kind::Scalar, RATE), Some(q), &format!("`{}`", info.name))?;
            let node = self.table.nodes[slot.at];
            let range = self.table.ranges.iter().find(|r| r.0 == slot.at).copied();
            for k in 1..names.len() {
                self.table.place(&[node]);
                if let Some((_, min, max)) = range {
                    self.table.ranges.push((slot.at + k, min, max));
                }
            }
            return Some(Bound::Value(Slot { at: slot.at, len: names.len() }));
        };
        for i in 0..block.entries.len() {
            if !names.contains(&block.entries[i].key.value.as_str()) {
                self.diagnostics.push(unknown_key(block, i, names, &format!("`{}`", info.name)));
                return None;
            }
        }
        let mut at = None;
        for name in names {
            let Some(e) = block.get(name) else {
                return self.wrong(value, info, &format!("one rate, or {} together", list(names.iter().copied(), 4)));
            };
            let slot = self.value(kind, task, prefix, &e.value, (Kind::Scalar, RATE), Some(q), &format!("`{name}`"))?;
            at.get_or_insert(slot.at);
        }
        Some(Bound::Value(Slot { at: at?, len: names.len() }))
    }

    fn frame(&mut self, value: &Value, info: &ParamInfo) -> Option<(String, LinkId)> {
        let Some(name) = text_of(value) else { return self.wrong(value, info, "the name of a link or arm") };
        let arm = self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
        match self.robot.model.link(name).or(arm) {
            Some(link) => Some((name.to_string(), link)),
            None => {
                self.diagnostics.push(unknown_link(&self.robot.model, name, value.span));
                None
            }
        }
    }

    fn arm(&mut self, value: &Value, info: &ParamInfo) -> Option<Arm> {
        let Some(name) = text_of(value) else { return self.wrong(value, info, "the name of an arm") };
        if let Some(arm) = self.robot.arms.iter().find(|a| a.name == name) {
            return Some(arm.clone());
        }
        let names = self.robot.arms.iter().map(|a| a.name.as_str());
        let d = Diagnostic::error(
            "HQ0201",
            value.span,
            format!("robot `{}` declares no arm `{name}`", self.robot.name.value),
        );
        self.diagnostics.push(match suggest(name, names.clone()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None if self.robot.arms.is_empty() => d.help("declare it in the robot: `arms { left { tip left_tool } }`"),
            None => d.help(format!("it declares {}", list(names, 6))),
        });
        None
    }

    fn geometries(&mut self, value: &Value) -> Option<Vec<Geometry>> {
        let mut all: Vec<Geometry> = Vec::new();
        let mut good = true;
        for item in items_of(value) {
            let Some(path) = path_of(item) else {
                self.diagnostics.push(Diagnostic::error(
                    "HQ0304",
                    item.span,
                    "the name of a point, segment, group or link is needed here",
                ));
                good = false;
                continue;
            };
            let names = self.robot.groups.get(&path).cloned().unwrap_or_else(|| vec![path.clone()]);
            for name in names {
                if let Some(g) = self.robot.geometries.iter().find(|g| g.name == name) {
                    all.push(g.clone());
                } else if let Some(link) = self.robot.model.link(&name) {
                    let shapes = &self.robot.model.link_ref(link).collision;
                    if shapes.is_empty() {
                        self.diagnostics.push(
                            Diagnostic::error("HQ0201", item.span, format!("link `{name}` has no collision shape"))
                                .help(format!(
                                    "declare a point on it in the robot: `points {{ {name}_point {name} }}`"
                                )),
                        );
                        good = false;
                    }
                    all.extend(shapes.iter().enumerate().map(|(i, s)| Geometry {
                        name: if shapes.len() == 1 { name.clone() } else { format!("{name}[{i}]") },
                        link,
                        origin: s.origin,
                        shape: s.shape,
                    }));
                } else {
                    let d = unknown_geometry(
                        &self.robot.model,
                        &self.robot.geometries,
                        &self.robot.groups,
                        &name,
                        item.span,
                    );
                    self.diagnostics.push(d);
                    good = false;
                }
            }
        }
        let mut unique: Vec<Geometry> = Vec::new();
        for g in all {
            if !unique.contains(&g) {
                unique.push(g);
            }
        }
        good.then_some(unique)
    }

    /// Numbers for joints: `{ name value .. }`, or one value for all joints of its unit. `per` is what the joint's own
    /// unit is multiplied with: nothing for positions, a rate for velocities.
    fn per_joint(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        value: &Value,
        info: &ParamInfo,
        per: Dimension,
    ) -> Option<Bound> {
        let model = &self.robot.model;
        let dimension = |dof: usize| joint_dimension(model, dof).times(per).unwrap_or(per);
        let mut out: Vec<(usize, Slot)> = Vec::new();
        if let ValueKind::Block(block) = &value.kind {
            let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
            let mut good = true;
            for e in &block.entries {
                let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
                let found = joints(std::slice::from_ref(&name), model, &self.robot.joint_groups, self.diagnostics);
                let Some(dofs) = found else {
                    good = false;
                    continue;
                };
                for &dof in &dofs {
                    if let Some(first) = seen.insert(dof, e.key.span) {
                        let text = format!("joint `{}` is given twice", model.dofs[dof].name);
                        self.diagnostics.push(Diagnostic::error("HQ0207", e.key.span, text).label(first, "first here"));
                        good = false;
                    }
                }
                match self.joint_values(kind, task, prefix, &e.value, &dofs, &dimension) {
                    Some(slots) => out.extend(dofs.into_iter().zip(slots)),
                    None => good = false,
                }
            }
            return good.then_some(Bound::PerJoint(out));
        }
        let typed = self.typed(kind, task, prefix, value, true)?;
        let revolute = ANGLE.times(per).unwrap_or(per);
        let wanted = if revolute.accepts(typed.dimension) { revolute } else { LENGTH.times(per).unwrap_or(per) };
        if typed.kind != Kind::Scalar
            || fits(self.graph, &typed, wanted, "").is_some_and(|d| d.severity == dsl::Severity::Error)
        {
            return self.wrong(value, info, "`{ joint value .. }`, or one number in the joints' unit");
        }
        let slot = self.value(kind, task, prefix, value, (Kind::Scalar, wanted), None, &format!("`{}`", info.name))?;
        out.extend((0..model.nv()).filter(|&d| dimension(d) == wanted).map(|d| (d, slot)));
        Some(Bound::PerJoint(out))
    }

    fn joint_values(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        prefix: &str,
        value: &Value,
        dofs: &[usize],
        dimension: &dyn Fn(usize) -> Dimension,
    ) -> Option<Vec<Slot>> {
        let (items, unit) = match &value.kind {
            ValueKind::Unit(inner, unit) if matches!(inner.kind, ValueKind::List(_)) => (items_of(inner), Some(unit)),
            ValueKind::List(_) => (items_of(value), None),
            _ => {
                let same = dofs.iter().all(|&d| dimension(d) == dimension(dofs[0]));
                if same && let Some(&first) = dofs.first() {
                    let slot = self.value(
                        kind,
                        task,
                        prefix,
                        value,
                        (Kind::Scalar, dimension(first)),
                        None,
                        "the value of these joints",
                    )?;
                    return Some(vec![slot; dofs.len()]);
                }
                return dofs
                    .iter()
                    .map(|&d| {
                        self.value(
                            kind,
                            task,
                            prefix,
                            value,
                            (Kind::Scalar, dimension(d)),
                            None,
                            "the value of this joint",
                        )
                    })
                    .collect();
            }
        };
        if items.len() != dofs.len() {
            self.diagnostics.push(
                Diagnostic::error("HQ0310", value.span, format!("{} joints, and {} values", dofs.len(), items.len()))
                    .help("give one value for each joint, or a single one for all"),
            );
            return None;
        }
        let mut out = Vec::new();
        for (item, &dof) in items.iter().zip(dofs) {
            let item = match unit {
                Some(u) => Value { kind: ValueKind::Unit(Box::new(item.clone()), u.clone()), span: item.span },
                None => item.clone(),
            };
            out.push(self.value(
                kind,
                task,
                prefix,
                &item,
                (Kind::Scalar, dimension(dof)),
                None,
                "the value of this joint",
            )?);
        }
        Some(out)
    }

    fn per_arm(
        &mut self,
        kind: &'static TaskKind,
        task: usize,
        value: &Value,
        info: &'static ParamInfo,
        d: Dimension,
    ) -> Option<Bound> {
        let block = block_of(value, &format!("`{}`", info.name), self.diagnostics)?;
        let prefix = format!("{}.", info.name);
        let mut out = Vec::new();
        let mut good = !block.entries.is_empty();
        if block.entries.is_empty() {
            return self.wrong(value, info, "`{ ARM value .. }`");
        }
        for e in &block.entries {
            let name = Value { kind: ValueKind::Name(e.key.value.clone()), span: e.key.span };
            let arm = self.arm(&name, info);
            let slot =
                self.value(kind, task, &prefix, &e.value, (Kind::Scalar, d), None, &format!("`{}`", e.key.value));
            match (arm, slot) {
                (Some(arm), Some(slot)) => out.push((arm, slot)),
                _ => good = false,
            }
        }
        good.then_some(Bound::PerArm(out))
    }
}
