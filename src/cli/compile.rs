//! `hierarq compile SPEC`

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hierarq::project;
use runtime::program::CompiledFile;

use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`) to print.
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Format: text, or JSON that `hierarq run` can run without the spec.
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

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, a.json);
    }
    if !a.json {
        output::show(&compiled.report);
    }
    let (program, missions) = (compiled.program.as_ref(), compiled.missions.as_slice());
    let text = match a.format {
        Format::Text => {
            let program = program.and_then(runtime::text::text);
            let all: Vec<String> = program.into_iter().chain(missions.iter().map(runtime::text::mission)).collect();
            all.join("\n")
        }
        Format::Json => {
            let name = a.spec.file_stem().map_or_else(|| "spec".into(), |s| s.to_string_lossy());
            let text = CompiledFile::to_json_with(&name, program, missions, program.map(runtime::stopping::of_stacks));
            text.map_err(|e| format!("the program cannot be written as JSON: {e}"))?
        }
    };
    output::data(&text);
    Ok(Outcome::Good)
}
