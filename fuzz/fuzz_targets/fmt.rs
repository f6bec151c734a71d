//! Printing what was read, in both spellings, and reading it again.
#![no_main]

#[path = "../../compiler/tests/common/invariants.rs"]
mod invariants;

libfuzzer_sys::fuzz_target!(|text: &str| {
    invariants::formats(text, dsl::Spelling::Hq);
    invariants::formats(text, dsl::Spelling::Yaml);
});
