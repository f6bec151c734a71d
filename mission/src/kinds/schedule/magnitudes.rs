//! Warnings about figures of a schedule that do not fit each other: a place that takes far longer to reach than all work there, an
//! operation that is far shorter than its service, a duration whose spread reaches below zero.

use blocks::{Help, Snippet};
use quantities::number;

use super::check::{Item, Key};
use super::problem::{Distances, Problem};
use crate::declare::{Origins, Remark, Remarks};

/// Number of times that a way may be as long as all work at its end.
const LONGER: f64 = 5.0;

/// Time (s) up to which a way is never reported.
const WAY: f64 = 900.0;

/// Part of a service below which an operation is too short.
const SHORTER: f64 = 0.1;

/// Mean of a normal distribution, in standard deviations, below which one duration in 20 is negative.
const NEGATIVE: f64 = 1.645;

/// Adds the warnings.
pub(super) fn add(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for (k, agent) in problem.agents.iter().enumerate().filter(|(_, agent)| agent.operations > 0) {
        let (name, item) = (&agent.name, Item::Agent(k));
        let mean = agent.duration.mean;
        let work = mean * agent.operations as f64;
        let ways = problem.robots.iter().enumerate().map(|(i, r)| problem.lengths(k, i).depositing / r.speed.high);
        let way = ways.reduce(f64::min).unwrap_or(0.0);
        if way > WAY && way > LONGER * work {
            let at = match problem.distances {
                Distances::Straight => places.of(item, &[Key::Place.name()]),
                Distances::Table(_) => places.of(Item::Mission, &[Key::Distances.name()]),
            };
            let text =
                format!("the way to `{name}` takes {} s, and all operations there take {} s", round(way), round(work));
            remarks.push(
                Remark::warning("HQ0917", at, text)
                    .note("this is the way of the fastest robot, at its full speed")
                    .help("check the unit of the place, and the speed of the robots"),
            );
        }
        let serve = problem.robots.iter().map(|r| r.serve).reduce(f64::min).unwrap_or(0.0);
        if mean < SHORTER * serve {
            let text = format!(
                "an operation of `{name}` takes {} s, and each service of it takes {} s",
                number(mean),
                number(serve)
            );
            remarks.push(
                Remark::warning("HQ0918", places.of(item, &[Key::Duration.name()]), text)
                    .note("the agent would wait for the robot nearly all the time")
                    .help("check the unit of the duration"),
            );
        }
        let sigma = agent.duration.sigma;
        if mean < NEGATIVE * sigma {
            let text = format!("more than one in 20 durations of `{name}` would be negative");
            let root = format!("normal({} s, {} s)", number(mean), number(round(sigma.sqrt())));
            remarks.push(
                Remark::warning("HQ0919", places.of(item, &[Key::Duration.name()]), text)
                    .note(format!("the standard deviation is {} s, and the mean {} s", number(sigma), number(mean)))
                    .help(Help::with(
                        "write the standard deviation, not the variance, such as {}",
                        [Snippet::entry("duration", root)],
                    )),
            );
        }
    }
}

/// Rounds to a tenth.
fn round(x: f64) -> f64 {
    (10.0 * x).round() / 10.0
}
