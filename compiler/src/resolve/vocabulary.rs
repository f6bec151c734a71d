//! Built-in names, with their descriptions. Keys are in [`crate::sections`].

/// A built-in name of expressions.
#[derive(Debug)]
pub struct Word {
    /// Name.
    pub name: &'static str,
    /// Description in Markdown.
    pub doc: &'static str,
}

const fn word(name: &'static str, doc: &'static str) -> Word {
    Word { name, doc }
}

/// Looks up a built-in name.
pub fn built_in(name: &str) -> Option<&'static Word> {
    BUILT_IN.iter().find(|k| k.name == name)
}

/// Built-in names, and functions that are not in the compiler's list of plain functions.
pub static BUILT_IN: &[Word] = &[
    word("pi", "π, a bare number."),
    word("t", "Time since this stack became active, in s."),
    word("time", "Time since the start of the run, in s."),
    word(
        "initial",
        "`initial(VALUE)`: the value at the moment the stack becomes active, of any expression of what the robot does or \
         of a value of the task; behind `expect` the value at the start of the run.",
    ),
    word(
        "frame",
        "`frame(LINK).position`, `frame(LINK).orientation`, `frame(LINK).pose`: of a link in the world; its present value in the expressions \
         of `keep` and `track`, the value at entry inside `initial(..)`.",
    ),
    word(
        "joint",
        "`joint(NAME)`: the position of a joint; in the expressions of `keep` and `track`, and in `initial(..)`.",
    ),
    word("point", "`point(LINK, [x, y, z] m)`: where a point fixed in a link is in the world, in `keep` and `track`."),
    word(
        "distance",
        "`distance(PART, PART)`: between points, segments and shapes, the smallest of groups, in `keep` and `track`; \
         `distance(PART, plane(POINT, NORMAL))`: how far a part is above a plane, negative below it.",
    ),
    word(
        "plane",
        "`plane([x, y, z] m, [0, 0, 1])`: a point of a plane and its normal, inside `distance(..)`; with `in LINK` after \
         one of them the link carries the plane along.",
    ),
    word(
        "com",
        "The robot's centre of mass in the world, a point in m, of the links to which the URDF gives a mass; in `keep` and \
         `track`, and in `initial(..)`.",
    ),
    word(
        "manipulability",
        "`manipulability(FRAME)`, `manipulability(FRAME, linear)`, `manipulability(FRAME, angular, JOINTS)`: how well joints move a \
         frame in all directions, zero at a singularity; in `keep` and `track`, conditions and expectations.",
    ),
    word(
        "field",
        "`field(NAME)`: the value of a safety field, which says how far the robot is from people: in `keep`, conditions and \
         expectations.",
    ),
    word(
        "present",
        "`present(SIGNAL)`, `present(HUMAN)`, `present(HUMAN.POINT)`: whether a signal, or all points of a person, have come, and not longer ago than their `timeout`.",
    ),
    word(
        "age",
        "`age(SIGNAL)`, `age(HUMAN)`, `age(HUMAN.POINT)`: time since the last valid reading, in s; of several points the longest. \
         Infinite before the first reading.",
    ),
    word(
        "uncertainty",
        "`uncertainty(HUMAN)`, `uncertainty(HUMAN.POINT)`: largest distance of a person who is not observed from their last position \
         seen last, in m; of several points the most. Zero while they are seen.",
    ),
    word("true", "The truth value of what holds."),
    word("false", "The truth value of what does not hold."),
];

/// Triggers after `on`, and the faults with an argument in `fault(..)`.
pub static TRIGGERS: &[Word] = &[
    word(
        "reached",
        "`reached(TASK, 5 mm, 2 deg)`: the target of the task is at rest, and each of its errors is at most its tolerance. \
         `reached(TASK, 5 mm, 1 mm/s)`: the robot moves along its rows no faster than that, too. Conditions after `when` know it as well.",
    ),
    word("ended", "`ended(all)`, `ended(REGION, ..)`: all regions of a state, or these, are in final states."),
    word(
        "fault",
        "`fault(any)`, `fault(KIND)`, `fault(stale(SIGNAL))`, `fault(infeasible(LEVEL))`, `fault(limit(TASK))`: a fault came.",
    ),
];

/// Kinds of fault, in the order of [`runtime::FaultKind::ALL`], with their descriptions.
pub static FAULTS: &[Word] = &[
    word("any", "Every fault."),
    word("not_finite", "A position, the time, or a row of a task is not finite."),
    word("deadline", "A tick came too late, or the time went back."),
    word("stale", "A signal that the state needs is absent or too old; `stale(SIGNAL)` for one of them."),
    word("value", "A moving parameter has left what is allowed for it."),
    word("crossed", "Bounds of a task have crossed."),
    word("overlap", "Parts between which a distance is kept overlap, so that no direction leads away."),
    word("infeasible", "The hard levels cannot be met together; `infeasible(LEVEL)` for one of them."),
    word("limit", "A limit is passed; `limit(TASK)` for one of them."),
    word("solver", "The hierarchy could not be solved."),
    word("tracking", "A joint does not follow what it is told: it stands, turns the other way, or moves twice as far."),
    word("jump", "A joint cannot have reached its reading since the last one."),
    word("beyond", "The measured robot has passed a hard limit, which its reference keeps."),
];

/// Functions of the robot's current state.
pub static PRESENT: &[&str] = &["frame", "joint", "point", "distance", "plane", "com", "manipulability", "field"];

/// Functions that need brackets: without them, such a name refers to something else.
pub static CALLED: &[&str] =
    &["frame", "joint", "point", "distance", "plane", "manipulability", "present", "age", "uncertainty", "field"];

/// Measures in expectations of a running scenario.
pub static MEASURED: &[Word] = &[
    word(
        "margin",
        "`margin(TASK)`: the smallest margin of a limit at the robot's true configuration; negative where it is passed.",
    ),
    word("error", "`error(TASK)`, `error(TASK.PART)`: how far a target is from being met, or one of its parts."),
    word("in", "`in(STATE)`: true while the machine is in a state, or in one inside it."),
    word("fault", "`fault`, `fault(KIND)`: true while there is a fault, or one of a kind."),
    word(
        "speed",
        "`speed(JOINT)`, `speed(GROUP)`, `speed(FRAME)`: how fast a joint moves, the fastest joint of a group, or the origin of a frame; never negative. Conditions of a machine know it too.",
    ),
    word(
        "acceleration",
        "`acceleration(JOINT)`, `acceleration(GROUP)`, `acceleration(FRAME)`: by how much the velocity that the controller chose for a joint, or that it \
         gives the origin of a frame, differs from that of the tick before, over the period; never negative. Conditions of a machine know it too.",
    ),
    word(
        "reversals",
        "`reversals(JOINT)`, `reversals(GROUP)`, `reversals(all)`: how often joints have turned round and back within 0.2 s so far; in a condition of a \
         machine since its state was entered.",
    ),
    word(
        "settled",
        "`settled(all, 1 deg/s, 1 mm/s)`, `settled(GROUP, 1 deg/s)`: true while none of the joints is faster than the bound in its unit. \
         Conditions of a machine know it too.",
    ),
];

/// Fields of a pose or a vector.
pub static VALUE_FIELDS: &[&str] = &["position", "orientation", "x", "y", "z"];

/// Fields of a wrench.
pub static WRENCH_FIELDS: &[&str] = &["force", "moment"];

/// Fields of a point or a pose that the host sends, the second one with an orientation.
pub static TRACKED_FIELDS: &[&str] = &["velocity", "angular_velocity", "position", "orientation", "x", "y", "z"];

/// Fields of a frame.
pub static FRAME_FIELDS: &[&str] = &["position", "orientation", "pose"];

#[cfg(test)]
mod tests {
    use runtime::FaultKind;

    use super::*;

    #[test]
    fn words_are_those_of_the_compiler() {
        let faults: Vec<&str> = std::iter::once("any").chain(FaultKind::ALL.map(FaultKind::word)).collect();
        assert_eq!(FAULTS.iter().map(|w| w.name).collect::<Vec<_>>(), faults);
        let measured: Vec<&str> = MEASURED.iter().map(|w| w.name).collect();
        assert_eq!(measured, crate::expr::MEASURES);
    }
}
