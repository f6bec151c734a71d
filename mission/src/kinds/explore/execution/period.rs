//! The begin of a period: targets that were reached, the prediction, the new plan, and what happens without one.

use std::time::{Duration, Instant};

use super::super::lattice::Deadline;
use super::super::solve::NoPlan;
use super::super::validate::validate;
use super::details::PlanNote;
use super::{Committed, ExploreExecution, LogEntry, reason};
use crate::execution::Replan;

impl ExploreExecution {
    /// Takes what was reached at the end of the period before, plans, and gives the robots their inputs.
    pub(super) fn begin_period(&mut self) {
        if self.period > 0 {
            self.take();
            let at = self.person.at(self.time);
            let ends: Vec<_> = (0..self.robots.len()).filter_map(|robot| self.place(robot)).chain([at]).collect();
            self.walked.iter_mut().zip(ends).for_each(|(way, end)| way.push(end));
            self.look_at_bases();
        }
        // The plan with which the mission begins was made before it.
        if self.period > 0 && self.settings.replan != Replan::None {
            self.plan_anew();
        }
        self.follow();
        self.lay_motions();
    }

    /// Targets that the plan has robots take now.
    pub(super) fn take(&mut self) {
        let Some(plan) = &self.plan else { return };
        let due: Vec<_> = plan.trajectories.visits.iter().filter(|visit| visit.step == plan.step).copied().collect();
        if self.without_plan {
            return;
        }
        for visit in due {
            let robot = &self.robots[visit.robot];
            let at = self.place(visit.robot).unwrap_or(robot.state.at);
            let there = self.problem.targets[visit.target].shape.contains(at, 1e-6);
            if !there || !robot.active {
                continue;
            }
            match self.takers[visit.target] {
                None => {
                    self.takers[visit.target] = Some((visit.robot, self.time));
                    self.robots[visit.robot].taken += 1;
                    self.record(LogEntry::Taken { member: visit.robot, target: visit.target });
                }
                Some((taker, _)) if taker != visit.robot => {
                    self.counts.redundant += 1;
                    self.record(LogEntry::Redundant { member: visit.robot, target: visit.target });
                }
                Some(_) => {}
            }
        }
    }

    fn plan_anew(&mut self) {
        if !self.robots.iter().any(|robot| robot.active) {
            self.plan = None;
            return;
        }
        self.solver.pass_period();
        let present = self.present();
        if self.person.is_unseen() {
            return self.go_without("nobody knows where the person is".into(), None);
        }
        let foresight = self.person.foresee(&self.problem, &self.grid, &present.open, self.time);
        // Whatever comes of the plan, a way out of now is the one that counts.
        self.way_out = None;
        if foresight.periods() == 0 {
            return self.go_without("the prediction has no period".into(), None);
        }
        let time = Duration::from_secs_f64(self.problem.planner.time);
        let begun = Instant::now();
        let until = Deadline::at(begun + time);
        let found = self.solver.plan(&self.kept, &present, &foresight, time);
        match found {
            Ok(best) => {
                self.plans.push(PlanNote::new(self.time, &best, begun.elapsed().as_secs_f64()));
                let broken = validate(&self.kept, &present, &foresight, &best.trajectories);
                if let Some(first) = broken.first() {
                    self.find_way_out(&foresight, &until);
                    return self.go_without(format!("the plan is refused: {first}"), None);
                }
                if best.exposed > 0 && self.leaves_for_safety(&foresight, &until) {
                    self.solver.forget();
                    return self.go_without(
                        "with each plan that keeps the connection the person could corner a robot".into(),
                        None,
                    );
                }
                self.counts.plans += 1;
                self.counts.exposed += usize::from(best.exposed > 0);
                self.counts.worst_gap = self.counts.worst_gap.max(best.gap());
                let before = self.assigned();
                let trajectories = best.trajectories;
                self.plan = Some(Committed { trajectories, foresight, present, begin: self.time, step: 0 });
                let visits = self.assigned();
                if self.without_plan {
                    self.without_plan = false;
                    self.record(LogEntry::PlanAgain);
                }
                if visits != before && !visits.is_empty() {
                    self.record(LogEntry::Assigned { visits });
                }
            }
            Err(why @ (NoPlan::Late | NoPlan::Engine(_))) if self.goes_on(&present, &foresight) => {
                self.counts.kept += 1;
                let (why, group) = reason(&why);
                self.record(LogEntry::NoPlan { why, group, kept: true });
            }
            Err(why) => {
                let (why, group) = reason(&why);
                self.find_way_out(&foresight, &until);
                self.go_without(why, group);
            }
        }
    }

    /// True if the rest of the last plan is good for the period that begins now, wherever the person walks.
    fn goes_on(&mut self, present: &super::Present, foresight: &super::Foresight) -> bool {
        if self.without_plan {
            return false;
        }
        let Some(plan) = &self.plan else { return false };
        let step = plan.step;
        let one = super::Trajectories {
            states: Vec::new(),
            inputs: plan
                .trajectories
                .inputs
                .iter()
                .map(|all| all.get(step..=step).map(<[_]>::to_vec).unwrap_or_default())
                .collect(),
            visits: Vec::new(),
        };
        let short =
            super::Foresight { positions: foresight.positions.iter().take(2).copied().collect(), ..foresight.clone() };
        validate(&self.kept, present, &short, &one).is_empty()
    }

    fn go_without(&mut self, why: String, group: Option<super::Group>) {
        let new = !self.without_plan;
        self.without_plan = true;
        self.counts.without_plan += 1;
        if new {
            self.record(LogEntry::NoPlan { why, group, kept: false });
        }
    }

    /// Gives the robots the inputs of the plan for the period that begins.
    fn follow(&mut self) {
        if self.without_plan {
            return self.fall_back(self.problem.period / super::TICKS as f64);
        }
        let Some(plan) = &mut self.plan else {
            self.robots.iter_mut().for_each(|robot| robot.input = [0.0; 2]);
            return;
        };
        let step = plan.step;
        plan.step += 1;
        match plan.trajectories.inputs.first().is_some_and(|inputs| step < inputs.len()) {
            true => {
                for (robot, inputs) in self.robots.iter_mut().zip(&plan.trajectories.inputs) {
                    robot.input = inputs[step];
                }
            }
            // A plan ends with robots that stand.
            false => self.robots.iter_mut().for_each(|robot| robot.input = [0.0; 2]),
        }
    }

    /// Robots with the targets that they are to take, in the order of time.
    pub fn assigned(&self) -> Vec<(usize, usize)> {
        let Some(plan) = &self.plan else { return Vec::new() };
        let mut visits: Vec<_> = plan.trajectories.visits.iter().filter(|visit| visit.step > plan.step).collect();
        visits.sort_by_key(|visit| (visit.robot, visit.step));
        visits
            .iter()
            .map(|visit| (visit.robot, visit.target))
            .filter(|(_, target)| self.takers[*target].is_none())
            .collect()
    }
}
