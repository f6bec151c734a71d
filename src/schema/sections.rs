//! The parts of a spec that are not tasks: params, robots, stacks, run.

use serde_json::{Map, Value, json};
use solver::Backend;
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE, RATE, TIME};
use stdlib_tasks::params::Quantity;

use super::{described, object, section, values};

/// Keys with their schemas and texts.
fn keys<const N: usize>(list: [(&str, Value, &str); N]) -> Map<String, Value> {
    list.into_iter().map(|(key, schema, text)| (key.to_string(), described(schema, text))).collect()
}

fn at_least_zero(d: Dimension) -> Value {
    values::scalar(&Quantity::at_least(d, 0.0))
}

pub(super) fn params() -> Value {
    let plain = json!({ "type": ["number", "string", "array"] });
    let ranged = keys([
        ("value", plain, "The value."),
        ("min", json!({ "type": ["number", "string"] }), "The smallest value that it may have."),
        ("max", json!({ "type": ["number", "string"] }), "The largest value that it may have."),
    ]);
    let mut value = object(ranged, &["value"], "A value, or `{ value, min, max }`.");
    value["type"] = json!(["number", "string", "array", "object"]);
    section("Values with a name: numbers, vectors, orientations, poses. `--set NAME=VALUE` overrides one.", &value)
}

pub(super) fn robots() -> Value {
    let link = || values::name();
    let vector = || values::vector(LENGTH);
    let limits = keys([
        ("lower", values::of_a_joint(), "The lowest position, in rad or m."),
        ("upper", values::of_a_joint(), "The highest position, in rad or m."),
        ("velocity", values::of_a_joint(), "The greatest speed, in rad/s or m/s; more than zero."),
    ]);
    let arm = keys([
        ("tip", link(), "The link at the end."),
        ("shoulder", link(), "The link at the shoulder of a human-like arm; `swivel_angle` needs it."),
        ("elbow", link(), "The link at the elbow; `swivel_angle` needs it."),
        ("wrist", link(), "The link at the wrist; `swivel_angle` needs it."),
        ("points", values::names(), "Points, segments and links for the groups `arms` and `arms.NAME`."),
    ]);
    let point = keys([
        ("link", link(), "The link that carries it."),
        ("offset", vector(), "Where it is in the frame of the link, in m."),
    ]);
    let mut point = object(point, &["link"], "A link, or `{ link, offset }`.");
    point["type"] = json!(["string", "object"]);
    let segment = keys([
        ("link", link(), "The link that carries it."),
        ("from", vector(), "Its beginning in the frame of the link, in m."),
        ("to", vector(), "Its end in the frame of the link, in m."),
    ]);
    let mut locks = values::per_joint();
    locks["type"] = json!(["string", "array", "object"]);
    locks["items"] = values::name();
    let joint_limits = json!({
        "type": "object",
        "propertyNames": { "pattern": values::JOINT_KEY },
        "additionalProperties": object(limits, &[], "Limits that replace those of the URDF."),
    });
    let rate = Quantity { min: 0.1, max: 1e5, ..Quantity::any(RATE) };
    let robot = keys([
        ("from", values::name(), "The robot that this one is made from; a key of its own replaces the other one's."),
        ("urdf", values::name(), "The path of the URDF, from the folder of the spec."),
        ("rate", values::scalar(&rate), "The rate of control, from 0.1 Hz to 100 kHz."),
        (
            "base",
            json!({ "enum": ["fixed", "planar", "unicycle", "floating"], "default": "fixed" }),
            "What carries the root link.",
        ),
        (
            "home",
            values::per_joint(),
            "Where the robot starts: values by joint, group or pattern. Zero, or the nearest limit, where left out.",
        ),
        ("lock", locks, "Joints that are taken out of the model, and where they are held."),
        ("joints", section("", &values::names()), "Groups of joints: names and patterns."),
        ("limits", joint_limits, "Limits that replace those of the URDF, by joint or group."),
        ("arms", section("", &object(arm, &["tip"], "An arm.")), "Arms by name."),
        ("points", section("", &point), "Points: a link, or `{ link, offset }`."),
        ("segments", section("", &object(segment, &["link", "from", "to"], "A segment.")), "Segments on links."),
        ("groups", section("", &values::names()), "Groups of points, segments and links."),
        (
            "tracking_gain",
            at_least_zero(RATE),
            "How strongly the measured configuration is pulled to the reference, up to the rate of control.",
        ),
        ("package_path", values::name(), "A folder for `package://` addresses, from the folder of the spec."),
    ]);
    let mut robot = object(robot, &[], "A robot.");
    robot["if"] = json!({ "required": ["from"] });
    robot["else"] = json!({ "required": ["urdf", "rate"] });
    section("The robot, by name.", &robot)
}

pub(super) fn stacks() -> Value {
    let level = keys([
        ("name", json!({ "type": "string", "pattern": values::NAME }), "The name of the level, for tables and logs."),
        (
            "hard",
            json!({ "enum": [true, false], "default": false }),
            "True: the level takes no slack, and the run has a fault where it cannot be met.",
        ),
        (
            "damping",
            at_least_zero(NONE),
            "Adds `damping · |v|²` to the cost of this level. Zero where left out: the level is strict.",
        ),
        (
            "tasks",
            json!({ "type": "array", "minItems": 1, "items": { "$ref": "#/$defs/member" } }),
            "The tasks of the level: names, or tasks in place.",
        ),
    ]);
    let mut parts: Map<String, Value> = level.clone();
    let level = object(level, &["name", "tasks"], "A level.");
    parts.remove("name");
    parts.extend(keys([
        ("replace", values::name(), "The level that this one stands for."),
        ("add", values::name(), "The name of one more level."),
        ("remove", values::name(), "The level that is left out."),
        ("before", values::name(), "The level that the new one stands before."),
        ("after", values::name(), "The level that the new one stands behind."),
    ]));
    let mut change = object(parts, &[], "A level that is replaced, added or removed.");
    change["oneOf"] =
        json!([{ "required": ["replace", "tasks"] }, { "required": ["add", "tasks"] }, { "required": ["remove"] }]);
    let stack = keys([
        ("from", values::name(), "The stack that this one is made from: a name, or `NAME(..)`."),
        ("changes", json!({ "type": "array", "items": change }), "What this stack changes in the one it is made from."),
        ("lock", values::names(), "Joints, groups and patterns that stand still while this stack runs."),
        (
            "levels",
            json!({ "type": "array", "minItems": 1, "items": level }),
            "The levels, the most important first: what one can do without disturbing those above it, it does.",
        ),
    ]);
    let mut stack = object(stack, &[], "A hierarchy of tasks.");
    stack["oneOf"] = json!([{ "required": ["levels"] }, { "required": ["from"] }]);
    super::heads("Hierarchies of tasks, by name; one with parameters as `\"NAME(side: arm)\"`.", &stack)
}

pub(super) fn run() -> Value {
    let simulator = keys([
        ("lag", at_least_zero(TIME), "Time constant between commanded and real velocity."),
        ("noise", values::angle(), "Standard deviation of the measured joint positions; in m for prismatic joints."),
        ("seed", at_least_zero(NONE), "Seed of the noise, a whole number."),
    ]);
    let solvers: Vec<&str> = Backend::ALL.iter().map(|b| b.name()).collect();
    let duration = Quantity::above(TIME, 0.0);
    let run = keys([
        ("stack", values::name(), "The stack that runs; the only one where left out."),
        ("duration", values::scalar(&duration), "How long, a time above zero; 10 s where left out."),
        ("title", values::name(), "Text for table and report."),
        ("solver", json!({ "enum": solvers, "default": Backend::default().name() }), "What solves the hierarchy."),
        ("simulator", object(simulator, &[], ""), "How the simulated robot differs from a perfect one."),
    ]);
    object(run, &[], "What `hierarq run` does.")
}
