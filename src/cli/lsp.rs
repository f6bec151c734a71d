//! `hierarq lsp`

use clap::Args;

use super::Outcome;

#[derive(Args)]
pub struct Arguments {
    /// Speak over standard input and output, which is what happens without it too.
    #[arg(long)]
    stdio: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let _ = a.stdio;
    let good = hierarq::lsp::serve().map_err(|e| format!("the editor cannot be understood: {e}"))?;
    Ok(Outcome::of(good))
}
