//! Solving degenerate hierarchies: no answer without a proof.
#![no_main]

#[path = "../../solver/tests/common/judged.rs"]
mod judged;

libfuzzer_sys::fuzz_target!(|data: &[u8]| judged::check(data));
