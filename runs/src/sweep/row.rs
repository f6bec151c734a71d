//! Rows of a sweep, one per run, and their columns.

use runtime::expect::Verdict;
use serde::{Deserialize, Serialize};

use super::head::{Head, Subject};

/// A run of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of the run, from 0.
    pub run: u64,
    /// Seed.
    pub seed: u64,
    /// Values of the params, in SI, in the order of [`Head::params`].
    pub values: Vec<Cell>,
    /// True if the result is as expected.
    pub holds: bool,
    /// Codes of the errors of the spec with these values; such a run is not executed.
    pub refused: Option<String>,
    /// Number of faults.
    pub faults: u64,
    /// Tick of the first fault, from 0.
    pub first_fault_tick: Option<u64>,
    /// Kind of the first fault.
    pub first_fault: Option<String>,
    /// True if a fault without a matching transition stopped the robot.
    pub halted: bool,
    /// Simulated time (s).
    pub duration: f64,
    /// Expectations, in the order of [`Head::expectations`].
    pub expectations: Vec<Expected>,
    /// Limits, in the order of [`Head::limits`].
    pub limits: Vec<Closest>,
    /// End of the mission, if one was executed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mission: Option<Ended>,
    /// Values at the end, in the order of [`Head::measures`]; a truth value is 1 or 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<Option<f64>>,
}

/// End of a mission in a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ended {
    /// `done`, `unfinished`, `stranded` or `refused`; `None` if the spec was refused.
    pub how: Option<String>,
    /// Time at which everything was done (s).
    pub done_at: Option<f64>,
    /// Number of plans that replaced another one.
    pub new_plans: u64,
    /// Number of members whose controllers broke down.
    pub broken: u64,
    /// First failure other than an expectation, as a sentence.
    pub trouble: Option<String>,
}

/// Result of an expectation in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Expected {
    /// Verdict; `None` if the run was refused.
    pub verdict: Option<Verdict>,
    /// Margin in SI; see [`runtime::expect::Outcome::margin`].
    pub margin: Option<f64>,
    /// Time at which it was closest to failing, or failed by most (s).
    pub at: Option<f64>,
}

/// Closest approach of a run to a limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Closest {
    /// Smallest `h` in SI; `None` if the limit was never active.
    pub margin: Option<f64>,
    /// Time of the closest approach (s).
    pub at: Option<f64>,
}

/// A value of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// An integer.
    #[serde(skip)]
    Whole(Option<u64>),
    /// A truth value.
    #[serde(skip)]
    Truth(Option<bool>),
    /// A number.
    Number(Option<f64>),
    /// A text.
    Text(Option<String>),
}

/// Type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Integers.
    Whole,
    /// Truth values.
    Truth,
    /// Numbers.
    Number,
    /// Texts.
    Text,
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Type.
    pub kind: Kind,
    /// True if each row has a value.
    pub always: bool,
    /// SI unit, if there is one.
    pub unit: Option<String>,
    /// Param, expectation or limit of the column, as named in the spec.
    pub of: Option<String>,
}

/// Columns of a sweep, in order.
pub fn columns(head: &Head) -> Vec<Column> {
    let mut all = Vec::new();
    let mut add = |name: String, kind, always, unit: Option<&str>, of: Option<&str>| {
        all.push(Column { name, kind, always, unit: unit.map(str::to_string), of: of.map(str::to_string) });
    };
    add("run".into(), Kind::Whole, true, None, None);
    add("seed".into(), Kind::Whole, true, None, None);
    for p in &head.params {
        let kind = if p.unit.is_some() { Kind::Number } else { Kind::Text };
        add(format!("param_{}", p.name), kind, true, p.unit.as_deref(), Some(&p.name));
    }
    add("holds".into(), Kind::Truth, true, None, None);
    add("refused".into(), Kind::Text, false, None, None);
    match head.subject {
        Subject::Controller => {
            add("faults".into(), Kind::Whole, true, None, None);
            add("first_fault_tick".into(), Kind::Whole, false, None, None);
            add("first_fault".into(), Kind::Text, false, None, None);
            add("halted".into(), Kind::Truth, true, None, None);
        }
        Subject::Mission => {
            add("end".into(), Kind::Text, false, None, None);
            add("done_at".into(), Kind::Number, false, Some("s"), None);
            add("new_plans".into(), Kind::Whole, true, None, None);
            add("broken".into(), Kind::Whole, true, None, None);
            add("trouble".into(), Kind::Text, false, None, None);
        }
    }
    add("duration".into(), Kind::Number, true, Some("s"), None);
    for (i, e) in head.expectations.iter().enumerate() {
        let (i, of) = (i + 1, Some(e.label.as_ref().unwrap_or(&e.text).as_str()));
        add(format!("expect_{i}_verdict"), Kind::Text, false, None, of);
        add(format!("expect_{i}_margin"), Kind::Number, false, e.unit.as_deref(), of);
        add(format!("expect_{i}_at"), Kind::Number, false, Some("s"), of);
    }
    for l in &head.limits {
        add(format!("limit_{}_margin", l.task), Kind::Number, false, Some(&l.unit), Some(&l.task));
        add(format!("limit_{}_at", l.task), Kind::Number, false, Some("s"), Some(&l.task));
    }
    for m in &head.measures {
        let kind = if m.unit.is_some() { Kind::Number } else { Kind::Truth };
        let unit = m.unit.as_deref().filter(|unit| !unit.is_empty());
        add(format!("measure_{}", m.title), kind, false, unit, Some(&m.title));
    }
    all
}

/// Words for verdicts.
const VERDICTS: [(Verdict, &str); 3] =
    [(Verdict::Holds, "holds"), (Verdict::Fails, "fails"), (Verdict::Undecided, "undecided")];

/// Word for a verdict.
pub fn word(verdict: Verdict) -> &'static str {
    VERDICTS.iter().find(|v| v.0 == verdict).map_or("", |v| v.1)
}

impl Row {
    /// Cells of the row, one for each of [`columns`].
    pub fn cells(&self, head: &Head) -> Vec<Cell> {
        let mut all = vec![Cell::Whole(Some(self.run)), Cell::Whole(Some(self.seed))];
        all.extend(self.values.iter().cloned());
        all.extend([Cell::Truth(Some(self.holds)), Cell::Text(self.refused.clone())]);
        match &self.mission {
            None => all.extend([
                Cell::Whole(Some(self.faults)),
                Cell::Whole(self.first_fault_tick),
                Cell::Text(self.first_fault.clone()),
                Cell::Truth(Some(self.halted)),
            ]),
            Some(ended) => all.extend([
                Cell::Text(ended.how.clone()),
                Cell::Number(ended.done_at),
                Cell::Whole(Some(ended.new_plans)),
                Cell::Whole(Some(ended.broken)),
                Cell::Text(ended.trouble.clone()),
            ]),
        }
        all.push(Cell::Number(Some(self.duration)));
        for e in &self.expectations {
            let verdict = e.verdict.map(|v| word(v).to_string());
            all.extend([Cell::Text(verdict), Cell::Number(e.margin), Cell::Number(e.at)]);
        }
        all.extend(self.limits.iter().flat_map(|l| [Cell::Number(l.margin), Cell::Number(l.at)]));
        all.extend(self.measures.iter().zip(&head.measures).map(|(value, of)| match of.unit {
            Some(_) => Cell::Number(*value),
            None => Cell::Truth(value.map(|value| value > 0.0)),
        }));
        all
    }

    /// Converts cells to a row; `None` if their types do not match.
    pub fn of(head: &Head, cells: Vec<Cell>) -> Option<Row> {
        let mut cells = cells.into_iter();
        let mut row = Row { run: whole(&mut cells)??, seed: whole(&mut cells)??, ..Row::default() };
        row.values = cells.by_ref().take(head.params.len()).collect();
        row.holds = truth(&mut cells)??;
        row.refused = text(&mut cells)?;
        match head.subject {
            Subject::Controller => {
                row.faults = whole(&mut cells)??;
                row.first_fault_tick = whole(&mut cells)?;
                row.first_fault = text(&mut cells)?;
                row.halted = truth(&mut cells)??;
            }
            Subject::Mission => {
                row.mission = Some(Ended {
                    how: text(&mut cells)?,
                    done_at: number(&mut cells)?,
                    new_plans: whole(&mut cells)??,
                    broken: whole(&mut cells)??,
                    trouble: text(&mut cells)?,
                });
            }
        }
        row.duration = number(&mut cells)??;
        for _ in &head.expectations {
            let verdict = match text(&mut cells)? {
                Some(word) => Some(VERDICTS.iter().find(|v| v.1 == word)?.0),
                None => None,
            };
            row.expectations.push(Expected { verdict, margin: number(&mut cells)?, at: number(&mut cells)? });
        }
        for _ in &head.limits {
            row.limits.push(Closest { margin: number(&mut cells)?, at: number(&mut cells)? });
        }
        for of in &head.measures {
            row.measures.push(match of.unit {
                Some(_) => number(&mut cells)?,
                None => truth(&mut cells)?.map(f64::from),
            });
        }
        cells.next().is_none().then_some(row)
    }
}

fn whole(cells: &mut impl Iterator<Item = Cell>) -> Option<Option<u64>> {
    match cells.next()? {
        Cell::Whole(x) => Some(x),
        _ => None,
    }
}

fn truth(cells: &mut impl Iterator<Item = Cell>) -> Option<Option<bool>> {
    match cells.next()? {
        Cell::Truth(x) => Some(x),
        _ => None,
    }
}

fn number(cells: &mut impl Iterator<Item = Cell>) -> Option<Option<f64>> {
    match cells.next()? {
        Cell::Number(x) => Some(x),
        _ => None,
    }
}

fn text(cells: &mut impl Iterator<Item = Cell>) -> Option<Option<String>> {
    match cells.next()? {
        Cell::Text(x) => Some(x),
        _ => None,
    }
}
