//! Compiling any text, as a spec beside the examples, and the first ticks of what comes out.
#![no_main]

#[path = "../../compiler/tests/common/invariants.rs"]
mod invariants;

use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let syntax = if text.starts_with("hierarq:") { dsl::Syntax::Yaml } else { dsl::Syntax::Native };
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    invariants::checks(text, syntax, &examples);
});
