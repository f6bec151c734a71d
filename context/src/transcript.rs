//! What was said, kept: one line of JSON for each exchange.
//!
//! A line is written when its exchange is over, so that a run that is cut leaves all that was said before. A transcript
//! can be read again, and its answers replayed. Keys are never in it.

use std::io::{BufRead, Write};

use serde::{Deserialize, Serialize};

use crate::endpoint::{AskError, Chat, Message};

/// One question and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exchange {
    /// Which attempt at an answer that holds, from 1.
    pub attempt: usize,
    /// Which try of the same question, from 1.
    pub trial: usize,
    /// The model that was asked.
    pub model: String,
    /// The conversation that was sent; of later attempts what was added to that of the attempt before.
    pub asked: Vec<Message>,
    /// What the model said, or why it said nothing.
    pub answered: Result<String, AskError>,
    /// Why it was refused; empty for an answer that was taken.
    pub refused: Vec<String>,
    /// How long the answer took (s).
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

/// The exchanges of a transcript. Empty lines are passed over.
///
/// # Errors
///
/// If it cannot be read, or a line is no exchange: the message names the line.
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

/// Answers as they were recorded, one after the other, whatever is asked. After the last there is none, and after
/// [`Chat::begin`] none of another conversation.
#[derive(Clone, Debug)]
pub struct Replay {
    model: String,
    exchanges: std::iter::Peekable<std::vec::IntoIter<Exchange>>,
    seconds: Option<f64>,
    /// Conversations are told apart.
    apart: bool,
    /// Nothing of this conversation has been asked.
    fresh: bool,
}

impl Exchange {
    /// It begins a conversation.
    fn is_first(&self) -> bool {
        self.attempt == 1 && self.trial == 1
    }
}

impl Replay {
    /// The answers of these exchanges.
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
