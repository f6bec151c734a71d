//! Times of a sequence with given durations: each robot does its jobs in order, each as early as possible.

use super::assistance::Assistance;
use super::instance::{Begin, Instance, Sequence};
use super::problem::ServiceTimes;

/// Durations of going, proximity and depositing of each job (s).
pub(crate) type Durations = Vec<[f64; 3]>;

/// A topological order of the jobs: each comes after the previous one of its robot and of its agent. Also stores the
/// robot of each job and the previous job of that robot. There is none if the sequence is incomplete or contradicts the
/// order of an agent's operations.
pub(crate) struct Order {
    pub jobs: Vec<usize>,
    pub robot: Vec<usize>,
    pub before: Vec<Option<usize>>,
}

impl Order {
    pub fn of(instance: &Instance, sequence: &Sequence) -> Option<Order> {
        let count = instance.jobs.len();
        let (mut robot, mut before) = (vec![usize::MAX; count], vec![None; count]);
        for (m, jobs) in sequence.iter().enumerate() {
            for (place, job) in jobs.iter().enumerate() {
                robot[*job] = m;
                before[*job] = place.checked_sub(1).map(|place| jobs[place]);
            }
        }
        let mut order = Order { jobs: Vec::with_capacity(count), robot, before };
        let mut next = vec![0; sequence.len()];
        let mut placed = vec![false; count];
        let mut moved = true;
        while moved {
            moved = false;
            for (m, jobs) in sequence.iter().enumerate() {
                while let Some(job) = jobs.get(next[m]) {
                    if instance.jobs[*job].previous.is_some_and(|previous| !placed[previous]) {
                        break;
                    }
                    placed[*job] = true;
                    order.jobs.push(*job);
                    next[m] += 1;
                    moved = true;
                }
            }
        }
        (order.jobs.len() == count).then_some(order)
    }
}

/// Computes the starts of services (s), each as early as possible, but not before `wanted`.
pub(crate) fn starts(instance: &Instance, order: &Order, durations: &Durations, wanted: Option<&[f64]>) -> Vec<f64> {
    let mut starts = vec![0.0; instance.jobs.len()];
    for &job in &order.jobs {
        let robot = order.robot[job];
        let free = order.before[job].map_or(instance.free[robot], |before| {
            starts[before] + instance.serve(robot) + durations[before][2] + instance.deposit(robot)
        });
        let ready = match instance.jobs[job].previous {
            Some(previous) => starts[previous] + instance.serve(order.robot[previous]) + instance.jobs[job].nominal,
            None => instance.jobs[job].release,
        };
        let arrival = free + durations[job][0] + durations[job][1];
        starts[job] = ready.max(arrival).max(wanted.map_or(f64::NEG_INFINITY, |wanted| wanted[job]));
    }
    starts
}

/// Computes the total cost of the schedule with these times.
pub(crate) fn cost(instance: &Instance, order: &Order, durations: &Durations, starts: &[f64]) -> f64 {
    let mut end = instance.busy;
    let mut cost = instance.constant;
    for (index, job) in instance.jobs.iter().enumerate() {
        let robot = order.robot[index];
        let serve = instance.serve(robot);
        end = end.max(starts[index] + serve + durations[index][2] + instance.deposit(robot));
        cost += job.start_cost * starts[index] + job.serve_cost * serve;
        cost += job.ways[robot].iter().zip(durations[index]).map(|(way, time)| way.cost(time)).sum::<f64>();
    }
    cost + instance.makespan_cost * end + instance.excess(starts, &order.robot)
}

/// Returns the schedule with these times and the services that have begun, by agent and operation. A robot leaves its
/// depot once it is free and the operation has begun, or earlier if that is necessary to be in time; then it waits near
/// the agent.
pub(crate) fn schedule(instance: &Instance, order: &Order, durations: &Durations, starts: &[f64]) -> Vec<Assistance> {
    let mut schedule = instance.done.clone();
    for (index, job) in instance.jobs.iter().enumerate() {
        let robot = order.robot[index];
        let serving = starts[index];
        let (start, end) = match job.begin {
            Begin::Fixed { start, end } => (start, end),
            Begin::Early { after } => {
                let start = starts[after] + instance.serve(order.robot[after]);
                (start, start + job.nominal)
            }
            Begin::Late => (serving - job.nominal, serving),
        };
        let home = order.before[index].map_or(instance.free[robot], |before| {
            starts[before] + instance.serve(robot) + durations[before][2] + instance.deposit(robot)
        });
        let proximity = serving - durations[index][1];
        let going = home.max(start.min(proximity - durations[index][0]));
        let depositing = serving + instance.serve(robot);
        let times = ServiceTimes {
            going,
            waiting: (going + durations[index][0]).min(proximity),
            proximity,
            serving,
            depositing,
            end: depositing + durations[index][2] + instance.deposit(robot),
        };
        schedule.push(Assistance {
            agent: job.agent,
            operation: job.operation,
            start,
            end,
            robot: instance.robots[robot],
            times,
        });
    }
    schedule.sort_by_key(Assistance::target);
    schedule
}
