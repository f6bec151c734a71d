//! `hierarq compile SPEC`

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hierarq::project;

use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`) to look at.
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Text for people, or data that `hierarq run` can run without the spec.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Print diagnostics as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Format {
    Text,
    Json,
}

pub fn run(a: &Arguments) -> Outcome {
    let compiled = project::load(&a.spec, &a.options.settings());
    let Some(program) = compiled.program else { return output::refuse(&compiled.report, a.json) };
    if !a.json {
        output::show(&compiled.report);
    }
    let text = match a.format {
        Format::Text => runtime::text::text(&program).unwrap_or_default(),
        Format::Json => match serde_json::to_string_pretty(&program) {
            Ok(text) => text + "\n",
            Err(e) => return Outcome::Trouble(format!("the program cannot be written as JSON: {e}")),
        },
    };
    output::print(&text);
    Outcome::Good
}
