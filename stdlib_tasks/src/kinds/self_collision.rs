//! Keeps parts of the robot apart.
//!
//! ```text
//! h(q) = |p_j - p_l| - d_min          [m]    safe where h >= 0            thesis (3.21), (3.22)
//! n·(J_j - J_l) v >= d_min' - φ (h - δ)      [m/s]   n from p_l to p_j    thesis (3.23), (3.24)
//! ```

use std::collections::BTreeSet;

use robot::{LinkId, Model, contacts};

use crate::bound::{BoundParams, ExceptedPair, Geometry};
use crate::build::check;
use crate::closest_points::SeparationError;
use crate::dimension::LENGTH;
use crate::gradient_bound;
use crate::params::{Auto, Input, ParamType, Presence, Quantity};
use crate::part_pairs::{PartPairs, Two};
use crate::protection::{Hazard, Protection};
use crate::sampled_margin::{SampledMargin, extent, separation_bound};
use crate::task::{BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use quantities::usual;

crate::params! {
    /// Parameters of `self_collision`.
    pub struct Params {
        /// One side: points, segments, links with their collision shapes, groups of them; `all` for all links with shapes.
        between: Vec<Geometry> = ParamType::Geometries, Presence::Required;
        /// The other side, likewise. Without it, the parts of `between` are kept apart from each other.
        and: Option<Vec<Geometry>> = ParamType::Geometries, Presence::Optional;
        /// Pairs of links to leave out, `[[hand, wrist], ..]`; a group stands for its links. Without `and`, also the pairs
        /// that the robot's `srdf` disables, and those that touch at every sampled posture.
        except: Option<Vec<ExceptedPair>> = ParamType::Pairs("and"), Presence::Optional;
        /// d_min: smallest distance between the two sides.
        d_min: Input<1> = ParamType::Scalar(usual::CLEARANCE), Presence::Required;
        /// φ: how fast the margin may decrease, relative to its size.
        gain: Input<1> = ParamType::Scalar(usual::LIMIT_GAIN), Presence::Default("10 /s");
        /// δ: a constant reserve for what sampling in time can lose; `auto` computes it from the hard speed limits, for all
        /// joints at full speed. Without it, a limit on a hard level looks ahead: its row asks at each tick for what the
        /// velocity of that tick would lose.
        sampled_margin: Option<Auto> = ParamType::AutoScalar(Quantity::at_least(LENGTH, 0.0).usually(1e-8, 1.0).constant()), Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "self_collision",
    summary: "keeps parts of the robot apart",
    docs: "One inequality row for each pair of a part j of `between` and a part l of `and`, except pairs that \
cannot move relative to each other. Without `and`, one row for each pair of parts of `between`, except neighbours: \
links that at most one joint moves against each other, which meet at that joint.\n\n\
```text\n\
h = |p_j - p_l| - d_min                   [m]     safe where h >= 0\n\
n·(J_j - J_l) v  >=  d_min' - φ (h - δ)   [m/s]   n = (p_j - p_l)/|p_j - p_l|\n\n\
p_j, p_l  3×1  m              closest points of the two parts in the world\n\
n         3×1                 unit vector from p_l to p_j in the world\n\
J_j, J_l  3×n  m/rad or m/m   Jacobians of p_j and p_l in the world's axes\n\
v         n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
d_min'         m/s            time derivative of d_min\n\
φ              1/s            gain\n\
δ              m              reserve, `sampled_margin`; otherwise 0\n\
```\n\n\
The closest points have exact closed forms for all pairs of points, segments, spheres, capsules and boxes. A \
cylinder of the URDF is replaced by the capsule that contains it, a mesh by its bounding capsule, unless the robot names \
the link under `hulls` or `pieces`; each piece is a part with rows of its own. The distance \
is negative if the surfaces overlap. If the cores of two parts (the points, segments or boxes inside their \
radii) meet, no direction leads apart: the task keeps the last valid direction and closest points. If there were \
none, this is a fault.\n\n\
A distance is curved, and a velocity that meets its row can lose some of it until the next tick. Without \
`sampled_margin`, a task on a hard level looks ahead: the distances after one period with the chosen velocity are \
computed, and if `h` were below zero there, the row asks for the difference and the hierarchy is solved again. If no \
other velocity is possible, the robot moves more slowly. `h` then stays at or above zero at every tick, and nothing is \
lost at rest. A task on a soft level does not look ahead.\n\n\
`sampled_margin auto` sets `δ = A T / (2 φ)` with the control period T instead. A bounds the relative acceleration at \
the speeds that `joint_velocity_limits` allow, on the hard levels down to that of the task. The robot stays δ away, \
and no hierarchy is solved twice. For a point or a sphere against any part, `h` stays at or above zero at every tick, \
if `φ T <= 1` and `d_min` is constant or moves at a constant rate. If two long parts become parallel, the closest \
points can jump, and the margin can lose more. `sampled_margin 0 m` accepts the loss.\n\n\
`between all` without `and` guards the whole robot, with a row for each pair of shapes: `hierarq compile` prints \
their number, and the pairs that are left out with the reasons. Every row is evaluated in each tick, and only few of \
them act in the solver; to pay for fewer, name the links that can meet. A pair that touches at home is not a limit that \
can be kept: name it in `except`, or disable it in the SRDF. Pairs that touch at home and at each of 1000 random postures \
are left out by themselves.\n\n\
Source: thesis (3.21)-(3.24); printed there with `h` and `J` both negated, which would bound the distance from above.",
    example: "task arms_apart = self_collision { between left_elbow  and right_elbow  d_min 0.2 m  gain 10 /s }",
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

struct SelfCollision {
    pairs: PartPairs,
    d_min: Input<1>,
    gain: Input<1>,
    sampled_margin: SampledMargin,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let sides = [("between", Some(&params.between)), ("and", params.and.as_ref())];
    for (name, side) in sides {
        if side.is_some_and(Vec::is_empty) {
            return Err(BuildError::new(name, "this side names nothing to keep apart")
                .help("name points, segments, links or groups of them, or remove the task"));
        }
    }
    let excepted: BTreeSet<[LinkId; 2]> = params.except.iter().flatten().map(|pair| pair.links).collect();
    let is_open = |a: &Geometry, b: &Geometry| !excepted.contains(&contacts::pair(a.link, b.link));
    let pairs = match &params.and {
        Some(and) => pairs_of_sides(ctx.model, &params.between, and, is_open)?,
        None => pairs_within(ctx.model, &params.between, is_open)?,
    };
    let names: Vec<&str> = pairs.iter().map(|[a, _]| a.name.as_str()).collect();
    let of_pair = |i: usize, speed: &[f64]| pairs.get(i).map_or(0.0, |[a, b]| separation_bound(a, b, ctx.model, speed));
    let sampled_margin =
        SampledMargin::new(params.sampled_margin, params.gain.of(ctx.values)[0], &names, &of_pair, ctx)?;
    Ok(Box::new(SelfCollision { pairs, d_min: params.d_min, gain: params.gain, sampled_margin }))
}

/// Pairs of a part of each side.
fn pairs_of_sides(
    model: &Model,
    between: &[Geometry],
    and: &[Geometry],
    is_open: impl Fn(&Geometry, &Geometry) -> bool,
) -> Result<PartPairs, BuildError> {
    // A part of both sides is one part.
    let mut parts: Vec<Geometry> = Vec::new();
    let mut index = |part: &Geometry| {
        parts.iter().position(|p| p == part).unwrap_or_else(|| {
            parts.push(part.clone());
            parts.len() - 1
        })
    };
    let mut sides = [between, and].map(|side| side.iter().map(&mut index).collect::<Vec<usize>>());
    let and = std::mem::take(&mut sides[1]);
    let mut pairs: Vec<Two> = Vec::new();
    let mut excepted = false;
    for &i in &sides[0] {
        for &j in &and {
            let (a, b) = (&parts[i], &parts[j]);
            if model.moves_between(a.link, b.link) && !pairs.contains(&[j, i]) {
                match is_open(a, b) {
                    true => pairs.push([i, j]),
                    false => excepted = true,
                }
            }
        }
    }
    match (pairs.is_empty(), excepted) {
        (false, _) => Ok(PartPairs::new(parts, pairs)),
        (true, true) => {
            Err(BuildError::new("except", "nothing is left of the two sides").help("leave fewer pairs out"))
        }
        (true, false) => {
            Err(BuildError::new("and", "the two sides name only parts that cannot move against each other")
                .help("name parts of other links on one side"))
        }
    }
}

/// Pairs of parts of one side whose links are no neighbours.
fn pairs_within(
    model: &Model,
    parts: &[Geometry],
    is_open: impl Fn(&Geometry, &Geometry) -> bool,
) -> Result<PartPairs, BuildError> {
    let mut pairs: Vec<Two> = Vec::new();
    for (i, a) in parts.iter().enumerate() {
        let is_other = |b: &Geometry| !contacts::are_neighbours(model, a.link, b.link) && is_open(a, b);
        pairs.extend((i + 1..parts.len()).filter(|j| is_other(&parts[*j])).map(|j| [i, j]));
    }
    if pairs.is_empty() {
        return Err(BuildError::new("between", "no two of these parts are left to keep apart")
            .help("name parts of links that are no neighbours, or name the other side with `and`"));
    }
    Ok(PartPairs::new(parts.to_vec(), pairs))
}

impl Task for SelfCollision {
    fn rows(&self) -> Vec<RowInfo> {
        let name = |[a, b]: [&Geometry; 2]| format!("{} to {}", a.name, b.name);
        self.pairs.iter().map(|pair| RowInfo { name: name(pair), dimension: LENGTH }).collect()
    }

    fn protections(&self) -> Vec<Protection> {
        let one = |[a, b]: [&Geometry; 2]| Protection { links: vec![a.link], hazard: Hazard::Link(b.link) };
        self.pairs.iter().map(one).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn enter(&mut self, _state: &State) {
        self.pairs.forget();
    }

    crate::task::takes_over!(pairs);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let ([gain], [d_min]) = (self.gain.of(state.values), self.d_min.of(state.values));
        let [d_min_rate] = self.d_min.of(state.rates);
        self.pairs.find(state);
        for i in 0..self.pairs.len() {
            let apart = self.pairs.separation(i).map_err(|e| match e {
                SeparationError::NotFinite => TaskFault::NotFinite { row: i },
                SeparationError::Overlap => TaskFault::Overlap { row: i },
            })?;
            let h = apart.distance - d_min;
            rows.margins[i] = h;
            if rows.is_idle(i) {
                continue;
            }
            self.pairs.add_row(state, i, apart, rows.row(i));
            rows.lower[i] = d_min_rate - gain * h + self.sampled_margin.rate(i, gain);
        }
        Ok(())
    }

    fn set_locked_joints_moving(&mut self, moving: bool) {
        self.sampled_margin.set_locked_joints_moving(moving);
    }

    fn gradient_bounds(&self, model: &Model) -> Vec<Vec<f64>> {
        self.pairs.iter().map(|[a, b]| gradient_bound::between(model, a, b)).collect()
    }

    fn looks_ahead(&self) -> bool {
        self.sampled_margin.looks_ahead
    }

    fn reach(&self, chain: f64) -> f64 {
        chain + self.pairs.iter().flatten().map(extent).fold(0.0, f64::max)
    }

    fn margin_after(&self, next: &State, row: usize, period: f64) -> f64 {
        let ([d_min], [d_min_rate]) = (self.d_min.of(next.values), self.d_min.of(next.rates));
        self.pairs.distance(row, next) - d_min - period * d_min_rate
    }

    fn sampled_loss(&self) -> Vec<f64> {
        self.sampled_margin.loss.clone()
    }

    fn sampled_margin(&self) -> Vec<f64> {
        self.sampled_margin.kept.clone()
    }
}
