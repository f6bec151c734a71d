//! Messages about a mission for one person, and the format of times. Operations count from 1.

use mission::execution::PlanChange;
use mission::kinds::schedule::execution::{Event, Happening, Record};
use mission::kinds::schedule::plan::Actor;
use mission::kinds::schedule::problem::Problem;

/// Formats seconds as `3:07` or `1:02:09`.
pub fn written(seconds: f64) -> String {
    // The cast saturates: NaN and huge numbers become the nearest valid ones.
    let whole = (seconds.abs() + 1e-9) as u64;
    let sign = if seconds <= -1.0 { "-" } else { "" };
    match whole / 3600 {
        0 => format!("{sign}{}:{:02}", whole / 60, whole % 60),
        hours => format!("{sign}{hours}:{:02}:{:02}", whole / 60 % 60, whole % 60),
    }
}

/// Returns the label of an agent.
pub fn agent(problem: &Problem, index: usize) -> &str {
    problem.agent_label(index).unwrap_or("?")
}

/// Returns the label of a robot.
pub fn robot(problem: &Problem, index: usize) -> &str {
    problem.robot_label(index).unwrap_or("?")
}

/// Returns the words of thesis 5.7.1 for a feedback in steps from -2 to 2.
fn feedback(wait: i8, approach: i8, distance: i8) -> String {
    let word = |words: [&'static str; 5], step: i8| words[(step.clamp(-2, 2) + 2) as usize];
    let wait = word(["too short", "short", "OK", "long", "too long"], wait);
    let approach = word(["very fast", "fast", "OK", "slow", "very slow"], approach);
    let distance = word(["very far", "far", "OK", "close", "very close"], distance);
    format!("waiting time {wait}, velocity {approach}, waiting distance {distance}")
}

/// Returns a record as a message for this agent; `None` if it does not concern the agent.
pub fn for_one(problem: &Problem, who: usize, record: &Record) -> Option<String> {
    let m = |index: &usize| robot(problem, *index);
    Some(match &record.what {
        Happening::OperationBegan { agent, operation } if *agent == who => {
            format!("Your operation {} begins.", operation + 1)
        }
        Happening::OperationLate { agent, operation, expected } if *agent == who => {
            format!("Operation {} is now expected to end at {}.", operation + 1, written(*expected))
        }
        Happening::OperationEnded { agent, operation } if *agent == who => {
            format!("Your operation {} is finished.", operation + 1)
        }
        Happening::Left { robot, agent, .. } if *agent == who => {
            format!("{} has left its depot and comes to you.", m(robot))
        }
        Happening::Waits { robot, agent, .. } if *agent == who => format!("{} waits near you.", m(robot)),
        Happening::Approaches { robot, agent, .. } if *agent == who => format!("{} comes up to you.", m(robot)),
        Happening::Serves { robot, agent, .. } if *agent == who => format!("{} serves you.", m(robot)),
        Happening::Served { robot, agent, .. } if *agent == who => format!("{} has served you.", m(robot)),
        Happening::RobotLate { robot, agent, expected, .. } if *agent == who => {
            format!("{} is late: expected at {}.", m(robot), written(*expected))
        }
        Happening::HeldUp { robot, agent: Some(agent), by } if *agent == who => {
            format!("{} cannot come to you as long as {}, out of order, stands in its way.", m(robot), m(by))
        }
        Happening::BrokenOff { robot, agent, .. } if *agent == who => {
            format!("{} had to break off its service.", m(robot))
        }
        Happening::Told { event: Event::Moved { agent, place: [x, y] } } if *agent == who => {
            format!("Robots now come to you at ({x:.2}, {y:.2}) m.")
        }
        Happening::Told { event: Event::Said { agent, wait, approach, distance } } if *agent == who => {
            format!("You told: {}.", feedback(*wait, *approach, *distance))
        }
        Happening::Told { event: Event::Failed { agent } } if *agent == who => {
            "The service failed, and is done again.".into()
        }
        Happening::Told { event: Event::Late { agent, by } } if *agent == who => format!("It takes {by:.0} s longer."),
        Happening::Told { event: Event::Lost { who: Actor::Agent(agent) } } if *agent == who => {
            "You have left the mission.".into()
        }
        Happening::Told { event: Event::Back { who: Actor::Agent(agent) } } if *agent == who => "You are back.".into(),
        Happening::Told { event: Event::Lost { who: Actor::Robot(robot) } } => format!("{} has broken down.", m(robot)),
        Happening::Told { event: Event::Back { who: Actor::Robot(robot) } } => format!("{} works again.", m(robot)),
        Happening::Plan(PlanChange::Reallocated { .. }) => "The plan was made anew.".into(),
        Happening::Plan(PlanChange::Stranded { why }) => format!("There is no plan any more: {why}."),
        Happening::Done => "The mission is done.".into(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_as_on_a_clock() {
        let times = [0.0, 59.9, 60.0, 187.0, 3729.0, -0.5, -61.0].map(written);
        assert_eq!(times, ["0:00", "0:59", "1:00", "3:07", "1:02:09", "0:00", "-1:01"]);
        assert_eq!(written(f64::NAN), "0:00");
    }
}
