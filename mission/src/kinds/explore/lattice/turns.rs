//! Planning one robot on the lattice: a dynamic program over time, position, velocity and the targets that it takes.

use super::super::motion::{Dynamics, State};
use super::super::objective::{RESERVE_COST, gain, reserve};
use super::super::polygon::Point;
use super::limits::{Bits, Limits};
use super::{Lattice, MARGIN, MOST_TARGETS, Motion};

impl Lattice<'_> {
    /// Plans a robot within its limits in each period; the cost with its penalties. `taken` are targets that others take. None: it
    /// cannot move at all.
    pub(super) fn plan(&self, robot: usize, limits: Vec<Limits>, taken: &[usize]) -> Option<(f64, Motion)> {
        let problem = self.problem;
        let who = &problem.robots[robot];
        let targets = self.targets(robot, taken);
        let tables: Vec<(Limits, [Vec<Bits>; 3])> = limits
            .into_iter()
            .map(|limits| {
                let table = |place: usize| (0..self.len()).map(|q| limits.bits_of(q, place)).collect();
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
        let worths = gains(begin);
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
            let worths = gains(step + 1);
            let mut next = vec![f64::INFINITY; subsets * states];
            for subset in 0..subsets {
                for (q, begin) in first.iter().enumerate() {
                    let (column, row) = ((q % self.columns) as i32, (q / self.columns) as i32);
                    for (a, after) in by_first.iter().enumerate() {
                        let index = subset * states + q * velocities + a;
                        let cost = costs[index];
                        if cost == f64::INFINITY {
                            continue;
                        }
                        let va = [(a % width) as i32 - fastest, (a / width) as i32 - fastest];
                        // Third points of accelerations are half a period's way ahead: as many places as the velocity has steps.
                        let third = if accelerates { self.index(column + va[0], row + va[1]) } else { Some(q) };
                        let Some(third) = third else { continue };
                        let until = begin.both(middle[third]);
                        if until.part == 0 || until.person == 0 {
                            continue;
                        }
                        for (b, effort) in after {
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
