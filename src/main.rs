//! The `hierarq` command.
fn main() {}
