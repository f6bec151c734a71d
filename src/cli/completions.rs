//! `hierarq completions SHELL`

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let mut script = Vec::new();
    clap_complete::generate(a.shell, &mut Cli::command(), "hierarq", &mut script);
    output::data(&String::from_utf8_lossy(&script));
    Ok(Outcome::Good)
}
