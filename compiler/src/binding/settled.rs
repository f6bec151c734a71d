//! `settled(JOINTS, 1 deg/s, 1 mm/s)`: true while no joint is faster than the bound in its unit.

use dsl::tree::Value;
use dsl::{Diagnostic, Span};
use runtime::program::{Measure, Op};
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, Dimension, LENGTH, VELOCITY};

use super::motion::Numbers;
use crate::diagnostics::refused::{Refused, refuse};
use crate::expr::constants::{Constants, joint_dimension};
use crate::expr::{Graph, Kind};
use crate::forms::path_of;
use crate::robot_binding::{BoundRobot, joints};

/// Form of the call, for messages.
const FORM: &str = "write `settled(all, 1 deg/s, 1 mm/s)`, or the name of a group in place of `all`";

/// Bound on the largest speed of some joints, which all turn or all slide.
pub(crate) struct SpeedLimit {
    /// The largest speed.
    pub measure: Measure,
    /// Its name in the log: `speed(all)`.
    pub name: String,
    /// Its dimension.
    pub dimension: Dimension,
    /// The bound, in rad/s or m/s.
    pub most: f64,
}

/// Units of the speeds of joints, with a bound for examples.
struct SpeedUnit {
    position: Dimension,
    speed: Dimension,
    name: &'static str,
    verb: &'static str,
    example: &'static str,
}

const UNITS: [SpeedUnit; 2] = [
    SpeedUnit { position: ANGLE, speed: ANGULAR_VELOCITY, name: "angular_speed", verb: "turn", example: "1 deg/s" },
    SpeedUnit { position: LENGTH, speed: VELOCITY, name: "linear_speed", verb: "slide", example: "1 mm/s" },
];

/// Binds the arguments of `settled(..)`: the joints, and a bound for each unit of their speeds.
pub(crate) fn settled(
    robot: &BoundRobot,
    args: &[Value],
    span: Span,
    constants: &mut Constants,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Vec<SpeedLimit>, Refused> {
    let [which, bounds @ ..] = args else {
        return refuse(
            Diagnostic::error("HQ0310", span, "`settled` takes joints and bounds of their speeds").help(FORM),
        );
    };
    let mut said = Vec::new();
    let Some(dofs) = joints(which.items(), &robot.model, &robot.joint_groups, &mut said) else {
        return Err(said.pop().map(Box::new));
    };
    let text = path_of(which).unwrap_or_else(|| {
        let names: Vec<&str> = dofs.iter().map(|&dof| robot.model.dofs[dof].name.as_str()).collect();
        names.join(" ")
    });
    if dofs.is_empty() {
        let d = Diagnostic::error("HQ0304", which.span, format!("`{text}` has no joints, and is always at rest"));
        return refuse(d.help("name a group with joints that move"));
    }
    let parts = UNITS.map(|unit| {
        let position = unit.position;
        let of = dofs.iter().copied().filter(|&dof| joint_dimension(&robot.model, dof) == position);
        (unit, of.collect::<Vec<usize>>())
    });
    let needed = || parts.iter().filter(|(_, dofs)| !dofs.is_empty());
    let form = || {
        let examples: Vec<&str> = needed().map(|(unit, _)| unit.example).collect();
        format!("write `settled({text}, {})`", examples.join(", "))
    };
    let mut found: [Option<f64>; 2] = [None; 2];
    for bound in bounds {
        let typed = constants.constant(bound, diagnostics).ok_or(None)?;
        let unit = parts
            .iter()
            .position(|(unit, dofs)| typed.kind == Kind::Scalar && unit.speed == typed.dimension && !dofs.is_empty());
        let Some(unit) = unit else {
            let text = format!("no joint of `{text}` has a speed of this dimension");
            let is = if typed.kind == Kind::Scalar { typed.dimension.describe() } else { typed.kind.describe().into() };
            return refuse(Diagnostic::error("HQ0301", bound.span, text).here(is).help(form()));
        };
        let most = typed.nodes.first().and_then(|&node| constants.graph.constant(node));
        if most.is_some_and(|x| x <= 0.0) {
            let d = Diagnostic::error("HQ0308", bound.span, "a bound of a speed must be more than zero");
            return refuse(d.help(
                "a joint that holds its place still moves a little: write the largest speed that is acceptable",
            ));
        }
        if found[unit].is_some() {
            let d = Diagnostic::error("HQ0310", bound.span, "a second bound of this unit");
            return refuse(d.help(form()));
        }
        found[unit] = Some(most.ok_or(None)?);
    }
    let mixed = needed().count() > 1;
    let mut out = Vec::new();
    for ((unit, dofs), most) in parts.iter().zip(found).filter(|((_, dofs), _)| !dofs.is_empty()) {
        let Some(most) = most else {
            let text = format!("`settled` has no bound for joints of `{text}` that {}", unit.verb);
            return refuse(Diagnostic::error("HQ0703", span, text).help(form()));
        };
        let name = format!("{}({text})", if mixed { unit.name } else { "speed" });
        out.push(SpeedLimit { measure: Measure::LargestSpeed(dofs.clone()), name, dimension: unit.speed, most });
    }
    Ok(out)
}

/// Returns the node of the truth value that all limits hold.
pub(crate) fn all_below(graph: &mut Graph, limits: Vec<SpeedLimit>, numbers: &mut Numbers) -> usize {
    let mut all = None;
    for SpeedLimit { measure, name, dimension, most } in limits {
        let speed = numbers(graph, &name, measure, dimension);
        let most = graph.push(Op::Const(most));
        let below = graph.push(Op::LessEqual(speed, most));
        // `a and b` is `if a then b else a`.
        all = Some(all.map_or(below, |a| graph.push(Op::Select(a, below, a))));
    }
    all.unwrap_or_else(|| graph.push(Op::Const(1.0)))
}
