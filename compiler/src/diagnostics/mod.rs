//! What the compiler says: codes and their pages, "did you mean", the wording for each spelling, the report as text and as JSON.

pub mod codes;
pub(crate) mod follow_ons;
pub(crate) mod refused;
pub mod report;
mod snippets;
mod window;
pub(crate) mod yaml_wording;
