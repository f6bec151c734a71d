//! The functions of the header, as C and C++ see them.

#[path = "common/spec.rs"]
mod spec;

mod cpp;
mod functions;
mod header;
