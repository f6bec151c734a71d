//! Writes the problems of a run, one tick a line, as [`super::Lines`] reads them.

use std::io::{self, BufWriter, Write};

use runtime::{Recorder, Tick};
use serde_json::{Map, Value, json};
use solver::{Level, Problem};

use super::MAX_NAME;

/// Writes what the solver was asked at each tick, before any damping; ticks of one state of the machine are of one kind.
/// Numbers are written so that the same doubles are read.
pub struct ProblemRecorder<W: Write> {
    out: W,
    failed: bool,
}

impl<W: Write> ProblemRecorder<W> {
    /// A recorder that writes to `out`.
    pub fn new(out: W) -> Self {
        ProblemRecorder { out, failed: false }
    }

    /// Whether a tick could not be written.
    pub fn has_failed(&self) -> bool {
        self.failed
    }
}

impl<W: Write> ProblemRecorder<BufWriter<W>> {
    /// Writes what is still in memory, and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        self.out.into_inner().map_err(io::IntoInnerError::into_error)
    }
}

impl<W: Write> Recorder for ProblemRecorder<W> {
    fn tick(&mut self, tick: &Tick) -> io::Result<()> {
        let kind = if tick.state.is_empty() { "run" } else { tick.state };
        // With its number a name may be as long as a file of ticks allows.
        let kind: String = kind.chars().take(MAX_NAME - 20).collect();
        let written = writeln!(self.out, "{}", line(&format!("{kind}-{}", tick.index), &kind, tick.problem));
        self.failed |= written.is_err();
        written
    }
}

/// A problem as a line, without the end of the line. Bounds that do not exist are `null`, parts with their defaults are left out.
fn line(id: &str, kind: &str, problem: &Problem) -> Value {
    let levels: Vec<Value> = problem.levels.iter().map(level).collect();
    let mut tick = Map::from_iter([
        ("id".to_string(), json!(id)),
        ("kind".to_string(), json!(kind)),
        ("n".to_string(), json!(problem.n)),
        ("levels".to_string(), Value::Array(levels)),
    ]);
    if problem.reference.iter().any(|r| *r != 0.0) {
        tick.insert("reference".to_string(), json!(problem.reference));
    }
    Value::Object(tick)
}

fn level(level: &Level) -> Value {
    let bound = |b: &f64| b.is_finite().then_some(*b);
    let rows: Vec<&[f64]> = (0..level.rows()).map(|i| level.row(i)).collect();
    let mut keys = Map::from_iter([
        ("A".to_string(), json!(rows)),
        ("lo".to_string(), json!(level.lower.iter().map(bound).collect::<Vec<_>>())),
        ("up".to_string(), json!(level.upper.iter().map(bound).collect::<Vec<_>>())),
    ]);
    if level.weight.iter().any(|w| *w != 1.0) {
        keys.insert("weight".to_string(), json!(level.weight));
    }
    if level.hard {
        keys.insert("hard".to_string(), json!(true));
    }
    if level.damping > 0.0 {
        keys.insert("damping".to_string(), json!(level.damping));
    }
    Value::Object(keys)
}
