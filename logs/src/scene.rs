//! The surroundings of a robot as markers: walls, volumes to keep out of, obstacles, people, and the closest points of each
//! limit on distances, with a line in the colour of its margin.
//!
//! A limit is recognised by the form of its parameters, not by its type: parts against three points of a plane, against other
//! parts, against obstacles, or against a point. Poses and distances are computed from the configuration and the signals that the log holds;
//! values that depend on how a stack was entered are not among these, and their lines are grey.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use robot::geometry::{closest, closest_plane};
use robot::{Closest, Data, LinkId, Model};
use runtime::Program;
use runtime::program::{HumanProgram, Times};
use stdlib_tasks::bound::{Bound, BoundParams, Geometry, Obstacle, Slot};
use stdlib_tasks::obstacle::{Form, PlacedObstacle};

use crate::markers::{Drawn, Marker, OBSTACLE, PERSON, UNKNOWN, WALL, of_margin, of_shape};
use crate::snapshot::Snapshot;

/// Frame of the room.
const WORLD: &str = "world";
/// Edge length of the part of a plane that is drawn, in m.
const PLANE: f64 = 2.0;
/// Lines of a limit that are drawn: those of the smallest distances.
const LINES: usize = 8;
/// Width of a line, in m.
const LINE: f64 = 0.006;
/// Most elements of a cloud or a surface that are drawn, and the radius of their balls where it is less (m).
const CORNERS: usize = 500;
const CORNER: f64 = 0.005;
/// Diameter of a point of a person, in m.
const PERSON_POINT: f64 = 0.12;

/// Hazard that a limit keeps parts of the robot away from.
enum Hazard {
    Plane { at: Vector3<f64>, normal: Vector3<f64>, on: Option<LinkId> },
    Parts(Vec<[Geometry; 2]>),
    Obstacles(Vec<Obstacle>),
    Point(Slot),
}

/// A limit that is drawn.
struct Limit {
    name: String,
    /// Index of its margin in a row.
    column: usize,
    parts: Vec<Geometry>,
    hazard: Hazard,
    distance: Option<Slot>,
}

/// A limit of a run: its name, its parameters, names of its rows, and the index of its margin in a row of the log.
pub struct Source<'p> {
    /// Name of the task.
    pub name: &'p str,
    /// Bound parameters.
    pub params: &'p BoundParams,
    /// Names of its rows.
    pub rows: BTreeSet<&'p str>,
    /// Index of its margin.
    pub column: usize,
}

/// The surroundings.
pub struct Scene {
    program: Program,
    /// Name of the frame of the room.
    world: String,
    data: Data,
    limits: Vec<Limit>,
    tape: runtime::program::Tape,
    registers: Vec<f64>,
    inputs: Vec<f64>,
    values: Vec<f64>,
    rates: Vec<f64>,
}

fn slot(params: &BoundParams, name: &str, len: usize) -> Option<Slot> {
    match params.get(name) {
        Some(Bound::Value(slot)) if slot.len == len => Some(*slot),
        _ => None,
    }
}

fn geometries(params: &BoundParams, name: &str) -> Option<Vec<Geometry>> {
    match params.get(name) {
        Some(Bound::Geometries(all)) => Some(all.clone()),
        _ => None,
    }
}

fn three(values: &[f64], at: usize) -> Option<Vector3<f64>> {
    let v = values.get(at..at + 3).map(Vector3::from_column_slice)?;
    v.iter().all(|x| x.is_finite()).then_some(v)
}

/// The limit of a task, if it is one on distances.
fn limit(source: &Source, program: &Program) -> Option<Limit> {
    let params = source.params;
    let first = params.values().find_map(|b| match b {
        Bound::Geometries(all) => Some(all.clone()),
        _ => None,
    });
    let obstacles = params.values().find_map(|b| match b {
        Bound::Obstacles(all) => Some(all.clone()),
        _ => None,
    });
    let (parts, hazard) = if let Some(plane) = slot(params, "through", 9) {
        let point = |i: usize| three(&program.values.initial, plane.at + 3 * i);
        let (a, b, c) = (point(0)?, point(1)?, point(2)?);
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-12)?;
        let on = match params.get("on") {
            Some(Bound::Frame(_, link)) => Some(*link),
            _ => None,
        };
        (first?, Hazard::Plane { at: a, normal, on })
    } else if let Some(obstacles) = obstacles {
        (first?, Hazard::Obstacles(obstacles))
    } else if let Some(between) = geometries(params, "between") {
        let others = geometries(params, "and").unwrap_or_else(|| between.clone());
        let row = |a: &Geometry, b: &Geometry| source.rows.contains(format!("{} to {}", a.name, b.name).as_str());
        let pair = |a: &Geometry, b: &Geometry| row(a, b).then(|| [a.clone(), b.clone()]);
        let pairs = between.iter().flat_map(|a| others.iter().filter_map(move |b| pair(a, b))).collect();
        (others, Hazard::Parts(pairs))
    } else {
        (first?, Hazard::Point(slot(params, "from", 3)?))
    };
    let distance = slot(params, "d_min", 1);
    Some(Limit { name: source.name.to_string(), column: source.column, parts, hazard, distance })
}

/// Places of the table of values that the scene reads.
fn places(limits: &[Limit], obstacles: &[Obstacle]) -> BTreeSet<usize> {
    let of_limits = limits.iter().flat_map(|l| {
        let point = match &l.hazard {
            Hazard::Point(slot) => Some(*slot),
            _ => None,
        };
        let own = match &l.hazard {
            Hazard::Obstacles(all) => all.iter().flat_map(Obstacle::slots).collect(),
            _ => Vec::new(),
        };
        own.into_iter().chain(point).chain(l.distance)
    });
    let all = of_limits.chain(obstacles.iter().flat_map(Obstacle::slots));
    all.flat_map(|s| s.at..s.at + s.len).collect()
}

impl Scene {
    /// Prepares the surroundings of a program.
    pub fn new(program: &Program, sources: &[Source]) -> Scene {
        let limits: Vec<Limit> = sources.iter().filter_map(|s| limit(s, program)).collect();
        let tape = program.values.tape.only(&places(&limits, &program.obstacles));
        Scene {
            data: Data::new(&program.robot.model),
            registers: vec![0.0; tape.ops.len()],
            // Values of how a stack was entered are not recorded.
            inputs: vec![f64::NAN; tape.inputs],
            values: program.values.initial.clone(),
            rates: vec![0.0; program.values.initial.len()],
            tape,
            limits,
            world: WORLD.to_string(),
            program: program.clone(),
        }
    }

    /// Poses of the links at the last tick.
    pub fn data(&self) -> &Data {
        &self.data
    }

    /// The frame of the room.
    pub fn world(&self) -> &str {
        &self.world
    }

    /// Names the frame of the room.
    pub fn name_world(&mut self, name: &str) {
        self.world = name.to_string();
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.program.robot.model
    }

    /// The table of signals in which all are absent.
    pub fn absent_signals(&self) -> Vec<f64> {
        self.program.interface.absent()
    }

    /// Computes poses and values of a tick.
    pub fn update(&mut self, tick: &Snapshot) {
        let nq = self.program.robot.model.nq();
        if let Some(q) = tick.row.get(1..1 + nq) {
            self.program.robot.model.forward(q, &mut self.data);
        }
        let times = Times { t: f64::NAN, time: tick.time };
        let Scene { tape, inputs, registers, values, rates, .. } = self;
        tape.evaluate(times, inputs, &tick.signals, registers, values, rates);
    }

    fn frame(&self, link: Option<LinkId>) -> &str {
        link.map_or(&self.world, |l| self.program.robot.model.link_ref(l).name.as_str())
    }

    /// Walls, in the frames that carry them.
    pub fn walls(&self) -> Vec<Marker> {
        let wall = |limit: &Limit| {
            let Hazard::Plane { at, normal, on } = &limit.hazard else { return None };
            // The part of the plane near the robot is drawn.
            let stands = if on.is_none() { self.program.robot.stands_at() } else { Vector3::zeros() };
            let place = stands - normal * normal.dot(&(stands - at));
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), normal)
                .unwrap_or_else(|| UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI));
            let pose = Isometry3::from_parts(place.into(), turn);
            let size = Drawn::Cube(Vector3::new(PLANE, PLANE, 0.004));
            Some(Marker::new(self.frame(*on), &limit.name, 0, size, pose, WALL))
        };
        self.limits.iter().filter_map(wall).collect()
    }

    /// Volumes that other parts of the robot keep out of: parts expanded by the distance of their limit.
    pub fn keep_out(&self) -> Vec<Marker> {
        let mut all = Vec::new();
        for limit in &self.limits {
            let Hazard::Parts(_) = limit.hazard else { continue };
            let by = limit.distance.and_then(|s| self.program.values.initial.get(s.at).copied()).unwrap_or(0.0);
            for (i, part) in limit.parts.iter().enumerate() {
                let place = |id: usize, drawn: Drawn, pose: Isometry3<f64>| {
                    Marker::new(self.frame(Some(part.link)), &limit.name, 3 * i + id, drawn, pose, WALL)
                };
                all.extend(of_shape(&part.shape, by, &part.origin, place));
            }
        }
        all
    }

    fn pose(&self, obstacle: &Obstacle) -> Option<Isometry3<f64>> {
        let at = three(&self.values, obstacle.position.at)?;
        let q = self.values.get(obstacle.orientation.at..obstacle.orientation.at + 4)?;
        let turn = UnitQuaternion::try_new(Quaternion::new(q[0], q[1], q[2], q[3]), 1e-12)?;
        (obstacle.is_present(&self.values)).then(|| Isometry3::from_parts(at.into(), turn))
    }

    /// Obstacles where the controller takes them to be; an absent one is removed.
    pub fn obstacles(&self) -> Vec<Marker> {
        let mut all = Vec::new();
        for o in &self.program.obstacles {
            let place = |id: usize, drawn: Drawn, pose: Isometry3<f64>| {
                Marker::new(self.frame(o.link), &o.name, id, drawn, pose, OBSTACLE)
            };
            let pose = self.pose(o);
            let here = pose.unwrap_or_default();
            let mut markers = match &o.form {
                Form::Shape(origin, shape) => of_shape(shape, 0.0, &(here * origin), place),
                Form::HalfSpace(turn) => {
                    let size = Vector3::new(2.0 * PLANE, 2.0 * PLANE, 0.01);
                    vec![place(0, Drawn::Cube(size), here * *turn * nalgebra::Translation3::new(0.0, 0.0, -0.005))]
                }
                Form::Soup(soup) if soup.corners(0).len() > 3 => vec![place(0, Drawn::Triangles(faces(soup)), here)],
                Form::Soup(soup) => vec![place(0, Drawn::Balls(corners(soup), 2.0 * soup.radius().max(CORNER)), here)],
            };
            if pose.is_none() {
                markers.iter_mut().for_each(|m| m.drawn = Drawn::Nothing);
            }
            all.append(&mut markers);
        }
        all
    }

    /// People: balls at their points, and lines between those that are linked. One whose points are not known is removed.
    pub fn people(&self, tick: &Snapshot) -> Vec<Marker> {
        let interface = &self.program.interface;
        interface.humans.iter().flat_map(|human| self.person(human, tick)).collect()
    }

    fn person(&self, human: &HumanProgram, tick: &Snapshot) -> [Marker; 2] {
        let interface = &self.program.interface;
        let at = |point: usize| {
            let signal = interface.signals.get(*human.points.get(point)?)?;
            let known = tick.signals.get(signal.known_at()).is_some_and(|x| *x > 0.0);
            three(&tick.signals, signal.at + 1).filter(|_| known)
        };
        let points: Vec<Vector3<f64>> = (0..human.points.len()).filter_map(at).collect();
        let lines: Vec<Vector3<f64>> =
            human.links.iter().filter_map(|(a, b)| Some([at(*a)?, at(*b)?])).flatten().collect();
        let drawn = |points: Vec<Vector3<f64>>, id: usize, of: fn(Vec<Vector3<f64>>, f64) -> Drawn, size: f64| {
            let drawn = if points.is_empty() { Drawn::Nothing } else { of(points, size) };
            Marker::new(&self.world, &human.name, id, drawn, Isometry3::identity(), PERSON)
        };
        [drawn(points, 0, Drawn::Balls, PERSON_POINT), drawn(lines, 1, Drawn::Lines, PERSON_POINT / 2.0)]
    }

    /// Closest points of the limits that run: lines in the colour of their margins.
    pub fn closest_points(&self, tick: &Snapshot) -> Vec<Marker> {
        let marker = |limit: &Limit| {
            let runs = tick.row.get(limit.column).is_some_and(|h| !h.is_nan());
            let mut lines = if runs { self.lines(limit) } else { Vec::new() };
            lines.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            lines.truncate(LINES);
            let least = limit.distance.map(|s| self.values.get(s.at).copied().unwrap_or(f64::NAN));
            let color = |c: &Closest| least.map_or(UNKNOWN, |least| of_margin(c.distance - least));
            let points: Vec<Vector3<f64>> = lines.iter().flat_map(|c| [c.on_a, c.on_b]).collect();
            let drawn = if points.is_empty() { Drawn::Nothing } else { Drawn::Lines(points, LINE) };
            let mut marker = Marker::new(&self.world, &limit.name, 0, drawn, Isometry3::identity(), UNKNOWN);
            marker.colors = lines.iter().flat_map(|c| [color(c), color(c)]).collect();
            marker
        };
        self.limits.iter().map(marker).collect()
    }

    fn lines(&self, limit: &Limit) -> Vec<Closest> {
        let pose = |g: &Geometry| self.data.pose(g.link) * g.origin;
        let to_point = |p: Vector3<f64>, g: &Geometry| {
            let point = robot::Shape::Sphere { radius: 0.0 };
            closest(&g.shape, &pose(g), &point, &Isometry3::translation(p.x, p.y, p.z)).ok()
        };
        match &limit.hazard {
            Hazard::Plane { at, normal, on } => {
                let carrier = on.map_or_else(Isometry3::identity, |l| *self.data.pose(l));
                let (n, a) = (carrier.rotation * normal, carrier * nalgebra::Point3::from(*at));
                limit.parts.iter().map(|g| closest_plane(&g.shape, &pose(g), &n, n.dot(&a.coords))).collect()
            }
            Hazard::Parts(pairs) => {
                pairs.iter().filter_map(|[a, b]| closest(&a.shape, &pose(a), &b.shape, &pose(b)).ok()).collect()
            }
            Hazard::Obstacles(all) => {
                let placed = all.iter().filter_map(|o| Some((o, self.pose(o)?)));
                let lines = placed.flat_map(|(o, own)| {
                    let at = o.link.map_or(own, |l| self.data.pose(l) * own);
                    let zero = Vector3::zeros();
                    let at = PlacedObstacle { pose: at, velocity: zero, angular_velocity: zero };
                    let others = limit.parts.iter().filter(move |g| Some(g.link) != o.link);
                    others.filter_map(move |g| o.closest(&g.shape, &pose(g), &at).ok())
                });
                lines.collect()
            }
            Hazard::Point(slot) => match three(&self.values, slot.at) {
                Some(p) => limit.parts.iter().filter_map(|g| to_point(p, g)).collect(),
                None => Vec::new(),
            },
        }
    }
}

/// Corners of a soup, at most [`CORNERS`], evenly chosen.
fn corners(soup: &robot::Soup) -> Vec<Vector3<f64>> {
    let every = soup.len().div_ceil(CORNERS).max(1);
    (0..soup.len()).step_by(every).filter_map(|e| soup.corners(e).first().copied()).collect()
}

/// Corners of the triangles of pieces.
fn faces(soup: &robot::Soup) -> Vec<Vector3<f64>> {
    (0..soup.len()).flat_map(|e| soup.faces(e)).flatten().collect()
}
