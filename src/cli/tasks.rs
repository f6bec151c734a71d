//! `hierarq tasks [TYPE]`

use clap::Args;
use hierarq::catalogue;
use serde_json::json;
use stdlib_tasks::KINDS;

use super::{Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// Task type [default: a list of all].
    kind: Option<String>,
    /// Print as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    match &a.kind {
        None => {
            if a.json {
                let all: Vec<_> = KINDS.iter().map(|k| catalogue::json(k)).collect();
                output::data(&format!("{:#}\n", json!({ "version": 1, "tasks": all })));
            } else {
                output::print(&catalogue::list());
            }
        }
        Some(name) => match stdlib_tasks::find(name) {
            Some(kind) if a.json => output::data(&format!("{:#}\n", catalogue::json(kind))),
            Some(kind) => output::print(&catalogue::page(kind)),
            None => {
                let near = compiler::names::suggest(name, KINDS.iter().map(|k| k.name));
                let near = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
                return Err(format!("there is no task type `{name}`{near} (`hierarq tasks` lists all)"));
            }
        },
    }
    Ok(Outcome::Good)
}
