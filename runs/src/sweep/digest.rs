//! Summary of a sweep: number of successful runs, worst runs, and the commands that repeat them.

use runtime::expect::Verdict;
use serde_json::{Map, Value as Json, json};

use super::head::Head;
use super::row::{Cell, Row, word};

/// Maximum number of failed runs that are listed.
const NAMED: usize = 10;

/// Summary of a sweep.
#[derive(Clone, Debug)]
pub struct Digest<'a> {
    head: &'a Head,
    /// Number of runs.
    pub runs: usize,
    /// Expected number of runs.
    pub wanted: usize,
    /// Number of runs with the expected result.
    pub hold: usize,
    /// Number of runs that did not compile.
    pub refused: usize,
    /// Number of runs in which a fault stopped the robot.
    pub halted: usize,
    /// Expectations, in source order.
    pub expectations: Vec<Figure<'a>>,
    /// Limits.
    pub limits: Vec<Figure<'a>>,
    /// First runs without the expected result.
    pub failed: Vec<&'a Row>,
}

/// Statistics of an expectation or a limit.
#[derive(Clone, Debug)]
pub struct Figure<'a> {
    /// Title.
    pub title: &'a str,
    /// SI unit of the margin.
    pub unit: &'a str,
    /// Number of runs in which it held; for a limit, in which it was not violated.
    pub hold: usize,
    /// Number of runs in which it was evaluated.
    pub of: usize,
    /// Worst run.
    pub worst: Option<Worst<'a>>,
}

/// The worst run of an expectation or a limit.
#[derive(Clone, Copy, Debug)]
pub struct Worst<'a> {
    /// Row of the run.
    pub row: &'a Row,
    /// Verdict; `None` for a limit.
    pub verdict: Option<Verdict>,
    /// Margin in SI.
    pub margin: Option<f64>,
    /// Time of the margin (s).
    pub at: Option<f64>,
}

impl Worst<'_> {
    /// Sort key, worst first: failed before undecided before held, then smaller margins, then earlier runs.
    fn key(&self) -> (u8, f64, u64) {
        let rank = match self.verdict {
            Some(Verdict::Fails) => 0,
            Some(Verdict::Undecided) => 1,
            Some(Verdict::Holds) | None => 2,
        };
        (rank, self.margin.unwrap_or(f64::INFINITY), self.row.run)
    }
}

fn figure<'a>(title: &'a str, unit: &'a str, hold: usize, all: Vec<Worst<'a>>) -> Figure<'a> {
    let of = all.len();
    let worse = |a: &Worst, b: &Worst| {
        let (a, b) = (a.key(), b.key());
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2))
    };
    Figure { title, unit, hold, of, worst: all.into_iter().min_by(worse) }
}

impl<'a> Digest<'a> {
    /// Summarises the rows of a sweep.
    pub fn new(head: &'a Head, rows: &'a [Row]) -> Digest<'a> {
        let expectations = head.expectations.iter().enumerate().map(|(i, e)| {
            let of = |row: &'a Row| {
                let e = row.expectations.get(i)?;
                Some(Worst { row, verdict: Some(e.verdict?), margin: e.margin, at: e.at })
            };
            let all: Vec<Worst> = rows.iter().filter_map(of).collect();
            let hold = all.iter().filter(|w| w.verdict == Some(Verdict::Holds)).count();
            figure(e.label.as_deref().unwrap_or(&e.text), e.unit.as_deref().unwrap_or_default(), hold, all)
        });
        let limits = head.limits.iter().enumerate().map(|(i, l)| {
            let of = |row: &'a Row| {
                let l = row.limits.get(i)?;
                Some(Worst { row, verdict: None, margin: Some(l.margin?), at: l.at })
            };
            let all: Vec<Worst> = rows.iter().filter_map(of).collect();
            let passed = |w: &&Worst| w.margin.is_some_and(|m| m < -runtime::record::summary::MARGIN_TOLERANCE);
            let hold = all.len() - all.iter().filter(passed).count();
            figure(&l.task, &l.unit, hold, all)
        });
        let count = |f: &dyn Fn(&Row) -> bool| rows.iter().filter(|r| f(r)).count();
        Digest {
            head,
            runs: rows.len(),
            wanted: head.own().count(),
            hold: count(&|r| r.holds),
            refused: count(&|r| r.refused.is_some()),
            halted: count(&|r| r.halted),
            expectations: expectations.collect(),
            limits: limits.collect(),
            failed: rows.iter().filter(|r| !r.holds).take(NAMED).collect(),
        }
    }

    /// True if all runs are present and have the expected result.
    pub fn ok(&self) -> bool {
        self.runs == self.wanted && self.hold == self.runs
    }

    /// Share of runs with the expected result; `None` without runs.
    pub fn share(&self) -> Option<f64> {
        (self.runs > 0).then(|| self.hold as f64 / self.runs as f64)
    }

    /// Command line that repeats a run.
    pub fn replay(&self, row: &Row) -> String {
        self.head.replay(row)
    }

    /// Summary as JSON, version 1.
    pub fn json(&self, output: &str) -> Json {
        let head = self.head;
        let expectation = |(f, e): (&Figure, &super::head::Expectation)| {
            let mut one = self.figure(f);
            one.insert("text".to_string(), json!(e.text));
            one.insert("label".to_string(), json!(e.label));
            one
        };
        let limit = |f: &Figure| {
            let mut one = self.figure(f);
            one.insert("task".to_string(), json!(f.title));
            one
        };
        let run = |row: &&Row| {
            let mut one = self.run(row);
            one.insert("refused".to_string(), json!(row.refused));
            one
        };
        json!({
            "version": 1,
            "spec": head.spec,
            "scenario": head.scenario,
            "command": head.command,
            "program": head.program,
            "shard": head.shard.map(|s| s.to_string()),
            "ok": self.ok(),
            "interrupted": self.runs < self.wanted,
            "runs": self.runs,
            "wanted": self.wanted,
            "hold": self.hold,
            "share": self.share(),
            "refused": self.refused,
            "halted": self.halted,
            "expectations": self.expectations.iter().zip(&head.expectations).map(expectation).collect::<Vec<_>>(),
            "limits": self.limits.iter().map(limit).collect::<Vec<_>>(),
            "failed": self.failed.iter().map(run).collect::<Vec<_>>(),
            "output": output,
        })
    }

    fn figure(&self, f: &Figure) -> Map<String, Json> {
        let mut one = Map::new();
        one.insert("hold".to_string(), json!(f.hold));
        one.insert("of".to_string(), json!(f.of));
        one.insert("unit".to_string(), json!((!f.unit.is_empty()).then_some(f.unit)));
        let worst = f.worst.map(|w| {
            let mut run = self.run(w.row);
            run.insert("verdict".to_string(), json!(w.verdict.map(word)));
            run.insert("margin".to_string(), json!(w.margin));
            run.insert("at_s".to_string(), json!(w.at));
            run
        });
        one.insert("worst".to_string(), json!(worst));
        one
    }

    /// JSON of a run: number, seed, values, and the command that repeats it.
    fn run(&self, row: &Row) -> Map<String, Json> {
        let value = |(p, cell): (&super::head::Param, &Cell)| {
            let value = match cell {
                Cell::Number(x) => json!({ "value": x, "unit": p.unit }),
                Cell::Text(text) => json!({ "value": text }),
                Cell::Whole(_) | Cell::Truth(_) => Json::Null,
            };
            (p.name.clone(), value)
        };
        let values: Map<String, Json> = self.head.params.iter().zip(&row.values).map(value).collect();
        let mut one = Map::new();
        one.insert("run".to_string(), json!(row.run));
        one.insert("seed".to_string(), json!(row.seed));
        one.insert("values".to_string(), Json::Object(values));
        one.insert("replay".to_string(), json!(self.replay(row)));
        one
    }
}
