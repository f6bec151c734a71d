//! Parameters of tasks and stacks, and the arguments given for them.

use dsl::tree::{Entry, Member, MemberTask, Parameter, TaskDefinition, Value, ValueKind};
use dsl::{Diagnostic, Help, Span, Spanned};
use names::{list, suggest};
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, Dimension, LENGTH, MASS, NONE, RATE, TIME, VELOCITY};

use super::module::missing;
use super::substitute::{Bindings, Bound, Frame};
use super::{Expander, Given};
use crate::diagnostics::examples;
use crate::expr::Kind;
use crate::expr::constants::is_word;
use crate::forms::{path_of, text_of};
use crate::sections::prefix;
use crate::units::assume;

/// Type of a parameter.
pub(crate) struct Type {
    /// Name of the type.
    pub name: &'static str,
    /// Description of an argument: "the name of an arm".
    pub is: &'static str,
    form: Form,
}

/// Check that an argument has to pass.
enum Form {
    /// A name or text.
    Name,
    /// The name of an arm of the robot.
    Arm,
    /// Names, alone or in a list.
    Names,
    /// Names of joints, which may serve as keys.
    Joints,
    /// A task.
    Task,
    /// An expression; `None` permits any dimension.
    Quantity(Kind, Option<Dimension>),
}

const fn named(name: &'static str, is: &'static str, form: Form) -> Type {
    Type { name, is, form }
}

const fn scalar(name: &'static str, is: &'static str, dimension: Dimension) -> Type {
    Type { name, is, form: Form::Quantity(Kind::Scalar, Some(dimension)) }
}

/// All types of parameters.
pub(crate) static TYPES: &[Type] = &[
    named("arm", "the name of an arm", Form::Arm),
    named("frame", "the name of a link or arm", Form::Name),
    named("joints", "names of joints or groups of joints, or patterns", Form::Joints),
    named("geometry", "names of points, segments, groups or links", Form::Names),
    named("task", "a task", Form::Task),
    named("name", "a name", Form::Name),
    scalar("number", "a bare number", NONE),
    scalar("length", "a length", LENGTH),
    scalar("angle", "an angle", ANGLE),
    scalar("duration", "a time", TIME),
    scalar("rate", "a rate", RATE),
    scalar("speed", "a velocity along a line", VELOCITY),
    scalar("angular_speed", "an angular velocity", ANGULAR_VELOCITY),
    scalar("mass", "a mass", MASS),
    named("vector", "a vector", Form::Quantity(Kind::Vector, None)),
    named("point", "a vector of lengths", Form::Quantity(Kind::Vector, Some(LENGTH))),
    named("pose", "a pose", Form::Quantity(Kind::Pose, Some(NONE))),
    named("orientation", "an orientation", Form::Quantity(Kind::Rotation, Some(NONE))),
];

/// Types of parameters of tasks and stacks, each with a description of its argument.
pub fn parameter_types() -> impl Iterator<Item = (&'static str, &'static str)> {
    TYPES.iter().map(|t| (t.name, t.is))
}

/// Type of that name.
fn find(name: &str) -> Option<&'static Type> {
    TYPES.iter().find(|t| t.name == name)
}

/// Kind and dimension of a type; `None` if it is not a quantity.
pub(crate) fn quantity(name: &str) -> Option<(Kind, Option<Dimension>)> {
    match find(name)?.form {
        Form::Quantity(kind, dimension) => Some((kind, dimension)),
        _ => None,
    }
}

/// Name of the type of numbers with this dimension.
pub(crate) fn type_of(dimension: Dimension) -> Option<&'static str> {
    let is = |t: &&Type| matches!(t.form, Form::Quantity(Kind::Scalar, Some(d)) if d == dimension);
    TYPES.iter().find(is).map(|t| t.name)
}

/// Arguments for a declaration.
pub(super) struct Arguments<'u> {
    pub args: &'u [Value],
    pub named: &'u [Entry],
    /// Span of the use.
    pub at: Span,
}

/// Declaration that takes the arguments.
pub(super) struct Taker<'t> {
    pub name: &'t Spanned<String>,
    pub parameters: &'t [Parameter],
    pub module: usize,
}

impl Expander<'_> {
    /// Binds the parameters of a declaration to the arguments of one use; `frame` is the frame of the use. Returns
    /// `None` if they do not fit, with diagnostics.
    pub(super) fn arguments(&mut self, taker: &Taker, given: &Arguments, frame: &mut Frame) -> Option<Bindings> {
        let name = taker.name.value.as_str();
        let before = self.diagnostics.len();
        let mut chosen: Vec<Option<&Value>> = given.args.iter().map(Some).take(taker.parameters.len()).collect();
        chosen.resize(taker.parameters.len(), None);
        let wrong =
            |span: Span, text: String| Diagnostic::error("HQ0214", span, text).label(taker.name.span, "declared here");
        let form = form(taker);
        if let Some(extra) = given.args.get(taker.parameters.len()) {
            let span = self.at(extra.span, frame);
            let count = match taker.parameters.len() {
                0 => "nothing".to_string(),
                1 => "one argument".to_string(),
                n => format!("{n} arguments"),
            };
            self.fail(wrong(span, format!("`{name}` takes {count}, and this is one more")).help(form.clone()));
        }
        for entry in given.named {
            let span = self.at(entry.key.span, frame);
            let Some(k) = taker.parameters.iter().position(|p| p.name == entry.key) else {
                let names = taker.parameters.iter().map(|p| p.name.value.as_str());
                let d = wrong(span, format!("`{name}` takes no `{}`", entry.key.value));
                self.fail(d.help(form.clone()).nearest(&entry.key.value, names));
                continue;
            };
            if let Some(first) = chosen[k] {
                let first = self.at(first.span, frame);
                let d = Diagnostic::error("HQ0207", span, format!("`{}` is given twice", entry.key.value));
                self.fail(d.label(first, "given here by its place").help("keep one of them"));
                continue;
            }
            chosen[k] = Some(&entry.value);
        }
        let lacking: Vec<&str> = (taker.parameters.iter().zip(&chosen))
            .filter(|(p, c)| c.is_none() && p.default.is_none())
            .map(|(p, _)| p.name.value.as_str())
            .collect();
        if !lacking.is_empty() && self.diagnostics.len() == before {
            let span = self.at(given.at, frame);
            self.fail(wrong(span, format!("`{name}` needs {}", list(lacking.iter().copied(), 8))).help(form));
        }
        let mut bound = Bindings::new();
        for (p, c) in taker.parameters.iter().zip(chosen) {
            let one = match (c, &p.default) {
                (Some(value), _) => self.argument(taker, p, value, frame),
                (None, Some(default)) => {
                    // A default may use the parameters before it.
                    let mut own = Frame::used(taker.module, bound.clone(), given.at);
                    self.argument(taker, p, default, &mut own)
                }
                (None, None) => None,
            };
            if let Some(one) = one {
                bound.insert(p.name.value.clone(), one);
            }
        }
        let errors = self.diagnostics[before..].iter().any(|d| d.severity == dsl::Severity::Error);
        (!errors && bound.len() == taker.parameters.len()).then_some(bound)
    }

    fn argument(&mut self, taker: &Taker, p: &Parameter, given: &Value, frame: &mut Frame) -> Option<Bound> {
        let what = format!("`{}` of `{}`", p.name.value, taker.name.value);
        // An unknown type was reported.
        let ty = find(&p.ty.value)?;
        if matches!(ty.form, Form::Task) {
            return self.task_argument(&what, p, given, frame);
        }
        let value = self.value(given, frame);
        if missing(&value.kind) {
            return Some(Bound::Value(value));
        }
        if !self.shallow(&value) {
            return None;
        }
        let good = match ty.form {
            Form::Name => text_of(&value).is_some(),
            Form::Names | Form::Joints => value.items().iter().all(|v| path_of(v).is_some()),
            Form::Arm => text_of(&value).is_some_and(|name| self.is_arm(name)),
            Form::Task => true,
            Form::Quantity(_, dimension) => {
                let given = Given { value: value.clone(), what, ty: p.ty.clone() };
                self.out.given.push(given);
                return Some(Bound::Value(match dimension {
                    Some(dimension) if dimension != NONE && may_be_bare(&value) => assume(value, dimension),
                    _ => value,
                }));
            }
        };
        if !good {
            let d = Diagnostic::error("HQ0215", value.span, format!("{what} takes {}", ty.is));
            let d = d.label(p.span, "declared here");
            let arms = self.arms().unwrap_or_default();
            let near = text_of(&value).and_then(|v| suggest(v, arms.iter().map(String::as_str)));
            self.fail(match (&ty.form, near) {
                (Form::Arm, Some(near)) => d.meant(near),
                (Form::Arm, None) if !arms.is_empty() => {
                    d.help(format!("the robot declares {}", list(arms.iter().map(String::as_str), 8)))
                }
                (Form::Arm, None) => d.help(Help::with("declare the arm in the robot: {}", [examples::arms()])),
                _ => d.help(format!("give {}", ty.is)),
            });
            return None;
        }
        Some(match ty.form {
            Form::Joints => Bound::Joints(value),
            _ => Bound::Value(value),
        })
    }

    /// Binds a task argument: the name of a task, or a type with arguments.
    fn task_argument(&mut self, what: &str, p: &Parameter, given: &Value, frame: &mut Frame) -> Option<Bound> {
        let task = match &given.kind {
            ValueKind::Name(name) => MemberTask::Name(Spanned::new(name.clone(), given.span)),
            ValueKind::Call(kind, args) => MemberTask::Inline(TaskDefinition {
                kind: kind.clone(),
                args: args.iter().filter(|a| !matches!(a.kind, ValueKind::Named(..))).cloned().collect(),
                named: args.iter().filter_map(entry).collect(),
                body: dsl::tree::Block { span: Span { start: given.span.end, ..given.span }, ..Default::default() },
                span: given.span,
            }),
            ValueKind::Missing => return None,
            _ => {
                let span = self.at(given.span, frame);
                let d = Diagnostic::error("HQ0215", span, format!("{what} is a task"));
                let d = d.label(p.span, "declared here");
                self.fail(d.help("give the name of a task, or a type with its arguments, such as `hold(left)`"));
                return None;
            }
        };
        let member = Member { task, weight: None, span: given.span, comments: Default::default() };
        self.members(&[member], frame).pop().map(|m| Bound::Task(m.task))
    }

    /// Arms of the robot; `None` if they are unknown, because there is no readable robot.
    fn arms(&self) -> Option<Vec<String>> {
        let robots = &self.out.robots;
        let mut names = Vec::new();
        for robot in robots {
            // Those of several robots have the name of theirs before their own.
            let prefix = if robots.len() > 1 { prefix(&robot.name.value) } else { String::new() };
            match robot.body.get("arms").map(|e| &e.value.kind) {
                Some(ValueKind::Block(arms)) => {
                    names.extend(arms.entries.iter().map(|e| format!("{prefix}{}", e.key.value)));
                }
                Some(_) => return None,
                None => {}
            }
        }
        (!robots.is_empty()).then_some(names)
    }

    fn is_arm(&self, name: &str) -> bool {
        self.arms().is_none_or(|arms| arms.iter().any(|a| a == name))
    }
}

/// True if a value may be a bare number or a vector of such. The value of a name is unknown until values are typed, so
/// every name passes.
fn may_be_bare(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Number(_) => true,
        ValueKind::Name(name) => !is_word(name),
        ValueKind::List(items) => !items.is_empty() && items.iter().all(may_be_bare),
        ValueKind::Negate(of) => may_be_bare(of),
        ValueKind::Binary(_, left, right) => may_be_bare(left) && may_be_bare(right),
        _ => false,
    }
}

/// Describes the use of a declaration.
fn form(taker: &Taker) -> String {
    let all = |wanted: bool| {
        let some = taker.parameters.iter().filter(|p| p.default.is_some() == wanted);
        some.map(|p| format!("{}: {}", p.name.value, p.ty.value)).collect::<Vec<_>>().join(", ")
    };
    let (needed, free) = (all(false), all(true));
    let free = if free.is_empty() { free } else { format!(", and if wanted `{free}`") };
    format!("write `{}({needed})`{free}", taker.name.value)
}

/// Converts a named argument to an entry.
fn entry(argument: &Value) -> Option<Entry> {
    match &argument.kind {
        ValueKind::Named(name, value) => {
            Some(Entry { key: name.clone(), value: (**value).clone(), comments: dsl::tree::Comments::default() })
        }
        _ => None,
    }
}
