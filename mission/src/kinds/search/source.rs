//! Sources of reward: their sets, boundaries and reward rates, srs 3.1.

use expressions::Function;
use serde::{Deserialize, Serialize};

use super::geometry::{self, Point, distance, edges, inside, nearest_on_segment, to_segment};

/// Distance from a boundary up to which a point is on it (m).
pub const TOUCHES: f64 = 1e-9;

/// A source of reward, `psi`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Name.
    pub name: String,
    /// The set that it belongs to.
    pub kind: SourceKind,
    /// Its boundary, `beta`.
    pub boundary: Boundary,
    /// Internal reward rate, `r_i`.
    pub inside: Rate,
    /// External reward rate, `r_e`.
    pub outside: Rate,
    /// Content at the present, `R`; none: infinite.
    pub pool: Option<f64>,
    /// Indices of the agents that may consume it, `tau`.
    pub targets: Vec<usize>,
    /// It is rewarding only after all of these are consumed: strict precedence.
    pub after: Vec<usize>,
    /// It is rewarding only until one of these is consumed: soft precedence.
    pub until: Vec<usize>,
    /// Agent in whose frame the boundary is, of an interaction source.
    pub of: Option<usize>,
}

/// The sets of srs (7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SourceKind {
    /// Of an element of the environment.
    Environment,
    /// Of the motion of an agent; its axis is the speed or the direction of travel.
    Action,
    /// Of a goal with a fixed place.
    Task,
    /// Of the position relative to an agent.
    Interaction,
}

impl SourceKind {
    /// All kinds, in the order of srs (7).
    pub const ALL: [SourceKind; 4] =
        [SourceKind::Environment, SourceKind::Action, SourceKind::Task, SourceKind::Interaction];
    /// Their names.
    pub const NAMES: [&str; 4] = ["environment", "action", "task", "interaction"];

    /// Name, as in specs.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// The boundary of a source, `beta`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Boundary {
    /// A polygon (m).
    Polygon(Vec<Point>),
    /// A circle.
    Circle {
        /// Its centre (m).
        centre: Point,
        /// Its radius (m), more than 0.
        radius: f64,
    },
    /// A polyline without an inside (m).
    Line(Vec<Point>),
    /// Points (m).
    Points(Vec<Point>),
    /// An interval of speeds (m/s).
    Speed([f64; 2]),
    /// An interval of directions of travel (rad), from the x axis of the map to the left; it may pass half a turn.
    Heading([f64; 2]),
}

/// The motion of an agent at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Speed (m/s).
    pub speed: f64,
    /// Direction (rad); without a meaning at rest.
    pub heading: f64,
}

impl Travel {
    /// No motion.
    pub const REST: Travel = Travel { speed: 0.0, heading: 0.0 };
}

/// Position of a point relative to a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Inside, or on the boundary.
    pub inside: bool,
    /// Length of the vector from the nearest point of the boundary, `p_beta`.
    pub distance: f64,
}

impl Boundary {
    /// Returns the side of a point of the ground; every point is outside an interval of motions.
    pub fn side(&self, p: Point) -> Side {
        let least = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::INFINITY, f64::min);
        match self {
            Boundary::Polygon(corners) => {
                let distance = least(&mut edges(corners).map(|[a, b]| to_segment(p, a, b)));
                Side { inside: distance <= TOUCHES || inside(p, corners), distance }
            }
            Boundary::Circle { centre, radius } => {
                let from = distance(p, *centre) - radius;
                Side { inside: from <= TOUCHES, distance: from.abs() }
            }
            Boundary::Line(points) => {
                let distance = least(&mut points.windows(2).map(|two| to_segment(p, two[0], two[1])));
                Side { inside: distance <= TOUCHES, distance }
            }
            Boundary::Points(points) => {
                let distance = least(&mut points.iter().map(|q| distance(p, *q)));
                Side { inside: distance <= TOUCHES, distance }
            }
            Boundary::Speed(_) | Boundary::Heading(_) => Side { inside: false, distance: f64::INFINITY },
        }
    }

    /// Returns true if a motion is in an interval of motions.
    fn has(&self, travel: Travel) -> bool {
        match self {
            Boundary::Speed([low, high]) => (*low..=*high).contains(&travel.speed),
            Boundary::Heading([low, high]) => {
                let turn = std::f64::consts::TAU;
                let turned = (travel.heading - low).rem_euclid(turn);
                // Rounding may leave the begin of the interval just below a whole turn.
                turned <= high - low + TOUCHES || turn - turned <= TOUCHES
            }
            _ => false,
        }
    }

    /// Returns the vector from its nearest point to a point of the ground (m), `p_beta` of srs (1).
    fn away(&self, p: Point) -> Point {
        let from = |q: Point| [p[0] - q[0], p[1] - q[1]];
        let nearest = |all: &mut dyn Iterator<Item = Point>| {
            let nearest = all.min_by(|a, b| distance(p, *a).total_cmp(&distance(p, *b)));
            nearest.map_or([0.0; 2], from)
        };
        match self {
            Boundary::Polygon(corners) => nearest(&mut edges(corners).map(|[a, b]| nearest_on_segment(p, a, b))),
            Boundary::Circle { centre, radius } => {
                let [x, y] = from(*centre);
                let length = x.hypot(y);
                // At the centre all points of the boundary are equally near, and the one on the x axis stands for them.
                if length == 0.0 { [-radius, 0.0] } else { [x, y].map(|c| c * (1.0 - radius / length)) }
            }
            Boundary::Line(points) => nearest(&mut points.windows(2).map(|two| nearest_on_segment(p, two[0], two[1]))),
            Boundary::Points(points) => nearest(&mut points.iter().copied()),
            Boundary::Speed(_) | Boundary::Heading(_) => [0.0; 2],
        }
    }

    /// Returns its points (m); of an interval of motions there are none.
    pub fn points(&self) -> Vec<Point> {
        match self {
            Boundary::Polygon(points) | Boundary::Line(points) | Boundary::Points(points) => points.clone(),
            Boundary::Circle { centre, .. } => vec![*centre],
            Boundary::Speed(_) | Boundary::Heading(_) => Vec::new(),
        }
    }
}

/// A reward rate (1/s) as a function of the vector from the boundary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Its value at the boundary; of `Rising` the value that it approaches. Not used if there is a function.
    pub peak: f64,
    /// Its form.
    pub fall: Fall,
    /// Length of the form (m), more than 0.
    pub scale: f64,
    /// The value as a function, which the form multiplies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub function: Option<RateFunction>,
}

/// A rate as a function of the distance from the boundary and of the vector from its nearest point, or of a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateFunction {
    /// The function; [`RateFunction::ARGUMENTS`] are the numbers that it depends on.
    pub of: Function,
    /// Extent of its values on the ground.
    pub extent: Extent,
}

/// Values of a rate on the ground, found on a raster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extent {
    /// The least one (1/s).
    pub least: f64,
    /// The greatest one (1/s).
    pub greatest: f64,
    /// Distance from the boundary up to which it is at least half the greatest one (m).
    pub reach: f64,
}

impl RateFunction {
    /// Number of its arguments: the distance and three numbers of the vector (m), the speed (m/s) and the heading (rad).
    pub const ARGUMENTS: usize = 6;
    /// Those of them that are of a place.
    pub const OF_PLACE: std::ops::Range<usize> = 0..4;
    /// The speed.
    pub const SPEED: usize = 4;
    /// The heading.
    pub const HEADING: usize = 5;
}

/// Form of a reward rate over the distance `d` from the boundary, with the length `l`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fall {
    /// `1`
    Constant,
    /// `max(0, 1 - d / l)`
    Linear,
    /// `exp(-d / l)`
    Exponential,
    /// `exp(-d^2 / (2 l^2))`
    Gaussian,
    /// `1 - exp(-d / l)`
    Rising,
}

impl Fall {
    /// All forms.
    pub const ALL: [Fall; 5] = [Fall::Constant, Fall::Linear, Fall::Exponential, Fall::Gaussian, Fall::Rising];
    /// Their names.
    pub const NAMES: [&str; 5] = ["constant", "linear", "exponential", "gaussian", "rising"];

    /// Name, as in specs.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

impl Rate {
    /// No reward.
    pub const ZERO: Rate = Rate { peak: 0.0, fall: Fall::Constant, scale: 1.0, function: None };

    /// A constant rate (1/s).
    pub fn constant(peak: f64) -> Rate {
        Rate { peak, ..Rate::ZERO }
    }

    /// Returns the least and the greatest rate (1/s) on the ground; of a function as they were found on a raster.
    pub fn range(&self) -> [f64; 2] {
        match &self.function {
            None => [self.peak; 2],
            Some(function) => [function.extent.least, function.extent.greatest],
        }
    }

    /// Returns true if it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        self.range() == [0.0; 2]
    }

    /// Returns the distance from the boundary beyond which it is small (m).
    pub fn reach(&self) -> f64 {
        self.function.as_ref().map_or(self.scale, |function| function.extent.reach)
    }

    /// Returns the rate (1/s) at a distance from the boundary (m); `away` returns the vector from the boundary (m). A function
    /// that has no finite value gives no reward: a problem in which one has none on the raster is refused.
    pub fn at(&self, distance: f64, away: impl FnOnce() -> Point) -> f64 {
        let x = self.raw(distance, away);
        if x.is_finite() { x } else { 0.0 }
    }

    /// Returns the rate (1/s), which may be not finite.
    pub(super) fn raw(&self, distance: f64, away: impl FnOnce() -> Point) -> f64 {
        let value = match &self.function {
            None => self.peak,
            Some(function) => {
                let [x, y] = away();
                function.of.evaluate(&[distance, x, y, 0.0, 0.0, 0.0])
            }
        };
        value * self.share(distance)
    }

    /// Returns the rate (1/s) of a motion, which may be not finite.
    fn raw_of(&self, travel: Travel) -> f64 {
        match &self.function {
            None => self.peak,
            Some(function) => function.of.evaluate(&[0.0, 0.0, 0.0, 0.0, travel.speed, travel.heading]),
        }
    }

    /// Returns its form at a distance from the boundary (m).
    fn share(&self, distance: f64) -> f64 {
        let d = distance / self.scale;
        match self.fall {
            Fall::Constant => 1.0,
            Fall::Linear => (1.0 - d).max(0.0),
            Fall::Exponential => (-d).exp(),
            Fall::Gaussian => (-0.5 * d * d).exp(),
            Fall::Rising => -(-d).exp_m1(),
        }
    }
}

impl Source {
    /// Returns the reward rate (1/s) at a point, srs (1), which of an interaction source is in the frame of the agent.
    pub fn rate(&self, p: Point) -> f64 {
        let (rate, distance) = self.rate_at(p);
        rate.at(distance, || self.boundary.away(p))
    }

    /// Returns the reward rate (1/s) of a motion, of an action source. Who stands has no direction: a source of directions gives
    /// nothing then.
    pub fn rate_of(&self, travel: Travel) -> f64 {
        let rate = self.raw_of(travel);
        if rate.is_finite() { rate } else { 0.0 }
    }

    fn raw_of(&self, travel: Travel) -> f64 {
        if travel.speed == 0.0 && matches!(self.boundary, Boundary::Heading(_)) {
            return 0.0;
        }
        if self.boundary.has(travel) { self.inside.raw_of(travel) } else { self.outside.raw_of(travel) }
    }

    /// Returns the rate that holds at a point, and the distance of the point from the boundary (m).
    fn rate_at(&self, p: Point) -> (&Rate, f64) {
        let side = self.boundary.side(p);
        (if side.inside { &self.inside } else { &self.outside }, side.distance)
    }

    /// Finds the values of its functions on a raster: of the ground, of which `low` and `high` are corners (m), or of the
    /// motions up to the greatest speed (m/s) of an agent.
    ///
    /// # Errors
    /// A point or a motion for which one has no finite value.
    pub fn survey(&mut self, [low, high]: [Point; 2], fastest: f64) -> Result<(), NoValue> {
        if self.inside.function.is_none() && self.outside.function.is_none() {
            return Ok(());
        }
        if self.kind == SourceKind::Action {
            return self.survey_motions(fastest).map_err(NoValue::Of);
        }
        let ground = [high[0] - low[0], high[1] - low[1]];
        let whole = match self.kind {
            SourceKind::Interaction => [ground.map(|x| -x), ground],
            _ => [low, high],
        };
        let radius = if let Boundary::Circle { radius, .. } = self.boundary { radius } else { 0.0 };
        let [near, far] = geometry::bounds(self.boundary.points());
        let around = [near.map(|x| x - radius - NEAR), far.map(|x| x + radius + NEAR)];
        let own = self.boundary.points();
        let points: Vec<Point> = [whole, around].into_iter().flat_map(raster).chain(own).collect();
        let mut samples: [Vec<(f64, f64)>; 2] = Default::default();
        // Without a sound map or boundary, which is reported, there is no raster.
        for p in points.into_iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            let (rate, distance) = self.rate_at(p);
            let value = rate.raw(distance, || self.boundary.away(p));
            if !value.is_finite() {
                return Err(NoValue::At(p));
            }
            samples[usize::from(std::ptr::eq(rate, &self.outside))].push((distance, value));
        }
        for (rate, samples) in [&mut self.inside, &mut self.outside].into_iter().zip(samples) {
            let Some(function) = &mut rate.function else { continue };
            let values = || samples.iter().map(|(_, value)| *value);
            let greatest = values().reduce(f64::max).unwrap_or_default();
            let half = samples.iter().filter(|(_, value)| *value >= 0.5 * greatest).map(|(distance, _)| *distance);
            let reach = half.fold(0.0, f64::max);
            function.extent = Extent { least: values().reduce(f64::min).unwrap_or_default(), greatest, reach };
        }
        Ok(())
    }

    fn survey_motions(&mut self, fastest: f64) -> Result<(), Travel> {
        let share = |i: usize| i as f64 / RASTER as f64;
        let directions = if matches!(self.boundary, Boundary::Heading(_)) { RASTER } else { 1 };
        let mut values: [Vec<f64>; 2] = Default::default();
        for (i, j) in (0..=RASTER).flat_map(|i| (0..directions).map(move |j| (i, j))) {
            let heading = std::f64::consts::TAU * (share(j) - 0.5);
            let travel = Travel { speed: fastest * share(i), heading };
            let value = self.raw_of(travel);
            if !value.is_finite() {
                return Err(travel);
            }
            values[usize::from(!self.boundary.has(travel))].push(value);
        }
        for (rate, values) in [&mut self.inside, &mut self.outside].into_iter().zip(values) {
            let Some(function) = &mut rate.function else { continue };
            let of = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick).unwrap_or_default();
            function.extent = Extent { least: of(f64::min), greatest: of(f64::max), reach: 0.0 };
        }
        Ok(())
    }

    /// Returns true if its rate can be negative.
    pub fn repels(&self) -> bool {
        self.inside.range()[0] < 0.0 || self.outside.range()[0] < 0.0
    }

    /// Returns true if its rate can be positive.
    pub fn attracts(&self) -> bool {
        let has_inside = !matches!(self.boundary, Boundary::Line(_) | Boundary::Points(_));
        (has_inside && self.inside.range()[1] > 0.0) || self.outside.range()[1] > 0.0
    }
}

/// Point or motion for which a rate has no finite value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoValue {
    /// At a point (m): of an interaction source relative to its agent.
    At(Point),
    /// For a motion.
    Of(Travel),
}

/// Number of points along each side of a raster on which functions are looked at.
const RASTER: usize = 48;
/// Distance around a boundary that has a raster of its own (m).
const NEAR: f64 = 1.0;

/// Points of a raster over a box.
fn raster([low, high]: [Point; 2]) -> impl Iterator<Item = Point> {
    let at = move |i: usize, axis: usize| low[axis] + (i as f64 + 0.5) / RASTER as f64 * (high[axis] - low[axis]);
    (0..RASTER * RASTER).map(move |i| [at(i % RASTER, 0), at(i / RASTER, 1)])
}
