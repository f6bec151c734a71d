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
    let value = json!({ "type": ["number", "string", "array"] });
    section("Values with a name: numbers, vectors, orientations. `--set NAME=VALUE` overrides one.", &value)
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
    section("The robot, by name.", &object(robot, &["urdf", "rate"], "A robot."))
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
    let level = object(level, &["name", "tasks"], "A level.");
    let stack = keys([
        ("lock", values::names(), "Joints, groups and patterns that stand still while this stack runs."),
        (
            "levels",
            json!({ "type": "array", "minItems": 1, "items": level }),
            "The levels, the most important first: what one can do without disturbing those above it, it does.",
        ),
    ]);
    section("Hierarchies of tasks, by name.", &object(stack, &["levels"], "A hierarchy of tasks."))
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
