//! Evaluation of a whole log: for every operation of a formula the series of its values, from the definitions.
//!
//! Bounded windows that the end of the log cuts off continue over ticks with unknown values. Every operation takes
//! linear time in the number of ticks: windows by [`super::wedge`], `until` by its rewriting to a window and a
//! recursion (Donzé, Ferrère, Maler, *Efficient robust monitoring for STL*, 2013).

use super::value::{Interval, Value};
use super::verdict::{Outcome, Sense};
use super::wedge::largest_ahead;
use crate::program::Window;
use crate::program::{Formula, Node, Unit};
use crate::program::{ProgramError, error};

/// One interval per tick.
type Series = Vec<Interval>;

/// Evaluates a formula on a log. `log` has a series of numbers for each signal, all of the same length; `units` are the
/// units of the signals.
///
/// # Errors
/// The formula does not pass [`Formula::check`], or the series differ in number or length.
pub fn evaluate(formula: &Formula, units: &[Unit], log: &[Vec<f64>]) -> Result<Outcome, ProgramError> {
    formula.check(units.len())?;
    let ticks = log.first().map_or(0, Vec::len);
    let same = log.len() == units.len() && log.iter().all(|s| s.len() == ticks);
    let Some(ticks) = u32::try_from(ticks).ok().filter(|_| same) else {
        return Err(error("log", "the series of the signals differ in number or length, or are too long"));
    };
    let value = |sense| at_the_start(formula, log, ticks, sense);
    let first_nan = |k: usize| log[k].iter().position(|x| x.is_nan());
    let undefined = formula.signals().into_iter().filter_map(first_nan).min();
    let undefined = undefined.and_then(|k| u32::try_from(k).ok());
    let antecedent = formula.antecedent().map(|f| at_the_start(&f, log, ticks, Sense::Truth));
    Ok(Outcome::new(value(Sense::Number), value(Sense::Truth), formula.unit(units), undefined, antecedent))
}

fn at_the_start(formula: &Formula, log: &[Vec<f64>], ticks: u32, sense: Sense) -> Interval {
    let mut all: Vec<Series> = Vec::with_capacity(formula.nodes.len());
    for node in &formula.nodes {
        let series = series(node, &all, log, ticks, sense, formula.period);
        all.push(series);
    }
    all.last().and_then(|root| root.first()).copied().unwrap_or(Interval::unknown(ticks))
}

/// Computes the series of an operation. `all` are the series of the operations before it.
fn series(node: &Node, all: &[Series], log: &[Vec<f64>], ticks: u32, sense: Sense, period: f64) -> Series {
    match node {
        Node::Predicate(k) => {
            let value = |(x, tick): (&f64, u32)| Interval::exact(Value::of_signal(*x, tick));
            let value = |x| if sense == Sense::Truth { value(x).truth() } else { value(x) };
            log[*k].iter().zip(0..ticks).map(value).collect()
        }
        Node::Not(a) => negated(&all[*a]),
        Node::And(list) => at_each_tick(ticks, |t| list.iter().map(|&a| all[a][t]).fold(Interval::TRUE, Interval::and)),
        Node::Or(list) => at_each_tick(ticks, |t| list.iter().map(|&a| all[a][t]).fold(Interval::FALSE, Interval::or)),
        Node::Implies([a, b]) => at_each_tick(ticks, |t| all[*a][t].negated().or(all[*b][t])),
        Node::Rise(a) => at_each_tick(ticks, |t| {
            let now = all[*a][t].truth();
            let rise = if t == 0 { now } else { now.and(all[*a][t - 1].truth().negated()) };
            // A value that held before would date the denial of the rise one tick too early.
            rise.known_from(t as u32)
        }),
        Node::Always(w, a) => negated(&eventually(*w, &negated(&all[*a]), ticks)),
        Node::Eventually(w, a) => eventually(*w, &all[*a], ticks),
        Node::Until(w, [a, b]) => until(*w, &all[*a], &all[*b], ticks),
        Node::Within(last, a) if sense == Sense::Truth => {
            eventually(Window { first: 0, last: Some(*last) }, &all[*a], ticks)
        }
        Node::Within(last, a) => within(*last, &all[*a], ticks, period),
    }
}

fn at_each_tick(ticks: u32, value: impl Fn(usize) -> Interval) -> Series {
    (0..ticks as usize).map(value).collect()
}

fn negated(series: &[Interval]) -> Series {
    series.iter().map(|x| x.negated()).collect()
}

/// Largest value in the window of every tick.
fn eventually(window: Window, series: &[Interval], ticks: u32) -> Series {
    let reach = window.last.map_or(ticks, |last| last - window.first) as usize;
    let end = |end: fn(&Interval) -> Value| largest_ahead(&series.iter().map(end).collect::<Vec<_>>(), reach);
    let (lower, upper) = (end(|x| x.lower), end(|x| x.upper));
    (0..ticks)
        .map(|t| {
            let from = t.saturating_add(window.first) as usize;
            let seen = match (lower.get(from), upper.get(from)) {
                (Some(&lower), Some(&upper)) => Interval { lower, upper },
                _ => Interval::FALSE,
            };
            if window.is_cut(t, ticks) { seen.or(Interval::unknown(ticks)) } else { seen }
        })
        .collect()
}

/// Series of `hold` until `goal` in a window, rewritten as a conjunction: `goal` holds somewhere in the window, `hold`
/// holds until the window begins, and from there the unbounded `hold` until `goal` holds.
fn until(window: Window, hold: &[Interval], goal: &[Interval], ticks: u32) -> Series {
    let mut open: Series = Vec::with_capacity(goal.len());
    // Backwards in time. After the end, a bounded window has unknown values, and an unbounded one has none.
    let mut next = if window.last.is_some() { Interval::unknown(ticks) } else { Interval::FALSE };
    for (h, g) in hold.iter().zip(goal).rev() {
        next = g.or(h.and(next));
        open.push(next);
    }
    open.reverse();
    let goal = eventually(window, goal, ticks);
    let before = (window.first > 0).then(|| {
        let window = Window { first: 0, last: Some(window.first - 1) };
        negated(&eventually(window, &negated(hold), ticks))
    });
    (0..ticks as usize)
        .map(|t| {
            let from = t.saturating_add(window.first as usize);
            let open = open.get(from).copied().unwrap_or(Interval::unknown(ticks));
            let before = before.as_ref().map_or(Interval::TRUE, |b| b[t]);
            goal[t].and(open).and(before)
        })
        .collect()
}

/// Deadline minus the first tick at which the operand holds, in s: for the upper end the first tick at which it may
/// hold, for the lower end the first at which it surely does.
fn within(last: u32, series: &[Interval], ticks: u32, period: f64) -> Series {
    let mut out: Series = Vec::with_capacity(series.len());
    let (mut surely, mut perhaps) = (None, ticks);
    for (t, x) in (0..ticks).zip(series).rev() {
        if x.lower.is_true() {
            surely = Some(t);
        }
        if x.upper.is_true() {
            perhaps = t;
        }
        out.push(slack(u64::from(t) + u64::from(last), surely, perhaps, ticks, period));
    }
    out.reverse();
    out
}

/// Time that is left to a deadline, in s. `surely` is the first tick at which it is met for sure, `perhaps` the first
/// at which it may be, or `ticks` if only the ticks after the end can meet it.
fn slack(deadline: u64, surely: Option<u32>, perhaps: u32, ticks: u32, period: f64) -> Interval {
    let at = |met: u32| {
        let robustness = (deadline as f64 - f64::from(met)) * period;
        Value::new(robustness, met.min(ticks.saturating_sub(1)))
    };
    let never = Value::new(f64::NEG_INFINITY, ticks.saturating_sub(1));
    Interval { lower: surely.map_or(never, at), upper: at(perhaps) }
}
