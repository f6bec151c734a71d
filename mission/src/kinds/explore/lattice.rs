//! Plans on a lattice: good motions of the robots within milliseconds, from which the mixed-integer program starts, and which stand
//! if it finds nothing better in time.
//!
//! One robot at a time is planned exactly over positions half a cell apart and the velocities between them, with the motions of the
//! others as they are: a dynamic program over time, position, velocity and the targets taken. The robots take turns, so that one
//! that keeps the team connected frees another one to go farther. What a motion must not do is what the program forbids, with
//! the same three points of each period; constraints that involve others cost a penalty while those have not moved yet.

use super::foresight::Foresight;
use super::grid::Grid;
use super::motion::{Dynamics, State};
use super::polygon::{Convex, Point, dot, minus, plus};
use super::problem::Problem;
use super::program::{Present, RESERVE_COST, Trajectories, Visit, free, reserve};

/// Penalty of a period in which a constraint with others is not met.
const PENALTY: f64 = 1e3;
/// Targets of which one robot considers all subsets.
const MOST_TARGETS: usize = 4;
/// Rounds in which each robot is planned once.
const ROUNDS: usize = 3;
/// Distance (m) that is kept beyond each constraint: more than the program asks for.
const MARGIN: f64 = 3e-4;
/// The most parts of the ground that one mask holds.
const MOST_PARTS: usize = 64;

/// Plans on the lattice; none: a robot has dynamics that no lattice fits, or no motion meets all constraints.
pub fn construct(
    problem: &Problem,
    present: &Present,
    foresight: &Foresight,
    last: Option<&Trajectories>,
) -> Option<Trajectories> {
    let lattice = Lattice::new(problem, present, foresight)?;
    let count = problem.robots.len();
    let orders: Vec<Vec<usize>> =
        (0..count).map(|first| (0..count).map(|turn| (first + turn) % count).collect()).collect();
    let mut best: Option<(f64, Vec<Motion>)> = None;
    for order in orders {
        let mut motions: Vec<Motion> = (0..count).map(|robot| lattice.begin(robot, last)).collect();
        let mut cost = f64::INFINITY;
        for _ in 0..ROUNDS {
            let mut all = 0.0;
            for robot in order.iter().copied().filter(|robot| present.active[*robot]) {
                if let Some((own, motion)) = lattice.plan(robot, &motions) {
                    motions[robot] = motion;
                    all = own;
                }
            }
            // The penalties that the last robot sees are those of all: it sees the others as they are.
            if all >= cost - 1e-9 {
                break;
            }
            cost = all;
        }
        if lattice.is_sound(&motions) {
            let cost = lattice.cost(&motions);
            if best.as_ref().is_none_or(|(known, _)| cost < known - 1e-9) {
                best = Some((cost, motions));
            }
        }
    }
    best.map(|(_, motions)| lattice.trajectories(&motions))
}

/// The motion of a robot.
#[derive(Clone, Debug, PartialEq)]
struct Motion {
    /// States at the present and at the end of each period.
    states: Vec<State>,
    inputs: Vec<Point>,
    /// Targets with the periods at whose ends they are taken.
    visits: Vec<(usize, usize)>,
}

/// The three points that bound the motion of a robot in a period.
type Three = [Point; 3];

struct Lattice<'p> {
    problem: &'p Problem,
    present: &'p Present,
    foresight: &'p Foresight,
    periods: usize,
    /// Distance of positions (m), and step of velocities (m/s).
    spacing: f64,
    columns: usize,
    rows: usize,
    origin: Point,
    parts: Vec<Vec<Convex>>,
}

/// What limits a robot in one period: sides of sets as bits of the corner points, and the connections.
struct Limits<'l, 'p> {
    lattice: &'l Lattice<'p>,
    robot: usize,
    step: usize,
    person: Convex,
    /// The set around the person by name of the point: its faces at the begin, in the middle and at the end.
    grown: [f64; 3],
    /// The other robots: the set of differences at which they touch, and their points.
    others: Vec<(usize, Convex, Three)>,
    /// In the first period the margin that the end needs beyond each face, for the motion from the known begin; see
    /// [`program`](super::program).
    needs: Option<Needs>,
    /// For each set of connections of this robot, to others in the order above and then to the person, if the team is connected.
    allowed: Vec<bool>,
}

/// Margins (m) that the end of the first period needs: by part and face, by face of the person, by other robot and face, by face of the
/// connection to each other robot, and to the person.
#[derive(Clone, Debug, Default)]
struct Needs {
    parts: Vec<Vec<f64>>,
    person: Vec<f64>,
    others: Vec<Vec<f64>>,
    links: Vec<Vec<f64>>,
    sees: Vec<f64>,
}

/// The margin that the end needs where the begin has `b0` and the third point `b1`; infinite: no end is good.
fn need(quadratic: bool, b0: f64, b1: f64) -> f64 {
    match b1 >= 0.0 {
        true => 0.0,
        false if quadratic && b0 > 0.0 => b1 * b1 / b0,
        false => f64::INFINITY,
    }
}

/// Bits of a point in a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Bits {
    part: u64,
    person: u64,
    /// Sides of the other robots, 16 bits each.
    others: u128,
    links: u8,
}

impl Bits {
    fn both(self, other: Bits) -> Bits {
        Bits {
            part: self.part & other.part,
            person: self.person & other.person,
            others: self.others & other.others,
            links: self.links & other.links,
        }
    }
}

impl<'p> Lattice<'p> {
    fn new(problem: &'p Problem, present: &'p Present, foresight: &'p Foresight) -> Option<Lattice<'p>> {
        let lag = |robot: &super::problem::Robot| matches!(robot.dynamics, Dynamics::Lag(_));
        let periods = foresight.periods().min(problem.periods);
        if problem.robots.iter().any(lag) || periods < 3 {
            return None;
        }
        let grid = Grid::new(problem)?;
        let [low, _] = problem.area.bounds();
        let spacing = 0.5 * grid.cell;
        let parts: Vec<Vec<Convex>> = (0..problem.robots.len()).map(|robot| free(problem, robot)).collect();
        if parts.iter().any(|parts| parts.is_empty() || parts.len() > MOST_PARTS) {
            return None;
        }
        Some(Lattice {
            problem,
            present,
            foresight,
            periods,
            spacing,
            columns: 2 * grid.columns + 1,
            rows: 2 * grid.rows + 1,
            origin: low,
            parts,
        })
    }

    fn len(&self) -> usize {
        self.columns * self.rows
    }

    fn point(&self, index: usize) -> Point {
        let (column, row) = (index % self.columns, index / self.columns);
        plus(self.origin, [column as f64 * self.spacing, row as f64 * self.spacing])
    }

    /// The factor from steps of the lattice to velocities (m/s): an acceleration leads to the mean of both velocities.
    fn pace(&self, robot: usize) -> f64 {
        match self.problem.robots[robot].dynamics {
            Dynamics::Acceleration => 2.0 * self.spacing / self.problem.period,
            _ => self.spacing / self.problem.period,
        }
    }

    /// The motion with which the planning begins: the rest of the last plan, or braking.
    fn begin(&self, robot: usize, last: Option<&Trajectories>) -> Motion {
        let discrete = self.problem.robots[robot].over(self.problem.period);
        let now = self.present.states[robot];
        let of_last = last.and_then(|last| last.inputs.get(robot)).map_or(&[][..], Vec::as_slice);
        let (mut states, mut inputs) = (vec![now], Vec::new());
        for step in 0..self.periods {
            let state = states[step];
            let brakes = state.velocity.map(|v| -discrete.velocity_velocity * v / discrete.velocity_input);
            let input =
                if self.present.active[robot] { of_last.get(step).copied().unwrap_or(brakes) } else { [0.0; 2] };
            inputs.push(input);
            states.push(if self.present.active[robot] { discrete.step(state, input) } else { now });
        }
        let visits = last.iter().flat_map(|last| &last.visits);
        let own = visits.filter(|visit| visit.robot == robot && self.is_open(visit.target));
        Motion { states, inputs, visits: own.map(|visit| (visit.target, visit.step)).collect() }
    }

    /// True for a target that robots may take.
    fn is_open(&self, target: usize) -> bool {
        self.present.open[target] && self.foresight.visits.iter().all(|(of, _)| *of != target)
    }

    fn three(&self, robot: usize, motion: &Motion, step: usize) -> Three {
        let discrete = self.problem.robots[robot].over(self.problem.period);
        [motion.states[step].at, discrete.third(motion.states[step]), motion.states[step + 1].at]
    }

    fn limits<'l>(&'l self, robot: usize, step: usize, motions: &[Motion]) -> Limits<'l, 'p> {
        let problem = self.problem;
        let back = problem.robots[robot].body.reflected();
        let near = problem.person.body.sum(&back);
        let stride = problem.strides(problem.period);
        let ahead = problem.robots[robot].over(problem.period).middle / problem.period;
        let others: Vec<usize> = (0..problem.robots.len()).filter(|other| *other != robot).collect();
        let active: Vec<usize> = others.iter().copied().filter(|other| self.present.active[*other]).collect();
        let threes: Vec<Three> = others.iter().map(|other| self.three(*other, &motions[*other], step)).collect();
        // Connections among the others, and from them to the person.
        let quadratic = problem.robots[robot].dynamics == Dynamics::Acceleration;
        let keeps = |margins: [f64; 3]| match step {
            0 => margins[2] >= MARGIN + need(quadratic, margins[0] - MARGIN, margins[1] - MARGIN),
            _ => margins.iter().all(|margin| *margin >= MARGIN),
        };
        let linked = |i: usize, j: usize| {
            let (a, b) = (threes[i], threes[j]);
            problem.connection.faces().iter().all(|face| keeps([0, 1, 2].map(|k| -face.outside(minus(a[k], b[k])))))
        };
        let from = self.foresight.positions[step];
        let at_person = |points: &Three| {
            problem.connection.faces().iter().all(|face| {
                let far = stride.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
                keeps([0, 1, 2].map(|k| -face.outside(minus(points[k], from)) - [0.0, ahead, 1.0][k] * far))
            })
        };
        let index: Vec<usize> = (0..others.len()).filter(|i| self.present.active[others[*i]]).collect();
        let mut allowed = vec![false; 1 << (others.len() + 1)];
        for (mask, allowed) in allowed.iter_mut().enumerate() {
            let to_person = mask >> others.len() & 1 == 1 || index.iter().any(|i| at_person(&threes[*i]));
            let own = index.iter().filter(|i| mask >> **i & 1 == 1).count();
            let degree = |i: usize| {
                index.iter().filter(|j| **j != i && linked(i.min(**j), i.max(**j))).count() + (mask >> i & 1)
            };
            let team = active.len() + 1;
            let pairs = index.iter().enumerate().all(|(place, i)| {
                let with_own = own + degree(*i) >= team;
                let with_others = index[..place].iter().all(|j| degree(*i) + degree(*j) >= team);
                with_own && with_others
            });
            *allowed = to_person && pairs;
        }
        let sets =
            others.iter().zip(&threes).map(|(other, three)| (*other, problem.robots[*other].body.sum(&back), *three));
        let mut limits = Limits {
            lattice: self,
            robot,
            step,
            grown: [0.0, ahead, 1.0],
            others: sets.collect(),
            allowed,
            person: near.sum_with_points(&stride),
            needs: None,
        };
        if step == 0 {
            limits.needs = Some(limits.needs_at_the_begin());
        }
        limits
    }

    /// Plans a robot around the motions of the others; the cost with its penalties. None: it cannot move at all.
    fn plan(&self, robot: usize, motions: &[Motion]) -> Option<(f64, Motion)> {
        let problem = self.problem;
        let who = &problem.robots[robot];
        let targets = self.targets(robot, motions);
        let tables: Vec<(Limits, [Vec<Bits>; 3])> = (0..self.periods)
            .map(|step| {
                let limits = self.limits(robot, step, motions);
                let table = |place: usize| (0..self.len()).map(|q| limits.bits(self.point(q), place)).collect();
                let all = [table(0), table(1), table(2)];
                (limits, all)
            })
            .collect();
        let pace = self.pace(robot);
        let fastest = (who.speed / pace + 1e-9).floor().min(8.0) as i32;
        let width = (2 * fastest + 1) as usize;
        let velocities = width * width;
        let states = self.len() * velocities;
        let subsets = 1_usize << targets.len();
        let velocity = |code: usize| {
            [(code % width) as i32 - fastest, (code / width) as i32 - fastest].map(|v| f64::from(v) * pace)
        };
        let taken_at: Vec<usize> = (0..self.len())
            .map(|q| {
                let at = self.point(q);
                let inside = |(bit, target): (usize, &usize)| {
                    usize::from(problem.targets[*target].shape.contains(at, -MARGIN)) << bit
                };
                targets.iter().enumerate().map(inside).sum()
            })
            .collect();
        let worth = |new: usize| -> f64 {
            targets
                .iter()
                .enumerate()
                .filter(|(bit, _)| new >> bit & 1 == 1)
                .map(|(_, t)| problem.targets[*t].worth)
                .sum()
        };
        let worths: Vec<f64> = (0..subsets).map(worth).collect();
        let effort = |a: Point, b: Point| -> f64 {
            let discrete = who.over(problem.period);
            (0..2).map(|i| ((b[i] - discrete.velocity_velocity * a[i]) / discrete.velocity_input).abs()).sum::<f64>()
                * problem.effort
        };
        let possible = |a: Point, b: Point| match who.dynamics {
            // A velocity changes by its acceleration times the period.
            _ if who.acceleration * problem.period >= 2.0 * who.speed => true,
            _ => (0..2).all(|i| (b[i] - a[i]).abs() <= who.acceleration * problem.period + 1e-9),
        };
        let steps: Vec<(usize, usize, f64)> = (0..velocities)
            .flat_map(|a| (0..velocities).map(move |b| (a, b)))
            .filter(|(a, b)| possible(velocity(*a), velocity(*b)))
            .map(|(a, b)| (a, b, effort(velocity(a), velocity(b))))
            .collect();
        let mut by_first: Vec<Vec<(usize, f64)>> = vec![Vec::new(); velocities];
        for (a, b, effort) in steps {
            by_first[a].push((b, effort));
        }
        let begin = 2;
        let mut costs = vec![f64::INFINITY; subsets * states];
        let mut launch: Vec<Point> = vec![[0.0; 2]; states];
        self.launch(robot, &tables, &velocity, velocities, |state, q, cost, first| {
            let taken = taken_at[q];
            let cost = cost - worths[taken];
            if cost < costs[taken * states + state] {
                costs[taken * states + state] = cost;
                launch[state] = first;
            }
        });
        let mut from: Vec<Vec<u32>> = vec![vec![u32::MAX; subsets * states]; self.periods + 1];
        let accelerates = who.dynamics == Dynamics::Acceleration;
        for step in begin..self.periods {
            let (limits, [first, middle, last]) = &tables[step];
            let mut next = vec![f64::INFINITY; subsets * states];
            for subset in 0..subsets {
                for q in 0..self.len() {
                    let (column, row) = ((q % self.columns) as i32, (q / self.columns) as i32);
                    for a in 0..velocities {
                        let index = subset * states + q * velocities + a;
                        let cost = costs[index];
                        if cost == f64::INFINITY {
                            continue;
                        }
                        let va = [(a % width) as i32 - fastest, (a / width) as i32 - fastest];
                        // Third points of accelerations are half a period's way ahead: as many places as the velocity has steps.
                        let third = if accelerates { self.index(column + va[0], row + va[1]) } else { Some(q) };
                        let Some(third) = third else { continue };
                        let until = first[q].both(middle[third]);
                        if until.part == 0 || until.person == 0 {
                            continue;
                        }
                        for (b, effort) in &by_first[a] {
                            let vb = [(b % width) as i32 - fastest, (b / width) as i32 - fastest];
                            let to = match accelerates {
                                true => self.index(column + va[0] + vb[0], row + va[1] + vb[1]),
                                false => self.index(column + vb[0], row + vb[1]),
                            };
                            let Some(to) = to else { continue };
                            let bits = until.both(last[to]);
                            if bits.part == 0 || bits.person == 0 {
                                continue;
                            }
                            let penalty = limits.penalty(bits);
                            let new = taken_at[to] & !subset;
                            let taken = subset | new;
                            let cost = cost + effort + penalty - worths[new];
                            let place = taken * states + to * velocities + b;
                            if cost < next[place] {
                                next[place] = cost;
                                from[step + 1][place] = index as u32;
                            }
                        }
                    }
                }
            }
            costs = next;
        }
        // A plan ends with robots that stand.
        let still = velocities / 2;
        let ends =
            (0..subsets).flat_map(|subset| (0..self.len()).map(move |q| subset * states + q * velocities + still));
        let end = ends.min_by(|a, b| costs[*a].total_cmp(&costs[*b])).filter(|end| costs[*end].is_finite())?;
        let cost = costs[end];
        let mut places = vec![end];
        for step in (begin + 1..=self.periods).rev() {
            let index = from[step][places[places.len() - 1]];
            places.push(index as usize);
        }
        places.reverse();
        let now = self.present.states[robot];
        let state = |place: usize| {
            let place = place % states;
            State { at: self.point(place / velocities), velocity: velocity(place % velocities) }
        };
        let second = state(places[0]);
        let discrete = who.over(problem.period);
        let mut of = vec![now];
        let middle = self.half_way(robot, now, second, launch[places[0] % states]);
        of.push(middle);
        of.extend(places.iter().map(|place| state(*place)));
        let input = |two: &[State]| {
            [0, 1].map(|i| {
                (two[1].velocity[i] - discrete.velocity_velocity * two[0].velocity[i]) / discrete.velocity_input
            })
        };
        let inputs: Vec<Point> = of.windows(2).map(input).collect();
        let mut visits = Vec::new();
        let mut open: Vec<usize> = targets.clone();
        for (step, state) in of.iter().enumerate().skip(begin) {
            open.retain(|target| {
                let here = problem.targets[*target].shape.contains(state.at, -MARGIN);
                if here {
                    visits.push((*target, step));
                }
                !here
            });
        }
        Some((cost, Motion { states: of, inputs, visits }))
    }

    fn index(&self, column: i32, row: i32) -> Option<usize> {
        let inside = (0..self.columns as i32).contains(&column) && (0..self.rows as i32).contains(&row);
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// The state after the first of the two periods that lead from the present to a state of the lattice; `first` is the
    /// velocity then.
    fn half_way(&self, robot: usize, now: State, _second: State, first: Point) -> State {
        let discrete = self.problem.robots[robot].over(self.problem.period);
        let input = [0, 1].map(|i| (first[i] - discrete.velocity_velocity * now.velocity[i]) / discrete.velocity_input);
        discrete.step(now, input)
    }

    /// The first two periods: from where the robot is to every state of the lattice.
    fn launch(
        &self,
        robot: usize,
        tables: &[(Limits, [Vec<Bits>; 3])],
        velocity: &dyn Fn(usize) -> Point,
        velocities: usize,
        mut found: impl FnMut(usize, usize, f64, Point),
    ) {
        let problem = self.problem;
        let who = &problem.robots[robot];
        let (now, time) = (self.present.states[robot], problem.period);
        let discrete = who.over(time);
        let most = who.acceleration * time + 1e-9;
        let (one, two) = (&tables[0].0, &tables[1].0);
        let third_now = one.bits(discrete.third(now), 1);
        for q in 0..self.len() {
            let at = self.point(q);
            if tables[1].1[2][q].part == 0 {
                continue;
            }
            for code in 0..velocities {
                let last = velocity(code);
                let first = match who.dynamics {
                    Dynamics::Acceleration => {
                        [0, 1].map(|i| (at[i] - now.at[i]) / time - 0.5 * (now.velocity[i] + last[i]))
                    }
                    // Both periods together lead there.
                    _ => [0, 1].map(|i| (at[i] - now.at[i]) / time - last[i]),
                };
                let fits = (0..2).all(|i| {
                    first[i].abs() <= who.speed - 1e-9
                        && (first[i] - now.velocity[i]).abs() <= most
                        && (last[i] - first[i]).abs() <= most
                });
                if !fits {
                    continue;
                }
                let middle = self.half_way(robot, now, State::default(), first);
                let until = third_now.both(one.bits(middle.at, 2));
                let after = two.bits(middle.at, 0).both(two.bits(discrete.third(middle), 1)).both(tables[1].1[2][q]);
                if until.part == 0 || until.person == 0 || after.part == 0 || after.person == 0 {
                    continue;
                }
                let inputs = |a: Point, b: Point| -> f64 {
                    (0..2).map(|i| ((b[i] - discrete.velocity_velocity * a[i]) / discrete.velocity_input).abs()).sum()
                };
                let effort = problem.effort * (inputs(now.velocity, first) + inputs(first, last));
                // Whoever is too near to the person, or too far, at the end of the first period has no reserve.
                let kept = one.bits_beyond(middle.at, 2, reserve(problem));
                let short = if kept.person == 0 { RESERVE_COST * reserve(problem) } else { 0.0 };
                let cost = effort + one.penalty(until) + two.penalty(after) + short;
                found(q * velocities + code, q, cost, first);
            }
        }
    }

    /// Targets that a robot may take: open ones that no other robot takes, the most valued and then the nearest ones.
    fn targets(&self, robot: usize, motions: &[Motion]) -> Vec<usize> {
        let others = motions.iter().enumerate().filter(|(other, _)| *other != robot);
        let taken: Vec<usize> =
            others.flat_map(|(_, motion)| motion.visits.iter().map(|(target, _)| *target)).collect();
        let mut open: Vec<usize> =
            (0..self.problem.targets.len()).filter(|target| self.is_open(*target) && !taken.contains(target)).collect();
        let at = self.present.states[robot].at;
        open.sort_by(|a, b| {
            let (a, b) = (&self.problem.targets[*a], &self.problem.targets[*b]);
            let far = |of: &super::problem::Target| super::polygon::distance(of.shape.middle(), at);
            b.worth.total_cmp(&a.worth).then(far(a).total_cmp(&far(b)))
        });
        open.truncate(MOST_TARGETS);
        open
    }

    /// True if the motions meet all constraints together.
    fn is_sound(&self, motions: &[Motion]) -> bool {
        (0..motions.len()).filter(|robot| self.present.active[*robot]).all(|robot| {
            (0..self.periods).all(|step| {
                let limits = self.limits(robot, step, motions);
                let three = self.three(robot, &motions[robot], step);
                let bits = (0..3).map(|place| limits.bits(three[place], place)).reduce(Bits::both);
                bits.is_some_and(|bits| bits.part != 0 && bits.person != 0 && limits.penalty(bits) == 0.0)
            })
        })
    }

    fn cost(&self, motions: &[Motion]) -> f64 {
        let effort: f64 = motions.iter().flat_map(|motion| motion.inputs.iter().flatten()).map(|u| u.abs()).sum();
        let visits = motions.iter().flat_map(|motion| &motion.visits);
        self.problem.effort * effort - visits.map(|(target, _)| self.problem.targets[*target].worth).sum::<f64>()
    }

    fn trajectories(&self, motions: &[Motion]) -> Trajectories {
        let visits = motions.iter().enumerate().flat_map(|(robot, motion)| {
            motion.visits.iter().map(move |(target, step)| Visit { robot, target: *target, step: *step })
        });
        Trajectories {
            states: motions.iter().map(|motion| motion.states.clone()).collect(),
            inputs: motions.iter().map(|motion| motion.inputs.clone()).collect(),
            visits: visits.collect(),
        }
    }
}

impl Limits<'_, '_> {
    /// Margins of a point that is the begin, the third point or the end of the motion: positive for a constraint that is met.
    fn margins(&self, at: Point, place: usize) -> Needs {
        let (problem, lattice) = (self.lattice.problem, self.lattice);
        let inside = |of: &Convex| of.faces().iter().map(|face| -face.outside(at)).collect();
        let near = minus(at, lattice.foresight.positions[self.step]);
        let stride = problem.strides(problem.period);
        let far = |normal: Point| stride.iter().map(|s| dot(normal, *s)).fold(0.0, f64::max);
        let share = self.grown[place];
        let faces = problem.connection.faces();
        let apart: Vec<Point> = self.others.iter().map(|(_, _, three)| minus(at, three[place])).collect();
        let sets = self.others.iter().zip(&apart);
        Needs {
            parts: lattice.parts[self.robot].iter().map(inside).collect(),
            // The part of the set that the person cannot have reached yet does not count.
            person: self
                .person
                .faces()
                .iter()
                .map(|face| face.outside(near) + (1.0 - share) * far(face.normal))
                .collect(),
            others: sets
                .map(|((_, set, _), apart)| set.faces().iter().take(16).map(|face| face.outside(*apart)).collect())
                .collect(),
            links: apart.iter().map(|apart| faces.iter().map(|face| -face.outside(*apart)).collect()).collect(),
            sees: faces.iter().map(|face| -face.outside(near) - share * far(face.normal)).collect(),
        }
    }

    /// What the end of the first period needs.
    fn needs_at_the_begin(&self) -> Needs {
        let who = &self.lattice.problem.robots[self.robot];
        let now = self.lattice.present.states[self.robot];
        let (b0, b1) = (self.margins(now.at, 0), self.margins(who.over(self.lattice.problem.period).third(now), 1));
        let quadratic = who.dynamics == Dynamics::Acceleration;
        let each = |b0: &[f64], b1: &[f64]| -> Vec<f64> {
            b0.iter().zip(b1).map(|(b0, b1)| need(quadratic, *b0 - MARGIN, *b1 - MARGIN)).collect()
        };
        let all = |b0: &[Vec<f64>], b1: &[Vec<f64>]| -> Vec<Vec<f64>> {
            b0.iter().zip(b1).map(|(b0, b1)| each(b0, b1)).collect()
        };
        Needs {
            parts: all(&b0.parts, &b1.parts),
            person: each(&b0.person, &b1.person),
            others: all(&b0.others, &b1.others),
            links: all(&b0.links, &b1.links),
            sees: each(&b0.sees, &b1.sees),
        }
    }

    /// Bits of a point that is the begin, the third point or the end of the motion. In the first period all that counts is the end.
    fn bits(&self, at: Point, place: usize) -> Bits {
        self.bits_beyond(at, place, 0.0)
    }

    /// The same with a reserve (m) to the person.
    fn bits_beyond(&self, at: Point, place: usize, reserve: f64) -> Bits {
        if self.needs.is_some() && place < 2 {
            return Bits { part: u64::MAX, person: u64::MAX, others: u128::MAX, links: u8::MAX };
        }
        let margins = self.margins(at, place);
        let nothing = Needs::default();
        let needs = self.needs.as_ref().unwrap_or(&nothing);
        let meets =
            |margin: &f64, need: Option<&f64>, more: f64| *margin >= need.copied().unwrap_or(0.0) + MARGIN + more;
        let all = |margins: &[f64], needs: Option<&Vec<f64>>, more: f64| {
            margins
                .iter()
                .enumerate()
                .all(|(face, margin)| meets(margin, needs.and_then(|needs| needs.get(face)), more))
        };
        let any = |margins: &[f64], needs: Option<&Vec<f64>>, more: f64| {
            margins.iter().enumerate().fold(0_u64, |bits, (face, margin)| {
                bits | u64::from(meets(margin, needs.and_then(|needs| needs.get(face)), more)) << face
            })
        };
        let part = margins
            .parts
            .iter()
            .enumerate()
            .fold(0, |bits, (part, margins)| bits | u64::from(all(margins, needs.parts.get(part), 0.0)) << part);
        let person = any(&margins.person, Some(&needs.person), reserve);
        let (mut others, mut links) = (0_u128, 0_u8);
        for (index, (other, ..)) in self.others.iter().enumerate() {
            others |= u128::from(any(&margins.others[index], needs.others.get(index), 0.0)) << (16 * index);
            let active = self.lattice.present.active[*other];
            links |= u8::from(active && all(&margins.links[index], needs.links.get(index), 0.0)) << index;
        }
        links |= u8::from(all(&margins.sees, Some(&needs.sees), reserve)) << self.others.len();
        Bits { part, person, others, links }
    }

    /// Penalty for what involves others.
    fn penalty(&self, bits: Bits) -> f64 {
        let apart = (0..self.others.len()).filter(|index| bits.others >> (16 * index) & 0xffff == 0).count();
        let connected = self.allowed[usize::from(bits.links)];
        PENALTY * (apart as f64 + f64::from(u8::from(!connected)))
    }
}
