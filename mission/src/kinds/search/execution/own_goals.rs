//! The goals that a person considers for themselves or for a robot, by the person's own belief.
//!
//! They are those of the planner, sources and lookouts; each is valued alone, by the reward of going there and staying, and the time that
//! takes. The plans of others do not count.

use crate::kinds::search::belief::Undetected;
use crate::kinds::search::geometry::{Point, distance, length};
use crate::kinds::search::ground::{Body, Ground};
use crate::kinds::search::habits::{Habits, OwnGoal};
use crate::kinds::search::lookouts::lookouts;
use crate::kinds::search::problem::{EMPTY, Travel};
use crate::kinds::search::ways::{goals, rate};

use super::SearchExecution;
use super::messages::SAME_PLACE;

/// The nearest goal is one of those with at least this share of the greatest worth. Ours.
const WORTHWHILE: f64 = 0.5;

/// A goal with its worth.
struct Offer {
    at: Point,
    /// Reward of staying there.
    worth: f64,
    /// Time of the way (s).
    way: f64,
    /// Time of the way and of the stay (s).
    whole: f64,
}

impl SearchExecution {
    /// The goal that a person chooses for an agent. `exposure` is that of each cell as the person knows it; `besides`: a place from which
    /// somebody is about to look around.
    pub(super) fn own_goal(
        &self,
        agent: usize,
        habits: &Habits,
        exposure: &[f64],
        besides: Option<Point>,
    ) -> Option<Point> {
        let offers = self.offers(agent, habits.goals_beyond, exposure, besides);
        let chosen = match habits.own_goal {
            OwnGoal::Greedy => offers.iter().max_by(|a, b| (a.worth / a.whole).total_cmp(&(b.worth / b.whole))),
            OwnGoal::Nearest => {
                let most = offers.iter().map(|offer| offer.worth).fold(0.0, f64::max);
                let worthwhile = offers.iter().filter(|offer| offer.worth >= WORTHWHILE * most);
                worthwhile.min_by(|a, b| a.way.total_cmp(&b.way))
            }
        };
        chosen.map(|offer| offer.at)
    }

    fn offers(&self, agent: usize, beyond: f64, exposure: &[f64], besides: Option<Point>) -> Vec<Offer> {
        let mut problem = self.present();
        problem.exposure = exposure.to_vec();
        let from = self.true_pose(agent, self.time).at;
        problem.agents[agent].start = from;
        let stay = problem.planner.stay;
        let ground = Ground::new(&problem, &Body::of(&problem.agents[agent]));
        let raster = ground.raster();
        let reached = raster.reached(from);
        let speed = problem.agents[agent].speed;
        let way = |to: Point| {
            let far = (distance(from, to) >= beyond.max(SAME_PLACE)).then(|| reached.way(to)).flatten();
            far.map(|points| length(&points) / speed).filter(|way| self.time + way + stay <= problem.horizon)
        };
        let mut offers = Vec::new();
        if let Some(sees) = problem.looks(agent) {
            let sight = problem.sight();
            if let Some(seat) = besides.and_then(|at| sight.seat(at)) {
                for (_, cell) in sight.seen(seat, sees.within) {
                    problem.exposure[*cell as usize] += sees.rate * stay;
                }
            }
            let left = Undetected::of(&problem);
            for at in lookouts(&problem, agent, &ground, Some(&reached)) {
                let (Some(way), Some(seat)) = (way(at), sight.seat(at)) else { continue };
                let seen = left.gain(&sight, seat, sees.within, sees.rate * stay);
                let worth = seen * problem.urgency(self.time + way);
                offers.push(Offer { at, worth, way, whole: way + stay });
            }
        }
        let pools = problem.pools();
        for (at, source) in goals(&problem, agent, &ground, Some(&reached)) {
            let rate = rate(&problem, agent, source, at, Travel::REST);
            if rate <= 0.0 || pools[source] <= EMPTY || !problem.is_open(source, &pools) {
                continue;
            }
            let Some(way) = way(at) else { continue };
            let stays = if pools[source].is_finite() { pools[source] / rate } else { stay };
            let left = problem.horizon - self.time - way;
            let stays = stays.min(left);
            offers.push(Offer { at, worth: rate * stays, way, whole: way + stays });
        }
        offers.retain(|offer| offer.worth > EMPTY && offer.whole > 0.0);
        offers
    }
}
