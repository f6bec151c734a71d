//! Bounds of the time and of the way that the robot needs to come to rest while a stack runs, from the largest speeds that this stack allows.
//!
//! A joint that moves at `v_max` and brakes with `a_max`, for decisions every T, with the lag L and the dead time D of its drives, needs at most
//!
//! ```text
//! t_brake = v_max/a_max + T                                     T if nothing limits its acceleration
//! t       = T + t_brake + D + L ln 100
//! way     = v_max (T + t_brake/2 + D + L)
//! ```
//!
//! A call for a stop waits for the next decision, up to T. Decisions then lower the velocity by `a_max T`, the last one by what is left, and
//! commands are ramps between them. A drive with a lag goes on by `L v`, and its velocity falls to a hundredth of what it was in `L ln 100`.
//!
//! `v_max` is the least limit on hard levels, or that of the robot; `a_max` that of the stack's `joint_acceleration_limits`, or that of the
//! URDF. A robot that is to stop at once is braked by its host: its commands have no `a_max`. A point of a link moves at most by the sum of
//! `r_j way_j` over the joints that carry it, with the lever `r_j` of joint j, its largest distance from the axis at any posture.
//!
//! Joints brake independently in these bounds. A limit of a distance that shapes the braking can make a joint wait for a slower one.
//! Source: ours.

use std::collections::BTreeSet;

use nalgebra::Isometry3;
use robot::{LinkId, Shape};
use serde::Serialize;
use stdlib_tasks::bound::Geometry;
use stdlib_tasks::gradient_bound;

use crate::evaluator::build_tasks;
use crate::program::{MachineProgram, Program, StackProgram};

/// Share of its velocity below which a drive with a lag counts as at rest.
const AT_REST: f64 = 0.01;

/// Bounds of a stop while a stack runs. Infinite where nothing limits the speed; JSON then has `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stopping {
    /// Name of the stack.
    pub stack: String,
    /// Paths of the states of the machine in which it runs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<String>,
    /// Longest time of its joints, in s.
    pub time_s: f64,
    /// Degrees of freedom that the stack does not lock.
    pub joints: Vec<JointStop>,
    /// The tips of arms and the links that safety fields watch; the link that moves furthest if there are none of these.
    pub links: Vec<LinkStop>,
}

/// Stop of a degree of freedom.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointStop {
    /// Its name.
    pub joint: String,
    /// Unit of the way: `rad` or `m`.
    pub unit: &'static str,
    /// Largest speed, in `unit/s`.
    pub speed: f64,
    /// Deceleration, in `unit/s^2`; infinite if nothing limits it.
    pub deceleration: f64,
    /// Largest time to rest, in s.
    pub time_s: f64,
    /// Largest way to rest, in `unit`.
    pub way: f64,
}

/// Stop of a link.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkStop {
    /// Its name.
    pub link: String,
    /// Largest way of its origin in the world, in m.
    pub way_m: f64,
}

/// Returns the bounds for all stacks of a program whose tasks can be built.
pub fn of_stacks(program: &Program) -> Vec<Stopping> {
    (0..program.stacks.len()).filter_map(|stack| of_stack(program, stack)).collect()
}

/// Returns the bounds for a stack. `None` if there is no such stack, or its tasks cannot be built.
pub fn of_stack(program: &Program, index: usize) -> Option<Stopping> {
    let stack = program.stacks.get(index)?;
    let joints = joints(program, stack)?;
    let mut ways = vec![0.0; program.robot.model.nv()];
    let free = (0..ways.len()).filter(|dof| !stack.locked.contains(dof));
    free.zip(&joints).for_each(|(dof, joint)| ways[dof] = joint.way);
    Some(Stopping {
        stack: stack.name.clone(),
        states: program.machine.as_ref().map(|machine| states(machine, index)).unwrap_or_default(),
        time_s: joints.iter().map(|j| j.time_s).fold(0.0, f64::max),
        joints,
        links: links(program, &ways),
    })
}

/// Stops of the degrees of freedom that a stack does not lock, in the order of the model.
fn joints(program: &Program, stack: &StackProgram) -> Option<Vec<JointStop>> {
    let robot = &program.robot;
    let mut speed: Vec<f64> = robot.model.dofs.iter().map(|d| d.velocity).collect();
    let mut deceleration = vec![f64::INFINITY; speed.len()];
    for built in build_tasks(program, stack) {
        // The last task of a hard level receives the limits of all of them.
        speed.iter_mut().zip(&built.speed).for_each(|(own, limit)| *own = own.min(*limit));
        for (dof, limit) in built.task.ok()?.acceleration_limits() {
            deceleration[dof] = deceleration[dof].min(limit);
        }
    }
    let period = robot.period;
    let one = |(dof, d): (usize, &robot::Dof)| {
        let speed = speed[dof];
        let deceleration = match deceleration[dof] {
            _ if robot.stops_at_once => f64::INFINITY,
            own if own.is_finite() => own,
            _ => d.acceleration,
        };
        // An infinite speed without a limit of the acceleration ends in a tick too.
        let braking = period + if deceleration.is_finite() { speed / deceleration } else { 0.0 };
        JointStop {
            joint: d.name.clone(),
            unit: d.unit.select("m", "rad"),
            speed,
            deceleration,
            time_s: period + braking + robot.dead_time + robot.lag * (1.0 / AT_REST).ln(),
            way: speed * (period + 0.5 * braking + robot.dead_time + robot.lag),
        }
    };
    let free = robot.model.dofs.iter().enumerate().filter(|(dof, _)| !stack.locked.contains(dof));
    Some(free.map(one).collect())
}

/// Paths of the states in which a stack runs, alone or as a part of it.
fn states(machine: &MachineProgram, stack: usize) -> Vec<String> {
    let stack_of = |state: usize| machine.states.get(state).and_then(|s| s.stack);
    let parts = machine.merged.iter().find(|m| m.stack == stack).map_or(&[][..], |m| &m.parts);
    let adds = |state: usize| machine.region_owner(state).and_then(stack_of).is_some_and(|own| parts.contains(&own));
    let runs = |state: &usize| {
        machine.states[*state].initial.is_none()
            && (machine.stack_of(&machine.owners(*state)) == Some(stack) || adds(*state))
    };
    (0..machine.states.len()).filter(runs).map(|state| machine.states[state].name.clone()).collect()
}

/// Stops of the links that are watched, for the largest way of each degree of freedom.
fn links(program: &Program, ways: &[f64]) -> Vec<LinkStop> {
    let model = &program.robot.model;
    let stop = |link: LinkId| {
        let origin =
            Geometry { name: String::new(), link, origin: Isometry3::identity(), shape: Shape::Sphere { radius: 0.0 } };
        let levers = gradient_bound::over_world(model, &origin);
        // A lever without a bound, on a base that does not move, adds nothing.
        let moved = ways.iter().zip(&levers).filter(|(way, lever)| **way > 0.0 && **lever > 0.0);
        let way_m = moved.map(|(way, lever)| way * lever).sum();
        LinkStop { link: model.link_ref(link).name.clone(), way_m }
    };
    let tips = program.robot.arms.iter().map(|arm| arm.tip);
    let mut seen = BTreeSet::new();
    let fields = program.fields.iter().flat_map(|field| field.links.iter().copied());
    let watched: Vec<LinkId> = tips.chain(fields).filter(|link| seen.insert(*link)).collect();
    if watched.is_empty() {
        let all = (0..model.links.len()).map(|i| stop(LinkId(i as u32)));
        return all.reduce(|a, b| if b.way_m > a.way_m { b } else { a }).into_iter().collect();
    }
    watched.into_iter().map(stop).collect()
}
