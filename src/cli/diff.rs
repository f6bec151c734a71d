//! `hierarq diff BEFORE AFTER`

use std::path::{Path, PathBuf};

use clap::Args;
use compiler::Compiled;
use hierarq::diff::{Differences, Form, render};
use hierarq::project;

use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    before: PathBuf,
    /// The spec or compiled program that it is compared with.
    after: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Print Markdown, for instance for a comment on a pull request.
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print the differences, or the diagnostics of a wrong spec, as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let mut both = Vec::new();
    for path in [&a.before, &a.after] {
        let compiled = project::load(path, &a.options.settings());
        if !compiled.is_good() {
            output::refuse(&compiled.report, path, a.json)?;
            return Err(format!("`{}` is not compared, because it does not compile", path.display()));
        }
        both.push(compiled);
    }
    let [before, after]: [Compiled; 2] = match both.try_into() {
        Ok(both) => both,
        Err(_) => return Err("two specs are compared".to_string()),
    };
    let is_program = |path: &Path| path.extension().is_some_and(|e| e == "json");
    let found = Differences::new(&before, &after, [is_program(&a.before), is_program(&a.after)]);
    let text = match a.json {
        true => serde_json::to_string_pretty(&found).map_err(|e| e.to_string())? + "\n",
        false => {
            let names = [&a.before, &a.after].map(|path| path.display().to_string());
            let form = if a.markdown { Form::Markdown } else { Form::Plain };
            format!("{}\n", render(&found, [&names[0], &names[1]], form).trim())
        }
    };
    output::data(&text);
    Ok(Outcome::of(found.is_empty()))
}
