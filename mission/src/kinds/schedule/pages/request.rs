//! Requests of people. Operations count from 0; each request names its operation, so that duplicated or late requests are
//! recognised.

use serde::Deserialize;

use crate::kind::pages::Refusal;
use crate::kind::{Detail, Event};

pub(super) use crate::kinds::schedule::event::feedback;

/// A request of a person.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PersonRequest {
    /// The operation begins.
    Begin { operation: usize },
    /// The operation is finished.
    Done { operation: usize },
    /// The service begins, and so does its measurement.
    Serve { operation: usize },
    /// The service is finished; that of an earlier operation if its measurement is still running.
    Served { operation: usize },
    /// The service failed, and is to be repeated.
    Failed {
        operation: usize,
        /// Expected end (s) that the page showed: a duplicated request counts once.
        until: Option<f64>,
    },
    /// The operation or the service takes longer.
    Longer {
        operation: usize,
        /// New expected end (s). A duplicated request has no further effect.
        until: f64,
    },
    /// Feedback on a service, each from -2 to 2.
    Feedback {
        operation: usize,
        /// The wait: too short to too long.
        wait: i8,
        /// The velocity: very fast to very slow.
        approach: i8,
        /// The waiting distance: very far to very close.
        distance: i8,
    },
}

impl PersonRequest {
    /// Checks the numbers, for an agent with so many operations.
    pub fn check(self, operations: usize) -> Result<(), Refusal> {
        let operation = match self {
            PersonRequest::Begin { operation }
            | PersonRequest::Done { operation }
            | PersonRequest::Serve { operation }
            | PersonRequest::Served { operation }
            | PersonRequest::Failed { operation, .. }
            | PersonRequest::Longer { operation, .. } => operation,
            PersonRequest::Feedback { operation, wait, approach, distance } => {
                if let Some(step) = [wait, approach, distance].into_iter().find(|step| !(-2..=2).contains(step)) {
                    return Err(Refusal::Invalid(format!("a step of feedback lies between -2 and 2, and is {step}")));
                }
                operation
            }
        };
        match operation < operations {
            true => Ok(()),
            false => Err(Refusal::Invalid(format!("there is no operation with number {operation}"))),
        }
    }
}

/// The event of a delay (s).
pub(super) fn late(member: usize, by: f64) -> Event {
    Event::of("late", member).and("by", Detail::Number(by))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_known_requests_are_read() {
        let good = r#"{"what":"feedback","operation":1,"wait":-2,"approach":0,"distance":1}"#;
        let is = PersonRequest::Feedback { operation: 1, wait: -2, approach: 0, distance: 1 };
        assert_eq!(serde_json::from_str::<PersonRequest>(good).expect("read"), is);
        for bad in [
            "",
            "{}",
            "[]",
            "null",
            r#"{"what":"done"}"#,
            r#"{"what":"done","operation":-1}"#,
            r#"{"what":"done","operation":1,"agent":2}"#,
            r#"{"what":"lost","member":0}"#,
            r#"{"what":"feedback","operation":1,"wait":300,"approach":0,"distance":1}"#,
            r#"{"what":"done","operation":1e99}"#,
            r#"{"what":"done","operation":1}{"#,
        ] {
            assert!(serde_json::from_str::<PersonRequest>(bad).is_err(), "{bad}");
        }
        let huge = PersonRequest::Done { operation: usize::MAX };
        assert!(huge.check(2).is_err() && is.check(2).is_ok());
        assert!(PersonRequest::Feedback { operation: 1, wait: 3, approach: 0, distance: 0 }.check(2).is_err());
    }
}
