//! `hierarq explain CODE`

use clap::Args;

use super::{Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// A code such as HQ0301; all codes are listed where it is left out.
    code: Option<String>,
}

pub fn run(a: &Arguments) -> Outcome {
    let Some(code) = &a.code else {
        let list: String = compiler::codes::all().map(|c| format!("{}  {}\n", c.0, c.1)).collect();
        output::print(&list);
        return Outcome::Good;
    };
    match compiler::codes::explain(code) {
        Some((title, text)) => {
            output::print(&format!("{}: {title}\n\n{text}\n", code.to_uppercase()));
            Outcome::Good
        }
        None => {
            let codes = compiler::codes::all().map(|c| c.0);
            let near =
                compiler::names::suggest(code, codes).map(|n| format!("; did you mean {n}?")).unwrap_or_default();
            Outcome::Trouble(format!("there is no code `{code}`{near} (`hierarq explain` lists all)"))
        }
    }
}
