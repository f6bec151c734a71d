//! Writes the problems of a run, one tick per line, for [`super::Lines`].

use std::io::{self, BufWriter, Write};

use runtime::{Recorder, Tick};
use serde_json::{Map, Value, json};
use solver::{Level, Problem};

use super::MAX_NAME;

/// Records the problem of the solver at each tick, before any damping; the kind of a tick is the state of the machine.
/// Numbers are written with enough digits to read back the same doubles.
pub struct ProblemRecorder<W: Write> {
    out: W,
    failed: bool,
}

impl<W: Write> ProblemRecorder<W> {
    /// Creates a recorder that writes to `out`.
    pub fn new(out: W) -> Self {
        ProblemRecorder { out, failed: false }
    }

    /// Returns true if a tick could not be written.
    pub fn has_failed(&self) -> bool {
        self.failed
    }
}

impl<W: Write> ProblemRecorder<BufWriter<W>> {
    /// Flushes the buffer and returns the writer.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn finish(self) -> io::Result<W> {
        self.out.into_inner().map_err(io::IntoInnerError::into_error)
    }
}

impl<W: Write> Recorder for ProblemRecorder<W> {
    fn tick(&mut self, tick: &Tick) -> io::Result<()> {
        let kind = if tick.state.is_empty() { "run" } else { tick.state };
        // The id appends a number to the kind, and must not exceed the maximum length.
        let kind: String = kind.chars().take(MAX_NAME - 20).collect();
        let written = writeln!(self.out, "{}", line(&format!("{kind}-{}", tick.index), &kind, tick.problem));
        self.failed |= written.is_err();
        written
    }
}

/// Formats a problem as a line, without the line break. Missing bounds are `null`, and default values are omitted.
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
