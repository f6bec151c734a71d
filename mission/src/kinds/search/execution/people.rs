//! Simulated people: they send messages and choose goals by their habits, as somebody at a page would.
//!
//! A person decides at the start, whenever the next way begins after an arrival, and after a stay at a goal of their own: to follow the
//! plan, or to go to a goal of their own, told before (*My goal*) or not (straying). *My pose* is sent at times of its own: whoever strays
//! is found by it, and goes on to an own goal that was not told. To follow the plan again a person waits for the next *My pose*, since the plan
//! begins where the person is believed to be. Messages go through [`SearchExecution::handle_event`], as those of scripts and pages do.
//!
//! Each draw has a stream that is named after the person and the number of the message or decision, so that a search without habits is executed as
//! ever, and no draw depends on the order of others. Habits of people who report, such as those with a page, are off.

use std::sync::Arc;

use crate::execution::Durations;
use crate::kinds::search::geometry::{Point, distance};
use crate::kinds::search::habits::{Habits, Weibull};
use crate::kinds::search::plan::Phase;
use crate::kinds::search::problem::Problem;
use crate::kinds::search::sight::Sight;
use crate::random::{stream, unit};

use super::SearchExecution;
use super::event::Event;
use super::messages::SAME_PLACE;
use super::settings::Settings;
use super::steps::Step;

/// A simulated person.
#[derive(Clone, Debug)]
pub(super) struct Person {
    agent: usize,
    habits: Habits,
    /// Distribution of the times between messages (s), if any are sent.
    times: Option<Weibull>,
    seed: u64,
    /// Time of the next *My pose* by habit (s); of none it is infinite.
    sends: f64,
    /// Time at which a reminder is followed (s); of none it is infinite.
    heeds: f64,
    /// Number of poses that were sent.
    poses: usize,
    /// Number of arrivals at the last decision; none: there was no decision.
    decided: Option<usize>,
    /// Number of decisions.
    decisions: usize,
    /// A goal that was chosen and told to nobody.
    own: Option<Point>,
    /// Time of the next decision of a person who strays (s); of none it is infinite.
    leaves: f64,
    /// Exposure of each cell as the person knows it: by their own true motion and by that of the others as it is shown.
    exposure: Vec<f64>,
}

impl Person {
    /// The people of a problem who have habits and do not report.
    pub fn all(problem: &Problem, settings: &Settings) -> Vec<Person> {
        let seed = match settings.durations {
            Durations::Sampled { seed } => seed,
            Durations::Planned => problem.planner.seed,
        };
        let acts = |agent: &usize| problem.agents[*agent].human && !settings.reporting.contains(agent);
        let cells = if problem.is_searching() { problem.sight().len() } else { 0 };
        let person = |agent: usize| {
            let habits = problem.agents[agent].habits?;
            let mut person = Person {
                agent,
                habits,
                times: habits.my_pose.and_then(|times| times.distribution().ok()),
                seed,
                sends: f64::INFINITY,
                heeds: f64::INFINITY,
                poses: 0,
                decided: None,
                decisions: 0,
                own: None,
                leaves: f64::INFINITY,
                exposure: vec![0.0; cells],
            };
            person.sends = problem.start + person.interval(problem);
            Some(person)
        };
        (0..problem.agents.len()).filter(acts).filter_map(person).collect()
    }

    /// Numbers between 0 and 1 for the `number`th use of a kind.
    fn draws<const N: usize>(&self, problem: &Problem, of: &str, number: usize) -> [f64; N] {
        let mut random = stream(self.seed, &["habits", of, &problem.agents[self.agent].name, &number.to_string()]);
        std::array::from_fn(|_| unit(&mut random))
    }

    /// The time until the next pose (s).
    fn interval(&self, problem: &Problem) -> f64 {
        let [share] = self.draws(problem, "my_pose", self.poses);
        self.times.map_or(f64::INFINITY, |times| times.quantile(share))
    }
}

impl SearchExecution {
    /// The steps of simulated people.
    pub(super) fn steps_of_people(&self) -> Vec<(f64, Step)> {
        let mut steps = Vec::new();
        for person in &self.world.people {
            let agent = person.agent;
            if self.done() || self.problem.agents[agent].lost {
                continue;
            }
            steps.push((person.sends.min(person.heeds), Step::Sends(agent)));
            match &self.world.members[agent].stray {
                Some(_) => steps.push((person.leaves, Step::Decides(agent))),
                None if self.is_proposed(person) => steps.push((self.time, Step::Decides(agent))),
                None => {}
            }
        }
        steps.retain(|(time, _)| *time <= self.problem.horizon);
        steps
    }

    /// A way begins about which a person has not decided.
    fn is_proposed(&self, person: &Person) -> bool {
        let member = &self.world.members[person.agent];
        let going = member.queue.get(member.next).is_some_and(|activity| activity.phase == Phase::Going);
        let told = self.problem.agents[person.agent].told.is_some();
        member.current.is_some() && going && !told && person.decided != Some(member.arrivals)
    }

    /// Changes what is known of a person.
    fn person(&mut self, agent: usize) -> Option<&mut Person> {
        self.world.people.iter_mut().find(|person| person.agent == agent)
    }

    /// Exposure of each cell as a simulated person knows it; none: nobody simulates the agent.
    pub fn known_exposure(&self, agent: usize) -> Option<&[f64]> {
        self.world.people.iter().find(|person| person.agent == agent).map(|person| person.exposure.as_slice())
    }

    /// A person looks around in an interval, and sees on the map where the others are believed to be.
    pub(super) fn learn(&mut self, from: f64, to: f64) {
        if self.world.people.is_empty() || !self.problem.is_searching() {
            return;
        }
        let sight: Arc<Sight> = self.problem.sight();
        let mut people = std::mem::take(&mut self.world.people);
        for person in &mut people {
            for agent in 0..self.problem.agents.len() {
                let Some(sees) = self.problem.looks(agent) else { continue };
                let own = agent == person.agent;
                let motion = if own { self.motion(agent, from, to) } else { self.believed_motion(agent, from, to) };
                motion.each_seat(from, to, |seat, begin, end| {
                    for (_, cell) in sight.seen(seat, sees.within) {
                        person.exposure[*cell as usize] += sees.rate * (end - begin);
                    }
                });
            }
        }
        self.world.people = people;
    }

    /// A person has said where they are: the next message by habit is that much later.
    pub(super) fn pose_was_sent(&mut self, agent: usize) {
        let now = self.time;
        let Some(index) = self.world.people.iter().position(|person| person.agent == agent) else { return };
        let person = &mut self.world.people[index];
        person.poses += 1;
        person.heeds = f64::INFINITY;
        person.sends = now + person.interval(&self.problem);
    }

    /// A person is reminded for the `number`th time, and may heed it.
    pub(super) fn heed(&mut self, agent: usize, number: usize, reaction: f64) {
        let now = self.time;
        let Some(index) = self.world.people.iter().position(|person| person.agent == agent) else { return };
        let [draw] = self.world.people[index].draws(&self.problem, "heeds", number);
        let person = &mut self.world.people[index];
        if draw < person.habits.heeds {
            person.heeds = person.heeds.min(now + reaction);
        }
    }

    /// A simulated person sends *My pose*.
    pub(super) fn send_pose(&mut self, agent: usize) {
        let before = self.person(agent).map(|person| person.poses);
        let to = self.true_pose(agent, self.time).at;
        let ends = self.world.members[agent].stray.as_ref().map(super::messages::Stray::ends);
        let said = self.handle_event(Event::MyPose { agent, to }).is_ok();
        if !said && self.person(agent).map(|person| person.poses) == before {
            // Nothing was sent, for instance at the edge of a wall: the next message is due as if it were.
            self.pose_was_sent(agent);
        }
        // A find or a done activity meanwhile ends the way to a goal of their own.
        let going = self.problem.objects.is_empty() || self.problem.is_searching();
        let own = self.person(agent).and_then(|person| person.own.take()).filter(|_| going && !self.done());
        let (Some(to), Some(ends)) = (own, ends) else { return };
        let now = self.time;
        let leaves = self.person(agent).map_or(f64::INFINITY, |person| person.leaves);
        self.leave_for(agent, to);
        if ends <= now
            && let Some(person) = self.person(agent)
        {
            // At the goal already: the stay goes on.
            person.leaves = leaves;
        }
    }

    /// A person goes to a goal and tells nobody.
    fn leave_for(&mut self, agent: usize, to: Point) {
        if self.handle_event(Event::Strays { agent, to }).is_err() {
            return;
        }
        let stay = self.problem.planner.stay;
        let ends = self.world.members[agent].stray.as_ref().map_or(self.time, super::messages::Stray::ends);
        if let Some(person) = self.person(agent) {
            (person.own, person.leaves) = (Some(to), ends + stay);
        }
    }

    /// A simulated person decides where to go, and what to tell.
    pub(super) fn decide(&mut self, agent: usize) {
        let arrivals = self.world.members[agent].arrivals;
        let Some(person) = self.person(agent) else { return };
        let number = person.decisions;
        (person.decisions, person.decided, person.own, person.leaves) =
            (number + 1, Some(arrivals), None, f64::INFINITY);
        let person = person.clone();
        let (habits, exposure) = (person.habits, &person.exposure);
        let [rejects, follows, tells] = person.draws(&self.problem, "decision", number);
        let strays = self.world.members[agent].stray.is_some();
        if !strays && rejects < habits.replan {
            // Always possible.
            let _ = self.handle_event(Event::Replan);
        }
        let own = if follows < habits.follows { None } else { self.own_goal(agent, &habits, exposure, None) };
        let told = own.is_some() && tells < habits.my_goal;
        if let Some(to) = own {
            if told {
                // The way begins where the person is believed to be, and the person goes from where they are.
                let said = self.handle_event(Event::MyGoal { agent, to }).is_ok();
                if strays || !said {
                    self.leave_for(agent, to);
                    if said && let Some(person) = self.person(agent) {
                        person.own = None;
                    }
                }
            } else {
                self.leave_for(agent, to);
            }
        }
        let probability = if told { habits.robot_goal } else { habits.robot_goal_alone };
        let robots = (0..self.problem.agents.len()).filter(|robot| {
            let who = &self.problem.agents[*robot];
            !who.human && !who.lost && who.told.is_none()
        });
        for robot in robots.collect::<Vec<_>>() {
            let name = self.problem.agents[robot].name.clone();
            let [draw] = person.draws(&self.problem, &format!("robot_goal {name}"), number);
            if draw < probability
                && let Some(to) = self.own_goal(robot, &habits, exposure, own)
                && own.is_none_or(|own| distance(own, to) > SAME_PLACE)
            {
                // A goal that the robot cannot reach is not told.
                let _ = self.handle_event(Event::RobotGoal { agent: robot, to });
            }
        }
    }
}
