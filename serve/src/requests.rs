//! Requests of the supervisor that the server itself handles; all others are passed to the mission.

use mission::kind::pages::{Refusal, parse};
use serde::Deserialize;
use serde_json::Value;

/// A request of the supervisor.
#[derive(Clone, Debug, PartialEq)]
pub enum SupervisorRequest {
    /// One that the server handles.
    Server(ServerRequest),
    /// One for the mission.
    Mission(Value),
}

/// A request that the server handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum ServerRequest {
    /// Start the clock.
    Run {},
    /// Stop the clock.
    Stop {},
    /// Create a new link for a person.
    Invite {
        /// Number of the member.
        member: usize,
    },
}

impl SupervisorRequest {
    /// Reads a request from its JSON.
    ///
    /// # Errors
    ///
    /// It is for the server, and has another form.
    pub fn read(body: Value) -> Result<SupervisorRequest, Refusal> {
        match body.get("what").and_then(Value::as_str) {
            Some("run" | "stop" | "invite") => parse(&body).map(SupervisorRequest::Server),
            _ => Ok(SupervisorRequest::Mission(body)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_known_requests_are_read() {
        let run = SupervisorRequest::Server(ServerRequest::Run {});
        assert_eq!(SupervisorRequest::read(json!({ "what": "run" })), Ok(run));
        assert!(SupervisorRequest::read(json!({ "what": "run", "x": 1 })).is_err());
        assert!(SupervisorRequest::read(json!({ "what": "invite" })).is_err());
        assert!(SupervisorRequest::read(json!({ "what": "invite", "member": -1 })).is_err());
        let lost = json!({ "what": "lost", "member": 0 });
        assert_eq!(SupervisorRequest::read(lost.clone()), Ok(SupervisorRequest::Mission(lost)));
    }
}
