//! `hierarq explain CODE`

use clap::Args;

use super::{Outcome, output};

/// Maximum width: longer lines are hard to read.
const WIDEST: usize = 100;

#[derive(Args)]
pub struct Arguments {
    /// Code such as HQ0301 [default: a list of all].
    code: Option<String>,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let Some(code) = &a.code else {
        let kind = |warning: bool| if warning { "  (warning)" } else { "" };
        let list: String =
            compiler::codes::all().map(|p| format!("{}  {}{}\n", p.code, p.title, kind(p.warning))).collect();
        output::print(&list);
        return Ok(Outcome::Good);
    };
    match compiler::codes::explain(code) {
        Some(page) => {
            output::print(&hierarq::catalogue::code_page(&page, output::width().min(WIDEST)));
            Ok(Outcome::Good)
        }
        None => {
            let codes = compiler::codes::all().map(|p| p.code);
            let near =
                compiler::names::suggest(code, codes).map(|n| format!("; did you mean {n}?")).unwrap_or_default();
            Err(format!("there is no code `{code}`{near} (`hierarq explain` lists all)"))
        }
    }
}
