//! The keys of the language that no task type declares, each with what it holds. A test holds them against what the
//! compiler accepts.

/// A key, or a word that begins a declaration.
#[derive(Debug)]
pub(super) struct Key {
    /// As it is written.
    pub name: &'static str,
    /// What it holds, in Markdown.
    pub doc: &'static str,
}

const fn key(name: &'static str, doc: &'static str) -> Key {
    Key { name, doc }
}

/// The key of this name.
pub(super) fn find(keys: &'static [Key], name: &str) -> Option<&'static Key> {
    keys.iter().find(|k| k.name == name)
}

/// What begins a declaration of a `*.hq` file.
pub(super) static DECLARATIONS: &[Key] = &[
    key("hierarq", "The version of the language, first in every spec: `hierarq 1`."),
    key("import", "Names of another spec: `import \"common/safety.hq\" { deck, canopies as robot }`."),
    key("let", "A named expression, which may move: `let wave = 0.1 m * sin(t/(1 s))`."),
    key("for", "Repeats declarations: `for side in [left, right] { task touch_${side} = .. }`."),
    key("param", "A named value that `--set` may override: `param approach = 0.15 m`."),
    key("robot", "The robot: `robot NAME { urdf \"..\"  rate 100 Hz }`."),
    key("task", "A named task: `task NAME = TYPE { .. }`."),
    key("stack", "An ordered hierarchy: `stack NAME { level NAME hard { task } }`, the most important level first."),
    key("run", "What `hierarq run` does: `run { stack NAME  duration 10 s }`."),
];

/// The sections of a `*.yaml` spec.
pub(super) static SECTIONS: &[Key] = &[
    key("hierarq", "The version of the language, first in every spec: `hierarq: 1`."),
    key("import", "Names of other specs: `common/safety.hq: [deck, canopies as robot]`."),
    key("lets", "Named expressions, which may move: `wave: 0.1 m * sin(t/(1 s))`."),
    key("for", "Repeated declarations: `- { name: side, in: [left, right], tasks: { .. } }`."),
    key("params", "Named values that `--set` may override: `approach: 0.15 m`."),
    key("robots", "The robot, by name."),
    key("tasks", "Tasks by name, each `NAME: { TYPE: { .. } }`."),
    key("stacks", "Ordered hierarchies by name, each with `levels`, the most important first."),
    key("run", "What `hierarq run` does: `stack`, `duration`, `title`, .."),
];

/// Of a robot.
pub(super) static ROBOT: &[Key] = &[
    key("urdf", "The path of the URDF, in quotes, from the folder of the spec. Required."),
    key("rate", "The rate of control, from 0.1 Hz to 100 kHz. Required."),
    key("base", "What carries the root link: `fixed` (the default), `planar`, `unicycle`, `floating`."),
    key("home", "The configuration at the start: joints or groups with positions. Zero where left out."),
    key("lock", "Joints, groups and patterns taken out of the model, as a list or with positions."),
    key("joints", "Groups of joints by name: `torso [torso_yaw, torso_lift]  arm \"arm_*\"`."),
    key(
        "limits",
        "Joint limits that replace those of the URDF: `elbow { lower 0 rad  upper 2 rad  velocity 1 rad/s }`.",
    ),
    key("arms", "Arms by name: `left { shoulder ..  elbow ..  wrist ..  tip ..  points [..] }`."),
    key("points", "Points by name: `NAME LINK`, or `NAME { link LINK  offset [x, y, z] m }`."),
    key("segments", "Segments by name: `NAME { link LINK  from [..] m  to [..] m }`."),
    key("groups", "Groups of points, segments and links by name."),
    key("tracking_gain", "How strongly the measured configuration is pulled to the reference, in 1/s. Default `0 /s`."),
    key("package_path", "A folder in which `package://` addresses of the URDF are looked for, in quotes."),
];

/// Of an arm.
pub(super) static ARM: &[Key] = &[
    key("shoulder", "The link at its shoulder, for `swivel_angle`."),
    key("elbow", "The link at its elbow, for `swivel_angle`."),
    key("wrist", "The link at its wrist, for `swivel_angle`."),
    key("tip", "The link at its end. Required."),
    key("points", "Points, segments and links that the groups `arms` and `arms.NAME` stand for."),
];

/// Of a point.
pub(super) static POINT: &[Key] = &[
    key("link", "The link that carries it. Required."),
    key("offset", "Where it is in the link's frame, `[x, y, z] m`."),
];

/// Of a segment.
pub(super) static SEGMENT: &[Key] = &[
    key("link", "The link that carries it. Required."),
    key("from", "One end in the link's frame, `[x, y, z] m`. Required."),
    key("to", "The other end in the link's frame, `[x, y, z] m`. Required."),
];

/// Of a joint limit.
pub(super) static LIMIT: &[Key] = &[
    key("lower", "The lowest position, in rad or m."),
    key("upper", "The highest position, in rad or m."),
    key("velocity", "The highest speed, in rad/s or m/s; more than zero."),
];

/// Of a run.
pub(super) static RUN: &[Key] = &[
    key("stack", "The stack that runs; the only one where left out."),
    key("duration", "How long it runs. Default `10 s`."),
    key("title", "Text for table and report; the stack's name where left out."),
    key("solver", "What solves the hierarchy: `active_set` (the default), or `clarabel`, the slower reference."),
    key("simulator", "How the robot differs from a perfect one: `{ lag ..  noise ..  seed .. }`."),
];

/// Of the simulator.
pub(super) static SIMULATOR: &[Key] = &[
    key("lag", "Time constant of a first-order lag between commanded and real velocity. Default `0 s`."),
    key("noise", "Standard deviation of the noise on measured joint positions, an angle. Default `0 rad`."),
    key("seed", "Of the noise, a whole number. Default `0`."),
];

/// Of a stack.
pub(super) static STACK: &[Key] = &[
    key("lock", "Joints, groups and patterns that stand still while this stack runs."),
    key("level", "A level: `level NAME hard { task  task weight 2 }`. The first is the most important."),
    key("replace", "In a stack `from` another one: another level in the place of one, `replace NAME { .. }`."),
    key("add", "In a stack `from` another one: one more level, `add NAME { .. } before OTHER`."),
    key("remove", "In a stack `from` another one: a level less, `remove NAME`."),
];

/// Of a stack in YAML.
pub(super) static STACK_YAML: &[Key] = &[
    key("lock", "Joints, groups and patterns that stand still while this stack runs."),
    key("from", "The stack that this one is made from: a name, or `NAME(..)`."),
    key(
        "changes",
        "What it changes: `- { replace: NAME, tasks: [..] }`, `- { add: NAME, before: NAME, tasks: [..] }`, `- { remove: NAME }`.",
    ),
    key("levels", "The levels in a list, the most important first: `- { name: limits, hard: true, tasks: [..] }`."),
];

/// Of a level, between its name and its braces.
pub(super) static LEVEL: &[Key] = &[
    key("hard", "This level takes no slack: it is met, or the run has a fault."),
    key("damping", "Adds `damping · |v|²` to the cost of this level. Default `0`."),
];

/// Of a level in YAML.
pub(super) static LEVEL_YAML: &[Key] = &[
    key("name", "The name of the level."),
    key("hard", "`true`: this level takes no slack; it is met, or the run has a fault."),
    key("tasks", "The tasks of the level in a list: names, or tasks in place."),
    key("damping", "Adds `damping · |v|²` to the cost of this level. Default `0`."),
];

/// Of the range of a param.
pub(super) static RANGE: &[Key] = &[
    key("min", "The least value that this param may have, written here or given with `--set`."),
    key("max", "The largest value that this param may have, written here or given with `--set`."),
];

/// Of a member of a level.
pub(super) static WEIGHT: Key = key("weight", "What this task's slack counts inside its level. Default `1`.");

/// The bases of a robot.
pub(super) static BASES: &[&str] = &["fixed", "planar", "unicycle", "floating"];

/// Names that expressions know without a declaration, and functions that the compiler's list of plain functions has not.
pub(super) static BUILT_IN: &[Key] = &[
    key("pi", "π, a bare number."),
    key("t", "Time since this stack became active, in s."),
    key("time", "Time since the start of the run, in s."),
    key(
        "initial",
        "`initial(VALUE)`: the value at the moment the stack becomes active, of any expression of what the robot does or \
         of a value of the task.",
    ),
    key(
        "frame",
        "`frame(LINK).position`, `frame(LINK).orientation`, `frame(LINK).pose`: of a link in the world; its present value in the expressions \
         of `keep` and `track`, the value at entry inside `initial(..)`.",
    ),
    key(
        "joint",
        "`joint(NAME)`: the position of a joint; in the expressions of `keep` and `track`, and in `initial(..)`.",
    ),
    key("point", "`point(LINK, [x, y, z] m)`: where a point fixed in a link is in the world, in `keep` and `track`."),
    key(
        "distance",
        "`distance(PART, PART)`: between points, segments and shapes, the smallest of groups, in `keep` and `track`; \
         `distance(PART, plane(POINT, NORMAL))`: how far a part is above a plane, negative below it.",
    ),
    key(
        "plane",
        "`plane([x, y, z] m, [0, 0, 1])`: a point of a plane and its normal, inside `distance(..)`; with `in LINK` behind \
         one of them the link carries the plane along.",
    ),
    key(
        "com",
        "The robot's centre of mass in the world, a point in m, of the links to which the URDF gives a mass; in `keep` and \
         `track`, and in `initial(..)`.",
    ),
    key("true", "The truth value of what holds."),
    key("false", "The truth value of what does not hold."),
];

/// Those that give what the robot does now.
pub(super) static PRESENT: &[&str] = &["frame", "joint", "point", "distance", "plane", "com"];

/// Those of them that are called: without brackets, such a name is that of something else.
pub(super) static CALLED: &[&str] = &["frame", "joint", "point", "distance", "plane"];

/// What a pose and a vector have.
pub(super) static VALUE_FIELDS: &[&str] = &["position", "orientation", "x", "y", "z"];

/// What a frame has.
pub(super) static FRAME_FIELDS: &[&str] = &["position", "orientation", "pose"];

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The names that the compiler offers where a key is unknown, of the one diagnostic that the text has.
    fn offered(text: &str) -> Vec<String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
        let compiled = compiler::compile(&compiler::Input {
            name: "test.hq",
            text,
            spelling: dsl::Spelling::Hq,
            folder: &folder,
            set: &[],
            package_paths: &[],
        });
        let unknown = compiled.report.diagnostics.iter().find(|d| d.code == "HQ0205");
        let help = unknown.and_then(|d| d.help.clone()).expect("an unknown key, with a help");
        help.split('`').skip(1).step_by(2).map(str::to_string).collect()
    }

    #[test]
    fn the_compiler_knows_the_same_keys() {
        let check = |keys: &[Key], text: &str| {
            let mut ours: Vec<&str> = keys.iter().map(|k| k.name).collect();
            let mut theirs = offered(text);
            ours.sort_unstable();
            theirs.sort_unstable();
            assert_eq!(ours, theirs, "{text}");
        };
        let robot = |inner: &str| format!("hierarq 1\nrobot r {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  {inner} }}\n");
        check(ROBOT, &robot("qqqqqqqq 1"));
        check(ARM, &robot("arms { left { qqqqqqqq 1 } }"));
        check(POINT, &robot("points { left { qqqqqqqq 1 } }"));
        check(SEGMENT, &robot("segments { left { qqqqqqqq 1 } }"));
        check(LIMIT, &robot("limits { all { qqqqqqqq 1 } }"));
        check(RUN, "hierarq 1\nrun { qqqqqqqq 1 }\n");
        check(SIMULATOR, "hierarq 1\nrun { simulator { qqqqqqqq 1 } }\n");
        check(&STACK[..1], "hierarq 1\nstack s { qqqqqqqq 1 }\n");
        check(&LEVEL[1..], "hierarq 1\nstack s { level a qqqqqqqq 1 { } }\n");
    }
}
