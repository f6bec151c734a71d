//! Slows parts of the robot that move towards a person, so that they come to rest before they are too near.
//!
//! ```text
//! S_p(v_r) = v_h (T_r + T_s) + v_r T_r + S_s(v_r) + C + Z_d + Z_r     [m]    ISO/TS 15066:2016, 5.5.4.2.3
//! n·J_p v >= -v_max(d)     S_p(v_max(d)) = d                          [m/s]  n from the person to the part
//! ```
//!
//! Its outputs (`OUTPUTS`) allow a machine to stop and to continue. With `method watch` the task has outputs only.
//!
//! `S_p` rises with `v_r`, so `d >= S_p` is a bound on the speed towards the person, in closed form: the barrier for
//! `d - S_p`, whose row is met as soon as it is written and needs no gain.

use nalgebra::{Isometry3, Vector3};
use robot::{Shape, geometry};

use crate::bound::{Bound, BoundParams, Geometry};
use crate::build::check;
use crate::dimension::{ACCELERATION, LENGTH, TIME, VELOCITY};
use crate::field::{SpeedAndSeparation, Stopping};
use crate::params::{Input, ParamType, Presence, Quantity};
use crate::protection::{Hazard, Protection};
use crate::slot::Slot;
use crate::task::{
    BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind, TaskOutput,
};
use quantities::usual;

crate::params! {
    /// Parameters of `speed_separation`.
    pub struct Params {
        /// The parts of the robot: points, segments, links with their collision shapes, groups of them.
        parts: Vec<Geometry> = ParamType::Geometries, Presence::Required;
        /// Position of the person in the world; its time derivative is the velocity of the person.
        from: Input<3> = ParamType::Vector(LENGTH), Presence::Required;
        /// `slow` bounds the speed of the parts; `watch` does not bound it and only computes the outputs, for a machine
        /// that stops the robot.
        method: String = ParamType::Choice(&["slow", "watch"]), Presence::Default("slow");
        /// Speed of the person: `assumed` uses `human_speed`, `measured` the time derivative of `from`. If the human
        /// has `velocity none`, this derivative is zero, so `measured` assumes that the person stands still.
        human: String = ParamType::Choice(&["assumed", "measured"]), Presence::Default("assumed");
        /// v_h: assumed speed of the person towards the robot; 1.6 m/s is the walking speed of ISO 13855.
        human_speed: Input<1> = ParamType::Scalar(Quantity { min_included: true, ..usual::WALKING_SPEED }), Presence::Default("1.6 m/s");
        /// T_r: time from the reading until the robot begins to stop. The task adds one control period, with `watch`
        /// two.
        reaction: Input<1> = ParamType::Scalar(Quantity::at_least(TIME, 0.0).usually(1e-4, 20.0).constant()), Presence::Required;
        /// T_s: time until the robot stands, at any speed.
        stopping: Option<Input<1>> = ParamType::Scalar(Quantity::at_least(TIME, 0.0).usually(1e-4, 60.0).constant()), Presence::Optional;
        /// a: instead of `stopping`, the smallest deceleration of the parts.
        deceleration: Option<Input<1>> = ParamType::Scalar(Quantity::above(ACCELERATION, 0.0).usually(0.01, 1e3).constant()), Presence::Optional;
        /// C: intrusion distance of ISO 13855, how far a part of the body reaches before it is detected.
        intrusion: Input<1> = ParamType::Scalar(usual::CLEARANCE.constant()), Presence::Required;
        /// Z_d: uncertainty of the person's position; it may move, as `uncertainty(operator)` does.
        human_uncertainty: Input<1> = ParamType::Scalar(Quantity::at_least(LENGTH, 0.0).usually(1e-6, 10.0)), Presence::Default("0 m");
        /// Z_r: uncertainty of the robot's position.
        robot_uncertainty: Input<1> = ParamType::Scalar(Quantity::at_least(LENGTH, 0.0).usually(1e-6, 10.0).constant()), Presence::Default("0 m");
    }
}

/// Outputs of the task.
const OUTPUTS: [TaskOutput; 4] = [
    TaskOutput {
        name: "distance",
        dimension: LENGTH,
        description: "d of the part with the smallest excess over `required`",
    },
    TaskOutput {
        name: "required",
        dimension: LENGTH,
        description: "S_p of that part, at the velocity that the hierarchy returned",
    },
    TaskOutput {
        name: "room",
        dimension: LENGTH,
        description: "smallest excess of d over the S_p of a robot at rest, of all parts; below zero the robot must stop",
    },
    TaskOutput { name: "speed_limit", dimension: VELOCITY, description: "smallest v_max of all parts" },
];

/// The velocity of people is measured unless it is assumed.
const PERSON_VELOCITY: PersonVelocityUse = PersonVelocityUse {
    uses_rate: |_, params| !matches!(params.get("human"), Some(Bound::Choice(human)) if human == "assumed"),
    consequence: "the required distance does not include the person's motion",
    alternative: Some("`human assumed` here"),
};

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "speed_separation",
    summary: "limits the speed of parts of the robot towards a person, so that they can stop in time",
    docs: "Speed and separation monitoring: the distance `d` between a part and the person must not be less than \
the protective separation distance\n\n\
```text\n\
S_p = S_h + S_r + S_s + C + Z_d + Z_r      [m]\n\
S_h = v_h (T_r + T_s)      the person, until the robot stands\n\
S_r = v_r T_r              the robot, until it begins to stop\n\
S_s = v_r T_s              the robot, until it stands; with `deceleration a`: v_r^2 / (2 a), and T_s = v_r / a\n\
```\n\n\
with the speeds `v_h`, `v_r` [m/s] of person and robot towards each other; a speed away from each other counts \
as zero. `S_p` increases with `v_r`, so this is a bound on that speed, `v_r <= v_max(d)` with `S_p(v_max) = d`. \
It gives one inequality row for each part:\n\n\
```text\n\
n·J_p v  >=  -v_max(d)     [m/s]\n\n\
d      m                   distance between the part and the person\n\
n      3×1                 unit vector in the world, from the person to the nearest point p of the part\n\
J_p    3×n  m/rad or m/m   Jacobian of p in the world's axes\n\
v      n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
v_max  m/s                 largest speed towards the person\n\
```\n\n\
The row needs no gain, and zero velocity always meets it: on a hard level, this row by itself is never \
infeasible. If even a robot at rest is too close, `v_max` is zero: the part may move away from the person, but \
no nearer. The margin is `d - S_p` at the velocity that the hierarchy returned.\n\n\
For a protective stop, a machine changes to a state in which the robot stands, and back when there is room:\n\n\
```text\n\
state work  { stack working   when separation.room < 0 m -> stop blend 0 s }\n\
state stop  { stack standing  when separation.room > 0.2 m for 0.5 s -> work }\n\
```\n\n\
Both stacks must contain the task: its outputs are absent while no stack with it runs. While the row of `slow` \
is active, `d` equals `S_p` up to rounding, so only `room` is suitable for a condition. With `method watch` the \
robot moves without a bound until `when separation.distance < separation.required -> stop`. A condition is \
evaluated one tick later than the row, so `T_r` includes a second control period. A machine may also handle a \
negative margin with `on fault(limit(TASK)) -> ..`.\n\n\
`T_s` and `a` refer to the whole stop. A transition with a `blend` changes the velocity over that time, which \
must be included in `stopping`.\n\n\
The task protects a person from a robot that moves. It does not move the robot out of the way: for that, `keep` \
a distance or the value of a safety field. The person is a point; for several points, write the task in a `for`. \
Parts that are not named are not monitored.\n\n\
The result is as accurate as the given distances and times, and the standard requires a rated controller and \
rated sensors: this is a rule of motion, not a safety function.\n\n\
Source: ISO/TS 15066:2016, 5.5.4.2.3, formulas (1) to (4); ISO 13855 for `human_speed` and `intrusion`. The row in \
closed form is ours.",
    example: "task slow = speed_separation(left_elbow) { from [2, 0, 1] m  reaction 0.1 s  deceleration 3 m/s^2  intrusion 0.1 m }",
    positional: &["parts"],
    outputs: &OUTPUTS,
    person_velocity: Some(&PERSON_VELOCITY),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

/// A part, and its separation from the person.
struct Part {
    geometry: Geometry,
    /// Direction from the person to the part, in the world; `None` before one was found.
    normal: Option<Vector3<f64>>,
    /// d of this tick, in m.
    distance: f64,
    /// v_h of this tick, in m/s.
    human: f64,
}

struct SpeedSeparation {
    parts: Vec<Part>,
    from: Input<3>,
    measured: bool,
    /// True if it bounds the speed; otherwise it has outputs only.
    slows: bool,
    human_speed: Input<1>,
    human_uncertainty: Input<1>,
    rule: SpeedAndSeparation,
    /// Rows of this tick, `nv` numbers each.
    jacobian: Vec<f64>,
    nv: usize,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.parts.is_empty() {
        return Err(BuildError::new("parts", "no part of the robot is named that could be slowed")
            .help("name points, segments, links or groups of them, or remove the task"));
    }
    let one = |input: Input<1>| input.of(ctx.values)[0];
    let stopping = match (params.stopping, params.deceleration) {
        (Some(time), None) => Stopping::Time(one(time)),
        (None, Some(a)) => Stopping::Deceleration(one(a)),
        (Some(_), Some(_)) => {
            return Err(BuildError::new("stopping", "how the robot stops is said twice")
                .help("keep one of `stopping`, a time, and `deceleration`"));
        }
        (None, None) => {
            return Err(BuildError::new("", "`speed_separation` does not say how the robot stops")
                .help("write `stopping 0.3 s`, a time for any speed, or `deceleration 3 m/s^2`"));
        }
    };
    let measured = match params.human.as_str() {
        "measured" => true,
        "assumed" => false,
        _ => return Err(BuildError::new("human", "`human` is `assumed` or `measured`")),
    };
    let slows = match params.method.as_str() {
        "slow" => true,
        "watch" => false,
        _ => return Err(BuildError::new("method", "`method` is `slow` or `watch`")),
    };
    // The distance of a tick is used until the next one; a machine acts on it one more tick later.
    let reaction = one(params.reaction) + ctx.period * if slows { 1.0 } else { 2.0 };
    // Z_d may move, and is subtracted from the distance at each tick.
    let rule = SpeedAndSeparation::new(reaction, stopping, one(params.intrusion), 0.0, one(params.robot_uncertainty))
        .map_err(|e| BuildError::new("", e.to_string()))?;
    let nv = ctx.model.nv();
    let part = |geometry| Part { geometry, normal: None, distance: f64::INFINITY, human: 0.0 };
    let parts: Vec<Part> = params.parts.into_iter().map(part).collect();
    Ok(Box::new(SpeedSeparation {
        jacobian: vec![0.0; nv * parts.len()],
        parts,
        from: params.from,
        measured,
        slows,
        human_speed: params.human_speed,
        human_uncertainty: params.human_uncertainty,
        rule,
        nv,
    }))
}

impl SpeedSeparation {
    /// S_p of a part for its speed away from the person, in m.
    fn required(&self, part: &Part, away: f64, uncertainty: f64) -> f64 {
        uncertainty + self.rule.distance(-away, part.human).0
    }

    /// v_max of a part, in m/s.
    fn allowed(&self, part: &Part, uncertainty: f64) -> f64 {
        self.rule.allowed_speed(part.distance - uncertainty, part.human).unwrap_or(0.0)
    }

    /// Parts, each with its speed away from the person in m/s when the robot moves with `v`.
    fn moving<'t>(&'t self, v: &'t [f64]) -> impl Iterator<Item = (&'t Part, f64)> {
        let away = move |row: &[f64]| row.iter().zip(v).map(|(j, v)| j * v).sum();
        self.parts.iter().zip(self.jacobian.chunks_exact(self.nv.max(1)).map(away))
    }
}

impl Task for SpeedSeparation {
    fn rows(&self) -> Vec<RowInfo> {
        self.parts.iter().map(|p| RowInfo { name: p.geometry.name.clone(), dimension: LENGTH }).collect()
    }

    fn protections(&self) -> Vec<Protection> {
        let from = vec![Slot { at: self.from.at, len: 3 }];
        let one = |p: &Part| Protection { links: vec![p.geometry.link], hazard: Hazard::Points(from.clone()) };
        self.parts.iter().filter(|_| self.slows).map(one).collect()
    }

    fn enter(&mut self, _state: &State) {
        self.parts.iter_mut().for_each(|p| p.normal = None);
    }

    crate::task::takes_over!(parts);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let (at, speed) = (Vector3::from(self.from.of(state.values)), Vector3::from(self.from.of(state.rates)));
        let ([assumed], [uncertainty]) = (self.human_speed.of(state.values), self.human_uncertainty.of(state.values));
        let person = Isometry3::translation(at.x, at.y, at.z);
        for i in 0..self.parts.len() {
            let part = &mut self.parts[i];
            let link = part.geometry.link;
            let pose = state.data.pose(link) * part.geometry.origin;
            let known = pose.translation.vector.iter().chain(&at).chain(&speed).all(|x| x.is_finite());
            if !known || !(assumed + uncertainty).is_finite() {
                return Err(TaskFault::NotFinite { row: i });
            }
            let here = Shape::Sphere { radius: 0.0 };
            let (point, normal) = match geometry::closest(&part.geometry.shape, &pose, &here, &person) {
                Ok(way) => {
                    part.distance = way.distance;
                    (way.on_a, way.normal)
                }
                // The person is inside the part, which leaves no direction: the last valid one is used.
                Err(_) => {
                    part.distance = 0.0;
                    (at, part.normal.ok_or(TaskFault::Overlap { row: i })?)
                }
            };
            part.normal = Some(normal);
            part.human = if self.measured { normal.dot(&speed) } else { assumed };
            let row = &mut self.jacobian[i * self.nv..(i + 1) * self.nv];
            row.fill(0.0);
            state.data.add_point(state.model, link, &point, &normal, row);
            let away: f64 = row.iter().zip(state.velocity).map(|(j, v)| j * v).sum();
            rows.row(i)[..self.nv].copy_from_slice(row);
            let part = &self.parts[i];
            if self.slows {
                rows.lower[i] = -self.allowed(part, uncertainty);
            }
            rows.margins[i] = part.distance - self.required(part, away, uncertainty);
        }
        Ok(())
    }

    fn observe(&self, state: &State, v: &[f64], margins: &mut [f64], _measures: &mut [f64]) {
        let [uncertainty] = self.human_uncertainty.of(state.values);
        for (margin, (part, away)) in margins.iter_mut().zip(self.moving(v)) {
            *margin = part.distance - self.required(part, away, uncertainty);
        }
    }

    fn write_outputs(&self, state: &State, v: &[f64], out: &mut [f64]) {
        let [uncertainty] = self.human_uncertainty.of(state.values);
        let [distance, required, room, speed_limit] = out else { return };
        [*distance, *required, *room, *speed_limit] = [f64::INFINITY; 4];
        let mut least = f64::INFINITY;
        for (part, away) in self.moving(v) {
            let needed = self.required(part, away, uncertainty);
            if part.distance - needed < least {
                least = part.distance - needed;
                [*distance, *required] = [part.distance, needed];
            }
            *room = room.min(part.distance - self.required(part, 0.0, uncertainty));
            *speed_limit = speed_limit.min(self.allowed(part, uncertainty));
        }
    }
}
