//! Tasks of a mission from a language model: the kind writes the prompt, and reads the answer.

use super::Mission;
use crate::planned::Planned;

/// Decisions that are left to a model, each with those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Decides {
    /// The tasks and their order; everything else is optimised.
    Tasks,
    /// Also who does each task, with which object; speeds and times are optimised.
    Allocation,
    /// The whole plan.
    Everything,
}

/// The first messages of a conversation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prompt {
    /// Instructions for the whole conversation.
    pub system: String,
    /// The question.
    pub user: String,
}

/// A valid answer of a model.
#[derive(Debug)]
pub struct Generated {
    /// The mission with the tasks of the answer.
    pub mission: Box<dyn Mission>,
    /// The answer as a file.
    pub text: String,
    /// The plan, if the model decided everything.
    pub planned: Option<Planned>,
}

/// A mission whose tasks a language model may write.
pub trait Generation {
    /// Word for what the model writes, `layers`.
    fn noun(&self) -> &'static str;

    /// Key of the mission that names a file with an answer.
    fn key(&self) -> &'static str;

    /// Keys of the JSON object that is the answer, the best first. They tell the answer from other objects in a text.
    fn answer_keys(&self) -> &'static [&'static str];

    /// Version of the wording of prompts: answers to different wordings are not comparable.
    fn version(&self) -> u32;

    /// The instruction of the mission, if it has one.
    fn instruction(&self) -> Option<&str>;

    /// The prompt for an instruction.
    fn prompt(&self, decides: Decides, instruction: &str) -> Prompt;

    /// Reads an answer: a JSON object.
    ///
    /// # Errors
    /// Every mistake in it, with its line and column, in the words that people are told.
    fn read(&self, answer: &str, decides: Decides) -> Result<Generated, Vec<String>>;
}
