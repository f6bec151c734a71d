//! Keeps the centre of mass above the support polygon: the convex hull of the feet, seen from above.
//!
//! ```text
//! P_k = c + w_f (p_k - c)             [m]    corner k of foot f;  c = sum_f w_f m_f / sum_f w_f
//! h = n·(com - P_a) - margin          [m]    safe where h >= 0, for each edge from P_a to P_b
//! n·(J_com - (1 - s) J_a - s J_b) v >= -φ h + margin' + n·((1 - s) P_a' + s P_b')    [m/s]   as thesis (3.19)
//! ```
//!
//! with n the unit normal of the edge in the ground's plane towards the inside, `J_a` the Jacobian of `P_a`, `P_a'` its
//! derivative in time while the robot stands still, and s the share of the edge at which the centre of mass is:
//! `s = (com - P_a)·(P_b - P_a)/|P_b - P_a|²`. The row is exact for feet that move: the edge turns about that point.

use nalgebra::{Point3, Vector2, Vector3};
use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::dimension::{LENGTH, NONE};
use crate::expression::{CenterOfMass, has_mass};
use crate::params::{FromBound, Input, ParamType, Presence, Quantity, Vectors};
use crate::support_polygon::{Edge, Hull};
use crate::task::{BuildError, Context, Doubt, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use quantities::usual;

/// Largest number of points of a sole.
const MOST_POINTS: usize = 16;

/// Height difference in m of points that stand on a level ground.
const FLAT: f64 = 0.01;

crate::params! {
    /// Parameters of a foot.
    pub struct FootParams {
        /// Length of a rectangular sole, along the x axis of the frame, whose origin is its middle.
        length: Option<Input<1>> = ParamType::Scalar(Quantity::above(LENGTH, 0.0).usually(1e-3, 5.0).constant()), Presence::Optional;
        /// Width of a rectangular sole, along the y axis of the frame.
        width: Option<Input<1>> = ParamType::Scalar(Quantity::above(LENGTH, 0.0).usually(1e-3, 5.0).constant()), Presence::Optional;
        /// Points of the sole in the axes of the frame, in place of `length` and `width`: their convex hull touches the
        /// ground.
        points: Option<Vectors> = ParamType::Vectors { least: 3, most: MOST_POINTS, dimension: LENGTH }, Presence::Optional;
        /// w: 1 if the foot carries, 0 if not. In between, its sole is drawn towards the middle of the feet that carry,
        /// so that the polygon changes without a jump.
        carries: Input<1> = ParamType::Scalar(Quantity::between(NONE, 0.0, 1.0)), Presence::Default("1");
    }
}

crate::params! {
    /// Parameters of `stance`.
    pub struct Params {
        /// The feet: links, or arms, which stand for their tips, each with its sole.
        feet: Vec<(String, BoundParams)> = ParamType::PerFrame(FootParams::INFO), Presence::Required;
        /// Smallest distance of the centre of mass from the edges of the polygon, seen from above.
        margin: Input<1> = ParamType::Scalar(usual::CLEARANCE), Presence::Default("0 m");
        /// φ: how fast the margin may decrease, relative to its size.
        gain: Input<1> = ParamType::Scalar(usual::LIMIT_GAIN), Presence::Default("5 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "stance",
    summary: "keeps the centre of mass above the support polygon of the feet",
    docs: "The support polygon is the convex hull of the soles that carry, seen from above, along z of the world. One \
inequality row for each point of a sole, which is that of the edge that begins there, anticlockwise:\n\n\
```text\n\
P_k = c + w_f (p_k - c)                       [m]     c = sum_f w_f m_f / sum_f w_f\n\
h = n·(com - P_a) - margin                    [m]     safe where h >= 0; edge from P_a to P_b\n\
n·(J_com - (1 - s) J_a - s J_b) v  >=  -φ h + margin' + n·((1 - s) P_a' + s P_b')    [m/s]\n\n\
p_k        3×1  m              point k of the sole of foot f in the world\n\
m_f        3×1  m              middle of the points of foot f\n\
w_f                            share of foot f, `carries`\n\
com        3×1  m              centre of mass in the world\n\
n          3×1                 unit normal of the edge, level, towards the inside\n\
s                              share of the edge at which the centre of mass is: (com - P_a)·(P_b - P_a)/|P_b - P_a|²\n\
J          3×n  m/rad or m/m   Jacobians of com, P_a, P_b in the world's axes\n\
P', margin'     m/s            time derivatives while the robot stands still\n\
v          n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
φ               1/s            gain\n\
```\n\n\
The rows are exact while the feet move or are held. A point that is no corner of the hull has no row at that tick, and its margin is \
infinite. The hull changes where a point passes through an edge: there both edges have the same `h`, so that the smallest \
margin has no jump.\n\n\
`carries 0` takes a foot out of the polygon, such as one that is lifted: in the stack of a state, or by a signal, \
`carries if(lifted, 0, 1)`. Then the polygon jumps, and if the centre of mass is outside of the smaller one, `h` is negative and \
the row asks for `-φ h`: on a hard level this can be more than the joints can do, the fault `infeasible`; on a soft level, the slack \
of the level and the margin tell how much is missing. A share that moves, such as \
`carries 1 - smoothstep(t/(1 s))`, makes the polygon smaller without a jump, and its rate is in the rows. If no foot carries, there is \
no polygon, which is the fault `not_finite`.\n\n\
The polygon is a limit of statics, for level ground with friction: feet on different heights, tilted feet, hands on a wall and \
fast motions need forces, which this task does not know. The compiler warns if the feet that carry do not stand level at \
the start (`HQ0508`).\n\n\
Edges that turn and a centre of mass on a curve can lose some of `h` between two ticks. A task on a hard level looks ahead, as \
`self_collision` does: the margins after one period with the chosen velocity are computed, and if `h` were below zero there, the \
hierarchy is solved again with what is missing, or the robot moves more slowly.\n\n\
Source: thesis (3.19) for any h; the polygon as the static condition of level contacts: McGhee and Frank, On the stability \
properties of quadruped creeping gaits, Mathematical Biosciences 3, 1968; the shares are ours.",
    example: "task support = stance {\n  feet { left_sole { length 17 cm  width 6 cm }  right_sole { length 17 cm  width 6 cm } }\n  margin 2 cm\n}",
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

/// A foot with its sole.
struct Foot {
    name: String,
    link: LinkId,
    /// Corners in the frame of the foot, in m.
    points: Vec<Point3<f64>>,
    /// Their middle.
    middle: Point3<f64>,
    /// w.
    carries: Input<1>,
}

/// A point of a sole at a tick.
#[derive(Clone, Copy)]
struct Corner {
    foot: usize,
    /// p in the world, in m.
    at: Vector3<f64>,
}

/// Weighted middle of the feet.
struct Middle {
    /// c in the world, in m.
    at: Vector3<f64>,
    /// Its derivative in time while the robot stands still, in m/s.
    rate: Vector3<f64>,
    /// Sum of the shares.
    weight: f64,
}

struct Stance {
    feet: Vec<Foot>,
    margin: Input<1>,
    gain: Input<1>,
    com: CenterOfMass,
    /// Points of all soles at this tick.
    corners: Vec<Corner>,
    /// P of each point from above, in m.
    drawn: Vec<Vector2<f64>>,
    hull: Hull,
    /// The point at which the edge that begins at each point ends; `None` for points that are no corners of the hull.
    ends: Vec<Option<usize>>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.feet.is_empty() {
        return Err(
            BuildError::new("feet", "no foot is named").help("name each frame that touches the ground, with its sole")
        );
    }
    if !has_mass(ctx.model) {
        return Err(BuildError::new("", "no link of the robot has a mass, and there is no centre of mass")
            .help("give the links of the URDF their `<inertial>`"));
    }
    let feet = params.feet.iter().map(|(name, foot)| Foot::new(name, foot, ctx)).collect::<Result<Vec<_>, _>>()?;
    // A share that moves may begin at zero.
    if feet.iter().all(|f| f.share(ctx.values) <= 0.0) {
        return Err(BuildError::new("feet", "no foot carries, so there is no polygon to stand on")
            .help("let at least one foot carry: `carries 1`, which is the default"));
    }
    let corners: Vec<Corner> = (feet.iter().enumerate())
        .flat_map(|(foot, f)| f.points.iter().map(move |_| Corner { foot, at: Vector3::zeros() }))
        .collect();
    let n = corners.len();
    Ok(Box::new(Stance {
        feet,
        margin: params.margin,
        gain: params.gain,
        com: CenterOfMass::new(ctx.model),
        corners,
        drawn: vec![Vector2::zeros(); n],
        hull: Hull::new(n),
        ends: vec![None; n],
    }))
}

impl Foot {
    fn new(name: &str, bound: &BoundParams, ctx: &Context) -> Result<Foot, BuildError> {
        let place = format!("feet.{name}");
        let (_, link) = FromBound::from_bound(bound.get("frame"))
            .ok_or_else(|| BuildError::new("feet", format!("foot `{name}` has no frame")))?;
        let params = FootParams::from_bound(bound)?;
        let number = |x: Input<1>| x.of(ctx.values)[0];
        let points = match (params.length, params.width, params.points) {
            (Some(length), Some(width), None) => {
                let (x, y) = (0.5 * number(length), 0.5 * number(width));
                [[x, y], [-x, y], [-x, -y], [x, -y]].map(|[x, y]| Point3::new(x, y, 0.0)).to_vec()
            }
            (None, None, Some(points)) => points.of(ctx.values).map(Point3::from).collect::<Vec<_>>(),
            (None, None, None) => {
                return Err(BuildError::new(&place, format!("foot `{name}` has no sole"))
                    .help("give the rectangle by `length` and `width`, or the corners by `points`"));
            }
            (_, _, Some(_)) => {
                return Err(BuildError::new(&place, format!("foot `{name}` has two soles, a rectangle and `points`"))
                    .help("write `length` and `width`, or `points`"));
            }
            (_, _, None) => {
                return Err(BuildError::new(&place, format!("the rectangle of foot `{name}` has one side only"))
                    .help("write both `length` and `width`"));
            }
        };
        // Sine of the angle at the first point, as of the three points of a wall.
        let line = |p: &Point3<f64>, q: &Point3<f64>| {
            let (u, v) = (p - points[0], q - points[0]);
            u.cross(&v).norm() <= 1e-5 * u.norm() * v.norm()
        };
        if !points.iter().all(|p| p.coords.iter().all(|x| x.is_finite()))
            || points.iter().all(|p| points.iter().all(|q| line(p, q)))
        {
            return Err(BuildError::new(
                &format!("{place}.points"),
                format!("the points of foot `{name}` lie on one line, and nothing can stand on them"),
            )
            .help("move one of them off the line"));
        }
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        let middle = Point3::from(sum / points.len() as f64);
        Ok(Foot { name: name.to_string(), link, points, middle, carries: params.carries })
    }

    /// w, or from the table of rates its rate in 1/s.
    fn share(&self, table: &[f64]) -> f64 {
        self.carries.of(table)[0]
    }
}

impl Stance {
    /// w of a foot, `time` seconds after the tick.
    fn share(&self, foot: usize, state: &State, time: f64) -> f64 {
        let rate = if time == 0.0 { 0.0 } else { self.feet[foot].share(state.rates) };
        (self.feet[foot].share(state.values) + time * rate).clamp(0.0, 1.0)
    }

    fn middle(&self, state: &State, time: f64) -> Middle {
        let (mut at, mut rate, mut weight) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (i, foot) in self.feet.iter().enumerate() {
            let m = (state.data.pose(foot.link) * foot.middle).coords;
            let share = self.share(i, state, time);
            at += m * share;
            weight += share;
        }
        at /= weight;
        for foot in &self.feet {
            let m = (state.data.pose(foot.link) * foot.middle).coords;
            rate += (m - at) * (foot.share(state.rates) / weight);
        }
        Middle { at, rate, weight }
    }

    /// P of a point from above.
    fn drawn(&self, middle: &Middle, corner: &Corner, state: &State, time: f64) -> Vector2<f64> {
        (middle.at + (corner.at - middle.at) * self.share(corner.foot, state, time)).xy()
    }

    /// Margin of an edge, with its inner normal and s.
    fn side(a: &Vector2<f64>, b: &Vector2<f64>, com: &Vector2<f64>) -> Option<Side> {
        let (along, d) = (b - a, com - a);
        let length = along.norm();
        let e = along / length;
        (length > 0.0).then(|| Side { height: e.perp(&d), normal: Vector3::new(-e.y, e.x, 0.0), s: e.dot(&d) / length })
    }

    /// Adds the row of `factor n·J_P` of a point.
    fn add_corner(&self, corner: &Corner, n: &Vector3<f64>, middle: &Middle, state: &State, row: &mut [f64]) {
        let share = self.share(corner.foot, state, 0.0);
        state.data.add_point(state.model, self.feet[corner.foot].link, &corner.at, &(n * share), row);
        if share < 1.0 {
            for (i, foot) in self.feet.iter().enumerate() {
                let m = (state.data.pose(foot.link) * foot.middle).coords;
                let part = (1.0 - share) * self.share(i, state, 0.0) / middle.weight;
                state.data.add_point(state.model, foot.link, &m, &(n * part), row);
            }
        }
    }

    /// P' of a point.
    fn rate(&self, corner: &Corner, middle: &Middle, state: &State) -> Vector3<f64> {
        let share = self.share(corner.foot, state, 0.0);
        middle.rate * (1.0 - share) + (corner.at - middle.at) * self.feet[corner.foot].share(state.rates)
    }

    /// Computes the points and the hull of this tick.
    fn place(&mut self, state: &State) -> Middle {
        let mut k = 0;
        for foot in &self.feet {
            let pose = state.data.pose(foot.link);
            for p in &foot.points {
                self.corners[k].at = (pose * p).coords;
                k += 1;
            }
        }
        let middle = self.middle(state, 0.0);
        for k in 0..self.corners.len() {
            self.drawn[k] = self.drawn(&middle, &self.corners[k], state, 0.0);
        }
        self.hull.compute(&self.drawn);
        self.ends.fill(None);
        for Edge { from, to } in self.hull.edges() {
            self.ends[from] = Some(to);
        }
        middle
    }
}

/// An edge as the centre of mass sees it.
struct Side {
    /// Distance of the centre of mass from the edge, positive inside, in m.
    height: f64,
    /// n.
    normal: Vector3<f64>,
    s: f64,
}

impl Task for Stance {
    fn rows(&self) -> Vec<RowInfo> {
        let of = |f: &Foot| (1..=f.points.len()).map(|i| format!("{} {i}", f.name)).collect::<Vec<_>>();
        self.feet.iter().flat_map(of).map(|name| RowInfo { name, dimension: LENGTH }).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let ([gain], [margin], [margin_rate]) =
            (self.gain.of(state.values), self.margin.of(state.values), self.margin.of(state.rates));
        let middle = self.place(state);
        let com = self.com.position(state.data);
        if !middle.at.iter().chain(&com).all(|x| x.is_finite()) {
            return Err(TaskFault::NotFinite { row: 0 });
        }
        for a in 0..self.corners.len() {
            let Some(b) = self.ends[a] else { continue };
            let Some(Side { height, normal: n, s }) = Self::side(&self.drawn[a], &self.drawn[b], &com.xy()) else {
                continue;
            };
            let h = height - margin;
            rows.margins[a] = h;
            if rows.is_idle(a) {
                continue;
            }
            let row = rows.row(a);
            let (from, to) = (self.corners[a], self.corners[b]);
            self.com.add_row(state, &n, row);
            self.add_corner(&from, &(n * (s - 1.0)), &middle, state, row);
            self.add_corner(&to, &(n * -s), &middle, state, row);
            let moves = self.rate(&from, &middle, state) * (1.0 - s) + self.rate(&to, &middle, state) * s;
            rows.lower[a] = margin_rate + n.dot(&moves) - gain * h;
            if !rows.lower[a].is_finite() {
                return Err(TaskFault::NotFinite { row: a });
            }
        }
        Ok(())
    }

    fn looks_ahead(&self) -> bool {
        true
    }

    fn reach(&self, chain: f64) -> f64 {
        // The joints move the centre of mass and the feet, each as far as the chain.
        2.0 * chain + self.feet.iter().flat_map(|f| &f.points).map(|p| p.coords.norm()).fold(0.0, f64::max)
    }

    fn margin_after(&self, next: &State, row: usize, period: f64) -> f64 {
        let Some(end) = self.ends.get(row).copied().flatten() else { return f64::INFINITY };
        let middle = self.middle(next, period);
        let at = |k: usize| {
            let foot = &self.feet[self.corners[k].foot];
            let first = self.corners.iter().position(|c| c.foot == self.corners[k].foot).unwrap_or(0);
            let at = (next.data.pose(foot.link) * foot.points[k - first]).coords;
            self.drawn(&middle, &Corner { at, ..self.corners[k] }, next, period)
        };
        let com = self.com.position(next.data);
        let margin = self.margin.of(next.values)[0] + period * self.margin.of(next.rates)[0];
        Self::side(&at(row), &at(end), &com.xy()).map_or(f64::INFINITY, |side| side.height - margin)
    }

    fn doubt(&mut self, state: &State) -> Option<Doubt> {
        self.place(state);
        let [margin] = self.margin.of(state.values);
        let most = self.hull.inradius(&self.drawn);
        if margin >= most {
            let text = format!(
                "`margin` is {:.1} cm, and no point of the polygon is farther than {:.1} cm from its edges",
                100.0 * margin,
                100.0 * most
            );
            return Some(Doubt {
                certain: true,
                ..Doubt::new("margin", text, "write a smaller margin, or larger soles")
            });
        }
        let carrying = |f: usize| self.share(f, state, 0.0) > 0.0;
        let lowest = |f: Option<usize>| {
            let of = self.corners.iter().filter(|c| carrying(c.foot) && f.is_none_or(|f| c.foot == f));
            let (low, high) = of.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c.at.z), h.max(c.at.z)));
            Heights { low, high }
        };
        for (i, foot) in self.feet.iter().enumerate().filter(|(i, _)| carrying(*i)) {
            let Heights { low, high } = lowest(Some(i));
            if high - low > FLAT {
                let text = format!(
                    "foot `{}` is tilted: the points of its sole differ by {:.1} cm in height",
                    foot.name,
                    100.0 * (high - low)
                );
                return Some(Doubt::new(
                    &format!("feet.{}", foot.name),
                    text,
                    "turn the frame of the foot so that its sole is level, or move the home configuration",
                ));
            }
        }
        let Heights { low, high } = lowest(None);
        (high - low > FLAT).then(|| {
            let text = format!("the feet that carry stand {:.1} cm apart in height", 100.0 * (high - low));
            Doubt::new("feet", text, "let the foot in the air not carry, `carries 0`, or move the home configuration")
        })
    }
}

/// Heights of points in the world, in m.
struct Heights {
    low: f64,
    high: f64,
}
