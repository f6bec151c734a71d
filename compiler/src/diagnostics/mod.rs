//! Diagnostics of the compiler: codes with their pages, wording for each syntax, and the report as text and as JSON.

pub(crate) mod allowances;
pub(crate) mod cascading_errors;
pub mod codes;
pub(crate) mod examples;
pub(crate) mod other_frameworks;
pub(crate) mod refused;
pub mod report;
mod window;
