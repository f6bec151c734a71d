//! `hierarq man [COMMAND]`

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use super::{Cli, Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// Command, such as `run` [default: the page of the whole program].
    command: Option<String>,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let mut all = Cli::command().disable_help_subcommand(true);
    all.build();
    let command = match &a.command {
        None => all,
        Some(name) => {
            let names = all.get_subcommands().map(clap::Command::get_name);
            match all.find_subcommand(name) {
                Some(found) => found.clone(),
                None => {
                    let near = compiler::names::suggest(name, names);
                    let near = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
                    return Err(format!("there is no command `{name}`{near}"));
                }
            }
        }
    };
    let mut page = Vec::new();
    let man = Man::new(command).manual("Hierarq").source(concat!("hierarq ", env!("CARGO_PKG_VERSION")));
    man.render(&mut page).map_err(|e| format!("the page cannot be written: {e}"))?;
    output::data(&String::from_utf8_lossy(&page));
    Ok(Outcome::Good)
}
