//! What pages tell the server, as it comes in: small JSON objects whose form is checked before anything else.

use serde::Deserialize;

/// Times that differ by less are the same (s).
const SAME: f64 = 1e-6;

/// What a person tells. Operations count from 0, and of layers are indices of tasks; each press names its own, so that one that comes twice or late is
/// recognised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum PersonTells {
    /// The operation begins.
    Begin {
        /// Which.
        operation: usize,
    },
    /// The operation is finished.
    Done {
        /// Which.
        operation: usize,
    },
    /// The service begins: from now on it is measured.
    Serve {
        /// Of which operation.
        operation: usize,
    },
    /// The service is finished.
    Served {
        /// Of which operation; of an earlier one where the measurement still ran.
        operation: usize,
    },
    /// The service or the task failed, and is to be done again.
    Failed {
        /// Of which operation, or which task.
        operation: usize,
        /// When it was expected to end (s), as the page showed it: what is told twice counts once.
        until: Option<f64>,
    },
    /// The operation, the service or the task takes longer.
    Longer {
        /// Which.
        operation: usize,
        /// Until when (s). Told twice it comes to the same.
        until: f64,
    },
    /// What the service was like, each from -2 to 2.
    Feedback {
        /// Of which operation.
        operation: usize,
        /// The wait: too short to too long.
        wait: i8,
        /// The velocity: very fast to very slow.
        approach: i8,
        /// The waiting distance: very far to very close.
        distance: i8,
    },
}

/// What the supervisor tells.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum SupervisorTells {
    /// The clock runs.
    Run {},
    /// The clock stands.
    Stop {},
    /// What has not begun is planned anew.
    Replan {},
    /// Somebody is lost: exactly one of the two is given.
    Lost {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
    },
    /// Somebody is back: exactly one of the two is given.
    Back {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
    },
    /// The service that a robot gives, or the task of a robot or an agent, failed: exactly one of the two is given.
    Failed {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
        /// When it was expected to end (s), as the page showed it.
        until: Option<f64>,
    },
    /// The service that a robot gives, or the operation or task of somebody, takes longer: exactly one of the two is given.
    Longer {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
        /// Until when (s).
        until: f64,
    },
    /// An agent is at another place.
    Moved {
        /// Which.
        agent: usize,
        /// Where (m).
        place: [f64; 2],
    },
    /// A person needs a new link.
    Invite {
        /// Which.
        agent: usize,
    },
}

/// By how much longer (s) something takes that was expected to end at a time, and is to end at `until`; none where it is no
/// longer.
pub fn longer(expected: Option<f64>, until: f64) -> Option<f64> {
    expected.map(|expected| until - expected).filter(|by| *by > SAME)
}

/// Whether what a page showed as expected still is: nothing that was told before has changed it.
pub fn still(expected: Option<f64>, shown: Option<f64>) -> bool {
    shown.is_none_or(|shown| expected.is_some_and(|expected| (expected - shown).abs() <= SAME))
}

/// What goes to the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tells {
    /// From the page of this agent.
    Person(usize, PersonTells),
    /// From the page of the supervisor; an invitation does not get here.
    Supervisor(SupervisorTells),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_known_is_read() {
        let good = r#"{"what":"feedback","operation":1,"wait":-2,"approach":0,"distance":1}"#;
        let is = PersonTells::Feedback { operation: 1, wait: -2, approach: 0, distance: 1 };
        assert_eq!(serde_json::from_str::<PersonTells>(good).expect("read"), is);
        for bad in [
            "",
            "{}",
            "[]",
            "null",
            r#"{"what":"done"}"#,
            r#"{"what":"done","operation":-1}"#,
            r#"{"what":"done","operation":1,"agent":2}"#,
            r#"{"what":"lost","robot":0}"#,
            r#"{"what":"feedback","operation":1,"wait":300,"approach":0,"distance":1}"#,
            r#"{"what":"done","operation":1e99}"#,
            r#"{"what":"done","operation":1}{"#,
        ] {
            assert!(serde_json::from_str::<PersonTells>(bad).is_err(), "{bad}");
        }
        assert_eq!(
            serde_json::from_str::<SupervisorTells>(r#"{"what":"run"}"#).expect("read"),
            SupervisorTells::Run {}
        );
        assert!(serde_json::from_str::<SupervisorTells>(r#"{"what":"run","x":1}"#).is_err());
        assert!(serde_json::from_str::<SupervisorTells>(r#"{"what":"moved","agent":0,"place":[1,null]}"#).is_err());
        assert!(serde_json::from_str::<SupervisorTells>(r#"{"what":"moved","agent":0,"place":[1,2,3]}"#).is_err());
    }
}
