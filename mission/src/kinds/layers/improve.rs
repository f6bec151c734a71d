//! Local search: exchanges agents and objects of a plan as long as that lowers the cost.

use std::time::Instant;

use super::dual::Choices;
use super::instance::Instance;
use super::speeds::{Load, timing};

/// A job and its new agent and object.
type Change = (usize, (usize, usize));

/// A plan during local search: choices with the loads and costs of their layers.
pub(super) struct Improver<'a> {
    instance: &'a Instance<'a>,
    pub choices: Choices,
    /// Loads by layer and agent.
    loads: Vec<Vec<Load>>,
    /// Costs by layer.
    costs: Vec<f64>,
    /// By object, the job that uses it.
    user: Vec<Option<usize>>,
    scratch: Vec<Load>,
    /// Number of layers timed.
    pub tried: u64,
    /// No change is tried after this instant.
    deadline: Option<Instant>,
}

impl<'a> Improver<'a> {
    /// Creates the local search. In `choices` each object is used at most once, and each agent has the abilities for
    /// its jobs.
    pub fn new(instance: &'a Instance<'a>, choices: Choices) -> Improver<'a> {
        let mut user = vec![None; instance.problem.objects.len()];
        for (index, job) in instance.jobs.iter().enumerate() {
            if let Some(object) = job.objects[choices[index].1] {
                user[object] = Some(index);
            }
        }
        let loads = vec![vec![Load::default(); instance.movers.len()]; instance.layers.len()];
        let costs = vec![0.0; instance.layers.len()];
        let mut improver =
            Improver { instance, choices, loads, costs, user, scratch: Vec::new(), tried: 0, deadline: None };
        for layer in 0..instance.layers.len() {
            improver.refresh(layer);
        }
        improver
    }

    /// Returns the cost of the plan.
    pub fn cost(&self) -> f64 {
        self.instance.offset + self.costs.iter().sum::<f64>()
    }

    /// Recomputes the loads and the cost of a layer.
    fn refresh(&mut self, layer: usize) {
        let instance = self.instance;
        let loads = &mut self.loads[layer];
        loads.fill(Load::default());
        for &index in &instance.layers[layer].jobs {
            let (agent, object) = self.choices[index];
            if let Some(mode) = instance.jobs[index].mode(object, agent) {
                loads[agent] = loads[agent].with(mode);
            }
        }
        self.costs[layer] = timing(&instance.movers, &instance.layers[layer], loads, instance.second).cost;
    }

    /// Returns the saving of these changes; `None` if an agent lacks an ability.
    fn saving(&mut self, changes: &[Change]) -> Option<f64> {
        let instance = self.instance;
        let layer_of = |job: usize| instance.jobs[job].layer;
        let mut saving = 0.0;
        for (number, (job, _)) in changes.iter().enumerate() {
            let Some(layer) = layer_of(*job) else { continue };
            if changes[..number].iter().any(|(other, _)| layer_of(*other) == Some(layer)) {
                continue;
            }
            self.scratch.clone_from(&self.loads[layer]);
            for (job, (agent, object)) in changes.iter().filter(|(job, _)| layer_of(*job) == Some(layer)) {
                let (old_agent, old_object) = self.choices[*job];
                let (old, new) =
                    (instance.jobs[*job].mode(old_object, old_agent)?, instance.jobs[*job].mode(*object, *agent)?);
                self.scratch[old_agent] = self.scratch[old_agent].without(old);
                self.scratch[*agent] = self.scratch[*agent].with(new);
            }
            self.tried += 1;
            let timing = timing(&instance.movers, &instance.layers[layer], &self.scratch, instance.second);
            saving += self.costs[layer] - timing.cost;
        }
        Some(saving)
    }

    /// Applies the changes if they lower the cost.
    fn accept(&mut self, changes: &[Change]) -> bool {
        let least = 1e-9 * self.costs.iter().sum::<f64>();
        if !self.saving(changes).is_some_and(|saving| saving > least) {
            return false;
        }
        for (job, _) in changes {
            if let Some(object) = self.instance.jobs[*job].objects[self.choices[*job].1] {
                self.user[object] = None;
            }
        }
        for (job, choice) in changes {
            self.choices[*job] = *choice;
            if let Some(object) = self.instance.jobs[*job].objects[choice.1] {
                self.user[object] = Some(*job);
            }
        }
        for (job, _) in changes {
            if let Some(layer) = self.instance.jobs[*job].layer {
                self.refresh(layer);
            }
        }
        true
    }

    /// Applies changes until none lowers the cost, `most` layers have been timed, or the deadline is reached.
    pub fn improve(&mut self, most: u64, deadline: Option<Instant>) {
        let mut changed = true;
        self.deadline = deadline;
        while changed {
            changed = false;
            for job in 0..self.instance.jobs.len() {
                if self.tried >= most || self.is_over() {
                    return;
                }
                if self.instance.jobs[job].layer.is_some() {
                    changed |= self.move_job(job);
                    changed |= self.exchange(job);
                }
            }
        }
    }

    fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Tries another agent or object for a job; if the object is in use, its job gets the object of this job instead.
    fn move_job(&mut self, index: usize) -> bool {
        let job = &self.instance.jobs[index];
        let mut changed = false;
        for object in 0..job.objects.len() {
            if self.is_over() {
                break;
            }
            for agent in 0..self.instance.movers.len() {
                let now = self.choices[index];
                if job.mode(object, agent).is_none() || now == (agent, object) {
                    continue;
                }
                let holder = job.objects[object].and_then(|thing| self.user[thing]).filter(|other| *other != index);
                let Some(other) = holder else {
                    changed |= self.accept(&[(index, (agent, object))]);
                    continue;
                };
                let mine = job.objects[now.1];
                let theirs = self.instance.jobs[other].objects.iter().position(|thing| *thing == mine);
                let Some(theirs) = theirs else { continue };
                let by = self.choices[other].0;
                changed |= self.accept(&[(index, (agent, object)), (other, (by, theirs))]);
            }
        }
        changed
    }

    /// Exchanges the agents of a job and a later one of its layer, with or without their objects.
    fn exchange(&mut self, index: usize) -> bool {
        let instance = self.instance;
        let Some(layer) = instance.jobs[index].layer else { return false };
        let mut changed = false;
        for &other in instance.layers[layer].jobs.iter().filter(|other| **other > index) {
            let (mine, theirs) = (self.choices[index], self.choices[other]);
            if self.is_over() {
                break;
            }
            if mine.0 == theirs.0 {
                continue;
            }
            if self.accept(&[(index, (theirs.0, mine.1)), (other, (mine.0, theirs.1))]) {
                changed = true;
                continue;
            }
            let (own, its) = (&instance.jobs[index].objects, &instance.jobs[other].objects);
            let to_me = own.iter().position(|thing| *thing == its[theirs.1]);
            let to_it = its.iter().position(|thing| *thing == own[mine.1]);
            if let (Some(to_me), Some(to_it)) = (to_me, to_it) {
                changed |= self.accept(&[(index, (theirs.0, to_me)), (other, (mine.0, to_it))]);
            }
        }
        changed
    }

    /// Returns the loads of each layer by agent.
    pub fn into_loads(self) -> Vec<Vec<Load>> {
        self.loads
    }
}
