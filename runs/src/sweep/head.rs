//! Metadata of a sweep's file, and the command lines that repeat the sweep and each of its runs.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use files::quoted;
use serde::{Deserialize, Serialize};

use super::row::{Cell, Row};
use crate::project::Settings;

/// Version of the metadata and the columns.
pub const VERSION: u32 = 1;

/// Description of a sweep and its columns. Two files whose heads differ only in the shard are parts of one sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// Always [`VERSION`].
    pub version: u32,
    /// Program that wrote the file, with its version.
    pub generated_by: String,
    /// Spec, as the user named it.
    pub spec: String,
    /// Scenario.
    pub scenario: String,
    /// Kind of the scenario.
    #[serde(default, skip_serializing_if = "Subject::is_controller")]
    pub subject: Subject,
    /// Hash of the program with the first value of each param: XXH3, 128 bits.
    pub program: String,
    /// Hash of the texts of the spec and of the files that it reads.
    pub texts: String,
    /// Number of runs in all shards.
    pub runs: u64,
    /// Seed of the first run.
    pub seed: u64,
    /// Command line of the whole sweep.
    pub command: String,
    /// Start of the command line for every single run.
    pub replay: String,
    /// Varied params.
    pub params: Vec<Param>,
    /// Expectations, in source order.
    pub expectations: Vec<Expectation>,
    /// Limits.
    pub limits: Vec<Limit>,
    /// Measures of a mission.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<Measured>,
    /// Shard; `None` for the whole sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
}

/// Kind of a scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// A robot runs its controller.
    #[default]
    Controller,
    /// A mission is executed.
    Mission,
}

impl Subject {
    /// True for a robot's controller.
    pub fn is_controller(&self) -> bool {
        *self == Subject::Controller
    }
}

/// A varied param.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Param {
    /// Name.
    pub name: String,
    /// Values, as written.
    pub values: String,
    /// SI unit of the number; `None` if the values are texts.
    pub unit: Option<String>,
}

/// An expectation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    /// Label in the spec.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Source text.
    pub text: String,
    /// SI unit of the margin; `None` if it has none.
    pub unit: Option<String>,
}

/// A limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// Name of the task.
    pub task: String,
    /// SI unit of the margins; several if the rows have different units.
    pub unit: String,
}

/// A measure of a mission or of a member.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Title, in the words of the language: `makespan`, `anna.travelled`, `anna.position.x`.
    pub title: String,
    /// Name of the measure.
    pub name: String,
    /// Index of the member; `None`: of the mission.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub member: Option<usize>,
    /// Component of a point; 0 for a number.
    #[serde(default)]
    pub axis: usize,
    /// SI unit, empty for a number without one; `None` for a truth value.
    pub unit: Option<String>,
}

/// Part `index`, from 1, of `of` parts. It contains every `of`th run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Index of the part, from 1.
    pub index: u64,
    /// Number of parts.
    pub of: u64,
}

impl Shard {
    /// True if the run belongs to this part.
    pub fn has(self, run: u64) -> bool {
        run.checked_rem(self.of).is_some_and(|rest| rest + 1 == self.index)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let number = |t: &str| t.trim().parse::<u64>().ok();
        let both = text.split_once('/').and_then(|(i, n)| Some((number(i)?, number(n)?)));
        let both = both.filter(|(i, n)| (1..=*n).contains(i));
        both.map(|(index, of)| Shard { index, of }).ok_or_else(|| "write I/N, with I from 1 to N".to_string())
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl Head {
    /// Returns the head without its shard.
    pub fn whole(&self) -> Head {
        Head { shard: None, ..self.clone() }
    }

    /// Numbers of the runs in this file.
    pub fn own(&self) -> impl Iterator<Item = u64> {
        let shard = self.shard;
        (0..self.runs).filter(move |&run| shard.is_none_or(|s| s.has(run)))
    }

    /// Describes the first difference from another head; `None` if both are equal.
    pub fn differs(&self, other: &Head) -> Option<String> {
        let pair = |what: &str, a: &str, b: &str| (a != b).then(|| format!("{what}: `{a}` there, `{b}` here"));
        let texts = (self.texts != other.texts || self.program != other.program)
            .then(|| "the spec, or a file that it brings in, is not the same any more".to_string());
        let shard = |h: &Head| h.shard.map_or_else(|| "the whole".to_string(), |s| s.to_string());
        pair("written by another version", &other.generated_by, &self.generated_by)
            .or_else(|| pair("another command", &other.command, &self.command))
            .or(texts)
            .or_else(|| pair("another shard", &shard(other), &shard(self)))
            .or_else(|| (self != other).then(|| "its columns are others".to_string()))
    }

    /// Arguments of `--set` for the values of a run.
    pub fn sets(&self, values: &[Cell]) -> Vec<(String, String)> {
        self.params.iter().zip(values).map(|(p, value)| (p.name.clone(), p.written(value))).collect()
    }

    /// Command line that repeats a run.
    pub fn replay(&self, row: &Row) -> String {
        let mut line = self.replay.clone();
        for (name, text) in self.sets(&row.values) {
            line += &format!(" --set {}", quoted(&format!("{name}={text}")));
        }
        line + &format!(" --seed {}", row.seed)
    }
}

impl Param {
    /// Formats a value for the language: a number with all digits, so that it parses to the same bits.
    pub fn written(&self, value: &Cell) -> String {
        match value {
            Cell::Number(Some(x)) => format!("{x:?}{}", self.unit.as_deref().unwrap_or_default()),
            Cell::Text(Some(text)) => text.clone(),
            _ => String::new(),
        }
    }
}

/// Command line for a scenario of a spec, with the common settings.
pub fn line(command: &str, spec: &str, scenario: &str, settings: &Settings) -> String {
    let mut line = format!("hierarq {command} {} --scenario {}", quoted(spec), quoted(scenario));
    let path = |p: &PathBuf| format!(" --package-path {}", quoted(&p.display().to_string()));
    line.extend(settings.package_paths.iter().map(path));
    line.extend(settings.set.iter().map(|(n, v)| format!(" --set {}", quoted(&format!("{n}={v}")))));
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_take_every_run_once() {
        let parts: Vec<Shard> = (1..=3).map(|i| format!("{i}/3").parse().expect("a shard")).collect();
        assert!((0..20).all(|run| parts.iter().filter(|s| s.has(run)).count() == 1));
        for bad in ["", "1", "0/3", "4/3", "1/0", "a/b", "-1/3"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
