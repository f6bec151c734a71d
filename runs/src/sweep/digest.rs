//! Summary of a sweep: number of successful runs, worst runs, and the commands that repeat them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use learning::evaluate::bootstrap;
use runtime::expect::Verdict;
use serde_json::{Map, Value as Json, json};

use super::head::{Head, Measured, Subject};
use super::row::{Cell, Row, word};

/// Maximum number of failed runs that are listed.
const NAMED: usize = 10;

/// Summary of a sweep.
#[derive(Clone, Debug)]
pub struct Digest<'a> {
    head: &'a Head,
    rows: &'a [Row],
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
    /// Ends of missions with their numbers of runs, the most frequent first.
    pub ends: Vec<(&'a str, usize)>,
    /// Measures of a mission and its members.
    pub measures: Vec<Spread<'a>>,
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

/// Distribution of a measure of missions over all runs that have a value of it.
#[derive(Clone, Debug)]
pub struct Spread<'a> {
    /// The measure.
    pub of: &'a Measured,
    /// Number of runs that have a value.
    pub runs: usize,
    /// Mean in SI; for a truth value the share of runs in which it is true. `None` without runs.
    pub mean: Option<f64>,
    /// Interval of 95 % of the mean, by bootstrap; `None` for fewer than two runs.
    pub interval: Option<[f64; 2]>,
    /// Standard deviation in SI; `None` for a truth value or fewer than two runs.
    pub deviation: Option<f64>,
    /// Runs with the smallest and the greatest value, with these; `None` for a truth value or without runs.
    pub extremes: Option<[(f64, &'a Row); 2]>,
}

impl<'a> Spread<'a> {
    fn new(of: &'a Measured, index: usize, rows: &'a [Row]) -> Spread<'a> {
        let all: Vec<(f64, &Row)> = rows.iter().filter_map(|r| Some(((*r.measures.get(index)?)?, r))).collect();
        let (runs, sum) = (all.len(), all.iter().map(|v| v.0).sum::<f64>());
        let mean = (runs > 0).then(|| sum / runs as f64);
        let values: Vec<f64> = all.iter().map(|(value, _)| *value).collect();
        // The same rows give the same interval, however a sweep was cut.
        let interval = (runs > 1).then(|| bootstrap(&values, 0)).map(|mean| [mean.low, mean.high]);
        let is_number = of.unit.is_some();
        let deviation = mean.filter(|_| is_number && runs > 1).map(|mean| {
            let squares: f64 = all.iter().map(|v| (v.0 - mean).powi(2)).sum();
            (squares / (runs - 1) as f64).sqrt()
        });
        // Of equal values that of the first run.
        let least = all.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
        let most = all.iter().copied().min_by(|a, b| b.0.total_cmp(&a.0));
        let extremes = least.zip(most).filter(|_| is_number).map(|(least, most)| [least, most]);
        Spread { of, runs, mean, interval, deviation, extremes }
    }
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

fn ends(rows: &[Row]) -> Vec<(&str, usize)> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for how in rows.iter().filter_map(|r| r.mission.as_ref()?.how.as_deref()) {
        match counts.iter_mut().find(|(known, _)| *known == how) {
            Some((_, count)) => *count += 1,
            None => counts.push((how, 1)),
        }
    }
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    counts
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
            rows,
            runs: rows.len(),
            wanted: head.own().count(),
            ends: ends(rows),
            measures: head.measures.iter().enumerate().map(|(i, m)| Spread::new(m, i, rows)).collect(),
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

    /// True if runs with the same values and other seeds have the same results throughout, and there are such runs.
    pub fn is_unseeded(&self) -> bool {
        let result = |row: &Row| Row { run: 0, seed: 0, ..row.clone() };
        let mut first: BTreeMap<String, Row> = BTreeMap::new();
        let mut pairs = 0;
        for row in self.rows.iter().filter(|row| row.refused.is_none()) {
            let values = self.head.sets(&row.values).into_iter().flat_map(|(_, value)| [value, "\n".to_string()]);
            match first.entry(values.collect()) {
                Entry::Vacant(entry) => {
                    entry.insert(result(row));
                }
                Entry::Occupied(entry) if *entry.get() != result(row) => return false,
                Entry::Occupied(_) => pairs += 1,
            }
        }
        pairs > 0
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
        let mut data = json!({
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
        });
        if head.subject == Subject::Mission {
            data["ends"] = self.ends.iter().map(|(how, runs)| ((*how).to_string(), json!(runs))).collect();
            data["measures"] = self.measures.iter().map(|spread| self.spread(spread)).collect();
        }
        data
    }

    fn spread(&self, spread: &Spread) -> Json {
        let extreme = |at: usize| {
            spread.extremes.map(|extremes| {
                let (value, row) = extremes[at];
                let mut run = self.run(row);
                run.insert("value".to_string(), json!(value));
                run
            })
        };
        json!({
            "measure": spread.of.title,
            "unit": spread.of.unit.as_deref().filter(|unit| !unit.is_empty()),
            "of": spread.runs,
            "mean": spread.mean,
            "interval": spread.interval,
            "deviation": spread.deviation,
            "smallest": extreme(0),
            "largest": extreme(1),
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
