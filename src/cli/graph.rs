//! `hierarq graph SPEC`

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use files::Target;
use hierarq::{graph, outputs, project};

use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`) with a machine, or a compiled program (`*.json`).
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Format of the drawing.
    #[arg(long, value_enum, default_value_t = Format::Mermaid)]
    format: Format,
    /// File to write [default: standard output].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Format {
    /// A Mermaid state diagram, which many Markdown viewers render.
    Mermaid,
    /// A graph of Graphviz.
    Dot,
    /// A picture.
    Svg,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let compiled = project::load(&a.spec, &a.options.settings());
    let sources = project::sources(&a.spec, &compiled.report);
    let Some(program) = compiled.program else { return output::refuse(&compiled.report, &a.spec, false) };
    output::show(&compiled.report);
    let target = a.out.as_deref().map(|path| Target::new("--out", path, outputs::PICTURE, &sources)).transpose()?;
    let format = match a.format {
        Format::Mermaid => graph::Format::Mermaid,
        Format::Dot => graph::Format::Dot,
        Format::Svg => graph::Format::Svg,
    };
    let Some(text) = graph::draw(&program, format) else {
        let spec = a.spec.display();
        return Err(format!(
            "`{spec}` has no machine to draw; write one: `machine NAME {{ initial STATE  state STATE {{ stack NAME }} }}`"
        ));
    };
    match target {
        Some(target) => target.write(&text)?,
        None => output::data(&text),
    }
    Ok(Outcome::Good)
}
