//! The schedule as a mixed-integer program in position form: job `j` is the `k`-th trip of robot `m`.
//!
//! `X[j,m,k]` is 1 if it is. The number of trips of each robot is either given, and then the trips before and after a
//! position bound its times; or positions are filled from the last one down, so that a robot's last trip is always in
//! its last position. `T[j,m,k]` is the start of the service, and 0 if `X` is 0: so sums over jobs are the starts of
//! positions, and the latest start is the only large constant. Durations belong to positions. The energy `l^2 / D` is
//! jointly convex in length and duration, and its tangent at speed `v` is `2 v l - v^2 D`: the tangents of a position
//! are valid for any job in it, and exact if the job uses one of their speeds. So the program bounds the cost from
//! below.

use crate::engine::Model;

use super::bounds::Bounds;
use super::instance::{Instance, Sequence};

/// Speeds (m/s) of the tangents, of each robot on each of the three legs. Ascending.
pub(crate) type Tangents = Vec<[Vec<f64>; 3]>;

/// Number of speeds of the first tangents of a leg, from the slowest to the fastest.
const FIRST: usize = 5;

/// The program, with the columns of the assignment.
pub(crate) struct Position {
    pub model: Model,
    /// Column of `X[j,m,k]`, by robot, position and job.
    assigned: Vec<Vec<Vec<usize>>>,
    /// True if the number of trips is given.
    given: bool,
}

/// Terms of a linear expression.
type Terms = Vec<(usize, f64)>;

/// Creates the first tangents, distributed over the permitted speeds of a robot.
pub(crate) fn first_tangents(instance: &Instance) -> Tangents {
    let of = |m: usize, z: usize| {
        let ways = instance.jobs.iter().map(|job| job.ways[m][z]).filter(|way| way.bend > 0.0 && !way.is_fixed());
        let (low, high) = ways.fold((f64::INFINITY, 0.0_f64), |(low, high), way| {
            (low.min(way.length / way.high), high.max(way.length / way.low))
        });
        if high <= 0.0 {
            return Vec::new();
        }
        let step = (high / low).powf(1.0 / (FIRST - 1) as f64);
        (0..FIRST).map(|k| low * step.powi(k as i32)).collect()
    };
    (0..instance.free.len()).map(|m| [of(m, 0), of(m, 1), of(m, 2)]).collect()
}

/// A robot's position on one of its legs.
struct Slot {
    duration: Terms,
}

struct Builder<'a, 'b> {
    instance: &'a Instance<'b>,
    model: Model,
    /// Seconds in a unit of time of the program.
    unit: f64,
    /// Number of trips of each robot, if given.
    trips: Option<&'a [usize]>,
    assigned: Vec<Vec<Vec<usize>>>,
    started: Vec<Vec<Vec<usize>>>,
}

impl Position {
    /// Builds the program of an instance. Its feasible set contains every schedule within the bounds, or only those
    /// with the given number of trips of each robot if `trips` is set.
    pub fn new(instance: &Instance, bounds: &Bounds, tangents: &Tangents, trips: Option<&[usize]>) -> Position {
        let (count, robots) = (instance.jobs.len(), instance.free.len());
        let unit = (0..count).flat_map(|j| (0..robots).map(move |m| instance.longest(j, m))).fold(1.0, f64::max);
        let mut builder =
            Builder { instance, model: Model::default(), unit, trips, assigned: Vec::new(), started: Vec::new() };
        let zero = instance.problem.start;
        let end = builder.model.real(
            instance.makespan_cost * unit,
            ((instance.busy - zero) / unit).max(0.0),
            if bounds.end.is_finite() { (bounds.end - zero) / unit } else { f64::INFINITY },
        );
        let fixed: f64 = instance.jobs.iter().map(|job| job.start_cost).sum();
        builder.model.offset = instance.constant + (fixed + instance.makespan_cost) * zero;
        for robot in 0..robots {
            builder.columns(bounds, robot);
        }
        for robot in 0..robots {
            builder.robot(bounds, tangents, robot, end);
        }
        builder.jobs();
        if trips.is_none() {
            builder.symmetry();
        }
        Position { model: builder.model, assigned: builder.assigned, given: trips.is_some() }
    }

    /// Reads the sequence from a point.
    pub fn sequence(&self, point: &[f64]) -> Sequence {
        let job = |columns: &Vec<usize>| columns.iter().position(|column| point[*column] > 0.5);
        self.assigned.iter().map(|positions| positions.iter().filter_map(job).collect()).collect()
    }

    /// Returns the point of a sequence in the integer columns, as a start of the search; empty if the sequence does not
    /// fit the numbers of trips of the program.
    pub fn point(&self, sequence: &Sequence) -> Vec<(usize, f64)> {
        let mut point = Vec::new();
        for (positions, jobs) in self.assigned.iter().zip(sequence) {
            let Some(unused) = positions.len().checked_sub(jobs.len()) else { return Vec::new() };
            if self.given && unused > 0 {
                return Vec::new();
            }
            for (k, columns) in positions.iter().enumerate() {
                let here = k.checked_sub(unused).map(|place| jobs[place]);
                let value = |job: usize| if here == Some(job) { 1.0 } else { 0.0 };
                point.extend(columns.iter().enumerate().map(|(job, column)| (*column, value(job))));
            }
        }
        point
    }
}

impl Builder<'_, '_> {
    /// Adds the columns `X` and `T` of a robot.
    fn columns(&mut self, bounds: &Bounds, robot: usize) {
        let (zero, unit) = (self.instance.problem.start, self.unit);
        let (mut assigned, mut started) = (Vec::new(), Vec::new());
        let slots = self.slots(bounds, robot);
        let blocks = self.blocks(robot);
        for k in 0..slots {
            let (mut xs, mut ts) = (Vec::new(), Vec::new());
            for (index, job) in self.instance.jobs.iter().enumerate() {
                let constants: f64 = job.ways[robot]
                    .iter()
                    .map(|way| if way.is_fixed() { way.cost(way.low) } else { way.constant })
                    .sum();
                let x = self.model.binary(constants + job.serve_cost * self.instance.serve(robot));
                let t = self.model.real(job.start_cost * unit, 0.0, f64::INFINITY);
                let (mut earliest, mut latest) = (bounds.earliest[index][robot], bounds.latest[index]);
                if self.trips.is_some() {
                    let tail = self.instance.shortest(index, robot) - job.ways[robot][0].low - job.ways[robot][1].low;
                    let lead = job.ways[robot][0].low + job.ways[robot][1].low;
                    earliest = earliest.max(self.instance.free[robot] + blocks[k] + lead);
                    latest = latest.min(bounds.end - blocks[slots - 1 - k] - tail);
                }
                if earliest > latest + 1e-6 {
                    self.model.columns[x].high = 0.0;
                }
                let (earliest, latest) = ((earliest - zero) / unit, (latest.max(earliest) - zero) / unit);
                self.model.at_least(0.0, [(t, 1.0), (x, -earliest)]);
                self.model.at_most([(t, 1.0), (x, -latest)], 0.0);
                xs.push(x);
                ts.push(t);
            }
            assigned.push(xs);
            started.push(ts);
        }
        self.assigned.push(assigned);
        self.started.push(started);
    }

    /// Returns the number of positions of a robot.
    fn slots(&self, bounds: &Bounds, robot: usize) -> usize {
        self.trips.map_or(bounds.trips[robot], |trips| trips[robot])
    }

    /// Returns lower bounds on the duration (s) of 0, 1, 2, ... trips of a robot.
    fn blocks(&self, robot: usize) -> Vec<f64> {
        let mut blocks: Vec<f64> =
            (0..self.instance.jobs.len()).map(|job| self.instance.shortest(job, robot)).collect();
        blocks.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        let sums = blocks.into_iter().map(|block| {
            sum += block;
            sum
        });
        std::iter::once(0.0).chain(sums).collect()
    }

    /// Adds the duration of a leg in a position, with its energy in the cost.
    fn slot(&mut self, tangents: &Tangents, robot: usize, k: usize, z: usize) -> Slot {
        let unit = self.unit;
        let columns = self.assigned[robot][k].clone();
        let ways: Vec<_> = self.instance.jobs.iter().map(|job| job.ways[robot][z]).zip(columns).collect();
        let mut duration: Terms =
            ways.iter().filter(|(way, _)| way.is_fixed()).map(|(way, x)| (*x, way.low / unit)).collect();
        let mut free: Vec<_> = ways.into_iter().filter(|(way, _)| !way.is_fixed()).collect();
        // Jobs with the same cost of a joule share one duration; each other weight has its own.
        free.sort_by(|a, b| a.0.weight.total_cmp(&b.0.weight));
        for class in free.chunk_by(|a, b| a.0.weight == b.0.weight) {
            let energy = self.instance.machine(robot).energy;
            let weight = class[0].0.weight;
            let d = self.model.real(weight * energy.standby * unit, 0.0, f64::INFINITY);
            self.model.at_least(0.0, class.iter().map(|(way, x)| (*x, -way.low / unit)).chain([(d, 1.0)]));
            self.model.at_most(class.iter().map(|(way, x)| (*x, -way.high / unit)).chain([(d, 1.0)]), 0.0);
            duration.push((d, 1.0));
            let speeds = &tangents[robot][z];
            if weight * energy.drag > 0.0 && !speeds.is_empty() {
                // l^2 / D = v_ref^2 unit (l / (v_ref unit))^2 / (D / unit)
                let reference = speeds[speeds.len() / 2];
                let u = self.model.real(weight * energy.drag * reference * reference * unit, 0.0, f64::INFINITY);
                for speed in speeds {
                    let v = speed / reference;
                    let lengths = class.iter().map(|(way, x)| (*x, -2.0 * v * way.length / (reference * unit)));
                    self.model.at_least(0.0, lengths.chain([(u, 1.0), (d, v * v)]));
                }
            }
        }
        Slot { duration }
    }

    /// Adds the constraints along the positions of a robot.
    fn robot(&mut self, bounds: &Bounds, tangents: &Tangents, robot: usize, end: usize) {
        let (instance, unit) = (self.instance, self.unit);
        let (serve, deposit) = (instance.serve(robot) / unit, instance.deposit(robot) / unit);
        let free = (instance.free[robot] - instance.problem.start) / unit;
        let scaled = |terms: &Terms, factor: f64| -> Terms { terms.iter().map(|(c, v)| (*c, v * factor)).collect() };
        let mut before: Option<(Terms, Terms)> = None;
        for k in 0..self.slots(bounds, robot) {
            let used: Terms = self.assigned[robot][k].iter().map(|x| (*x, 1.0)).collect();
            let start: Terms = self.started[robot][k].iter().map(|t| (*t, 1.0)).collect();
            if self.trips.is_some() {
                self.model.row(1.0, used.iter().copied(), 1.0);
            }
            let slots = [0, 1, 2].map(|z| self.slot(tangents, robot, k, z));
            let mut arrive = start.clone();
            arrive.extend(scaled(&slots[0].duration, -1.0));
            arrive.extend(scaled(&slots[1].duration, -1.0));
            let mut from_depot = arrive.clone();
            from_depot.extend(scaled(&used, -free));
            self.model.at_least(0.0, from_depot);
            if let Some((home, earlier)) = before {
                let mut chain = arrive;
                chain.extend(scaled(&home, -1.0));
                self.model.at_least(0.0, chain);
                if self.trips.is_none() {
                    let mut filled = used.clone();
                    filled.extend(scaled(&earlier, -1.0));
                    self.model.at_least(0.0, filled);
                }
            }
            let mut home = start;
            home.extend(scaled(&used, serve + deposit));
            home.extend(slots[2].duration.iter().copied());
            before = Some((home, used));
        }
        if let Some((home, used)) = before {
            self.model.at_most(used, 1.0);
            let mut last = scaled(&home, -1.0);
            last.push((end, 1.0));
            self.model.at_least(0.0, last);
        }
    }

    /// Each job is done once, and after the previous one of its agent.
    fn jobs(&mut self) {
        let all = |columns: &Vec<Vec<Vec<usize>>>, job: usize| -> Vec<(usize, usize)> {
            columns.iter().enumerate().flat_map(|(m, slots)| slots.iter().map(move |slot| (m, slot[job]))).collect()
        };
        for (index, job) in self.instance.jobs.iter().enumerate() {
            self.model.row(1.0, all(&self.assigned, index).into_iter().map(|(_, x)| (x, 1.0)), 1.0);
            if let Some(previous) = job.previous {
                let mut terms: Terms = all(&self.started, index).into_iter().map(|(_, t)| (t, 1.0)).collect();
                terms.extend(all(&self.started, previous).into_iter().map(|(_, t)| (t, -1.0)));
                let serve = |m: usize| self.instance.serve(m) / self.unit;
                terms.extend(all(&self.assigned, previous).into_iter().map(|(m, x)| (x, -serve(m))));
                self.model.at_least(job.nominal / self.unit, terms);
                self.precede(previous, index);
            }
        }
    }

    /// Adds cuts for two jobs of an agent on one robot: not both the earlier job at position `k` or after and the later
    /// one at `k` or before. Integer points satisfy them by their times; fractional ones may not.
    fn precede(&mut self, earlier: usize, later: usize) {
        for positions in &self.assigned {
            for k in 0..positions.len() {
                let after = positions[k..].iter().map(|columns| (columns[earlier], 1.0));
                let before = positions[..=k].iter().map(|columns| (columns[later], 1.0));
                self.model.at_most(after.chain(before), 1.0);
            }
        }
    }

    /// Symmetry: of two identical robots the first has at least as many trips.
    fn symmetry(&mut self) {
        for m in 1..self.instance.free.len() {
            let used = |m: usize| self.assigned[m].iter().flatten().copied();
            if alike(self.instance, m - 1, m) {
                let terms: Terms = used(m - 1).map(|x| (x, 1.0)).chain(used(m).map(|x| (x, -1.0))).collect();
                self.model.at_least(0.0, terms);
            }
        }
    }
}

/// Returns true if exchanging two robots changes nothing.
pub(crate) fn alike(instance: &Instance, m: usize, n: usize) -> bool {
    let close = |a: f64, b: f64| a == b;
    let same = |job: &super::instance::Job| {
        job.ways[m].iter().zip(&job.ways[n]).all(|(a, b)| {
            close(a.low, b.low)
                && close(a.high, b.high)
                && close(a.rate, b.rate)
                && close(a.bend, b.bend)
                && close(a.constant, b.constant)
        })
    };
    close(instance.free[m], instance.free[n])
        && close(instance.serve(m), instance.serve(n))
        && close(instance.deposit(m), instance.deposit(n))
        && instance.jobs.iter().all(same)
}
