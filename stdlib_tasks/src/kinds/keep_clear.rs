//! Keeps parts of the robot away from obstacles in the room.
//!
//! ```text
//! h(q, t) = |p - o| - d_min                            [m]    safe where h >= 0     as thesis (3.21), (3.22)
//! n·(J_p - J_o) v >= d_min' + n·o' - φ (h - δ)         [m/s]  n from o to p         as thesis (3.23), (3.24)
//! ```
//!
//! `o'` is the velocity of the obstacle's closest point, which the thesis, whose obstacles are links, does not have.

use nalgebra::{Isometry3, Vector3};
use robot::{Frontier, LinkId, Model, Shape};

use crate::bound::{BoundParams, Geometry};
use crate::build::check;
use crate::clearance;
use crate::closest_points::SeparationError;
use crate::dimension::{LENGTH, NONE};
use crate::gradient_bound;
use crate::obstacle::{Form, Obstacle, PlacedObstacle};
use crate::obstacle_pair::{Meeting, ObstaclePair, ObstacleSeparation, distance_at};
use crate::params::{Auto, Input, ParamType, Presence, Quantity};
use crate::protection::{Hazard, Protection};
use crate::sampled_margin::{SampledMargin, extent};
use crate::task::{BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use quantities::usual;

/// Largest number of pairs of a part and an obstacle.
const MOST_PAIRS: usize = 4096;

/// Number of spots of a part and an obstacle of many elements.
const SPOTS: usize = 4;

crate::params! {
    /// Parameters of `keep_clear`.
    pub struct Params {
        /// The parts of the robot: points, segments, links with their collision shapes, groups of them.
        links: Vec<Geometry> = ParamType::Geometries, Presence::Required;
        /// The obstacles from which they are kept, declared with `obstacle`.
        of: Vec<Obstacle> = ParamType::Obstacles, Presence::Required;
        /// d_min: smallest distance between a part and an obstacle.
        d_min: Input<1> = ParamType::Scalar(usual::CLEARANCE), Presence::Default("0 m");
        /// φ: how fast the margin may decrease, relative to its size.
        gain: Input<1> = ParamType::Scalar(usual::LIMIT_GAIN), Presence::Default("5 /s");
        /// Largest number of rows of a part and an obstacle of many elements (`points`, `heightfield`, and a `mesh` with its
        /// hollows): those of its nearest spots; default: 4. Any other obstacle has one row for each part.
        spots: Option<Input<1>> = ParamType::Scalar(Quantity::at_least(NONE, 1.0).usually(1.0, 32.0).constant()), Presence::Optional;
        /// Largest number of rows, those of the nearest pairs; default: a row for each pair.
        nearest: Option<Input<1>> = ParamType::Scalar(Quantity::at_least(NONE, 1.0).constant()), Presence::Optional;
        /// δ: a constant reserve for what sampling in time can lose; `auto` computes it from the hard speed limits, for all
        /// joints at full speed. Without it, a limit on a hard level looks ahead: its row asks at each tick for what the
        /// velocity of that tick would lose.
        sampled_margin: Option<Auto> = ParamType::AutoScalar(Quantity::at_least(LENGTH, 0.0).usually(1e-8, 1.0).constant()), Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "keep_clear",
    summary: "keeps parts of the robot away from obstacles in the room",
    docs: "One inequality row for each pair of a part of `links` and an obstacle of `of`, except pairs that cannot \
move relative to each other:\n\n\
```text\n\
h = |p - o| - d_min                                [m]     safe where h >= 0\n\
n·(J_p - J_o) v  >=  d_min' + n·o' - φ (h - δ)     [m/s]   n = (p - o)/|p - o|\n\n\
p, o      3×1  m              closest points of the part and the obstacle in the world\n\
n         3×1                 unit vector from o to p in the world\n\
J_p       3×n  m/rad or m/m   Jacobian of p in the world's axes\n\
J_o       3×n  m/rad or m/m   Jacobian of o, if a link carries the obstacle; else zero\n\
v         n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
o'        3×1  m/s            velocity of the obstacle's point, from the rates of its position and orientation\n\
d_min'         m/s            time derivative of d_min\n\
φ              1/s            gain\n\
δ              m              reserve, `sampled_margin`; otherwise 0\n\
```\n\n\
The distance is exact for every form: points, spheres, capsules, boxes, cylinders, planes and hulls of meshes. The \
normal is continuous until the cores meet (the points, segments and bodies inside the radii); then the task keeps the \
last valid direction and closest points, and if there were none, this is a fault. The closest points of parallel \
edges or faces can jump when they turn. A `plane` has a depth instead: its direction always exists.\n\n\
An obstacle that moves towards a robot faster than the robot can flee makes a row that no velocity meets: on a hard \
level the fault `infeasible`, on a soft level an error that the level shows. An obstacle that is absent \
(`present`) has no row.\n\n\
A cloud of points, a heightfield and a mesh with its hollows have a row for each of the nearest `spots` of a part. The \
first is that of the nearest element, a point, a triangle or a convex piece. Each further one is that of the nearest element for which no \
spot before it stands: a spot stands for what is behind the plane through it, across its normal, or in front of it by at most \
14 degrees and a tenth of its distance, and nearest to about the same part of the shape (of a capsule, to the same half of its \
axis). So a wall of thousands of points has one row, or a few for a long part, and the wall on the other side has its own. No element is nearer than the first spot. A \
further spot has no row while it is so far away that no row could be active there, at the hard speed limits and with this \
gain.\n\n\
`nearest 8` writes the rows of the eight pairs with the smallest margins at each tick, for rooms with many obstacles: \
the hierarchy is solved for these alone, and the distances of all pairs are computed at each tick. A pair that is not \
among them is at least as far away as each of those.\n\n\
A distance is curved, and a velocity that meets its row can lose some of it until the next tick. Without \
`sampled_margin`, a task on a hard level looks ahead, as `self_collision` does: the distances after one period with the \
chosen velocity are computed, of obstacles that move as far as they will have come, and if `h` were below zero there, \
the hierarchy is solved again with what is missing, or the robot moves more slowly.\n\n\
`sampled_margin auto` sets `δ = A T / (2 φ)` with the control period T instead. A bounds the acceleration of the part's \
points at the speeds that `joint_velocity_limits` allow, on the hard levels down to that of the task. For points and \
spheres, `h` then stays at or above zero at every tick, if `φ T <= 1`, and `d_min` and the obstacle's position are \
constant or move at constant rates without rotation. `sampled_margin 0 m` accepts the loss.\n\n\
Source: thesis (3.21)-(3.24), as for `self_collision`, with the velocity of the obstacle.",
    example: "task clear = keep_clear(arms) { of [table, pillar]  d_min 5 cm  gain 5 /s }",
    positional: &["links"],
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

/// Place of a row: a pair, and the rank of a spot among those of the pair, from the nearest on.
#[derive(Clone, Copy)]
struct Place {
    pair: usize,
    rank: usize,
}

struct KeepClear {
    parts: Vec<Geometry>,
    obstacles: Vec<Obstacle>,
    pairs: Vec<ObstaclePair>,
    /// Places of rows, those of a pair beside each other.
    places: Vec<Place>,
    d_min: Input<1>,
    gain: Input<1>,
    sampled_margin: SampledMargin,
    /// Number of rows if only the nearest pairs have one.
    nearest: Option<usize>,
    /// The largest speed at which each pair approaches while all joints move at their limits, in m/s.
    fastest: Vec<f64>,
    /// Slopes of the distances, see [`Task::gradient_bounds`].
    slopes: Vec<Vec<f64>>,
    /// Obstacles at this tick; `None` while they are absent.
    placed: Vec<Option<PlacedObstacle>>,
    /// Separations of this tick, of each place.
    separations: Vec<Option<ObstacleSeparation>>,
    /// Places, the nearest first.
    order: Vec<usize>,
    /// Room for the search of spots.
    frontier: Frontier,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let Params { links: parts, of: obstacles, d_min, gain, spots, nearest, sampled_margin } =
        Params::from_bound(bound)?;
    let spots = spots.map_or(Ok(SPOTS), |n| whole("spots", n.of(ctx.values)[0]))?;
    if parts.is_empty() {
        return Err(BuildError::new("links", "no part of the robot is named that could be kept clear")
            .help("name points, segments, links or groups of them, or remove the task"));
    }
    if obstacles.is_empty() {
        return Err(BuildError::new("of", "no obstacle is named").help("name declared obstacles, or remove the task"));
    }
    let moves = |part: &Geometry, obstacle: &Obstacle| match obstacle.link {
        Some(link) => ctx.model.moves_between(part.link, link),
        None => !ctx.model.support(part.link).is_empty(),
    };
    let mut pairs = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let moving = obstacles.iter().enumerate().filter(|(_, o)| moves(part, o));
        pairs.extend(moving.map(|(o, obstacle)| ObstaclePair::new(p, o, &obstacle.form, spots)));
    }
    if pairs.is_empty() {
        return Err(BuildError::new("links", "none of these parts can move relative to an obstacle")
            .help("name parts that joints move"));
    }
    let count: usize = pairs.iter().map(ObstaclePair::count).sum();
    if count > MOST_PAIRS {
        let text = format!(
            "these are {count} pairs of a part and an obstacle or a spot of one, and {MOST_PAIRS} are the most"
        );
        return Err(BuildError::new("of", text).help("name the parts and the obstacles that can meet"));
    }
    let of_pair = |(pair, p): (usize, &ObstaclePair)| (0..p.count()).map(move |rank| Place { pair, rank });
    let places: Vec<Place> = pairs.iter().enumerate().flat_map(of_pair).collect();
    let nearest = nearest.map(|n| whole("nearest", n.of(ctx.values)[0])).transpose()?;
    // All places have rows then.
    let nearest = nearest.filter(|n| *n < count);
    let names: Vec<&str> = pairs.iter().map(|p| parts[p.part].name.as_str()).collect();
    let acceleration_bound_of = |i: usize, speed: &[f64]| {
        let part = &parts[pairs[i].part];
        clearance::acceleration_bound(ctx.model, obstacles[pairs[i].obstacle].link, part.link, extent(part), speed)
    };
    let sampled_margin =
        SampledMargin::new(sampled_margin, gain.of(ctx.values)[0], &names, &acceleration_bound_of, ctx)?;
    let of = |p: &ObstaclePair| slope(ctx.model, &parts[p.part], &obstacles[p.obstacle], ctx.values);
    let slopes: Option<Vec<Vec<f64>>> = pairs.iter().map(of).collect();
    let speed = |slope: &Vec<f64>| -> f64 {
        let limits = ctx.speed.iter().zip(ctx.entry_speed).map(|(a, b)| a.max(*b));
        // A joint that does not move the pair may be as fast as it likes.
        slope.iter().zip(limits).filter(|(s, _)| **s > 0.0).map(|(s, v)| s * v).sum()
    };
    let fastest = match &slopes {
        Some(all) => all.iter().map(speed).collect(),
        None => vec![f64::INFINITY; pairs.len()],
    };
    // A row may be that of another pair at each tick, or of another spot.
    let slopes = if nearest.is_some() || count > pairs.len() { None } else { slopes }.unwrap_or_default();
    let mut frontier = Frontier::default();
    for obstacle in &obstacles {
        if let Form::Soup(soup) = &obstacle.form {
            frontier.reserve(soup);
        }
    }
    Ok(Box::new(KeepClear {
        frontier,
        placed: vec![None; obstacles.len()],
        separations: vec![None; count],
        order: (0..count).collect(),
        places,
        parts,
        obstacles,
        pairs,
        d_min,
        gain,
        sampled_margin,
        nearest,
        fastest,
        slopes,
    }))
}

/// A number of rows.
fn whole(key: &str, n: f64) -> Result<usize, BuildError> {
    if n.fract() == 0.0 {
        return Ok(n as usize);
    }
    Err(BuildError::new(key, format!("the number of rows is a whole number, and this is {n}"))
        .help(format!("write for instance `{key} 8`")))
}

/// Bounds of the slope of a distance, as numbers for each degree of freedom; `None` if no bound is known.
fn slope(model: &Model, part: &Geometry, obstacle: &Obstacle, values: &[f64]) -> Option<Vec<f64>> {
    let Some(link) = obstacle.link else { return Some(gradient_bound::over_world(model, part)) };
    match &obstacle.form {
        Form::HalfSpace(_) => Some(gradient_bound::over_plane(model, Some(link), &Vector3::z(), part)),
        Form::Shape(origin, shape) => {
            over_ball(model, part, obstacle, link, origin.translation.vector.norm() + shape.bounding_radius(), values)
        }
        Form::Soup(soup) => over_ball(model, part, obstacle, link, soup.bounding_radius(), values),
    }
}

/// The same for an obstacle in a ball about its frame on a link. Where it is within the ball does not matter.
fn over_ball(
    model: &Model,
    part: &Geometry,
    obstacle: &Obstacle,
    link: LinkId,
    radius: f64,
    values: &[f64],
) -> Option<Vec<f64>> {
    let at = values.get(obstacle.position.at..)?.get(..3)?;
    let around = Geometry {
        name: obstacle.name.clone(),
        link,
        origin: Isometry3::translation(at[0], at[1], at[2]),
        shape: Shape::Capsule { radius: 0.0, half_length: radius },
    };
    Some(gradient_bound::between(model, part, &around))
}

impl KeepClear {
    /// Computes the separations of a pair, whose places begin at `first`.
    fn separate(&mut self, index: usize, first: usize, state: &State) -> Result<(), SeparationError> {
        let pair = &mut self.pairs[index];
        let found = &mut self.separations[first..first + pair.count()];
        found.fill(None);
        match &self.placed[pair.obstacle] {
            Some(at) => {
                // Farther away, no row can be active: nothing approaches so fast.
                let moved = at.velocity.norm() + at.angular_velocity.norm() * self.obstacles[pair.obstacle].radius();
                let ([gain], [d_min], [rate]) =
                    (self.gain.of(state.values), self.d_min.of(state.values), self.d_min.of(state.rates));
                let fastest = self.fastest[index] + moved + rate.abs() + self.sampled_margin.rate(index, gain).abs();
                let range = if gain > 0.0 { d_min + fastest / gain } else { f64::INFINITY };
                let (part, obstacle) = (&self.parts[pair.part], &self.obstacles[pair.obstacle]);
                pair.find(&Meeting { part, obstacle, at, range }, state, found, &mut self.frontier)
            }
            None => {
                // The obstacle may be elsewhere when it comes back.
                pair.forget();
                Ok(())
            }
        }
    }

    /// Writes the row of a pair.
    fn write(&self, row: usize, pair: usize, found: &ObstacleSeparation, state: &State, rows: &mut Rows) {
        let ([gain], [d_min]) = (self.gain.of(state.values), self.d_min.of(state.values));
        let [d_min_rate] = self.d_min.of(state.rates);
        let ObstacleSeparation { distance, on_part, on_obstacle, normal, .. } = found;
        let h = distance - d_min;
        rows.margins[row] = h;
        if rows.is_idle(row) {
            return;
        }
        let ObstaclePair { part, obstacle, .. } = self.pairs[pair];
        let coefficients = rows.row(row);
        state.data.add_point(state.model, self.parts[part].link, on_part, normal, coefficients);
        if let Some(link) = self.obstacles[obstacle].link {
            state.data.add_point(state.model, link, on_obstacle, &-normal, coefficients);
        }
        let approach = self.placed[obstacle].as_ref().map_or(0.0, |at| {
            let turning = at.angular_velocity.cross(&(on_obstacle - at.pose.translation.vector));
            normal.dot(&(at.velocity + turning))
        });
        rows.lower[row] = d_min_rate + approach - gain * h + self.sampled_margin.rate(pair, gain);
    }
}

impl Task for KeepClear {
    fn rows(&self) -> Vec<RowInfo> {
        let name = |place: &Place| {
            let pair = &self.pairs[place.pair];
            let names = format!("{} to {}", self.parts[pair.part].name, self.obstacles[pair.obstacle].name);
            if place.rank == 0 { names } else { format!("{names}, spot {}", place.rank + 1) }
        };
        let named = |name| RowInfo { name, dimension: LENGTH };
        match self.nearest {
            None => self.places.iter().map(|p| named(name(p))).collect(),
            Some(n) => (1..=n).map(|i| named(format!("nearest {i}"))).collect(),
        }
    }

    fn protections(&self) -> Vec<Protection> {
        let one = |p: &ObstaclePair| {
            let (part, obstacle) = (&self.parts[p.part], &self.obstacles[p.obstacle]);
            let hazard = match obstacle.link {
                Some(link) => Hazard::Link(link),
                None => Hazard::Obstacle(obstacle.name.clone(), obstacle.position),
            };
            Protection { links: vec![part.link], hazard }
        };
        self.pairs.iter().map(one).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn enter(&mut self, _state: &State) {
        self.pairs.iter_mut().for_each(ObstaclePair::forget);
    }

    crate::task::takes_over!(pairs, nearest);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        for (i, (placed, obstacle)) in self.placed.iter_mut().zip(&self.obstacles).enumerate() {
            *placed = match obstacle.is_present(state.values) {
                true => {
                    let row = self.places.iter().position(|p| self.pairs[p.pair].obstacle == i).unwrap_or(0);
                    let row = if self.nearest.is_some() { 0 } else { row };
                    Some(obstacle.place(state).map_err(|_| TaskFault::NotFinite { row })?)
                }
                false => None,
            };
        }
        let mut first = 0;
        for pair in 0..self.pairs.len() {
            // Rows of the nearest places are not those of a pair.
            let row = if self.nearest.is_some() { 0 } else { first };
            self.separate(pair, first, state).map_err(|why| match why {
                SeparationError::Overlap => TaskFault::Overlap { row },
                SeparationError::NotFinite => TaskFault::NotFinite { row },
            })?;
            first += self.pairs[pair].count();
        }
        let Some(n) = self.nearest else {
            for (i, place) in self.places.iter().enumerate() {
                if let Some(found) = &self.separations[i] {
                    self.write(i, place.pair, found, state, rows);
                }
            }
            return Ok(());
        };
        let distance = |i: &usize| self.separations[*i].as_ref().map_or(f64::INFINITY, |s| s.distance);
        let mut order = std::mem::take(&mut self.order);
        order.sort_unstable_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        // In the order of the pairs, a row stays that of its pair while the same pairs are the nearest.
        order[..n].sort_unstable();
        for (row, &place) in order[..n].iter().enumerate() {
            if let Some(found) = &self.separations[place] {
                self.write(row, self.places[place].pair, found, state, rows);
            }
        }
        self.order = order;
        Ok(())
    }

    fn set_locked_joints_moving(&mut self, moving: bool) {
        self.sampled_margin.set_locked_joints_moving(moving);
    }

    fn gradient_bounds(&self, _model: &Model) -> Vec<Vec<f64>> {
        self.slopes.clone()
    }

    fn subjects(&self) -> usize {
        self.pairs.len()
    }

    fn subject(&self, row: usize) -> usize {
        match self.place(row) {
            Some(Place { pair, rank: 0 }) => *pair,
            // The nearest spot has the margin of the pair.
            _ => usize::MAX,
        }
    }

    fn margin_inputs(&self, subject: usize) -> Option<Vec<usize>> {
        let obstacle = &self.obstacles[self.pairs.get(subject)?.obstacle];
        let pose = obstacle.slots().flat_map(|s| s.at..s.at + s.len);
        Some(pose.chain([self.d_min.at]).collect())
    }

    fn looks_ahead(&self) -> bool {
        self.sampled_margin.looks_ahead
    }

    fn reach(&self, chain: f64) -> f64 {
        // A joint that carries an obstacle turns it about itself, however far the part is.
        let carried = if self.obstacles.iter().any(|o| o.link.is_some()) { chain } else { 0.0 };
        chain + carried + self.parts.iter().map(extent).fold(0.0, f64::max)
    }

    fn margin_after(&self, next: &State, row: usize, period: f64) -> f64 {
        let Some(pair) = self.place(row).and_then(|p| self.pairs.get(p.pair)) else { return f64::INFINITY };
        let (part, obstacle) = (&self.parts[pair.part], &self.obstacles[pair.obstacle]);
        let found = self.separations.get(self.place_index(row)).copied().flatten();
        if !obstacle.is_present(next.values) || (found.is_none() && pair.count() > 1) {
            return f64::INFINITY;
        }
        let Ok(at) = obstacle.place(next) else { return f64::NAN };
        // Another element may be the nearest one then: the first spot looks at all of them.
        let is_first = self.place(row).is_none_or(|p| p.rank == 0);
        let element = found.and_then(|f| f.element).filter(|_| !is_first);
        let distance = distance_at(part, obstacle, element, &at.after(period), next);
        let ([d_min], [d_min_rate]) = (self.d_min.of(next.values), self.d_min.of(next.rates));
        distance - d_min - period * d_min_rate
    }

    fn sampled_loss(&self) -> Vec<f64> {
        self.of_rows(&self.sampled_margin.loss)
    }

    fn sampled_margin(&self) -> Vec<f64> {
        self.of_rows(&self.sampled_margin.kept)
    }
}

impl KeepClear {
    /// Index of the place that a row had at the last tick.
    fn place_index(&self, row: usize) -> usize {
        if self.nearest.is_some() { self.order.get(row).copied().unwrap_or(row) } else { row }
    }

    /// The place that a row had at the last tick.
    fn place(&self, row: usize) -> Option<&Place> {
        self.places.get(self.place_index(row))
    }

    /// Numbers of pairs as numbers of rows: of the nearest places, any may be that of a row.
    fn of_rows(&self, pairs: &[f64]) -> Vec<f64> {
        match self.nearest {
            // Without curvature there are none.
            None if pairs.is_empty() => Vec::new(),
            None => self.places.iter().map(|p| pairs[p.pair]).collect(),
            Some(n) => vec![pairs.iter().copied().fold(0.0, f64::max); n],
        }
    }
}
