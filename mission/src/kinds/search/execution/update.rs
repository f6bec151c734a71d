//! The plan follows what happens: how it is repaired, and what replaces it; the rule is in [`crate::execution`].

use crate::execution::{Improved, PlanChange, Repaired, Replan, ReplanPolicy, Replans};
use crate::kinds::search::choose::plan_checked;
use crate::kinds::search::plan::{Activity, Awaited, Phase, Plan};
use crate::kinds::search::problem::Problem;
use crate::kinds::search::reward::evaluate;
use crate::kinds::search::validate::validate;
use crate::plan::{Statistics, Status};

use super::record::LogEntry;
use super::settings::Settings;
use super::steps::part;
use super::{EQUAL, SearchExecution, SearchWorld, own};

/// Difference of two ends below which they are the same (s).
const SAME: f64 = 1e-6;

/// The activities of each agent from now on.
pub enum Remaining {
    /// Those of the plan so far, at these times.
    Kept(Vec<Vec<Activity>>),
    /// Those of a new plan.
    Fresh(Vec<Vec<Activity>>),
}

impl Replans for SearchWorld {
    type Steps = Remaining;

    fn changed(change: PlanChange) -> LogEntry {
        LogEntry::Plan(change)
    }

    /// Any change of the reward is a reason: a plan takes less than a second.
    fn rule(settings: &Settings) -> (Replan, f64) {
        (settings.replan, EQUAL)
    }

    fn repair(of: &SearchExecution, problem: Problem) -> Repaired<Self> {
        let nobody = problem.agents.iter().all(|agent| agent.lost);
        let displaced = of.world.members.iter().any(|member| member.displaced);
        if nobody || (displaced && Self::is_open(&problem)) {
            return Repaired { problem, plan: None };
        }
        let rest = of.rest();
        let plan = plan_of(&problem, of.remaining(&rest, problem.end()));
        Repaired { problem, plan: Some((Remaining::Kept(rest), plan)) }
    }

    fn broken(problem: &Problem, plan: &Plan) -> Option<String> {
        validate(problem, plan).first().map(ToString::to_string)
    }

    fn moved(&self, steps: &Remaining) -> bool {
        let Remaining::Kept(rest) = steps else { return true };
        let known =
            self.members.iter().zip(rest).flat_map(|(member, own)| member.queue.iter().skip(member.next).zip(own));
        let mut ends = known.filter(|(was, _)| was.phase != Phase::Waiting);
        ends.any(|(was, is)| (was.end - is.end).abs() > SAME)
    }

    fn steps_of(problem: &Problem, plan: &Plan) -> Result<Remaining, String> {
        Ok(Remaining::Fresh((0..problem.agents.len()).map(|agent| own(plan, agent)).collect()))
    }

    fn adopt(of: &mut SearchExecution, steps: Remaining) {
        match steps {
            Remaining::Kept(rest) => {
                for (member, own) in of.world.members.iter_mut().zip(rest) {
                    for (was, is) in member.queue.iter_mut().skip(member.next).zip(own) {
                        (was.start, was.end) = (is.start, is.end);
                    }
                }
            }
            Remaining::Fresh(queues) => {
                for (agent, queue) in queues.into_iter().enumerate() {
                    of.end(agent, false);
                    let member = &mut of.world.members[agent];
                    member.displace(false);
                    member.queue = queue;
                }
                (0..of.world.members.len()).for_each(|agent| of.start(agent));
            }
        }
    }

    fn index(of: &SearchExecution) -> f64 {
        let (was, is) = (of.world.expected, of.expected());
        if (was - is).abs() <= EQUAL { 0.0 } else { ((was - is) / was).abs() }
    }

    fn rebase_index(of: &mut SearchExecution) {
        of.world.expected = of.expected();
    }

    fn is_open(problem: &Problem) -> bool {
        problem.horizon - problem.start > EQUAL && problem.agents.iter().any(|agent| !agent.lost)
    }

    fn improve(of: &SearchExecution) -> Result<Improved<Activity>, String> {
        let fresh = Self::plan_anew(&of.problem, &of.settings)?;
        match fresh.cost < of.plan.cost - EQUAL {
            true => Ok(Improved::Fresh(Box::new(fresh))),
            false => Err("the present plan collects as much".into()),
        }
    }

    fn plan_anew(problem: &Problem, settings: &Settings) -> Result<Plan, String> {
        Ok(plan_checked(problem, &settings.options(problem)).plan)
    }

    fn nobody_left(problem: &Problem) -> Option<&'static str> {
        problem.agents.iter().all(|agent| agent.lost).then_some("everybody")
    }

    fn strand(of: &mut SearchExecution, problem: Problem, _again: bool) {
        of.plan = plan_of(&problem, Vec::new());
        of.problem = problem;
    }
}

/// The plan of activities from the start of a problem on.
fn plan_of(problem: &Problem, activities: Vec<Activity>) -> Plan {
    let rewards = evaluate(problem, &activities);
    Plan {
        members: problem.agents.iter().map(|agent| agent.name.clone()).collect(),
        activities,
        cost: -rewards.total,
        status: Status::Unbounded { stopped: None },
        engine: "rescheduling".into(),
        statistics: Statistics::default(),
    }
}

impl SearchExecution {
    /// Brings the plan up to the world.
    pub(super) fn update(&mut self, policy: ReplanPolicy) {
        let problem = self.present();
        self.update_plan(problem, policy);
    }

    /// Reward of the whole mission: what is collected, and what the plan promises.
    fn expected(&self) -> f64 {
        self.world.rewards.total - self.plan.cost
    }

    /// The activities that are under way or to come, as they are expected from now on, by agent.
    pub(super) fn rest(&self) -> Vec<Vec<Activity>> {
        let mut rest: Vec<Vec<Activity>> = Vec::new();
        for (agent, member) in self.world.members.iter().enumerate() {
            let mut own: Vec<Activity> = member.queue.iter().skip(member.next).cloned().collect();
            if self.problem.agents[agent].lost {
                own.clear();
            }
            if let (Some(current), Some(first)) = (&member.current, own.first_mut()) {
                if let Some(way) = &current.way {
                    first.way = part(&way.points, [current.share(self.time), 1.0]);
                }
                first.start = self.time;
                first.begun = true;
                first.end = current.ends.map_or(self.time, |ends| ends.max(self.time));
            }
            rest.push(own);
        }
        let planned: Vec<Vec<f64>> =
            rest.iter().map(|own| own.iter().map(|activity| activity.end - activity.start).collect()).collect();
        // Waits depend on one another: as many passes as there are agents settle them.
        for _ in 0..=rest.len() {
            for agent in 0..rest.len() {
                let mut time = self.time;
                for i in 0..rest[agent].len() {
                    let activity = &rest[agent][i];
                    let end = match (activity.phase, activity.awaits) {
                        (Phase::Waiting, Some(of)) => {
                            let number = of.number.checked_sub(self.world.members[of.agent].next);
                            let end = number.and_then(|number| rest[of.agent].get(number)).map(|other| other.end);
                            end.unwrap_or(time).max(time)
                        }
                        (Phase::Waiting, None) => time,
                        _ => time + planned[agent][i],
                    };
                    (rest[agent][i].start, rest[agent][i].end) = (time, end);
                    time = end;
                }
            }
        }
        rest
    }

    /// The part of these activities that counts: until the end of the plan's time. Numbers of activities that are waited for are those among
    /// the rest.
    fn remaining(&self, rest: &[Vec<Activity>], horizon: f64) -> Vec<Activity> {
        let mut all = Vec::new();
        for activity in rest.iter().flatten().filter(|activity| activity.start < horizon) {
            let Activity { start, end, .. } = *activity;
            if end <= horizon {
                let awaits = activity.awaits.and_then(|of| {
                    let number = of.number.checked_sub(self.world.members.get(of.agent)?.next)?;
                    // An activity that ended before the wait began is not waited for.
                    let other = rest.get(of.agent)?.get(number)?;
                    (other.end >= end).then_some(Awaited { agent: of.agent, number })
                });
                all.push(Activity { awaits, ..activity.clone() });
                continue;
            }
            let share = (horizon - start) / (end - start);
            let way =
                if activity.phase == Phase::Going { part(&activity.way, [0.0, share]) } else { activity.way.clone() };
            all.push(Activity { end: horizon, way, awaits: None, ..activity.clone() });
        }
        all
    }

    /// The problem from here and now on.
    pub fn present(&self) -> Problem {
        let mut problem = self.problem.clone();
        problem.start = self.time;
        for (agent, who) in problem.agents.iter_mut().enumerate() {
            let pose = self.pose(agent, self.time);
            (who.start, who.heading) = (pose.at, pose.heading);
        }
        for (source, pool) in problem.sources.iter_mut().zip(&self.world.rewards.pools) {
            source.pool = source.pool.map(|_| *pool);
        }
        problem
    }
}
