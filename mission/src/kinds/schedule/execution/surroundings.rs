//! The obstacles of a base: other bases, those that have broken down among them, people and working robots
//! at their places, and things.
//!
//! A base that has broken down is a thing until it is back. An agent is one for every base but the one that comes to it,
//! or to somebody who stands so near that the place could not be reached otherwise.

use super::ScheduleExecution;
use super::motion::distance;
use super::settings::{Obstacle, Potentials, Travel};
use super::view::{Doing, Stage};

/// The rate `phi` at which a margin may be used up (1/s).
const PHI: f64 = 2.0;
/// Distance to its target below which a base has arrived (m).
const ARRIVED: f64 = 0.05;
/// Rings on which a free place is looked for, and places on each.
const RINGS: usize = 400;
const PLACES: usize = 32;
/// A base that has come no nearer than by this (m) in this time (s) is held up.
const NEARER: f64 = 0.1;
const HELD: f64 = 60.0;

/// Obstacle near a base: the vector to it, and this base's share of the permitted decrease of their distance per
/// second.
pub(super) struct Other {
    /// Unit vector away from it.
    pub away: [f64; 2],
    /// To its edge (m).
    pub distance: f64,
    /// `phi (d - d_min)`, shared if the other moves too (m/s).
    pub margin: f64,
}

impl ScheduleExecution {
    /// Everything that a base keeps away from.
    pub(super) fn others(&self, robot: usize, potentials: &Potentials) -> Vec<Other> {
        let here = self.world.robots[robot].position;
        let other = |place: [f64; 2], radius: f64, first: bool, share: f64| {
            let centre = distance(here, place);
            // In the same place, the first goes one way and the second the other.
            let away = match centre > 1e-9 {
                true => [(here[0] - place[0]) / centre, (here[1] - place[1]) / centre],
                false => [if first { 1.0 } else { -1.0 }, 0.0],
            };
            let distance = centre - radius;
            Other { away, distance, margin: (share * PHI * (distance - potentials.clearance)).max(0.0) }
        };
        let bases = self.world.robots.iter().enumerate().filter(|(index, _)| *index != robot);
        let bases = bases.map(|(index, state)| {
            // One that has broken down leaves the whole margin to who moves.
            let share = if state.stage == Stage::Lost { 1.0 } else { 0.5 };
            other(state.position, 0.0, robot < index, share)
        });
        let things = potentials.obstacles.iter().map(|thing| other(thing.place, thing.radius, true, 1.0));
        let agents = self.agents_to_avoid(robot, potentials).map(|place| other(place, 0.0, true, 1.0));
        bases.chain(things).chain(agents).collect()
    }

    /// The places of agents that a base keeps away from.
    pub(super) fn agents_to_avoid(&self, robot: usize, potentials: &Potentials) -> impl Iterator<Item = [f64; 2]> {
        let state = &self.world.robots[robot];
        let target = state.target.map(|(agent, _)| self.problem.agents[agent].place);
        let wanted = [Some(state.leg.to), target, Some(self.problem.robots[robot].depot)];
        let clearance = potentials.clearance;
        let there = self.world.agents.iter().zip(&self.problem.agents).filter(|(state, _)| state.doing != Doing::Lost);
        there
            .map(|(_, who)| who.place)
            .filter(move |place| wanted.iter().flatten().all(|wanted| distance(*wanted, *place) >= clearance))
    }

    /// The bases that have broken down.
    fn broken_down(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        let lost = self.world.robots.iter().enumerate().filter(|(_, state)| state.stage == Stage::Lost);
        lost.map(|(index, state)| (index, state.position))
    }

    /// A robot is where it goes.
    pub(super) fn is_there(&self, robot: usize) -> bool {
        let Travel::Bases(potentials) = &self.settings.travel else { return true };
        let (to, stage) = (self.world.robots[robot].leg.to, self.world.robots[robot].stage);
        let inside = |thing: &Obstacle| thing.radius + potentials.clearance - distance(thing.place, to);
        // A place to stand, by the way or at home, is reached at the edge of what covers it; nobody is served from there.
        let lost = self.broken_down().map(|(_, place)| Obstacle { place, radius: 0.0 });
        let lost = lost.filter(|_| stage != Stage::Approaching);
        let covered = potentials.obstacles.iter().copied().chain(lost).map(|thing| inside(&thing));
        let inside = covered.fold(0.0, f64::max);
        let near = if inside > 0.0 { 2.0 * ARRIVED + inside } else { ARRIVED };
        distance(self.position(robot, self.time), to) <= near
    }

    /// The base that has broken down and holds this one up, if one does: it stands where this one is to serve, or near it,
    /// and this one comes no nearer to where it goes.
    pub(super) fn held_up_by(&mut self, robot: usize) -> Option<usize> {
        let Travel::Bases(potentials) = &self.settings.travel else { return None };
        let here = self.position(robot, self.time);
        let state = &self.world.robots[robot];
        let left = distance(here, state.leg.to);
        let nearest = match state.nearest {
            Some((since, least)) if left > least - NEARER => (since, least),
            _ => (self.time, left),
        };
        let long = self.time - nearest.0 >= HELD;
        let (to, serves) = (state.leg.to, state.stage == Stage::Approaching);
        let covers = |place: [f64; 2]| serves && distance(place, to) < potentials.clearance - ARRIVED;
        let holds = |place: [f64; 2]| {
            let apart = distance(place, here);
            apart < potentials.threshold && (long || covers(place))
        };
        let lost = self.broken_down().filter(|(_, place)| holds(*place));
        let by = lost.min_by(|a, b| distance(a.1, here).total_cmp(&distance(b.1, here)));
        self.world.robots[robot].nearest = Some(nearest);
        by.map(|(index, _)| index)
    }

    /// Robots that were held up go on: the way may be free.
    pub(super) fn let_on(&mut self) {
        for robot in 0..self.world.robots.len() {
            if self.world.robots[robot].held_up.take().is_some() {
                let to = self.world.robots[robot].leg.to;
                let until = self.reach(robot, to);
                self.send(robot, to, until);
                (self.world.robots[robot].not_before, self.world.robots[robot].nearest) = (until, None);
            }
        }
    }

    /// Position of a robot that comes back: its depot, or the nearest free place beside it.
    pub(super) fn free_place(&self, robot: usize) -> [f64; 2] {
        let depot = self.problem.robots[robot].depot;
        let Travel::Bases(potentials) = &self.settings.travel else { return depot };
        let clear = |place: [f64; 2]| {
            let bases = (0..self.world.robots.len()).filter(|other| *other != robot).all(|other| {
                // It moves on until its next command.
                let reach = potentials.step * self.problem.robots[other].speed.high;
                distance(self.position(other, self.time), place) >= potentials.clearance + reach
            });
            let agents = || self.agents_to_avoid(robot, potentials);
            bases
                && !potentials.obstacles.iter().any(|thing| potentials.covers(thing, place))
                && agents().all(|agent| distance(agent, place) >= potentials.clearance)
        };
        let ring = |ring: usize| {
            let radius = ring as f64 * potentials.clearance / 4.0;
            (0..if ring == 0 { 1 } else { PLACES }).map(move |place| {
                let angle = std::f64::consts::TAU * place as f64 / PLACES as f64;
                [depot[0] + radius * angle.cos(), depot[1] + radius * angle.sin()]
            })
        };
        (0..RINGS).flat_map(ring).find(|place| clear(*place)).unwrap_or(depot)
    }
}
