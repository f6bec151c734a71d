//! Descriptions of the language for people and editors: the language server, the catalogue of task types, the page of
//! keys, and the JSON Schema of the YAML syntax.

pub mod catalogue;
pub mod keys;
#[cfg(feature = "lsp")]
pub mod lsp;
pub mod schema;
