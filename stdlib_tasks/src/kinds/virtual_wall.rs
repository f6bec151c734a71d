//! Keeps points or shapes of the robot on the free side of a plane.
//!
//! ```text
//! h(q) = n·(p - a) - d_min            [m]    safe where h >= 0            thesis (3.17), (3.18)
//! n·J_p v >= d_min' - φ (h - δ)       [m/s]  δ: the sampled-time reserve  thesis (3.19), (3.20)
//! ```
//!
//! where n and a are constants of the world or of the link that carries the plane, and `J_p` is in the latter case the
//! Jacobian of the point relative to that link.

use nalgebra::{Point3, Vector3};
use robot::{Closest, LinkId, Model, geometry};

use crate::bound::{BoundParams, Geometry};
use crate::build::check;
use crate::clearance;
use crate::dimension::LENGTH;
use crate::gradient_bound;
use crate::params::{Auto, Input, ParamType, Presence, Quantity, Vectors};
use crate::protection::{Hazard, Protection};
use crate::sampled_margin::{SampledMargin, extent};
use crate::task::{BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use quantities::usual;

crate::params! {
    /// Parameters of `virtual_wall`.
    pub struct Params {
        /// The parts that are kept away: points, segments, links with their collision shapes, groups of them.
        points: Vec<Geometry> = ParamType::Geometries, Presence::Required;
        /// Three points of the plane, not on one line. Seen from the free side they go round anticlockwise:
        /// the normal is `(p2 - p1) x (p3 - p1)`.
        through: Vectors = ParamType::Vectors { least: 3, most: 3, dimension: LENGTH }, Presence::Required;
        /// The link that carries the plane; `through` is then in that link's frame. Default: the world.
        on: Option<(String, LinkId)> = ParamType::Frame, Presence::Optional;
        /// d_min: smallest distance of a point from the plane.
        d_min: Input<1> = ParamType::Scalar(usual::CLEARANCE), Presence::Default("0 m");
        /// φ: how fast the margin may decrease, relative to its size.
        gain: Input<1> = ParamType::Scalar(usual::LIMIT_GAIN), Presence::Default("5 /s");
        /// δ: a constant reserve for what sampling in time can lose; `auto` computes it from the hard speed limits, for all
        /// joints at full speed. Without it, a limit on a hard level looks ahead: its row asks at each tick for what the
        /// velocity of that tick would lose.
        sampled_margin: Option<Auto> = ParamType::AutoScalar(Quantity::at_least(LENGTH, 0.0).usually(1e-8, 1.0).constant()), Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "virtual_wall",
    summary: "keeps points or shapes of the robot on the free side of a plane",
    docs: "One inequality row for each point or shape:\n\n\
```text\n\
n = (p2 - p1)×(p3 - p1) / |..|\n\
h = n·(p - p1) - d_min        [m]     safe where h >= 0\n\
n·J_p v  >=  d_min' - φ (h - δ)       [m/s]\n\n\
p1, p2, p3  3×1  m              points of the plane in the world, `through`\n\
n           3×1                 unit normal of the plane in the world, towards the free side\n\
p           3×1  m              the point in the world\n\
J_p         3×n  m/rad or m/m   Jacobian of p in the world's axes\n\
v           n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
d_min'           m/s            time derivative of d_min\n\
φ                1/s            gain\n\
δ                m              reserve, `sampled_margin`; otherwise 0\n\
```\n\n\
For a shape, `p` is its point nearest to the plane; for an edge or a face that is parallel to the plane, its \
middle. With `on LINK`, the plane moves with the link: `p1`, `p2`, `p3` are given in the link's frame, and `J_p` \
is the Jacobian of `p` relative to the link.\n\n\
A point that turns about a joint moves on a curve, and a velocity that meets its row can lose some of `h` until the \
next tick. Without `sampled_margin`, a wall on a hard level looks ahead: the heights after one period with the chosen \
velocity are computed, and if `h` were below zero there, the row asks for the difference and the hierarchy is solved \
again. If no other velocity is possible, the robot moves more slowly. `h` then stays at or above zero at every tick, \
and nothing is lost at rest. A wall on a soft level does not look ahead.\n\n\
`sampled_margin auto` sets `δ = A T / (2 φ)` with the control period T instead. A bounds the acceleration of the point \
at the speeds that `joint_velocity_limits` allow, on the hard levels down to that of the task. The robot stays δ \
away, and no hierarchy is solved twice. For points and spheres, `h` stays at or above zero at every tick, if \
`φ T <= 1` and `d_min` is constant or moves at a constant rate. A flat shape that rotates into a position parallel to \
the plane can lose more, because its nearest point jumps. `sampled_margin 0 m` accepts the loss.\n\n\
Source: thesis (3.17)-(3.20); the Jacobian has the sign that follows from `h`, not the printed one.",
    example: "task deck = virtual_wall { points left_elbow  through [[0, 0, 0.4], [1, 0, 0.4], [0, 1, 0.4]] m  d_min 0.3 m }",
    positional: &["points"],
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

struct VirtualWall {
    points: Vec<Geometry>,
    on: Option<LinkId>,
    a: Point3<f64>,
    n: Vector3<f64>,
    d_min: Input<1>,
    gain: Input<1>,
    sampled_margin: SampledMargin,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.points.is_empty() {
        return Err(BuildError::new("points", "nothing is named that the wall could keep away")
            .help("name points, segments, links or groups of them, or remove the task"));
    }
    let through: Vec<Vector3<f64>> = params.through.of(ctx.values).map(Vector3::from).collect();
    let [p1, p2, p3] = through[..] else {
        return Err(BuildError::new("through", "a plane is given by three points").help("write three points"));
    };
    let (u, v) = (p2 - p1, p3 - p1);
    let normal = u.cross(&v);
    // Sine of the angle at p1: three points with less than a thousandth of a degree are on a line.
    let is_plane = normal.norm() > 1e-5 * u.norm() * v.norm() && normal.norm().is_finite();
    if !is_plane {
        return Err(BuildError::new("through", "the three points lie on one line, and no plane is given by them")
            .help("move one of them off the line"));
    }
    let on = params.on.map(|f| f.1);
    let acceleration_bound_of = |i: usize, speed: &[f64]| {
        let g: &Geometry = &params.points[i];
        clearance::acceleration_bound(ctx.model, on, g.link, extent(g), speed)
    };
    let names: Vec<&str> = params.points.iter().map(|g| g.name.as_str()).collect();
    let sampled_margin =
        SampledMargin::new(params.sampled_margin, params.gain.of(ctx.values)[0], &names, &acceleration_bound_of, ctx)?;
    let (a, n) = (Point3::from(p1), normal.normalize());
    Ok(Box::new(VirtualWall {
        points: params.points,
        on,
        a,
        n,
        d_min: params.d_min,
        gain: params.gain,
        sampled_margin,
    }))
}

impl VirtualWall {
    /// Point and unit normal of the plane in the world.
    fn plane(&self, state: &State) -> Plane {
        match self.on {
            Some(link) => {
                let pose = state.data.pose(link);
                Plane { point: pose * self.a, normal: pose.rotation * self.n }
            }
            None => Plane { point: self.a, normal: self.n },
        }
    }
}

/// A plane in the world.
struct Plane {
    point: Point3<f64>,
    /// Unit vector towards the free side.
    normal: Vector3<f64>,
}

impl Plane {
    /// Point of a part that is nearest to the plane, with its height over the plane in m.
    fn nearest(&self, g: &Geometry, state: &State) -> Closest {
        let pose = state.data.pose(g.link) * g.origin;
        geometry::closest_plane(&g.shape, &pose, &self.normal, self.normal.dot(&self.point.coords))
    }
}

impl Task for VirtualWall {
    fn rows(&self) -> Vec<RowInfo> {
        self.points.iter().map(|g| RowInfo { name: g.name.clone(), dimension: LENGTH }).collect()
    }

    fn protections(&self) -> Vec<Protection> {
        self.points.iter().map(|g| Protection { links: vec![g.link], hazard: Hazard::Plane }).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let ([gain], [d_min]) = (self.gain.of(state.values), self.d_min.of(state.values));
        let [d_min_rate] = self.d_min.of(state.rates);
        let plane = self.plane(state);
        let n = plane.normal;
        for (i, g) in self.points.iter().enumerate() {
            let nearest = plane.nearest(g, state);
            let h = nearest.distance - d_min;
            rows.margins[i] = h;
            if rows.is_idle(i) {
                continue;
            }
            let row = rows.row(i);
            state.data.add_point(state.model, g.link, &nearest.on_a, &n, row);
            if let Some(link) = self.on {
                state.data.add_point(state.model, link, &nearest.on_a, &-n, row);
            }
            rows.lower[i] = d_min_rate - gain * h + self.sampled_margin.rate(i, gain);
        }
        Ok(())
    }

    fn set_locked_joints_moving(&mut self, moving: bool) {
        self.sampled_margin.set_locked_joints_moving(moving);
    }

    fn gradient_bounds(&self, model: &Model) -> Vec<Vec<f64>> {
        self.points.iter().map(|g| gradient_bound::over_plane(model, self.on, &self.n, g)).collect()
    }

    fn looks_ahead(&self) -> bool {
        self.sampled_margin.looks_ahead
    }

    fn reach(&self, chain: f64) -> f64 {
        // A joint that carries the plane turns it about itself, however far the part is.
        let to_plane = if self.on.is_some() { chain } else { 0.0 };
        chain + to_plane + self.points.iter().map(extent).fold(0.0, f64::max)
    }

    fn margin_after(&self, next: &State, row: usize, period: f64) -> f64 {
        let ([d_min], [d_min_rate]) = (self.d_min.of(next.values), self.d_min.of(next.rates));
        let plane = self.plane(next);
        let height = self.points.get(row).map_or(f64::INFINITY, |g| plane.nearest(g, next).distance);
        height - d_min - period * d_min_rate
    }

    fn sampled_loss(&self) -> Vec<f64> {
        self.sampled_margin.loss.clone()
    }

    fn sampled_margin(&self) -> Vec<f64> {
        self.sampled_margin.kept.clone()
    }
}
