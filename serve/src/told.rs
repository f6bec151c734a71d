//! Reports from pages: small JSON objects, whose form is checked before anything else.

use serde::Deserialize;

/// Tolerance for equal times (s).
const SAME: f64 = 1e-6;

/// Report of a person. Operations count from 0, and are indices of tasks in a mission of layers; each report names its
/// operation, so that duplicated or late reports are recognised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum PersonTells {
    /// The operation begins.
    Begin {
        /// Number of the operation.
        operation: usize,
    },
    /// The operation is finished.
    Done {
        /// Number of the operation.
        operation: usize,
    },
    /// The service begins, and so does its measurement.
    Serve {
        /// Number of the operation.
        operation: usize,
    },
    /// The service is finished.
    Served {
        /// Number of the operation; an earlier one if its measurement is still running.
        operation: usize,
    },
    /// The service or the task failed, and is to be repeated.
    Failed {
        /// Number of the operation, or index of the task.
        operation: usize,
        /// Expected end (s) that the page showed: a duplicated report counts once.
        until: Option<f64>,
    },
    /// The operation, the service or the task takes longer.
    Longer {
        /// Number of the operation.
        operation: usize,
        /// New expected end (s). A duplicated report has no further effect.
        until: f64,
    },
    /// Feedback on a service, each from -2 to 2.
    Feedback {
        /// Number of the operation.
        operation: usize,
        /// The wait: too short to too long.
        wait: i8,
        /// The velocity: very fast to very slow.
        approach: i8,
        /// The waiting distance: very far to very close.
        distance: i8,
    },
}

/// Report of the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum SupervisorTells {
    /// Start the clock.
    Run {},
    /// Stop the clock.
    Stop {},
    /// Replan everything that has not begun.
    Replan {},
    /// A member is lost: exactly one of the two is given.
    Lost {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
    },
    /// A member is back: exactly one of the two is given.
    Back {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
    },
    /// The service of a robot, or the task of a robot or an agent, failed: exactly one of the two is given.
    Failed {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
        /// Expected end (s) that the page showed.
        until: Option<f64>,
    },
    /// The service of a robot, or the operation or task of a member, takes longer: exactly one of the two is given.
    Longer {
        /// Index of a robot.
        robot: Option<usize>,
        /// Index of an agent.
        agent: Option<usize>,
        /// New expected end (s).
        until: f64,
    },
    /// An agent is at another position.
    Moved {
        /// Index of the agent.
        agent: usize,
        /// New position (m).
        place: [f64; 2],
    },
    /// Create a new link for a person.
    Invite {
        /// Index of the agent.
        agent: usize,
    },
}

/// Returns the additional time (s) of an activity with this expected end and the new end `until`; `None` if it is not
/// longer.
pub fn longer(expected: Option<f64>, until: f64) -> Option<f64> {
    expected.map(|expected| until - expected).filter(|by| *by > SAME)
}

/// Returns true if the expected end that a page showed is still valid: no earlier report has changed it.
pub fn still(expected: Option<f64>, shown: Option<f64>) -> bool {
    shown.is_none_or(|shown| expected.is_some_and(|expected| (expected - shown).abs() <= SAME))
}

/// A report for the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tells {
    /// From the page of this agent.
    Person(usize, PersonTells),
    /// From the page of the supervisor; invitations are handled before.
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
