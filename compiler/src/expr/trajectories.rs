//! Trajectories: `trapezoid`, `s_curve` and `waypoints`, with named arguments after the goal.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use names::list;
use runtime::program::{MAX_POINTS, Motion, Shape, TrajectoryProgram};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE, TIME};

use super::errors;
use super::scope::Failed;
use super::{Axes, Frame, Kind, Lowering, Typed, frames, ops};
use crate::expr::constants::{check_dimension, wrong_dimension};
use crate::units;

/// A named argument.
#[derive(Debug)]
pub struct Named {
    /// Name.
    pub name: &'static str,
    /// Description for users.
    pub text: &'static str,
    /// True if it can be omitted.
    pub optional: bool,
}

/// A function that computes a trajectory.
#[derive(Debug)]
pub struct Trajectory {
    /// Name.
    pub name: &'static str,
    /// Syntax of a call.
    pub form: &'static str,
    /// Description for users.
    pub text: &'static str,
    /// Named arguments.
    pub named: &'static [&'static Named],
    motion: Motion,
}

const fn named(name: &'static str, text: &'static str, optional: bool) -> Named {
    Named { name, text, optional }
}

static SPEED: Named =
    named("speed", "the largest speed: of a point its norm, of an orientation how fast it turns", false);
static ACCELERATION: Named = named("acceleration", "the largest acceleration", false);
static JERK: Named = named("jerk", "the largest jerk", false);
static ANGULAR_SPEED: Named = named("angular_speed", "of a pose: how fast its orientation turns at most", true);
static ANGULAR_ACCELERATION: Named =
    named("angular_acceleration", "of a pose: the largest angular acceleration of its orientation", true);
static ANGULAR_JERK: Named = named("angular_jerk", "of a pose: the largest angular jerk of its orientation", true);
static CORNER: Named = named("corner", "how far from a point between it may pass; 0 where it is left out", true);
static HOLD: Named = named("hold", "time of rest at each inner point; default 0", true);
static FROM: Named = named(
    "from",
    "where it begins, read when the stack is entered; where it is left out, at the task's own value, as that moves then",
    true,
);

/// All trajectories.
pub static TRAJECTORIES: &[Trajectory] = &[
    Trajectory {
        name: "trapezoid",
        form: "trapezoid(goal, speed: 0.2 m/s, acceleration: 0.5 m/s^2)",
        text: "moves to the goal within a speed and an acceleration, from where it is when the stack is entered; to a goal that changes it goes on from there as it moves",
        named: &[&SPEED, &ACCELERATION, &ANGULAR_SPEED, &ANGULAR_ACCELERATION, &FROM],
        motion: Motion::Trapezoid,
    },
    Trajectory {
        name: "s_curve",
        form: "s_curve(goal, speed: 0.2 m/s, acceleration: 0.5 m/s^2, jerk: 5 m/s^3)",
        text: "moves to the goal within a speed, an acceleration and a jerk, from where it is when the stack is entered; to a goal that changes it goes on from there as it moves",
        named: &[&SPEED, &ACCELERATION, &JERK, &ANGULAR_SPEED, &ANGULAR_ACCELERATION, &ANGULAR_JERK, &FROM],
        motion: Motion::SCurve,
    },
    Trajectory {
        name: "waypoints",
        form: "waypoints(a, b, c, speed: 0.2 m/s, acceleration: 0.5 m/s^2, corner: 2 cm)",
        text: "moves over points along straight lines within a speed and an acceleration, passes each inner point within `corner`, or rests there for `hold`, and ends at the last",
        named: &[&SPEED, &ACCELERATION, &CORNER, &HOLD, &FROM],
        motion: Motion::Waypoints,
    },
];

/// Start of a trajectory.
pub enum Start {
    /// The argument `from`, lowered as any value.
    Written,
    /// A value, and the nodes of its velocity if it may move.
    At(Typed, Vec<usize>),
}

/// Shape of a trajectory for values of a kind; `None` for truth values.
fn shape(kind: Kind) -> Option<Shape> {
    match kind {
        Kind::Scalar => Some(Shape::Number),
        Kind::Vector => Some(Shape::Vector),
        Kind::Rotation => Some(Shape::Orientation),
        Kind::Pose => Some(Shape::Pose),
        Kind::Truth => None,
    }
}

/// A call with its arguments assigned.
struct Call<'v> {
    of: &'static Trajectory,
    goals: Vec<&'v Value>,
    /// Argument for each named parameter.
    given: Vec<Option<&'v Value>>,
}

impl<'v> Call<'v> {
    fn get(&self, wanted: &Named) -> Option<&'v Value> {
        let at = self.of.named.iter().position(|n| n.name == wanted.name)?;
        self.given.get(at).copied().flatten()
    }
}

/// Lowered start of a trajectory.
struct Begun {
    /// Value at the start.
    value: Vec<usize>,
    /// Velocity at the start; empty for zero.
    velocity: Vec<usize>,
    /// Common axes of start and goal.
    to: Frame,
}

impl Lowering<'_> {
    /// Assigns the arguments of a call to goals and named parameters.
    fn sorted<'v>(&mut self, of: &'static Trajectory, args: &'v [Value], span: Span) -> Result<Call<'v>, Failed> {
        let mut call = Call { of, goals: Vec::new(), given: vec![None; of.named.len()] };
        let before = self.diagnostics.len();
        for arg in args {
            let ValueKind::Named(name, value) = &arg.kind else {
                if call.given.iter().any(Option::is_some) {
                    let d = Diagnostic::error("HQ0310", arg.span, "the goal must precede the named arguments");
                    self.diagnostics.push(d.help(format!("write `{}`", of.form)));
                } else {
                    call.goals.push(arg);
                }
                continue;
            };
            let Some(at) = of.named.iter().position(|n| n.name == name.value) else {
                let names = || of.named.iter().map(|n| n.name);
                let text = format!("`{}` takes nothing called `{}`", of.name, name.value);
                let d = Diagnostic::error("HQ0214", name.span, text);
                self.diagnostics.push(d.one_of("it takes", &name.value, names()));
                continue;
            };
            if call.given[at].is_some() {
                let d = Diagnostic::error("HQ0207", name.span, format!("`{}` is given twice", name.value));
                self.diagnostics.push(d.help("keep one of the two"));
            }
            call.given[at] = Some(value);
        }
        let most = if of.motion == Motion::Waypoints { MAX_POINTS } else { 1 };
        if call.goals.is_empty() || call.goals.len() > most {
            let wanted = if most == 1 { "one goal".to_string() } else { format!("1 to {most} points") };
            let text = format!("`{}` takes {wanted}, and this call has {}", of.name, call.goals.len());
            let help = if most == 1 && call.goals.len() > 1 {
                "limits have names, `speed: 0.2 m/s`; for several points write `waypoints(a, b, ..)`".to_string()
            } else {
                format!("write `{}`", of.form)
            };
            self.diagnostics.push(Diagnostic::error("HQ0310", span, text).help(help));
        }
        let lacks = of.named.iter().zip(&call.given).filter(|(n, given)| !n.optional && given.is_none());
        let lacking: Vec<&str> = lacks.map(|(n, _)| n.name).collect();
        if !lacking.is_empty() && call.goals.len() <= most {
            let text = format!("`{}` needs {}", of.name, list(lacking.iter().copied(), 9));
            self.diagnostics.push(Diagnostic::error("HQ0214", span, text).help(format!("write `{}`", of.form)));
        }
        if self.diagnostics.len() > before { Err(Failed) } else { Ok(call) }
    }

    /// Lowers a call of one of [`TRAJECTORIES`].
    pub(super) fn trajectory(&mut self, of: &'static Trajectory, args: &[Value], span: Span) -> Result<Typed, Failed> {
        let call = self.sorted(of, args, span)?;
        let goals = self.goals(&call, span)?;
        let last = goals.last().cloned().ok_or(Failed)?;
        let Some(shape) = shape(last.kind) else {
            let d =
                Diagnostic::error("HQ0304", last.span, "a truth value cannot move to another").here("a truth value");
            return self.fail(d.help("a goal is a number, a vector, an orientation or a pose"));
        };
        let turns = last.kind == Kind::Rotation;
        let (mut limits, mut dimension) = (Vec::new(), last.dimension);
        let mut all = Ok(());
        let first = [&SPEED, &ACCELERATION, &JERK].into_iter().enumerate();
        for (order, of) in first.filter(|(_, n)| call.of.named.iter().any(|m| m.name == n.name)) {
            let Some(value) = call.get(of) else { continue };
            // The speed determines the dimension of a bare goal.
            if order == 0 && last.bare && last.kind != Kind::Pose {
                let speed = self.value(value)?;
                dimension = if speed.bare { NONE } else { speed.dimension.times(TIME).unwrap_or(NONE) };
            }
            let of_what = match last.kind {
                Kind::Pose => LENGTH,
                _ if turns => ANGLE,
                _ => dimension,
            };
            match self.limit(of, value, (of_what, order + 1)) {
                Ok(node) => limits.push(node),
                Err(failed) => all = Err(failed),
            }
        }
        let mut lacking = Vec::new();
        let angular = [&ANGULAR_SPEED, &ANGULAR_ACCELERATION, &ANGULAR_JERK].into_iter().enumerate();
        for (order, of) in angular.filter(|(_, n)| call.of.named.iter().any(|m| m.name == n.name)) {
            match (call.get(of), last.kind == Kind::Pose) {
                (Some(value), true) => match self.limit(of, value, (ANGLE, order + 1)) {
                    Ok(node) => limits.push(node),
                    Err(failed) => all = Err(failed),
                },
                (None, true) => lacking.push(of.name),
                (Some(value), false) => {
                    let text = format!("`{}` is that of a pose, and this is {}", of.name, last.kind.describe());
                    let d = Diagnostic::error("HQ0214", value.span, text);
                    let plain = of.name.trim_start_matches("angular_");
                    all = self.fail(d.help(format!("write `{plain}`")));
                }
                (None, false) => {}
            }
        }
        if !lacking.is_empty() {
            let names = list(lacking.iter().copied(), 3);
            let d = Diagnostic::error("HQ0214", span, format!("the orientation of a pose needs {names}"));
            all = self.fail(d.help("write for instance `angular_speed: 1 rad/s, angular_acceleration: 3 rad/s^2`"));
        }
        if call.of.motion == Motion::Waypoints {
            for (of, dimension) in [(&CORNER, dimension), (&HOLD, TIME)] {
                match call.get(of).map(|value| self.size(of, value, dimension)) {
                    Some(Ok(node)) => limits.push(node),
                    Some(Err(failed)) => all = Err(failed),
                    None => limits.push(self.graph.number(0.0)),
                }
            }
        }
        let Begun { value: start, velocity, to } = self.start(&call, &Typed { dimension, ..last.clone() }, span)?;
        all?;
        let goals = goals.into_iter().flat_map(|g| g.nodes).collect();
        let program =
            TrajectoryProgram { motion: call.of.motion, shape, at: 0, goals, limits, start, velocity, turn: false };
        let nodes = self.graph.trajectory(program);
        let dimension = if matches!(last.kind, Kind::Rotation | Kind::Pose) { NONE } else { dimension };
        let axes = Axes { to, ..last.axes };
        Ok(Typed { nodes, dimension, bare: false, span, axes, ..last })
    }

    /// Lowers the goals. They have one kind and dimension and the same axes, and do not depend on the robot's state.
    fn goals(&mut self, call: &Call, span: Span) -> Result<Vec<Typed>, Failed> {
        let typed: Vec<Result<Typed, Failed>> = call.goals.iter().map(|g| self.value(g)).collect();
        let mut goals: Vec<Typed> = typed.into_iter().collect::<Result<_, _>>()?;
        for goal in &goals {
            self.fixed_goal(goal)?;
            if call.of.motion == Motion::Waypoints && goal.kind != Kind::Vector {
                let text = format!("waypoints are points, and this is {}", goal.kind.describe());
                let d = Diagnostic::error("HQ0304", goal.span, text).here(goal.kind.describe());
                return self.fail(d.help("write positions, `[x, y, z] m`, and a `trapezoid` for orientations"));
            }
        }
        for i in 1..goals.len() {
            let Some(dimension) = ops::joined(self.graph, &goals[0], &goals[i]) else {
                let d = errors::different(&goals[0], &goals[i], "the points of one way have one unit", span);
                return self.fail(d.help("bring them to one unit"));
            };
            let Some(axes) = goals[0].axes.joined(&goals[i].axes) else {
                return self.fail(frames::different(&goals[0], &goals[i], span, false));
            };
            let bare = goals[0].bare && goals[i].bare;
            goals[0] = Typed { dimension, axes: axes.clone(), bare, ..goals[0].clone() };
            goals[i] = Typed { dimension, axes, bare, ..goals[i].clone() };
        }
        Ok(goals)
    }

    fn fixed_goal(&mut self, goal: &Typed) -> Result<(), Failed> {
        if !goal.nodes.iter().any(|&n| self.graph.is_state(n)) {
            return Ok(());
        }
        let d = Diagnostic::error("HQ0312", goal.span, "the robot's state cannot be a goal or a limit of a trajectory");
        let note = "a trajectory can depend on time, signals and captured values; a goal that follows the robot would move with it";
        self.fail(
            d.note(note).help("write `initial(..)` around it for its value at the moment the stack becomes active"),
        )
    }

    /// Lowers a limit: positive, with the dimension `base` per second to the power of `order`.
    fn limit(&mut self, of: &Named, value: &Value, (base, order): (Dimension, usize)) -> Result<usize, Failed> {
        let per = Dimension { s: -(order as i8), ..NONE };
        let Some(dimension) = base.times(per) else {
            return self.fail(errors::unit_error(&units::UnitError::TooLarge, value.span));
        };
        self.number_of(of, value, dimension, false)
    }

    /// Lowers a size: zero or more.
    fn size(&mut self, of: &Named, value: &Value, dimension: Dimension) -> Result<usize, Failed> {
        self.number_of(of, value, dimension, true)
    }

    fn number_of(&mut self, of: &Named, value: &Value, dimension: Dimension, zero: bool) -> Result<usize, Failed> {
        let typed = self.value(value)?;
        let what = format!("`{}`", of.name);
        if typed.kind != Kind::Scalar {
            let is = typed.kind.describe();
            let d = Diagnostic::error("HQ0304", value.span, format!("{what} is a number, and this is {is}")).here(is);
            return self.fail(d.help(format!("it is {}", of.text)));
        }
        self.fixed_goal(&typed)?;
        if let Some(d) = check_dimension(self.graph, &typed, dimension, &what) {
            let error = d.severity == dsl::Severity::Error;
            self.diagnostics.push(d);
            if error {
                return Err(Failed);
            }
        }
        let wrong = |x: f64| !x.is_finite() || x < 0.0 || (x == 0.0 && !zero);
        match self.graph.constant(typed.nodes[0]) {
            Some(x) if wrong(x) => {
                let wanted = if zero { "0 or more" } else { "positive" };
                let unit = units::written(dimension);
                let text = format!("{what} is {wanted}, and this is {x} {unit}");
                let d = Diagnostic::error("HQ0308", value.span, text.trim_end()).here(format!("{x} {unit}").trim_end());
                self.fail(d.help(format!("it is {}", of.text)))
            }
            _ => Ok(typed.nodes[0]),
        }
    }

    /// Lowers the start of a trajectory to `goal`, with its velocity.
    fn start(&mut self, call: &Call, goal: &Typed, span: Span) -> Result<Begun, Failed> {
        let from = call.get(&FROM);
        let start = self.scope.start(self.graph, from, span, self.diagnostics).ok_or(Failed)?;
        let (value, velocity) = match (start, from) {
            (Start::At(value, velocity), _) => (value, velocity),
            (Start::Written, Some(from)) => (self.value(from)?, Vec::new()),
            (Start::Written, None) => return self.fail(needs_from(span)),
        };
        if value.kind != goal.kind {
            let (is, wanted) = (value.kind.describe(), goal.kind.describe());
            let d = Diagnostic::error("HQ0304", value.span, format!("it begins as {is}, and its goal is {wanted}"));
            return self.fail(d.label(goal.span, wanted).help("write `from: VALUE` with a value like the goal"));
        }
        let number = matches!(goal.kind, Kind::Scalar | Kind::Vector);
        if number && !value.bare && !ops::is_zero(self.graph, &value) && !goal.dimension.accepts(value.dimension) {
            return self.fail(wrong_dimension(&value, goal.dimension, "`from`"));
        }
        match goal.axes.to.joined(&value.axes.to) {
            Some(to) => Ok(Begun { value: value.nodes, velocity, to }),
            None => self.fail(frames::different(goal, &value, span, false)),
        }
    }
}

/// Diagnostic for a trajectory without a start.
pub fn needs_from(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0214", span, "this trajectory begins nowhere")
        .note("only one that is the whole value of a task's own target begins where the task is when its stack is entered")
        .help("write `from: VALUE` in it, such as `from: initial(frame(F).position)`, or `from: frame(F).position`")
}

/// Diagnostic for named arguments of a function that takes none.
pub(super) fn no_names(function: &Spanned<String>, arg: &Value, form: Option<&str>) -> Diagnostic {
    let d = Diagnostic::error("HQ0214", arg.span, format!("the arguments of `{}` have no names", function.value));
    d.help(form.map_or_else(|| "leave the name out".to_string(), |form| format!("write `{form}`")))
}
