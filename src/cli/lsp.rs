//! `hierarq lsp`

use clap::Args;

use super::Outcome;

#[derive(Args)]
pub struct Arguments {
    /// Speak over standard input and output, which is what happens without it too.
    #[arg(long)]
    stdio: bool,
}

pub fn run(a: &Arguments) -> Outcome {
    let _ = a.stdio;
    match hierarq::lsp::serve() {
        Ok(true) => Outcome::Good,
        Ok(false) => Outcome::Failed,
        Err(e) => Outcome::Trouble(format!("the editor cannot be understood: {e}")),
    }
}
