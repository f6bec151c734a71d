//! Reading any text as a `*.hq` file.
#![no_main]

#[path = "../../compiler/tests/common/invariants.rs"]
mod invariants;

libfuzzer_sys::fuzz_target!(|text: &str| invariants::reads(text, dsl::Syntax::Native));
