//! Asks a model until its answer passes the checks: errors go back to the model, a bounded number of times.
//!
//! A rejected answer stays in the conversation, followed by all its errors, in the words that the compiler has for
//! people. A question without an answer is sent again after a pause that doubles each time. If the server asks for a
//! longer pause, it gets it, up to a limit. When the attempts are used up, the last errors are returned.
//!
//! The kind of mission writes the prompt, and reads answers.

use std::time::{Duration, Instant};

use mission::kind::generation::{Decides, Generated, Generation, Prompt};

use crate::answer;
use crate::endpoint::{AskError, Chat, Message, Speaker};
use crate::transcript::Exchange;

/// Limits on attempts and pauses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Maximum number of answers that are judged, at least 1.
    pub attempts: usize,
    /// Maximum number of times that one question is sent if the server does not answer, at least 1.
    pub trials: usize,
    /// First pause before a question is sent again; it doubles each time.
    pub pause: Duration,
    /// Maximum length of a pause.
    pub longest_pause: Duration,
}

impl Default for Bounds {
    fn default() -> Bounds {
        Bounds { attempts: 5, trials: 4, pause: Duration::from_secs(1), longest_pause: Duration::from_secs(60) }
    }
}

/// Reason why no valid answer was generated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// The server does not answer, or not with a chat completion.
    #[error("{0}")]
    Server(AskError),
    /// All answers were rejected.
    #[error("none of {attempts} answers can be used")]
    Refused {
        /// Number of answers that were judged.
        attempts: usize,
        /// Errors of the last answer.
        reasons: Vec<String>,
    },
    /// The transcript cannot be written.
    #[error("the transcript cannot be written: {0}")]
    Transcript(String),
}

const NO_OBJECT: &str = "the answer holds no JSON object; answer with one object and nothing else";

/// Wish for the tasks of a mission.
#[derive(Clone, Copy)]
pub struct Wish<'w> {
    /// The mission.
    pub mission: &'w dyn Generation,
    /// The person's instruction.
    pub instruction: &'w str,
    /// Decisions that are left to the model.
    pub decides: Decides,
}

/// Returns the first messages of the conversation.
pub fn prompt(wish: &Wish<'_>) -> [Message; 2] {
    let Prompt { system, user } = wish.mission.prompt(wish.decides, wish.instruction);
    [Message::new(Speaker::System, system), Message::new(Speaker::User, user)]
}

/// Asks the model for the tasks of a mission until the mission accepts an answer. Passes each exchange to `keep`.
///
/// # Errors
///
/// As [`generate`].
pub fn tasks(
    chat: &mut dyn Chat,
    wish: &Wish<'_>,
    bounds: &Bounds,
    keep: impl FnMut(&Exchange) -> std::io::Result<()>,
) -> Result<Generated, GenerateError> {
    let question = Question { prompt: &prompt(wish), keys: wish.mission.answer_keys() };
    generate(chat, &question, bounds, |text| wish.mission.read(text, wish.decides), keep)
}

/// A question that is answered by a JSON object.
#[derive(Clone, Copy, Debug)]
pub struct Question<'q> {
    /// The first messages of the conversation.
    pub prompt: &'q [Message],
    /// Keys of the answer, the best first.
    pub keys: &'q [&'q str],
}

/// Asks the model until `judge` accepts an answer, and returns what `judge` made of it.
///
/// `judge` gets the JSON text, padded so that its lines and columns are those of the whole answer. It returns the
/// result or all errors. Each exchange is passed to `keep` when it is over.
///
/// # Errors
///
/// If the server does not answer, no answer is accepted within `bounds`, or `keep` fails.
pub fn generate<T>(
    chat: &mut dyn Chat,
    question: &Question<'_>,
    bounds: &Bounds,
    mut judge: impl FnMut(&str) -> Result<T, Vec<String>>,
    mut keep: impl FnMut(&Exchange) -> std::io::Result<()>,
) -> Result<T, GenerateError> {
    let mut conversation = question.prompt.to_vec();
    let mut told = 0;
    let mut reasons = Vec::new();
    let attempts = bounds.attempts.max(1);
    for attempt in 1..=attempts {
        let mut trial = 1;
        let (text, mut exchange) = loop {
            let begun = Instant::now();
            let answered = chat.ask(&conversation);
            let exchange = Exchange {
                attempt,
                trial,
                model: chat.model().to_string(),
                asked: conversation[told..].to_vec(),
                answered,
                refused: Vec::new(),
                seconds: chat.recorded_seconds().unwrap_or_else(|| begun.elapsed().as_secs_f64()),
            };
            let error = match &exchange.answered {
                Ok(text) => break (text.clone(), exchange),
                // An answer that was cut off counts as an answer: the model gets the reason and may try again.
                Err(AskError::Unfinished(_)) => break ("(not finished)".to_string(), exchange),
                Err(error) => error.clone(),
            };
            keep(&exchange).map_err(|error| GenerateError::Transcript(error.to_string()))?;
            if !error.passes() || trial >= bounds.trials.max(1) {
                return Err(GenerateError::Server(error));
            }
            std::thread::sleep(pause(bounds, trial, &error));
            trial += 1;
        };
        let part = answer::part(&text, question.keys);
        let judged = match (&exchange.answered, part) {
            (Err(error), _) => Err(vec![format!("{error}; answer more briefly")]),
            (Ok(_), Some(part)) => judge(&part.in_place()),
            (Ok(_), None) => Err(vec![NO_OBJECT.to_string()]),
        };
        match judged {
            Ok(good) => {
                keep(&exchange).map_err(|error| GenerateError::Transcript(error.to_string()))?;
                return Ok(good);
            }
            Err(refusals) => {
                exchange.refused = refusals;
                keep(&exchange).map_err(|error| GenerateError::Transcript(error.to_string()))?;
                told = conversation.len();
                let lines = part.and_then(|part| part.lines());
                conversation.push(Message::new(Speaker::Assistant, &text));
                conversation.push(Message::new(Speaker::User, refusal(&exchange.refused, lines)));
                reasons = exchange.refused;
            }
        }
    }
    Err(GenerateError::Refused { attempts, reasons })
}

/// Composes the message for the model after a rejected answer. `lines` are the lines that were read, if not all of it
/// was.
fn refusal(reasons: &[String], lines: Option<(usize, usize)>) -> String {
    let mut text = match lines {
        Some((from, to)) => format!("What you wrote in lines {from} to {to}, which was read, cannot be used:\n"),
        None => String::from("This cannot be used:\n"),
    };
    for reason in reasons {
        text.push_str("- ");
        text.push_str(reason);
        text.push('\n');
    }
    text.push_str("Answer again with the whole corrected JSON object and nothing else.");
    text
}

fn pause(bounds: &Bounds, trial: usize, error: &AskError) -> Duration {
    let doubled = bounds.pause.saturating_mul(1 << (trial - 1).min(16));
    let asked = match error {
        AskError::Busy { wait: Some(seconds) } => Duration::try_from_secs_f64(*seconds).unwrap_or(Duration::MAX),
        _ => Duration::ZERO,
    };
    doubled.max(asked).min(bounds.longest_pause)
}
