//! The log of a run in MCAP, beside `log.csv`.

use std::io::{BufWriter, Result as Written};
use std::path::{Path, PathBuf};

use files::{Draft, Results};
use logs::{About, Finished, McapRecorder, Origin, Overflow, SourceText};
use runtime::program::ScenarioProgram;
use runtime::{Controller, Program, Recorder, Tick};

/// Name of the file in the folder of the run.
const NAME: &str = "log.mcap";

/// A log that grows.
pub struct McapLog(McapRecorder<BufWriter<Draft>>);

/// Returns whether this build can write such a log.
pub fn possible() -> Result<(), String> {
    Ok(())
}

/// The texts that a program was compiled from, the spec first. Names begin at the folder of the spec, so that they do not depend on
/// where that is.
pub fn texts(report: &compiler::Report) -> Vec<SourceText> {
    let spec = report.sources.iter().next().map(|(_, s)| PathBuf::from(&s.name)).unwrap_or_default();
    let folder = spec.parent().unwrap_or(Path::new(""));
    let text = |s: &dsl::SourceText| {
        let name = Path::new(&s.name).strip_prefix(folder).unwrap_or(Path::new(&s.name));
        SourceText { name: name.to_string_lossy().replace('\\', "/"), text: s.text.clone() }
    };
    report.sources.iter().map(|(_, source)| text(source)).collect()
}

impl McapLog {
    /// Begins the log of a run.
    pub fn begin(
        results: &Results,
        program: &Program,
        scenario: Option<&ScenarioProgram>,
        report: &compiler::Report,
        controller: &Controller,
    ) -> Result<McapLog, String> {
        let about = About::new(program, scenario, texts(report), Origin::Run);
        let out = BufWriter::with_capacity(1 << 16, results.part(NAME)?);
        let log = McapRecorder::new(out, &about, program, controller, Overflow::Wait);
        log.map(McapLog).map_err(|e| format!("cannot write {NAME}: {e}"))
    }

    /// Ends the log and adds it to the results of the run.
    pub fn finish(self, results: &mut Results) -> Result<(), String> {
        let failed = |e: std::io::Error| format!("cannot write {NAME}: {e}");
        let Finished { out, .. } = self.0.finish().map_err(failed)?;
        results.add(NAME, out.into_inner().map_err(|e| failed(e.into_error()))?);
        Ok(())
    }
}

impl Recorder for McapLog {
    fn tick(&mut self, tick: &Tick) -> Written<()> {
        self.0.record(tick)
    }
}
