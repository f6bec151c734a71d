//! Looking for hidden objects while a search is under way (srs section 5): true places, what is detected, and the belief.
//!
//! Each object has a true place and a threshold, drawn from the exponential distribution of mean 1: it is detected when the
//! exposure of its cell reaches the threshold, which has the probabilities of (22) to (24). Twice a second, and at each event, it is
//! checked which ones are. An agent that reports, such as a person with a page, says itself what it finds. Exposures follow the true motions, and those of the belief, from which plans are made, the believed
//! ones. The belief that a straying person caused is not corrected afterwards.

use std::sync::Arc;

use crate::execution::{Durations, ReplanPolicy};
use crate::kinds::search::belief::prior;
use crate::kinds::search::geometry::Point;
use crate::kinds::search::problem::Problem;
use crate::kinds::search::reward::Motion;
use crate::kinds::search::sight::Sight;
use crate::random::{stream, unit};

use super::record::LogEntry;
use super::settings::Settings;
use super::{EQUAL, SearchExecution};

/// Time between two checks of what is detected (s).
pub(super) const LOOK: f64 = 0.5;

/// A hidden object as it truly is.
#[derive(Clone, Debug, PartialEq)]
pub struct Secret {
    /// Index of its group.
    pub object: usize,
    /// True place (m).
    pub at: Point,
    /// Its cell; none: no cell is in sight of it.
    cell: Option<u32>,
    /// Exposure at which it is detected.
    threshold: f64,
    /// Time at which it was found (s).
    pub found: Option<f64>,
}

/// The state of looking for hidden objects.
#[derive(Clone, Debug)]
pub(super) struct Hunt {
    sight: Arc<Sight>,
    /// True exposure of each cell.
    exposure: Vec<f64>,
    /// Its part by the agents whose finds are simulated: those who report say themselves what they find.
    simulated: Vec<f64>,
    pub secrets: Vec<Secret>,
    /// Share of the ground that each agent has explored.
    pub explored: Vec<f64>,
    /// Number of objects that each agent has found.
    pub finds: Vec<usize>,
    /// Something was found, and the plan does not account for it yet.
    news: bool,
    /// Straying people who have found something: they tell the others, who then know where they are.
    reporters: Vec<usize>,
    /// Time at which plans were last made for those who had nothing to do (s).
    extended: f64,
}

impl Hunt {
    /// The begin; none: nothing is hidden.
    pub fn new(problem: &Problem, settings: &Settings) -> Option<Hunt> {
        if !problem.is_searching() {
            return None;
        }
        let seed = match settings.durations {
            Durations::Sampled { seed } => seed,
            Durations::Planned => problem.planner.seed,
        };
        let sight = problem.sight();
        let mut secrets = Vec::new();
        for (index, object) in problem.objects.iter().enumerate() {
            let prior = prior(&sight, object);
            for number in object.found..object.count {
                let mut random = stream(seed, &["hidden", &object.name, &number.to_string()]);
                let drawn = draw(&prior, unit(&mut random));
                let place = object.places.get(number).copied();
                let at = place.unwrap_or_else(|| drawn.map_or_else(Point::default, |cell| sight.middles()[cell]));
                let cell = match place {
                    Some(at) => sight.seat(at),
                    None => drawn.map(|cell| cell as u32),
                };
                let threshold = -unit(&mut random).ln();
                secrets.push(Secret { object: index, at, cell, threshold, found: None });
            }
        }
        let agents = problem.agents.len();
        Some(Hunt {
            exposure: vec![0.0; sight.len()],
            simulated: vec![0.0; sight.len()],
            sight,
            secrets,
            explored: vec![0.0; agents],
            finds: vec![0; agents],
            news: false,
            reporters: Vec::new(),
            extended: f64::NEG_INFINITY,
        })
    }

    /// Share of the ground that the team has explored: the mean over its cells of the probability that an object there would have
    /// been detected.
    pub fn explored(&self) -> f64 {
        self.explored.iter().sum()
    }
}

/// The cell at a quantile of a distribution.
fn draw(prior: &[f64], quantile: f64) -> Option<usize> {
    let mut left = quantile * prior.iter().sum::<f64>();
    let mut last = None;
    for (cell, mass) in prior.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
        last = Some(cell);
        left -= mass;
        if left <= 0.0 {
            break;
        }
    }
    last
}

impl SearchExecution {
    /// Hidden objects as they truly are.
    pub fn secrets(&self) -> &[Secret] {
        self.world.hunt.as_ref().map_or(&[], |hunt| &hunt.secrets)
    }

    /// Share of the ground that is explored: by an agent, or by all.
    pub fn explored(&self, agent: Option<usize>) -> f64 {
        let Some(hunt) = &self.world.hunt else { return 0.0 };
        agent.map_or_else(|| hunt.explored(), |agent| hunt.explored.get(agent).copied().unwrap_or_default())
    }

    /// Number of objects that an agent has found.
    pub fn finds(&self, agent: usize) -> usize {
        self.world.hunt.as_ref().and_then(|hunt| hunt.finds.get(agent).copied()).unwrap_or_default()
    }

    /// Agents look around in an interval: exposures grow, and objects are detected.
    pub(super) fn look(&mut self, from: f64, to: f64) {
        let Some(mut hunt) = self.world.hunt.take() else { return };
        let mut exposed = std::mem::take(&mut self.problem.exposure);
        exposed.resize(hunt.sight.len(), 0.0);
        let mut detected: Vec<(usize, usize)> = Vec::new();
        for agent in 0..self.problem.agents.len() {
            let Some(sees) = self.problem.looks(agent) else { continue };
            let reports = self.settings.reporting.contains(&agent);
            let (exposure, simulated, sight) = (&mut hunt.exposure, &mut hunt.simulated, &hunt.sight);
            let mut gained = 0.0;
            let motion = self.motion(agent, from, to);
            motion.each_seat(from, to, |seat, begin, end| {
                for (_, cell) in sight.seen(seat, sees.within) {
                    let of = &mut exposure[*cell as usize];
                    let before = *of;
                    *of += sees.rate * (end - begin);
                    if !reports {
                        simulated[*cell as usize] += sees.rate * (end - begin);
                    }
                    gained += (-before).exp() - (-*of).exp();
                }
            });
            hunt.explored[agent] += gained / sight.len().max(1) as f64;
            let believed: Motion<'_> = self.believed_motion(agent, from, to);
            believed.each_seat(from, to, |seat, begin, end| {
                for (_, cell) in sight.seen(seat, sees.within) {
                    exposed[*cell as usize] += sees.rate * (end - begin);
                }
            });
            for (number, secret) in hunt.secrets.iter().enumerate().filter(|(_, secret)| secret.found.is_none()) {
                let is_new = detected.iter().all(|(known, _)| *known != number);
                let reached = |cell: u32| hunt.simulated[cell as usize] >= secret.threshold;
                if is_new && !reports && secret.cell.is_some_and(reached) {
                    detected.push((number, agent));
                }
            }
        }
        self.problem.exposure = exposed;
        self.world.hunt = Some(hunt);
        for (number, agent) in detected {
            self.find(number, Some(agent));
        }
    }

    /// An object is found, by an agent or by somebody who says so.
    fn find(&mut self, number: usize, agent: Option<usize>) {
        let now = self.time;
        let Some(hunt) = &mut self.world.hunt else { return };
        let secret = &mut hunt.secrets[number];
        secret.found = Some(now);
        hunt.news = true;
        let object = secret.object;
        if let Some(agent) = agent {
            hunt.finds[agent] += 1;
            if self.world.members[agent].stray.is_some() {
                hunt.reporters.push(agent);
            }
        }
        self.problem.objects[object].found += 1;
        let worth = self.problem.objects[object].worth * self.problem.urgency(now);
        let rewards = &mut self.world.rewards;
        rewards.total += worth;
        rewards.objects += worth;
        if let Some(agent) = agent {
            rewards.agents[agent] += worth;
            self.record(LogEntry::Found { object, agent });
        }
        self.reopen();
    }

    /// Somebody says that an object of a group is found.
    pub(super) fn report_find(&mut self, object: usize) {
        let open = |secret: &Secret| secret.object == object && secret.found.is_none();
        if let Some(number) = self.secrets().iter().position(open) {
            self.find(number, None);
        }
    }

    /// The plan accounts for what was found; and who has nothing more to do gets something to do while something is hidden.
    pub(super) fn follow(&mut self) {
        let (now, searching) = (self.time, self.problem.is_searching());
        let Some(hunt) = &mut self.world.hunt else { return };
        if self.problem.horizon - now <= EQUAL {
            return;
        }
        let (news, reporters) = (std::mem::take(&mut hunt.news), std::mem::take(&mut hunt.reporters));
        for agent in reporters.iter().copied().filter(|_| searching) {
            self.end_stray(agent);
        }
        if news && searching {
            let policy = if reporters.is_empty() { ReplanPolicy::IfCostly } else { ReplanPolicy::IfInfeasible };
            self.update(policy);
        } else if news {
            // Nobody looks for anything any more.
            for agent in 0..self.world.members.len() {
                self.end_stray(agent);
                if !self.problem.agents[agent].lost {
                    self.end(agent, false);
                    self.world.members[agent].displace(true);
                }
            }
            return self.update(ReplanPolicy::IfInfeasible);
        }
        let idle = |agent: &usize| {
            let member = &self.world.members[*agent];
            self.problem.looks(*agent).is_some() && member.current.is_none() && member.next >= member.queue.len()
        };
        let idle: Vec<usize> = (0..self.world.members.len()).filter(idle).collect();
        let Some(hunt) = &mut self.world.hunt else { return };
        if !idle.is_empty() && now > hunt.extended {
            hunt.extended = now;
            idle.into_iter().for_each(|agent| self.world.members[agent].displace(true));
            self.update(ReplanPolicy::IfInfeasible);
        }
    }
}
