//! `hierarq schema [spec|plan]`

use clap::{Args, ValueEnum};

use super::{Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// Format to describe.
    #[arg(value_enum, default_value_t = Of::Spec)]
    of: Of,
}

/// A form with a JSON Schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Of {
    /// A spec in the YAML syntax, for editors.
    Spec,
    /// The output of `plan --json`.
    Plan,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    match a.of {
        Of::Spec => output::data(&format!("{:#}\n", hierarq::schema::schema())),
        Of::Plan => output::data(&format!("{:#}\n", mission::kinds::plan_schema())),
    }
    Ok(Outcome::Good)
}
