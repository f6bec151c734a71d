//! `log.csv` and MCAP, one made of the other: the numbers are the same to the last bit.

use std::io::{Result, Write};

use runtime::csv::cell;
use runtime::program::{Program, Subject};
use runtime::record::columns::Columns;
use runtime::record::csv::header;
use runtime::{Controller, FaultKind};

use crate::about::COLUMNS;
use crate::decode::{DecodeError, Leaf, Schema, Value};
use crate::read::{Log, LogError};
use crate::snapshot::{Snapshot, as_in_csv};
use crate::topics::Topic;

/// Reason why a log in CSV is not one of a program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CsvError {
    /// There is nothing in it.
    #[error("it is empty")]
    Empty,
    /// It is something else.
    #[error("it is no `log.csv` of a run: its first line does not begin with `time`")]
    Foreign,
    /// A column is another one.
    #[error(
        "column {at} is `{found}`, and in a run of the spec it is `{expected}`: the log is of another robot, or of an earlier spec"
    )]
    Column {
        /// Number of the column, from 1.
        at: usize,
        /// Its name.
        found: String,
        /// The name that it should have.
        expected: String,
    },
    /// There are more or fewer columns.
    #[error("it has {found} columns, and a run of the spec {expected}: the log is of another spec")]
    Columns {
        /// Columns of the file.
        found: usize,
        /// Columns of a run.
        expected: usize,
    },
    /// A row is too short or too long.
    #[error("line {line} has {found} cells, and the first line {expected}: the log is cut off or damaged")]
    Row {
        /// Number of the line, from 1.
        line: usize,
        /// Its cells.
        found: usize,
        /// Columns of the file.
        expected: usize,
    },
    /// A cell is not a number.
    #[error("line {line}: `{text}` in column `{column}` is not a number")]
    Number {
        /// Number of the line, from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// The cell.
        text: String,
    },
    /// A fault is not known.
    #[error("line {line}: there is no fault `{text}`")]
    Fault {
        /// Number of the line, from 1.
        line: usize,
        /// The cell.
        text: String,
    },
}

/// Splits a line into cells (RFC 4180).
fn cells(line: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    let (mut quoted, mut letters) = (false, line.chars().peekable());
    while let Some(c) = letters.next() {
        let last = all.len() - 1;
        match c {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                all[last].push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => all.push(String::new()),
            c => all[last].push(c),
        }
    }
    all
}

/// The rows of a log in CSV.
pub struct Rows<'t> {
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
    names: Vec<String>,
    machine: bool,
    program: &'t Program,
    signals_at: usize,
}

impl<'t> Rows<'t> {
    /// Checks the first line of a log in CSV against the columns of a run of the program. `signals_at` is the index of the
    /// first number of a signal in a row.
    ///
    /// # Errors
    /// The log is not one of the program.
    pub fn new(
        text: &'t str,
        program: &'t Program,
        controller: &Controller,
        signals_at: usize,
    ) -> std::result::Result<Rows<'t>, CsvError> {
        let mut lines = text.lines().enumerate();
        let names = cells(lines.next().ok_or(CsvError::Empty)?.1);
        if names[0] != "time" {
            return Err(CsvError::Foreign);
        }
        let expected = header(program, &Columns::new(program, controller));
        for (i, (found, expected)) in names.iter().zip(&expected).enumerate() {
            if found != expected {
                return Err(CsvError::Column { at: i + 1, found: found.clone(), expected: expected.clone() });
            }
        }
        if names.len() != expected.len() {
            return Err(CsvError::Columns { found: names.len(), expected: expected.len() });
        }
        Ok(Rows { lines, names, machine: program.run.subject == Subject::Machine, program, signals_at })
    }

    fn row(&self, index: usize, line: &str) -> std::result::Result<Snapshot, CsvError> {
        let (number, cells) = (index + 1, cells(line));
        if cells.len() != self.names.len() {
            return Err(CsvError::Row { line: number, found: cells.len(), expected: self.names.len() });
        }
        let mut tick = Snapshot { index: index - 1, ..Snapshot::default() };
        let fault = &cells[cells.len() - 1];
        if !fault.is_empty() && !FaultKind::ALL.iter().any(|kind| kind.word() == fault) {
            return Err(CsvError::Fault { line: number, text: fault.clone() });
        }
        tick.fault.clone_from(fault);
        for (i, text) in cells[..cells.len() - 1].iter().enumerate() {
            if i == 1 && self.machine {
                tick.state.clone_from(text);
                continue;
            }
            let x = if text.is_empty() { Some(f64::NAN) } else { text.parse().ok().filter(|x: &f64| x.is_finite()) };
            tick.row.push(x.ok_or_else(|| CsvError::Number {
                line: number,
                column: self.names[i].clone(),
                text: text.clone(),
            })?);
        }
        tick.time = tick.row[0];
        as_in_csv(&mut tick, &self.program.interface, self.signals_at);
        Ok(tick)
    }
}

impl Iterator for Rows<'_> {
    type Item = std::result::Result<Snapshot, CsvError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (index, line) = self.lines.next()?;
        Some(self.row(index, line))
    }
}

/// Reason why a log cannot be written as CSV.
#[derive(Debug, thiserror::Error)]
pub enum ToCsvError {
    /// The log cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A message cannot be read.
    #[error("it is damaged: {0}")]
    Message(#[from] DecodeError),
    /// The stream failed.
    #[error("{0}")]
    Write(#[from] std::io::Error),
}

/// Writes the numbers of a log as `log.csv`.
///
/// # Errors
/// The log cannot be used, or the stream failed.
pub fn write(log: &Log, out: &mut dyn Write) -> std::result::Result<usize, ToCsvError> {
    let machine = log.program.run.subject == Subject::Machine;
    let (mut state, mut fault) = (String::new(), String::new());
    let mut pending: Option<Vec<f64>> = None;
    let mut schema: Option<Schema> = None;
    let mut ticks = 0;
    for message in log.messages()? {
        let message = message?;
        // The state and the fault of a tick follow its numbers.
        let topic = Topic::ALL.into_iter().find(|t| t.name() == message.channel.topic);
        match topic {
            Some(Topic::State | Topic::Fault) => {
                let leaves = Schema::new(&Topic::State.definition().text()).decode(&message.data)?;
                let text = leaves.first().map(|leaf| match &leaf.value {
                    Value::Text(text) => text.clone(),
                    other => other.to_string(),
                });
                let text = text.unwrap_or_default();
                match topic {
                    Some(Topic::State) => state = text,
                    _ => fault = text.split(':').next().unwrap_or_default().to_string(),
                }
            }
            Some(Topic::Columns) => {
                if ticks == 0 {
                    first_line(out, message.channel.metadata.get(COLUMNS), machine)?;
                }
                ticks += 1;
                let schema = schema.get_or_insert_with(|| Schema::new(&Topic::Columns.definition().text()));
                let numbers =
                    schema.decode(&message.data)?.into_iter().filter_map(|Leaf { path, value }| match value {
                        Value::Number(x) if path.starts_with("data") => Some(x),
                        _ => None,
                    });
                pending = Some(numbers.collect());
            }
            // The first channel of a tick: the last tick is complete.
            Some(Topic::JointStates) => {
                if let Some(row) = pending.take() {
                    line(out, &row, machine.then_some(&state), &fault)?;
                }
            }
            _ => {}
        }
    }
    if let Some(row) = pending {
        line(out, &row, machine.then_some(&state), &fault)?;
    }
    Ok(ticks)
}

fn first_line(out: &mut dyn Write, names: Option<&String>, machine: bool) -> Result<()> {
    let mut names: Vec<String> = names.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
    if machine && !names.is_empty() {
        names.insert(1, "state".to_string());
    }
    names.push("fault".to_string());
    writeln!(out, "{}", names.iter().map(|name| cell(name)).collect::<Vec<_>>().join(","))
}

fn line(out: &mut dyn Write, row: &[f64], state: Option<&String>, fault: &str) -> Result<()> {
    let Some((time, rest)) = row.split_first() else { return Ok(()) };
    write!(out, "{time}")?;
    if let Some(state) = state {
        write!(out, ",{}", cell(state))?;
    }
    for x in rest {
        if x.is_finite() { write!(out, ",{x}")? } else { write!(out, ",")? }
    }
    writeln!(out, ",{fault}")
}
