//! Log entries of a schedule as messages for one agent. Operations count from 1.

use crate::execution::PlanChange;
use crate::kind::pages::PersonMessage;
use crate::kind::pages::words::clock_time;
use crate::kinds::schedule::execution::{Event, LogEntry};
use crate::kinds::schedule::plan::Actor;
use crate::kinds::schedule::problem::Problem;

/// Returns an entry as a message for this agent; `None` if it does not concern the agent.
pub(super) fn for_one(problem: &Problem, who: usize, what: &LogEntry) -> Option<PersonMessage> {
    let robot = |index: &usize| problem.robot_label(*index).unwrap_or("?");
    let text = match what {
        LogEntry::OperationBegan { agent, operation } if *agent == who => {
            format!("Your operation {} begins.", operation + 1)
        }
        LogEntry::OperationLate { agent, operation, expected } if *agent == who => {
            let text = format!("Operation {} is now expected to end at {}.", operation + 1, clock_time(*expected));
            return Some(PersonMessage::latest("operation late", text));
        }
        LogEntry::OperationEnded { agent, operation } if *agent == who => {
            format!("Your operation {} is finished.", operation + 1)
        }
        LogEntry::Left { robot: m, agent, .. } if *agent == who => {
            format!("{} has left its depot and comes to you.", robot(m))
        }
        LogEntry::Waits { robot: m, agent, .. } if *agent == who => format!("{} waits near you.", robot(m)),
        LogEntry::Approaches { robot: m, agent, .. } if *agent == who => format!("{} approaches you.", robot(m)),
        LogEntry::Serves { robot: m, agent, .. } if *agent == who => format!("{} serves you.", robot(m)),
        LogEntry::Served { robot: m, agent, .. } if *agent == who => format!("{} has served you.", robot(m)),
        LogEntry::RobotLate { robot: m, agent, expected, .. } if *agent == who => {
            let text = format!("{} is late: expected at {}.", robot(m), clock_time(*expected));
            return Some(PersonMessage::latest("robot late", text));
        }
        LogEntry::HeldUp { robot: m, agent: Some(agent), by } if *agent == who => {
            let text = format!("{} cannot reach you: {} is out of order and blocks its way.", robot(m), robot(by));
            return Some(PersonMessage::latest("robot blocked", text));
        }
        LogEntry::BrokenOff { robot: m, agent, .. } if *agent == who => format!("{} aborted its service.", robot(m)),
        LogEntry::Handled { event: Event::Moved { agent, place: [x, y] } } if *agent == who => {
            format!("Robots now come to you at ({x:.2}, {y:.2}) m.")
        }
        LogEntry::Handled { event: Event::Said { agent, wait, approach, distance } } if *agent == who => {
            format!("Your feedback: {}.", feedback(*wait, *approach, *distance))
        }
        LogEntry::Handled { event: Event::Failed { agent } } if *agent == who => {
            "The service failed and is repeated.".into()
        }
        LogEntry::Handled { event: Event::Late { agent, by } } if *agent == who => {
            format!("It takes {by:.0} s longer.")
        }
        LogEntry::Handled { event: Event::Lost { who: Actor::Agent(agent) } } if *agent == who => {
            "You have left the mission.".into()
        }
        LogEntry::Handled { event: Event::Back { who: Actor::Agent(agent) } } if *agent == who => {
            "You are back.".into()
        }
        LogEntry::Handled { event: Event::Lost { who: Actor::Robot(m) } } => format!("{} has broken down.", robot(m)),
        LogEntry::Handled { event: Event::Back { who: Actor::Robot(m) } } => format!("{} works again.", robot(m)),
        LogEntry::Plan(PlanChange::Reallocated { .. }) => {
            return Some(PersonMessage::latest("plan", "There is a new plan."));
        }
        LogEntry::Plan(PlanChange::Stranded { why }) => {
            return Some(PersonMessage::latest("plan", format!("There is no plan any more: {why}.")));
        }
        LogEntry::Done => "The mission is done.".into(),
        _ => return None,
    };
    Some(PersonMessage::new(text))
}

/// Returns the words of thesis 5.7.1 for a feedback in steps from -2 to 2.
fn feedback(wait: i8, approach: i8, distance: i8) -> String {
    let word = |words: [&'static str; 5], step: i8| words[(step.clamp(-2, 2) + 2) as usize];
    let wait = word(["too short", "short", "OK", "long", "too long"], wait);
    let approach = word(["very fast", "fast", "OK", "slow", "very slow"], approach);
    let distance = word(["very far", "far", "OK", "close", "very close"], distance);
    format!("waiting time {wait}, velocity {approach}, waiting distance {distance}")
}
