//! Log entries of a mission of layers as messages for one agent.

use crate::execution::PlanChange;
use crate::kind::pages::PersonMessage;
use crate::kind::pages::words::clock_time;
use crate::kinds::layers::execution::{Event, LogEntry};
use crate::kinds::layers::problem::Problem;

/// Returns an entry as a message for this agent; `None` if it does not concern the agent.
pub(super) fn for_one(problem: &Problem, who: usize, what: &LogEntry) -> Option<PersonMessage> {
    let of = |task: &usize| problem.task_label(*task).unwrap_or("A task");
    let name = |agent: &usize| problem.agent_label(*agent).unwrap_or("?");
    let text = match what {
        LogEntry::Begun { agent, task, .. } if *agent == who => format!("{} begins.", of(task)),
        LogEntry::Ended { agent, task } if *agent == who => format!("{} is done.", of(task)),
        LogEntry::Dropped { agent, task } if *agent == who => format!("{} is to be repeated.", of(task)),
        LogEntry::TaskLate { agent, task, expected } if *agent == who => {
            let text = format!("{} is now expected to be done at {}.", of(task), clock_time(*expected));
            return Some(PersonMessage::latest("task late", text));
        }
        LogEntry::Handled { event: Event::Late { agent, by } } if *agent == who => {
            format!("It takes {by:.0} s longer.")
        }
        LogEntry::Handled { event: Event::Failed { agent } } if *agent == who => "It failed.".into(),
        LogEntry::LayerDone { layer } => {
            format!("Layer {} is done.", problem.layer_label(*layer).unwrap_or_default())
        }
        LogEntry::Handled { event: Event::Lost { agent } } if *agent == who => "You have left the mission.".into(),
        LogEntry::Handled { event: Event::Back { agent } } if *agent == who => "You are back.".into(),
        LogEntry::Handled { event: Event::Lost { agent } } => format!("{} has left.", name(agent)),
        LogEntry::Handled { event: Event::Back { agent } } => format!("{} is back.", name(agent)),
        LogEntry::Plan(PlanChange::Reallocated { .. }) => {
            return Some(PersonMessage::latest("plan", "There is a new plan."));
        }
        LogEntry::Plan(PlanChange::Stranded { why }) => {
            return Some(PersonMessage::latest("plan", format!("There is no plan for everything any more: {why}.")));
        }
        LogEntry::Done => "The mission is done.".into(),
        _ => return None,
    };
    Some(PersonMessage::new(text))
}
