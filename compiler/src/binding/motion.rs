//! Measures of the robot's motion by name: `speed(..)`, `acceleration(..)` and `reversals(..)`. Expectations measure
//! them in the world, conditions of a machine inside the controller. [`super::settled`] compares several of them.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use robot::LinkId;
use runtime::program::{Interface, Measure, MeasuredProgram, Op};
use stdlib_tasks::dimension::{ACCELERATION, Dimension, NONE, RATE, VELOCITY};

use super::scope::TaskScope;
use super::settled::{all_below, settled};
use crate::diagnostics::refused::{Refused, refuse};
use crate::expand::type_of;
use crate::expr::constants::Constants;
use crate::expr::constants::joint_dimension;
use crate::expr::{Axes, Graph, Kind, REACHED, SETTLED, Typed, not_measured};
use crate::forms::path_of;
use crate::robot_binding::{BoundRobot, is_pattern, joints, unknown_joint};

/// Syntax of a measure of the motion, for messages; `None` if the function is not in [`crate::expr::MOTION`].
pub(crate) fn form(function: &str) -> Option<&'static str> {
    Some(match function {
        "speed" => "speed(JOINT)`, `speed(GROUP)` or `speed(FRAME)",
        "acceleration" => "acceleration(JOINT)`, `acceleration(GROUP)` or `acceleration(FRAME)",
        "reversals" => "reversals(JOINT)` or `reversals(GROUP)",
        _ => return None,
    })
}

/// Returns a call's only argument, a name or a path of names, with its text.
pub(crate) fn named<'v>(
    function: &Spanned<String>,
    args: &'v [Value],
    span: Span,
    form: &str,
) -> Result<(&'v Value, String), Refused> {
    let [argument] = args else {
        let text = format!("`{}` takes one name, not {} arguments", function.value, args.len());
        return refuse(Diagnostic::error("HQ0310", span, text).help(format!("the form is `{form}`")));
    };
    match path_of(argument) {
        Some(path) => Ok((argument, path)),
        None if matches!(argument.kind, ValueKind::Missing) => Err(None),
        None => {
            let d = Diagnostic::error("HQ0304", argument.span, "a name is needed here");
            let help = format!("the form is `{form}`; write a name with other characters in quotes");
            Err(Some(Box::new(d.help(help))))
        }
    }
}

/// Link of that name, or the tip of the arm of that name.
fn link(robot: &BoundRobot, name: &str) -> Option<LinkId> {
    robot.model.link(name).or_else(|| robot.arms.iter().find(|a| a.name == name).map(|a| a.tip))
}

/// Diagnostic for a name that is neither a joint nor a frame.
fn neither(robot: &BoundRobot, name: &str, at: Span) -> Diagnostic {
    let frames = robot.arms.iter().map(|a| &a.name).chain(robot.model.links.iter().map(|l| &l.name));
    let frames: Vec<&str> = frames.map(String::as_str).collect();
    unknown_joint(&robot.model, name, at, &frames, &robot.joint_groups.locked)
}

/// Binds `function(argument)`, where [`form`] knows the function, to a measure with its dimension. `path` is the
/// argument's text.
pub(crate) fn motion(
    robot: &BoundRobot,
    function: &str,
    argument: &Value,
    path: &str,
) -> Result<(Measure, Dimension), Refused> {
    let model = &robot.model;
    let per_second = |d: Dimension| d.times(RATE).ok_or(None);
    match function {
        // The argument is a joint, a group, or a pattern of joint names.
        "reversals" => {
            let mut said = Vec::new();
            match joints(std::slice::from_ref(argument), model, &robot.joint_groups, &mut said) {
                Some(dofs) => Ok((Measure::Reversals(dofs), NONE)),
                None => Err(said.pop().map(Box::new)),
            }
        }
        "acceleration" if is_group(robot, path) && link(robot, path).is_none() => {
            let Group { dofs, dimension } = group_of_one_unit(robot, argument, path, "acceleration")?;
            Ok((Measure::LargestAcceleration(dofs), per_second(dimension).and_then(per_second)?))
        }
        "acceleration" => match (model.dof(path), link(robot, path)) {
            (Some(dof), _) => {
                let dimension = per_second(joint_dimension(model, dof)).and_then(per_second)?;
                Ok((Measure::Acceleration(dof), dimension))
            }
            (None, Some(link)) => Ok((Measure::PointAcceleration(link), ACCELERATION)),
            (None, None) => refuse(neither(robot, path, argument.span)),
        },
        _ if is_group(robot, path) && link(robot, path).is_none() => {
            let Group { dofs, dimension } = group_of_one_unit(robot, argument, path, "speed")?;
            Ok((Measure::LargestSpeed(dofs), per_second(dimension)?))
        }
        _ => match (model.dof(path).filter(|&d| model.dofs[d].q_index.is_some()), link(robot, path)) {
            (Some(dof), _) => Ok((Measure::Speed(dof), per_second(joint_dimension(model, dof))?)),
            (None, Some(link)) => Ok((Measure::PointSpeed(link), VELOCITY)),
            (None, None) => refuse(neither(robot, path, argument.span)),
        },
    }
}

/// True for the name of a group of joints, or for a pattern of joint names.
fn is_group(robot: &BoundRobot, name: &str) -> bool {
    let groups = &robot.joint_groups;
    groups.members.contains_key(name) || groups.failed.contains(name) || is_pattern(name)
}

/// Joints of one unit.
struct Group {
    dofs: Vec<usize>,
    dimension: Dimension,
}

/// Binds the joints of a group, whose largest `what` has one unit.
fn group_of_one_unit(robot: &BoundRobot, argument: &Value, path: &str, what: &str) -> Result<Group, Refused> {
    let mut said = Vec::new();
    let Some(dofs) = joints(std::slice::from_ref(argument), &robot.model, &robot.joint_groups, &mut said) else {
        return Err(said.pop().map(Box::new));
    };
    let mut dimensions: Vec<Dimension> = dofs.iter().map(|&dof| joint_dimension(&robot.model, dof)).collect();
    dimensions.dedup();
    match dimensions.as_slice() {
        [dimension] => Ok(Group { dimension: *dimension, dofs }),
        [] => {
            let d = Diagnostic::error("HQ0304", argument.span, format!("`{path}` has no joints, and no {what}"));
            refuse(d.help("name a group with joints that move"))
        }
        _ => {
            let text = format!("some joints of `{path}` turn and others slide, and their {what}s have no common unit");
            let d = Diagnostic::error("HQ0304", argument.span, text);
            refuse(match what {
                "speed" => d.help(format!("give a bound for each: `settled({path}, 1 deg/s, 1 mm/s)`")),
                _ => d.help("name a group of joints that turn, and one of joints that slide"),
            })
        }
    }
}

/// Adds a measure, with its text and dimension, to the graph, and returns its node.
pub(crate) type Numbers<'s> = dyn FnMut(&mut Graph, &str, Measure, Dimension) -> usize + 's;

impl TaskScope<'_> {
    /// Lowers a measure of the motion, or the criterion that a target is reached, if the scope is a condition.
    pub(super) fn measure(
        &mut self,
        graph: &mut Graph,
        function: &Spanned<String>,
        args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Typed, Refused> {
        let truth = |node| Typed {
            kind: Kind::Truth,
            dimension: NONE,
            nodes: vec![node],
            bare: false,
            axes: Axes::default(),
            span,
        };
        if let Some(flag) = self.targets.iter().find(|flag| flag.span == span && function.value == REACHED) {
            return flag.node.map(truth).ok_or(None);
        }
        if let (SETTLED, Some(numbers)) = (function.value.as_str(), self.numbers.as_mut()) {
            let mut constants = Constants { graph, params: self.params };
            let bounds = settled(self.robot, args, span, &mut constants, diagnostics)?;
            return Ok(truth(all_below(graph, bounds, numbers)));
        }
        let (Some(form), Some(numbers)) = (form(&function.value), self.numbers.as_mut()) else {
            return refuse(not_measured(function, span));
        };
        let (argument, path) = named(function, args, span, form)?;
        let (measure, dimension) = motion(self.robot, &function.value, argument, &path)?;
        let nodes = vec![numbers(graph, &format!("{}({path})", function.value), measure, dimension)];
        Ok(Typed { kind: Kind::Scalar, dimension, nodes, bare: false, axes: Axes::default(), span })
    }
}

/// State whose transitions are lowered, with the measures that conditions of the machine use so far.
pub(crate) struct MeasuredState<'m> {
    /// Index of the state.
    pub index: usize,
    /// Path of the state.
    pub name: &'m str,
    /// Signals of the program; each measure is read through a variable behind them.
    pub interface: &'m mut Interface,
    /// Measures so far.
    pub measured: &'m mut Vec<MeasuredProgram>,
    /// Targets that the condition asks to be reached.
    pub targets: &'m [TargetFlag],
}

/// Criterion that a target is reached, in a condition.
pub(crate) struct TargetFlag {
    /// Span of the call.
    pub span: Span,
    /// Node of its flag in the graph; `None` if it is wrong, which is reported.
    pub node: Option<usize>,
}

impl MeasuredState<'_> {
    /// Returns the graph node of a measure called `text`. Reversals are counted from the entry of the state on.
    pub(crate) fn number(&mut self, graph: &mut Graph, text: &str, measure: Measure, dimension: Dimension) -> usize {
        let since = matches!(measure, Measure::Reversals(_)).then_some(self.index);
        let known = self.measured.iter().find(|m| m.measure == measure && m.since == since);
        let signal = known.map(|m| m.signal).unwrap_or_else(|| {
            let name = if since.is_some() { format!("{text} in {}", self.name) } else { text.to_string() };
            let signal = self.interface.declare_output(name, type_of(dimension).unwrap_or("number"));
            self.measured.push(MeasuredProgram { signal, measure, since });
            signal
        });
        graph.push(Op::Signal(self.interface.signals[signal].at + 1))
    }
}

#[cfg(test)]
mod tests {
    use crate::expr::{MEASURES, MOTION, SETTLED};

    #[test]
    fn the_words_are_those_of_conditions() {
        let known: Vec<&str> = MEASURES.iter().copied().filter(|word| super::form(word).is_some()).collect();
        assert_eq!([known, vec![SETTLED]].concat(), MOTION);
    }
}
