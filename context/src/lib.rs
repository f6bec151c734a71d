//! The context generator: layered task plans from a language model, thesis 6.3.1.
//!
//! A model is asked over HTTP for the layers of a mission ([`prompt`], [`endpoint`]); what it answers is judged by the
//! same checks as layers that a person wrote, and where they refuse, the refusals go back to it ([`generate`], [`layers`]), a bounded
//! number of times. Everything that was said is kept ([`transcript`]). The model is outside: this crate talks to any server
//! with the interface of OpenAI's chat completions, and nothing of it is needed to plan with layers that are there.

pub mod answer;
pub mod endpoint;
pub mod generate;
pub mod layers;
pub mod prompt;
mod rules;
pub mod transcript;
