//! All that is around a robot: obstacles that stay where they are, obstacles that move or come and go, and people, whose tracked
//! points are balls, joined by rows of balls along their links.
//!
//! Bodies that move are mocap bodies of MuJoCo: they are placed from outside at each time step, and nothing pushes them. Their
//! motion between two ticks is that of their velocity at the first one. A body that is absent, or at a place that is not known, is
//! far below everything.

use std::collections::BTreeSet;
use std::fmt::Write;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robot::{LinkId, Shape};
use runtime::physics::Around;
use runtime::program::{HumanScript, Program, ScenarioProgram, Tape, Times, no_body, varies};
use stdlib_tasks::obstacle::Obstacle;
use stdlib_tasks::slot::Slot;

use crate::geometry::{Geometries, Group};

/// Place of what is absent (m).
const AWAY: [f64; 3] = [0.0, 0.0, -1e4];

/// Most balls along a link of a person.
const MOST_BALLS: usize = 40;

/// A body that is placed at each step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moving {
    /// Obstacle of this index.
    Obstacle(usize),
    /// A ball between two points of a person: for each, the index of its signal, and the share of the second one.
    Ball([usize; 2], f64),
}

/// An obstacle that stays where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Its index.
    pub obstacle: usize,
    /// Link that carries it; `None` for the room.
    pub on: Option<LinkId>,
    /// Its pose in the frame of the link, or in the world.
    pub pose: Isometry3<f64>,
}

/// The surroundings of a robot.
pub struct Room {
    program: Program,
    person_radius: f64,
    standing: Vec<Standing>,
    moving: Vec<Moving>,
    tape: Tape,
    registers: Vec<f64>,
    inputs: Vec<f64>,
    values: Vec<f64>,
    rates: Vec<f64>,
    /// Position and velocity of each moving body at the last tick (m, m/s); `None` for one that is absent.
    motions: Vec<Option<Motion>>,
}

/// Motion of a body: pose as position and quaternion, and the rates of their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Motion {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    turn: Quaternion<f64>,
    turning: Quaternion<f64>,
}

impl Room {
    /// The surroundings of a program with obstacles where they truly are, and with the people of a scenario; nothing, if links
    /// touch nothing.
    pub fn new(truth: &Program, scenario: Option<&ScenarioProgram>, contacts: bool, person_radius: f64) -> Room {
        let mut room = Room {
            person_radius,
            standing: Vec::new(),
            moving: Vec::new(),
            tape: truth.values.tape.only(&BTreeSet::new()),
            registers: Vec::new(),
            inputs: Vec::new(),
            values: truth.values.initial.clone(),
            rates: vec![0.0; truth.values.initial.len()],
            motions: Vec::new(),
            program: truth.clone(),
        };
        if contacts {
            room.obstacles();
            let people = scenario.map_or(&[][..], |s| &s.world.humans);
            people.iter().for_each(|script| room.person(script));
        }
        let slots = |body: &Moving| match body {
            Moving::Obstacle(k) => truth.obstacles[*k].slots().collect(),
            Moving::Ball(..) => Vec::new(),
        };
        let places: BTreeSet<usize> =
            room.moving.iter().flat_map(slots).flat_map(|s: Slot| s.at..s.at + s.len).collect();
        room.tape = truth.values.tape.only(&places);
        room.registers = vec![0.0; room.tape.ops.len()];
        // A pose may depend on the time and on signals alone, which the compiler has checked.
        room.inputs = vec![f64::NAN; room.tape.inputs];
        room.motions = vec![None; room.moving.len()];
        room
    }

    fn obstacles(&mut self) {
        let Room { program, standing, moving, .. } = self;
        for (k, o) in program.obstacles.iter().enumerate().filter(|(_, o)| no_body(program, o).is_none()) {
            if o.slots().any(|slot| varies(program, slot)) {
                moving.push(Moving::Obstacle(k));
                continue;
            }
            let pose = pose(o, &program.values.initial).filter(|_| o.is_present(&program.values.initial));
            standing.extend(pose.map(|pose| Standing { obstacle: k, on: o.link, pose }));
        }
    }

    fn person(&mut self, script: &HumanScript) {
        let Some(human) = self.program.interface.humans.get(script.human) else { return };
        self.moving.extend(human.points.iter().map(|&point| Moving::Ball([point; 2], 0.0)));
        for &(a, b) in &human.links {
            let (Some(&from), Some(&to)) = (human.points.get(a), human.points.get(b)) else { continue };
            let count = balls_between(script, a, b, self.person_radius);
            let share = |k: usize| (k + 1) as f64 / (count + 1) as f64;
            self.moving.extend((0..count).map(|k| Moving::Ball([from, to], share(k))));
        }
    }

    /// Number of bodies that move.
    pub fn moving(&self) -> usize {
        self.moving.len()
    }

    /// Obstacles that stay where they are.
    pub fn standing(&self) -> &[Standing] {
        &self.standing
    }

    /// An obstacle.
    pub fn obstacle(&self, k: usize) -> &Obstacle {
        &self.program.obstacles[k]
    }

    /// Writes the obstacles that stay where they are in the room, or on a link. Meshes are added to `meshes`.
    pub fn write_standing(&self, on: Option<LinkId>, xml: &mut String, meshes: &mut String) {
        let group = if on.is_some() { Group::Carried } else { Group::Room };
        for Standing { obstacle: k, pose, .. } in self.standing.iter().filter(|s| s.on == on) {
            let mut geometries = Geometries::default();
            geometries.form(&format!("obstacle{k}"), pose, &self.obstacle(*k).form, group, on.is_some());
            let _ = writeln!(xml, "<body name=\"obstacle {k}\">\n{}</body>", geometries.geoms);
            *meshes += &geometries.meshes;
        }
    }

    /// Writes the bodies that move, in their order. Meshes are added to `meshes`.
    pub fn write_moving(&self, xml: &mut String, meshes: &mut String) {
        for body in &self.moving {
            let mut geometries = Geometries::default();
            let here = Isometry3::identity();
            match body {
                Moving::Obstacle(k) => {
                    geometries.form(&format!("obstacle{k}"), &here, &self.obstacle(*k).form, Group::Room, true);
                }
                Moving::Ball(..) => {
                    geometries.shape("", &here, &Shape::Sphere { radius: self.person_radius }, Group::Room);
                }
            }
            let [x, y, z] = AWAY;
            let _ = writeln!(xml, "<body pos=\"{x} {y} {z}\" mocap=\"true\">\n{}</body>", geometries.geoms);
            *meshes += &geometries.meshes;
        }
    }

    /// Computes where everything is at a tick, and how it moves; `None` for a tick at which nothing that moves is there.
    pub fn tick(&mut self, around: Option<&Around>) {
        let Some(around) = around else {
            self.motions.fill(None);
            return;
        };
        let Room { program, moving, tape, registers, inputs, values, rates, motions, .. } = self;
        let times = Times { t: f64::NAN, time: around.time };
        tape.evaluate(times, inputs, around.signals, registers, values, rates);
        for (body, motion) in moving.iter().zip(motions) {
            *motion = match body {
                Moving::Obstacle(k) => of_obstacle(&program.obstacles[*k], values, rates),
                Moving::Ball(points, share) => of_ball(program, around.signals, *points, *share),
            };
        }
    }

    /// Writes the position and the orientation of each moving body at so many seconds after the tick.
    pub fn place(&self, after: f64, positions: &mut [f64], orientations: &mut [f64]) {
        let places = positions.chunks_exact_mut(3).zip(orientations.chunks_exact_mut(4));
        for (motion, (position, orientation)) in self.motions.iter().zip(places) {
            let Some(m) = motion else {
                position.copy_from_slice(&AWAY);
                continue;
            };
            position.copy_from_slice((m.position + m.velocity * after).as_slice());
            let turn = UnitQuaternion::new_normalize(m.turn + m.turning * after);
            orientation.copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        }
    }
}

/// Number of balls between two points of a person, so many that no two are farther apart than their radius.
fn balls_between(script: &HumanScript, a: usize, b: usize, radius: f64) -> usize {
    let (Some(a), Some(b)) = (script.tracks.get(a), script.tracks.get(b)) else { return 0 };
    // Between two waypoints, the distance of two points on straight lines is largest at one of both.
    let times = a.0.iter().chain(&b.0).map(|waypoint| waypoint.0);
    let length = times.map(|t| (Vector3::from(a.at(t).0) - Vector3::from(b.at(t).0)).norm()).fold(0.0, f64::max);
    ((length / radius).ceil().max(1.0) as usize - 1).min(MOST_BALLS)
}

/// Numbers of a slot.
fn numbers(slot: Slot, table: &[f64]) -> &[f64] {
    table.get(slot.at..slot.at + slot.len).unwrap_or_default()
}

/// Pose of an obstacle in its frame; `None` if it is not known.
fn pose(o: &Obstacle, values: &[f64]) -> Option<Isometry3<f64>> {
    let &[x, y, z] = numbers(o.position, values) else { return None };
    let &[w, i, j, k] = numbers(o.orientation, values) else { return None };
    let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-12)?;
    let finite = [x, y, z, w, i, j, k].into_iter().all(f64::is_finite);
    finite.then(|| Isometry3::from_parts(Translation3::new(x, y, z), turn))
}

/// Motion of an obstacle in the room; `None` while it is absent.
fn of_obstacle(o: &Obstacle, values: &[f64], rates: &[f64]) -> Option<Motion> {
    let at = pose(o, values).filter(|_| o.is_present(values))?;
    let number = |table: &[f64], slot, i: usize| {
        numbers(slot, table).get(i).copied().filter(|x: &f64| x.is_finite()).unwrap_or(0.0)
    };
    let quaternion = |part: &dyn Fn(usize) -> f64| Quaternion::new(part(0), part(1), part(2), part(3));
    Some(Motion {
        position: at.translation.vector,
        velocity: Vector3::from_fn(|i, _| number(rates, o.position, i)),
        turn: quaternion(&|i| number(values, o.orientation, i)),
        turning: quaternion(&|i| number(rates, o.orientation, i)),
    })
}

/// Motion of a ball of a person; `None` if one of its points is not known.
fn of_ball(program: &Program, signals: &[f64], points: [usize; 2], share: f64) -> Option<Motion> {
    let of = |at: usize| {
        let three = signals.get(at..at + 3).map(Vector3::from_column_slice)?;
        three.iter().all(|x| x.is_finite()).then_some(three)
    };
    let point = |index: usize| {
        let signal = program.interface.signals.get(index)?;
        Some((of(signal.at + 1)?, of(signal.velocity_at()).unwrap_or_default()))
    };
    let ((a, va), (b, vb)) = (point(points[0])?, point(points[1])?);
    Some(Motion {
        position: a + (b - a) * share,
        velocity: va + (vb - va) * share,
        turn: Quaternion::identity(),
        turning: Quaternion::new(0.0, 0.0, 0.0, 0.0),
    })
}
