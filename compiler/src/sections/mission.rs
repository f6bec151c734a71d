//! The keys of missions: which kinds there are, and what a schedule says of its robots and of those whom they serve.

use stdlib_tasks::dimension::{DAMPING, Dimension, FORCE, LENGTH, NONE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::layers::LAYERS;
use super::{Holds, Key, Named, Place, Section};

const POWER: Dimension = Dimension { m: 2, kg: 1, s: -3, rad: 0 };

const A_TIME: Holds = Holds::Number(Quantity::at_least(TIME, 0.0));
const A_LENGTH: Holds = Holds::Number(Quantity::at_least(LENGTH, 0.0));
const A_WEIGHT: Holds = Holds::Number(Quantity::at_least(NONE, 0.0));
const WEIGHTS: Holds = Holds::Numbers(Quantity::at_least(NONE, 0.0));
const SPEEDS: Holds = Holds::Range(Quantity::above(VELOCITY, 0.0));
const A_SHARE: Holds = Holds::Number(Quantity::between(NONE, 0.0, 1.0));
const A_CONFIDENCE: Quantity = Quantity::between(NONE, 1e-6, 1.0 - 1e-6);

/// The text that people read in place of a name.
pub(super) const LABEL: Key = Key::optional(
    "label",
    Holds::Text,
    "Text that people read in place of the name, in any script: `label \"Łukasz\"`; default: the name.",
);

/// A mission, by its kind.
pub static MISSION: Section = Section {
    name: "a mission",
    keys: &[
        Key::optional(
            "schedule",
            Holds::Block(&SCHEDULE),
            "Who serves whom, when and how fast: service robots come to people and working robots at the end of each of \
             their operations.",
        )
        .at(Place::Word),
        Key::optional(
            "layers",
            Holds::Block(&LAYERS),
            "Assignment of tasks and objects to agents: layers of tasks, one after the other.",
        )
        .at(Place::Word),
    ],
};

/// A mission of the kind `schedule`.
pub static SCHEDULE: Section = Section {
    name: "a schedule",
    keys: &[
        Key::or(
            "confidence",
            Holds::Number(A_CONFIDENCE),
            "0.9",
            "The probability that an operation ends within its planned duration.",
        ),
        Key::optional(
            "weights",
            Holds::Block(&SCHEDULE_WEIGHTS),
            "Weights of the terms in the cost of a plan, in addition to the waits of people, which have weights of \
             their own.",
        ),
        Key::or(
            "reallocate_above",
            A_WEIGHT,
            "0.1",
            "During the execution of a plan: it is planned again when the cost of its remaining part has changed by \
             more than this fraction.",
        ),
        Key::or(
            "batch",
            Holds::Number(Quantity::at_least(NONE, 1.0)),
            "4",
            "Number of operations that are planned at a time if there are too many for all at once; a whole number.",
        ),
        Key::optional(
            "adaptation",
            Holds::Block(&ADAPTATION),
            "Constants of the adaptation of a plan to the feedback of people.",
        ),
        Key::optional(
            "distances",
            Holds::Of(Named::Member, &Holds::Of(Named::Member, &Holds::Number(Quantity::at_least(LENGTH, 0.0)))),
            "Lengths of the paths from the depot of each robot to each agent, `distances { m1 { h1 12 m  h2 15 m } }`; \
             default: straight lines.",
        ),
        Key::required(
            "robot",
            Holds::Block(&SCHEDULE_ROBOT),
            "A robot that serves: `robot NAME { depot [x, y] m  speed [0.05, 0.2] m/s  serve 20 s }`.",
        )
        .at(Place::Hq),
        Key::required("robots", Holds::Each(&Holds::Block(&SCHEDULE_ROBOT)), "The robots that serve, by name.")
            .at(Place::Yaml),
        Key::optional(
            "human",
            Holds::Block(&SCHEDULE_HUMAN),
            "A person who is served: `human NAME { place [x, y] m  operations 3  duration normal(204 s, 20 s) }`.",
        )
        .at(Place::Hq),
        Key::optional("humans", Holds::Each(&Holds::Block(&SCHEDULE_HUMAN)), "People who are served, by name.")
            .at(Place::Yaml),
        Key::optional(
            "worker",
            Holds::Block(&SCHEDULE_WORKER),
            "A working robot that is served: `worker NAME { place [x, y] m  operations 3  duration 250 s }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "workers",
            Holds::Each(&Holds::Block(&SCHEDULE_WORKER)),
            "Working robots that are served, by name.",
        )
        .at(Place::Yaml),
    ],
};

/// Weights of the cost of a schedule.
pub static SCHEDULE_WEIGHTS: Section = Section {
    name: "`weights` of a schedule",
    keys: &[
        Key::or("worker_wait", A_WEIGHT, "1", "Of the waits of working robots, `beta`."),
        Key::or("energy", A_WEIGHT, "1", "Of the energy of the robots that serve, `gamma`."),
        Key::or("makespan", A_WEIGHT, "1", "Of the time until all is done, `kappa`."),
    ],
};

/// Constants of the adaptation to people.
pub static ADAPTATION: Section = Section {
    name: "an adaptation",
    keys: &[
        Key::or("memory", A_SHARE, "0.5", "Weight of the latest feedback relative to earlier ones, `theta`."),
        Key::or("wait_gain", A_WEIGHT, "1", "Rate at which feedback on waits changes their weights, `k_alpha`."),
        Key::or(
            "approach_gain",
            A_WEIGHT,
            "1",
            "Rate at which feedback on approaches changes their weights, `k_zeta`.",
        ),
        Key::or(
            "margin",
            A_SHARE,
            "0.01",
            "Smallest relative distance between the ends of a range of speeds, `c_epsilon`.",
        ),
        Key::or(
            "wait_step",
            A_TIME,
            "30 s",
            "Change of a person's `wait_limit` by the feedback `too_short` (longer) or `too_long` (shorter); half of \
             it by `short` and `long`.",
        ),
    ],
};

/// A robot of a schedule.
pub static SCHEDULE_ROBOT: Section = Section {
    name: "a robot of a schedule",
    keys: &[
        LABEL,
        Key::required("depot", Holds::Pair(LENGTH), "Position where it starts, and where every service ends."),
        Key::required("speed", SPEEDS, "Range of its speed, `[lowest, highest]`; one number for a fixed speed."),
        Key::optional(
            "proximity_speed",
            SPEEDS,
            "Range of its speed near an agent. Default: from 0.8 times the lowest to 0.75 times the highest speed of \
             all robots of the mission.",
        ),
        Key::required("serve", A_TIME, "Time to serve an agent."),
        Key::or("deposit", A_TIME, "0 s", "Time that it is busy at its depot after each service."),
        Key::or(
            "factor",
            Holds::Number(Quantity::above(NONE, 0.0)),
            "1",
            "Physical factor: larger for a heavier robot, which needs more energy and has to be slower near people.",
        ),
        Key::optional(
            "energy",
            Holds::Block(&ENERGY),
            "Power during motion, `standby + friction v + drag v^2`. Only ratios matter: between these three, and \
             between the robots.",
        ),
    ],
};

/// Coefficients of the power of a robot that moves.
pub static ENERGY: Section = Section {
    name: "the energy of a robot",
    keys: &[
        Key::or("standby", Holds::Number(Quantity::at_least(POWER, 0.0)), "1 W", "Constant power."),
        Key::optional(
            "friction",
            Holds::Number(Quantity::at_least(FORCE, 0.0)),
            "Coefficient of the speed; default: 20 N times the factor.",
        ),
        Key::optional(
            "drag",
            Holds::Number(Quantity::at_least(DAMPING, 0.0)),
            "Coefficient of the squared speed; default: 400 N s/m times the factor.",
        ),
    ],
};

const PLACE: Key = Key::required("place", Holds::Pair(LENGTH), "Position where the agent works and is served.");
const OPERATIONS: Key = Key::or(
    "operations",
    Holds::Number(Quantity::at_least(NONE, 0.0)),
    "1",
    "Number of its operations, a whole number; a robot comes at the end of each.",
);
const DURATION: Key = Key::required(
    "duration",
    Holds::Spread(Quantity::above(TIME, 0.0)),
    "Duration of an operation: `250 s`, or `normal(204 s, 20 s)` with its mean and standard deviation.",
);
const WAIT_DISTANCE: Key = Key::or(
    "wait_distance",
    A_LENGTH,
    "1 m",
    "Distance from the agent at which a robot waits for the end of the operation.",
);
const APPROACH_WEIGHTS: Key = Key::or(
    "approach_weights",
    WEIGHTS,
    "1",
    "Weights of the energy near the agent: one for all operations, or a list with one for each.",
);
const APPROACHES: Key = Key::optional(
    "approaches",
    Holds::Of(Named::Member, EACH_APPROACH),
    "Exceptions for single robots, by the name of the robot.",
);
const EACH_APPROACH: &Holds = &Holds::Block(&APPROACH);

/// A person of a schedule.
pub static SCHEDULE_HUMAN: Section = Section {
    name: "a human of a schedule",
    keys: &[
        LABEL,
        PLACE,
        OPERATIONS,
        DURATION,
        Key::or(
            "severity",
            A_SHARE,
            "0",
            "Severity of the working conditions, from 0 to 1; a higher severity increases the effect of the person's \
             feedback.",
        ),
        WAIT_DISTANCE,
        Key::or(
            "wait_weights",
            WEIGHTS,
            "1",
            "Weights of the waits: one for all operations, or a list with one for each, `alpha`.",
        ),
        Key::or(
            "wait_limit",
            A_TIME,
            "60 s",
            "Limit of waits for a person whose feedback reduces the weight of waits: the time beyond the limit has at \
             least the initial weight. Feedback on waits changes the limit by `wait_step`.",
        ),
        APPROACH_WEIGHTS,
        APPROACHES,
    ],
};

/// A working robot of a schedule.
pub static SCHEDULE_WORKER: Section = Section {
    name: "a worker of a schedule",
    keys: &[
        LABEL,
        PLACE,
        OPERATIONS,
        DURATION,
        WAIT_DISTANCE,
        APPROACH_WEIGHTS,
        APPROACHES,
        Key::optional(
            "runs",
            Holds::Block(&RUNS),
            "The controller that it runs in scenarios. The duration of an operation is then what its machine makes of \
             it, and plans use `duration`.",
        ),
    ],
};

/// The controller of a working robot.
pub static RUNS: Section = Section {
    name: "what a worker runs",
    keys: &[
        Key::required("spec", Holds::Spec, "The spec of its controller, `\"picker.hq\"`, which has a machine."),
        Key::required(
            "go",
            Holds::Name(Named::SignalThere),
            "A signal of that spec, a flag: true while an operation goes on, false between two operations.",
        ),
        Key::required(
            "done",
            Holds::Name(Named::StateThere),
            "A state of its machine; the current operation ends when this state is entered.",
        ),
        Key::optional(
            "scenario",
            Holds::Text,
            "A scenario of that spec that defines the environment of the robot: its start, its simulator, people, \
             signals other than `go`, outcomes of actions. Its expectations and its duration are ignored. Default: no \
             events, and every action ends immediately.",
        ),
    ],
};

/// How one robot comes to an agent.
pub static APPROACH: Section = Section {
    name: "the approach of a robot",
    keys: &[
        Key::optional("speed", SPEEDS, "Range of its speed near this agent; default: the robot's."),
        Key::optional("wait_distance", A_LENGTH, "Distance at which it waits; default: the agent's."),
    ],
};
