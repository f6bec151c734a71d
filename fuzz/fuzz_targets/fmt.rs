//! Printing what was read, in both syntaxes, and reading it again.
#![no_main]

#[path = "../../compiler/tests/common/invariants.rs"]
mod invariants;

libfuzzer_sys::fuzz_target!(|text: &str| {
    invariants::formats(text, dsl::Syntax::Native);
    invariants::formats(text, dsl::Syntax::Yaml);
});
