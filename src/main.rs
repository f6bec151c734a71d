//! The `hierarq` command.

mod cli;
mod ticks;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
