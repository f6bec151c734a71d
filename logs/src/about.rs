//! Description of the run of a log, beside its messages: the program that ran, the texts that it was compiled from, and their hashes.

use std::collections::BTreeMap;

use ring::digest::{SHA256, digest};
use runtime::Program;
use runtime::program::CompiledFile;

/// Version of the contents: names of attachments, metadata and channels. A log of another version is refused.
pub const VERSION: &str = "1";
/// Name of the attachment with the compiled program.
pub const PROGRAM: &str = "program.json";
/// Beginning of the names of attachments with texts.
pub const SOURCE: &str = "source/";
/// Name of the metadata that are written at the beginning.
pub const METADATA: &str = "hierarq";
/// Name of the metadata that are written at the end.
pub const END: &str = "hierarq_end";
/// Key of the column names in the metadata of the channel of columns.
pub const COLUMNS: &str = "columns";
/// Key of the names in the metadata of the channel of commands.
pub const DEGREES_OF_FREEDOM: &str = "degrees_of_freedom";

/// Source of the numbers of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A run.
    Run,
    /// `log.csv`, which does not have the levels.
    Csv,
}

impl Origin {
    /// Its word in metadata.
    pub fn word(self) -> &'static str {
        match self {
            Origin::Run => "run",
            Origin::Csv => "csv",
        }
    }
}

/// A text that a program was compiled from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceText {
    /// Its name.
    pub name: String,
    /// The text.
    pub text: String,
}

/// A run, as a log describes it.
#[derive(Clone, Debug)]
pub struct About {
    /// The program that ran; in a scenario, that of the scenario, with the scenario alone in its list.
    pub program: Program,
    /// True for the run of the only scenario of the program.
    pub in_scenario: bool,
    /// The texts, the spec first.
    pub sources: Vec<SourceText>,
    /// Source of the numbers.
    pub origin: Origin,
}

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    digest(&SHA256, bytes).as_ref().iter().map(|b| format!("{b:02x}")).collect()
}

impl About {
    /// Describes a run: its program, its scenario if it has one, and the texts, the spec first.
    pub fn new(
        program: &Program,
        scenario: Option<&runtime::program::ScenarioProgram>,
        sources: Vec<SourceText>,
        origin: Origin,
    ) -> About {
        let mut program = program.clone();
        program.scenarios = scenario.cloned().into_iter().collect();
        About { program, in_scenario: scenario.is_some(), sources, origin }
    }

    /// The program as JSON.
    ///
    /// # Errors
    /// A number of it is not finite, which no compiled program has.
    pub fn program_text(&self) -> Result<String, serde_json::Error> {
        CompiledFile::to_json(&self.program.name, Some(&self.program), &[])
    }

    /// The metadata of the beginning. `text` is [`About::program_text`].
    pub fn metadata(&self, text: &str) -> BTreeMap<String, String> {
        let program = &self.program;
        let mut all: BTreeMap<&str, String> = BTreeMap::from([
            ("version", VERSION.to_string()),
            ("hierarq", env!("CARGO_PKG_VERSION").to_string()),
            ("origin", self.origin.word().to_string()),
            ("program", program.name.clone()),
            ("title", program.title.clone()),
            ("robot", program.robot.name.clone()),
            ("program_sha256", sha256(text.as_bytes())),
            ("period_s", program.robot.period.to_string()),
            ("duration_s", program.run.duration.to_string()),
            ("solver", program.run.solver.name().to_string()),
            ("seed", program.run.simulator.seed.to_string()),
        ]);
        if self.in_scenario {
            all.insert("scenario", program.scenarios.first().map(|s| s.name.clone()).unwrap_or_default());
        }
        if let Some(spec) = self.sources.first() {
            all.insert("spec", spec.name.clone());
            all.insert("spec_sha256", sha256(spec.text.as_bytes()));
        }
        all.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
    }
}
