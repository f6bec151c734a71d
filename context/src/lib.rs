//! The context generator: tasks of a mission from a language model, thesis 6.3.1.
//!
//! The crate asks a model over HTTP for the tasks of a mission ([`endpoint`]). The kind of mission writes the prompt, and its
//! checks judge the answers; their errors go back to the model ([`generate`]), a bounded number of times. Every exchange is
//! recorded ([`transcript`]). The model is external: this crate talks to any server with the interface of OpenAI's chat
//! completions. Planning with existing tasks does not need this crate.

pub mod answer;
pub mod endpoint;
pub mod generate;
pub mod transcript;
