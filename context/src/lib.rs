//! The context generator: layered task plans from a language model, thesis 6.3.1.
//!
//! The crate asks a model over HTTP for the layers of a mission ([`prompt`], [`endpoint`]). The same checks as for
//! hand-written layers judge the answers; their errors go back to the model ([`generate`], [`layers`]), a bounded
//! number of times. Every exchange is recorded ([`transcript`]). The model is external: this crate talks to any server
//! with the interface of OpenAI's chat completions. Planning with existing layers does not need this crate.

pub mod answer;
pub mod endpoint;
pub mod generate;
pub mod layers;
pub mod prompt;
mod rules;
pub mod transcript;
