//! Transcript of the exchanges with a model: one line of JSON each.
//!
//! A line is written when its exchange is over, so that a run that is interrupted leaves all earlier exchanges. A
//! transcript can be read again, and its answers replayed. Keys are never in it.

use std::io::{BufRead, Write};

use serde::{Deserialize, Serialize};

use crate::endpoint::{AskError, Chat, Message};

/// One question and its outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exchange {
    /// Number of the attempt at a valid answer, from 1.
    pub attempt: usize,
    /// Number of times that this question has been sent, from 1.
    pub trial: usize,
    /// The model that was asked.
    pub model: String,
    /// The conversation that was sent; for later attempts only the messages added since the attempt before.
    pub asked: Vec<Message>,
    /// The model's answer, or the reason why there is none.
    pub answered: Result<String, AskError>,
    /// Errors of a rejected answer; empty for an accepted one.
    pub refused: Vec<String>,
    /// Duration of the answer (s).
    pub seconds: f64,
}

/// Writes an exchange as one line and flushes it.
///
/// # Errors
///
/// If it cannot be written.
pub fn write(to: &mut dyn Write, exchange: &Exchange) -> std::io::Result<()> {
    let mut line = serde_json::to_string(exchange)?;
    line.push('\n');
    to.write_all(line.as_bytes())?;
    to.flush()
}

/// Reads the exchanges of a transcript. Skips empty lines.
///
/// # Errors
///
/// If the input cannot be read, or a line is no exchange: the message contains the number of the line.
pub fn read(from: impl BufRead) -> std::io::Result<Vec<Exchange>> {
    let mut exchanges = Vec::new();
    for (number, line) in from.lines().enumerate() {
        let line = line?;
        if line.trim().is_empty() {
            continue;
        }
        let exchange = serde_json::from_str(&line)
            .map_err(|error| std::io::Error::other(format!("line {} is no exchange: {error}", number + 1)))?;
        exchanges.push(exchange);
    }
    Ok(exchanges)
}

/// A model that replays recorded answers in their order, independent of the questions. [`AskError::RecordingEnds`]
/// follows the last answer; once [`Chat::begin`] was called, it also follows the last answer of each conversation.
#[derive(Clone, Debug)]
pub struct Replay {
    model: String,
    exchanges: std::iter::Peekable<std::vec::IntoIter<Exchange>>,
    seconds: Option<f64>,
    /// Conversations are separated: [`Chat::begin`] was called.
    apart: bool,
    /// No question of this conversation was asked yet.
    fresh: bool,
}

impl Exchange {
    /// Returns true if this exchange begins a conversation.
    fn is_first(&self) -> bool {
        self.attempt == 1 && self.trial == 1
    }
}

impl Replay {
    /// Creates a model that replays these exchanges.
    pub fn new(exchanges: Vec<Exchange>) -> Replay {
        let model = exchanges.first().map_or_else(String::new, |exchange| exchange.model.clone());
        Replay { model, exchanges: exchanges.into_iter().peekable(), seconds: None, apart: false, fresh: true }
    }
}

impl Chat for Replay {
    fn model(&self) -> &str {
        &self.model
    }

    fn ask(&mut self, _: &[Message]) -> Result<String, AskError> {
        let (apart, fresh) = (self.apart, self.fresh);
        self.fresh = false;
        let next = self.exchanges.next_if(|exchange| !apart || fresh || !exchange.is_first());
        self.seconds = next.as_ref().map(|exchange| exchange.seconds);
        next.map_or(Err(AskError::RecordingEnds), |exchange| exchange.answered)
    }

    fn begin(&mut self) {
        while self.exchanges.next_if(|exchange| !exchange.is_first()).is_some() {}
        (self.apart, self.fresh) = (true, true);
    }

    fn recorded_seconds(&self) -> Option<f64> {
        self.seconds
    }
}
