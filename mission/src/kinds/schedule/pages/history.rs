//! Data of a person's page that come from the log: measured durations, and services without feedback.

use crate::kind::pages::{Answer, Form, Measured, Question};
use crate::kinds::schedule::execution::{Event, LogEntry, Record};
use crate::kinds::schedule::plan::Actor;
use crate::kinds::schedule::problem::{AgentKind, Problem};

use serde_json::json;

/// A measurement.
#[derive(Clone, Copy, Debug)]
struct Measurement {
    operation: usize,
    /// Start (s).
    since: f64,
    /// Duration (s), if it has ended.
    took: Option<f64>,
}

/// The last service of an agent.
#[derive(Clone, Copy, Debug)]
struct LastService {
    operation: usize,
    robot: usize,
    /// True if the person has given feedback.
    answered: bool,
}

/// The history of one agent.
#[derive(Clone, Debug)]
pub(super) struct History {
    /// Current or last operation.
    operation: Option<Measurement>,
    /// Current or last measurement of a service by the person.
    service: Option<Measurement>,
    last: Option<LastService>,
    human: bool,
}

impl History {
    /// Creates an empty history.
    pub fn new(kind: AgentKind) -> History {
        History { operation: None, service: None, last: None, human: kind == AgentKind::Human }
    }

    /// Returns true during the measurement of a service.
    pub fn measures(&self) -> bool {
        self.measured_operation().is_some()
    }

    /// Returns the operation whose service is being measured.
    pub fn measured_operation(&self) -> Option<usize> {
        self.service.filter(|of| of.took.is_none()).map(|of| of.operation)
    }

    /// Starts the measurement of an operation's service.
    pub fn begin_measurement(&mut self, operation: usize, time: f64) {
        self.service = Some(Measurement { operation, since: time, took: None });
    }

    /// Ends the measurement; returns its duration (s), or `None` if none was running.
    pub fn end_measurement(&mut self, time: f64) -> Option<f64> {
        let of = self.service.as_mut().filter(|of| of.took.is_none())?;
        of.took = Some(time - of.since);
        of.took
    }

    /// Returns the last measurements.
    pub fn measured(&self) -> Vec<Measured> {
        let of = |word: &str, at: Option<Measurement>| {
            at.map(|at| Measured { name: format!("{word} {}", at.operation + 1), seconds: at.took })
        };
        of("Operation", self.operation).into_iter().chain(of("Service", self.service)).collect()
    }

    /// Returns the operation that was served last, and whether the person has given feedback.
    pub fn feedback_on(&self) -> Option<(usize, bool)> {
        self.last.map(|last| (last.operation, last.answered))
    }

    /// Returns the questions about the last service, if the person has not given feedback. Their words and order are those
    /// of thesis 5.7.1; each step is half a unit from -1 to 1.
    pub fn form(&self, problem: &Problem) -> Option<Form> {
        let LastService { operation, robot, .. } = self.last.filter(|last| self.human && !last.answered)?;
        let question = |key, text, answers: [&'static str; 5]| Question {
            key,
            text,
            answers: answers.into_iter().zip(-2..).map(|(text, value)| Answer { text, value }).collect(),
        };
        let robot = problem.robot_label(robot).unwrap_or("A robot");
        Some(Form {
            key: operation.to_string(),
            heading: "Feedback",
            text: format!("{robot} served operation {}. Your answers change the next service:", operation + 1),
            questions: vec![
                question("wait", "The waiting time was", ["Too short", "Short", "OK", "Long", "Too long"]),
                question("approach", "The robot came", ["Very fast", "Fast", "OK", "Slow", "Very slow"]),
                question("distance", "It waited", ["Very far", "Far", "OK", "Close", "Very close"]),
            ],
            request: json!({ "what": "feedback", "operation": operation }),
        })
    }
}

/// Adds a record to the histories of the agents.
pub(super) fn observe(histories: &mut [History], record: &Record) {
    let mut change = |agent: usize, change: &dyn Fn(&mut History)| {
        if let Some(history) = histories.get_mut(agent) {
            change(history);
        }
    };
    match &record.what {
        LogEntry::OperationBegan { agent, operation } => change(*agent, &|history| {
            history.operation = Some(Measurement { operation: *operation, since: record.time, took: None });
        }),
        LogEntry::OperationEnded { agent, .. } => change(*agent, &|history| {
            if let Some(of) = &mut history.operation {
                of.took = Some(record.time - of.since);
            }
        }),
        LogEntry::Served { robot, agent, operation } => change(*agent, &|history| {
            history.last = Some(LastService { operation: *operation, robot: *robot, answered: false });
        }),
        // After it comes back, an agent repeats its current operation.
        LogEntry::Handled { event: Event::Lost { who: Actor::Agent(agent) } } => change(*agent, &|history| {
            history.operation = history.operation.filter(|of| of.took.is_some());
            history.service = history.service.filter(|of| of.took.is_some());
        }),
        LogEntry::Handled { event: Event::Said { agent, .. } } => change(*agent, &answer),
        LogEntry::Handled { event: Event::Feedback(said) } => change(said.agent, &answer),
        _ => {}
    }
}

fn answer(history: &mut History) {
    if let Some(last) = &mut history.last {
        last.answered = true;
    }
}
