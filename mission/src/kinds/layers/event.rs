//! Events of a mission of layers by the words of the language, as events of its execution.

use crate::kind::Event as Named;
use crate::numbers::MAX_NUMBER;

use super::execution::Event;
use super::problem::Problem;
use super::words::of_event;

/// The event of the execution.
pub(super) fn typed(problem: &Problem, of: &Named) -> Result<Event, String> {
    let name = of.event.as_str();
    if name == "replan" {
        return Ok(Event::Replan);
    }
    let agent = of.member.filter(|member| *member < problem.agents.len());
    let agent = agent.ok_or_else(|| format!("`{name}` names a member that does not exist"))?;
    Ok(match name {
        "begun" => Event::Begun { agent },
        "done" => Event::Done { agent },
        "late" => {
            let by = of.number("by").filter(|by| by.abs() <= MAX_NUMBER);
            Event::Late { agent, by: by.ok_or("`late` needs `by`")? }
        }
        "failed" => Event::Failed { agent },
        "lost" => Event::Lost { agent },
        "back" => Event::Back { agent },
        other => return Err(format!("a mission of layers has no event `{other}`")),
    })
}

/// The words for an event.
pub(super) fn describe(problem: &Problem, of: &Named) -> String {
    typed(problem, of).map_or_else(|_| of.event.clone(), |event| of_event(&event, problem))
}
