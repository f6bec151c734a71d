//! Everything that is measured of explorations.

use quantities::dimension::{LENGTH, NONE, TIME};

use super::ExploreExecution;
use crate::kind::{Form, Measure, number, truth};

const ROBOT: &[&str] = &["robot"];
const PERSON: &[&str] = &["human"];
const MOVING: &[&str] = &["robot", "human"];
const TARGET: &[&str] = &["target"];

/// The value of a measure; the index is that of the member, or of the target.
type Value = fn(&ExploreExecution, usize) -> Option<[f64; 3]>;

const fn count(name: &'static str, doc: &'static str) -> Measure {
    Measure::whole(name, Form::Number(NONE), doc)
}

fn of(count: usize) -> Option<[f64; 3]> {
    Some(number(count as f64))
}

/// Measures with their values.
pub(in super::super) const MEASURES: &[(Measure, Value)] = &[
    (Measure::whole("done", Form::Truth, "True once the person is at the exit; `done` alone is the same."), |e, _| {
        Some(truth(e.done.is_some()))
    }),
    (Measure::whole("stranded", Form::Truth, "True while every robot is lost."), |e, _| {
        Some(truth(e.nobody_is_left()))
    }),
    (Measure::whole("makespan", Form::Number(TIME), "Time from the start until the person is at the exit."), |e, _| {
        Some(number(e.done.unwrap_or(e.time)))
    }),
    (count("targets", "Number of targets that are taken, by robots and by the person."), |e, _| {
        of(e.takers.iter().flatten().count())
    }),
    (count("by_robots", "Number of targets that robots have taken."), |e, _| {
        of(e.takers.iter().flatten().filter(|(member, _)| *member < e.robots.len()).count())
    }),
    (count("by_person", "Number of targets that the person has taken."), |e, _| {
        of(e.takers.iter().flatten().filter(|(member, _)| *member == e.robots.len()).count())
    }),
    (count("redundant", "Number of visits of a target that somebody else had taken."), |e, _| of(e.counts.redundant)),
    (count("collisions", "Number of contacts of bodies, each counted once while it lasts."), |e, _| {
        of(e.counts.collisions)
    }),
    (count("disconnections", "Number of times that the team lost its connection."), |e, _| of(e.counts.disconnections)),
    (count("without_plan", "Number of periods without a plan, in which the robots follow the fallback."), |e, _| {
        of(e.counts.without_plan)
    }),
    (count("kept", "Number of periods in which the last plan went on, as there was no new one in time."), |e, _| {
        of(e.counts.kept)
    }),
    (
        count(
            "exposed",
            "Number of periods with a plan after which it was not known that all robots could give way, whatever the person did.",
        ),
        |e, _| of(e.counts.exposed),
    ),
    (count("worst_gap", "The largest relative gap of a plan to the best one."), |e, _| {
        Some(number(e.counts.worst_gap))
    }),
    (Measure::whole("connected", Form::Truth, "True while the graph of the team is connected."), |e, _| {
        Some(truth(e.is_connected()))
    }),
    (Measure::whole("planned", Form::Truth, "True while the robots follow a plan."), |e, _| {
        Some(truth(!e.without_plan))
    }),
    (
        Measure::whole(
            "closest",
            Form::Number(LENGTH),
            "Smallest distance so far between the bodies of a robot and of the person; negative for the depth of a contact.",
        ),
        |e, _| e.counts.closest.map(number),
    ),
    (Measure::of(MOVING, "position", Form::Point, "Its position."), |e, member| {
        let [x, y] = e.place(member)?;
        Some([x, y, 0.0])
    }),
    (Measure::of(MOVING, "taken", Form::Number(NONE), "Number of targets that it has taken."), |e, member| {
        of(e.robots.get(member).map_or(e.person.taken, |robot| robot.taken))
    }),
    (Measure::of(MOVING, "travelled", Form::Number(LENGTH), "Length of its way so far."), |e, member| {
        Some(number(e.robots.get(member).map_or(e.person.travelled, |robot| robot.travelled)))
    }),
    (
        Measure::of(ROBOT, "clearance", Form::Number(LENGTH), "Distance between its body and that of the person."),
        |e, member| e.clearance(member).map(number),
    ),
    (Measure::of(ROBOT, "lost", Form::Truth, "True while it takes no part."), |e, member| {
        Some(truth(!e.robots.get(member)?.active))
    }),
    (Measure::of(PERSON, "lost", Form::Truth, "True while the robots do not know where the person is."), |e, _| {
        Some(truth(e.person.is_unseen()))
    }),
    (Measure::of(TARGET, "taken", Form::Truth, "True once somebody has taken it."), |e, target| {
        Some(truth(e.takers.get(target)?.is_some()))
    }),
    (Measure::of(TARGET, "by_robot", Form::Truth, "True once a robot has taken it."), |e, target| {
        Some(truth(e.takers.get(target)?.is_some_and(|(member, _)| member < e.robots.len())))
    }),
];
