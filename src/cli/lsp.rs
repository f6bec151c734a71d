//! `hierarq lsp`

use clap::Args;

use super::Outcome;

#[derive(Args)]
pub struct Arguments {
    /// Communicate over standard input and output; always the case, accepted for editors that pass it.
    #[arg(long)]
    stdio: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let _ = a.stdio;
    let good = hierarq::lsp::serve().map_err(|e| format!("invalid message from the editor: {e}"))?;
    Ok(Outcome::of(good))
}
