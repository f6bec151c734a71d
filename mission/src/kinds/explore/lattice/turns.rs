//! Planning one robot on the lattice: a dynamic program over time, position, velocity and the targets that it takes.

use super::super::motion::{Dynamics, State};
use super::super::objective::{RESERVE_COST, gain, reserve};
use super::super::polygon::Point;
use super::limits::{Bits, Limits};
use super::velocities::Velocities;
use super::{LATER, Lattice, MARGIN, MOST_TARGETS, Motion};

/// Work of a motion of the first two periods, of which the limits are not in a table.
const LAUNCH: usize = 8;

/// Limits of a period, with their bits at each position as the begin, the third point and the end of a motion.
struct Table<'l, 'p> {
    limits: Limits<'l, 'p>,
    bits: [Vec<Bits>; 3],
}

impl Lattice<'_> {
    /// Plans a robot within its limits in each period; the cost with its penalties. `taken` are targets that others take. None: it
    /// cannot move at all, or the time is over.
    pub(super) fn plan(&self, robot: usize, limits: Vec<Limits>, taken: &[usize]) -> Option<(f64, Motion)> {
        let problem = self.problem;
        let who = &problem.robots[robot];
        let targets = self.targets(robot, taken);
        let tables = limits.into_iter().map(|limits| self.table(limits)).collect::<Option<Vec<Table>>>()?;
        let velocities = Velocities::new(problem, robot, self.ground.spacing);
        let count = velocities.count();
        let states = self.ground.len() * count;
        let subsets = 1_usize << targets.len();
        let taken_at: Vec<usize> = (0..self.ground.len())
            .map(|q| {
                let at = self.ground.point(q);
                let inside = |(bit, target): (usize, &usize)| {
                    usize::from(problem.targets[*target].shape.contains(at, -MARGIN)) << bit
                };
                targets.iter().enumerate().map(inside).sum()
            })
            .collect();
        // Worth of a set of targets that is taken at the end of a period.
        let gains = |step: usize| -> Vec<f64> {
            let of = |(bit, target): (usize, &usize), new: usize| match new >> bit & 1 {
                1 => gain(&problem.targets[*target], step),
                _ => 0.0,
            };
            (0..subsets).map(|new| targets.iter().enumerate().map(|each| of(each, new)).sum()).collect()
        };
        let effort = |a: Point, b: Point| -> f64 {
            let discrete = who.over(problem.period);
            (0..2).map(|i| ((b[i] - discrete.velocity_velocity * a[i]) / discrete.velocity_input).abs()).sum::<f64>()
                * problem.effort
        };
        let steps = |a: usize| -> Vec<(usize, f64)> {
            velocities.after[a].iter().map(|b| (*b, effort(velocities.of(a), velocities.of(*b)))).collect()
        };
        let by_first: Vec<Vec<(usize, f64)>> = (0..count).map(steps).collect();
        let begin = 2;
        let mut costs = vec![f64::INFINITY; subsets * states];
        let mut launch: Vec<Point> = vec![[0.0; 2]; states];
        let worths = gains(begin);
        self.launch(robot, &tables, &velocities, |state, q, cost, first| {
            let taken = taken_at[q];
            let cost = cost - worths[taken];
            if cost < costs[taken * states + state] {
                costs[taken * states + state] = cost;
                launch[state] = first;
            }
        })?;
        // By period from the third one on, the state before each state.
        let mut from: Vec<Vec<u32>> = Vec::with_capacity(self.periods);
        for (step, table) in tables.iter().enumerate().take(self.periods).skip(begin) {
            let Table { limits, bits: [first, middle, last] } = table;
            let worths = gains(step + 1);
            let mut next = vec![f64::INFINITY; subsets * states];
            let mut before = vec![u32::MAX; subsets * states];
            let exposed = self.exposed_at(robot, step + 1);
            if self.until.is_over_after(subsets * states) {
                return None;
            }
            for subset in 0..subsets {
                for (q, begin) in first.iter().enumerate() {
                    let mut looked = count;
                    let (column, row) = ((q % self.ground.columns) as i32, (q / self.ground.columns) as i32);
                    for (a, after) in by_first.iter().enumerate() {
                        let index = subset * states + q * count + a;
                        let cost = costs[index];
                        if cost == f64::INFINITY {
                            continue;
                        }
                        looked += after.len();
                        for (b, effort) in after {
                            let [third, to] = velocities.ahead(a, *b);
                            let place = |by: [i32; 2]| self.ground.index(column + by[0], row + by[1]);
                            let (Some(third), Some(to)) = (place(third), place(to)) else { continue };
                            let bits = begin.both(middle[third]).both(last[to]);
                            if bits.part == 0 || bits.person == 0 {
                                continue;
                            }
                            let mut cost = cost + effort + limits.penalty(bits);
                            if exposed.as_ref().is_some_and(|exposed| exposed[to * count + b]) {
                                cost += LATER * self.exposed;
                            }
                            let new = taken_at[to] & !subset;
                            let cost = cost - worths[new];
                            let place = (subset | new) * states + to * count + b;
                            if cost < next[place] {
                                next[place] = cost;
                                before[place] = index as u32;
                            }
                        }
                    }
                    if self.until.is_over_after(looked) {
                        return None;
                    }
                }
            }
            costs = next;
            from.push(before);
        }
        // A plan ends with robots that stand.
        let (still, positions) = (velocities.still(), self.ground.len());
        let ends = (0..subsets).flat_map(|subset| (0..positions).map(move |q| subset * states + q * count + still));
        let end = ends.min_by(|a, b| costs[*a].total_cmp(&costs[*b])).filter(|end| costs[*end].is_finite())?;
        let cost = costs[end];
        let mut places = vec![end];
        for before in from.iter().rev() {
            places.push(before[places[places.len() - 1]] as usize);
        }
        places.reverse();
        let now = self.present.states[robot];
        let state = |place: usize| {
            let place = place % states;
            State { at: self.ground.point(place / count), velocity: velocities.of(place % count) }
        };
        let discrete = who.over(problem.period);
        let mut of = vec![now, self.half_way(robot, now, launch[places[0] % states])];
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

    /// The state after the first of the two periods that lead from the present to a state of the lattice; `first` is the
    /// velocity then.
    fn half_way(&self, robot: usize, now: State, first: Point) -> State {
        let discrete = self.problem.robots[robot].over(self.problem.period);
        let input = [0, 1].map(|i| (first[i] - discrete.velocity_velocity * now.velocity[i]) / discrete.velocity_input);
        discrete.step(now, input)
    }

    /// Limits of a period at all positions; none: the time is over.
    fn table<'l, 'p>(&self, limits: Limits<'l, 'p>) -> Option<Table<'l, 'p>> {
        let mut bits: [Vec<Bits>; 3] = Default::default();
        for (place, bits) in bits.iter_mut().enumerate() {
            bits.reserve(self.ground.len());
            for q in 0..self.ground.len() {
                bits.push(limits.bits_of(q, place));
                if self.until.is_over_after(limits.work(place)) {
                    return None;
                }
            }
        }
        Some(Table { limits, bits })
    }

    /// The first two periods: from where the robot is to every state of the lattice. None: the time is over.
    fn launch(
        &self,
        robot: usize,
        tables: &[Table<'_, '_>],
        velocities: &Velocities,
        mut found: impl FnMut(usize, usize, f64, Point),
    ) -> Option<()> {
        let problem = self.problem;
        let who = &problem.robots[robot];
        let (now, time) = (self.present.states[robot], problem.period);
        let discrete = who.over(time);
        let most = who.acceleration * time + 1e-9;
        let (one, two, ends) = (&tables[0].limits, &tables[1].limits, &tables[1].bits[2]);
        let third_now = one.bits(discrete.third(now), 1);
        let exposed = self.exposed_at(robot, 2);
        for (q, end) in ends.iter().enumerate() {
            let at = self.ground.point(q);
            if end.part == 0 {
                continue;
            }
            if self.until.is_over_after(LAUNCH * velocities.count()) {
                return None;
            }
            for code in 0..velocities.count() {
                let last = velocities.of(code);
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
                let middle = self.half_way(robot, now, first);
                let until = third_now.both(one.bits(middle.at, 2));
                let after = two.bits(middle.at, 0).both(two.bits(discrete.third(middle), 1)).both(*end);
                if until.part == 0 || until.person == 0 || after.part == 0 || after.person == 0 {
                    continue;
                }
                let inputs = |a: Point, b: Point| -> f64 {
                    (0..2).map(|i| ((b[i] - discrete.velocity_velocity * a[i]) / discrete.velocity_input).abs()).sum()
                };
                let effort = problem.effort * (inputs(now.velocity, first) + inputs(first, last));
                let short = RESERVE_COST * one.missing_reserve(middle.at, reserve(problem));
                let state = q * velocities.count() + code;
                let later = exposed.as_ref().is_some_and(|exposed| exposed[state]);
                let exposure = f64::from(u8::from(self.is_exposed(robot, middle))) + LATER * f64::from(u8::from(later));
                let cost = effort + one.penalty(until) + two.penalty(after) + short + self.exposed * exposure;
                found(state, q, cost, first);
            }
        }
        Some(())
    }

    /// Targets that a robot may take: open ones that no other robot takes, the most valued and then the nearest ones.
    fn targets(&self, robot: usize, taken: &[usize]) -> Vec<usize> {
        let mut open: Vec<usize> =
            (0..self.problem.targets.len()).filter(|target| self.is_open(*target) && !taken.contains(target)).collect();
        let at = self.present.states[robot].at;
        open.sort_by(|a, b| {
            let (a, b) = (&self.problem.targets[*a], &self.problem.targets[*b]);
            let far = |of: &super::super::problem::Target| super::super::polygon::distance(of.shape.middle(), at);
            b.worth.total_cmp(&a.worth).then(far(a).total_cmp(&far(b)))
        });
        open.truncate(MOST_TARGETS);
        open
    }
}
