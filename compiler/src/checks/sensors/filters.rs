//! Warns of filters that lag far behind what they are to show: the velocity of a walking person, or a contact.
//!
//! A first-order low-pass with the cutoff f has the time constant `1/(2π f)`. A person who walks at 1.6 m/s is further by
//! the speed times this time than the estimated velocity has noticed.

use std::f64::consts::TAU;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Program, SignalProgram, Velocity};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{LENGTH, TIME};
use stdlib_tasks::task::RowKind;

use crate::analysis::value_ranges::Ranges;
use crate::checks::people::WALKING;
use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, readings};
use crate::units::shown;

/// Shortest way (m) of a person within the time constant that is reported, whatever distance is kept.
const SHORT_WAY: f64 = 0.2;

/// Way (m) that is reported where no constant distance is kept.
const LONG_WAY: f64 = 0.8;

/// Longest usual time constant (s) of a force that the motion reacts to: a tool goes on by 6 cm at 0.25 m/s.
const SLOW: f64 = 0.25;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    people(c, out);
    wrenches(c, out);
}

/// Filters of the velocities of people.
fn people(c: &Checked, out: &mut Vec<Diagnostic>) {
    for human in &c.program.interface.humans {
        let cutoff = readings::points(c.program, human).find_map(|s| match s.motion?.velocity {
            Velocity::Estimated(cutoff) => Some(cutoff),
            _ => None,
        });
        let written = readings::human(c.expanded, &human.name).and_then(|h| h.body.get("cutoff"));
        let (Some(cutoff), Some(written)) = (cutoff, written) else { continue };
        let lag = 1.0 / (TAU * cutoff);
        let way = WALKING * lag;
        let speed = |s: &SignalProgram| s.velocity_at()..s.velocity_at() + 3;
        let speeds: Vec<usize> = readings::points(c.program, human).flat_map(speed).collect();
        let uses = |task: &usize| uses_speed(c.program, *task, &speeds);
        let Some(task) = in_stacks(c.program).into_iter().find(uses) else { continue };
        let kept = kept(c, task);
        if way <= kept.map_or(LONG_WAY, |d| d.max(SHORT_WAY)) {
            continue;
        }
        let t = &c.program.tasks[task];
        let distance =
            kept.map_or(String::new(), |d| format!(", and `{}` keeps {}", t.name, shown(rounded(d), LENGTH)));
        out.push(
            Diagnostic::warning(
                "HQ0543",
                readings::entry(written),
                format!("the velocity of `{}` lags by {}", human.name, shown(rounded(lag), TIME)),
            )
            .here(format!("a time constant of {}", shown(rounded(lag), TIME)))
            .label(c.places.tasks[task].span, format!("`{}` relies on it", t.name))
            .note(format!("a person who walks at 1.6 m/s goes {} in that time{distance}", shown(rounded(way), LENGTH)))
            .help(Help::with("write for instance {}, which lags by 32 ms", [Snippet::entry("cutoff", "5 Hz")])),
        );
    }
}

/// True if a limit reads the velocity of one of these points.
fn uses_speed(program: &Program, task: usize, speeds: &[usize]) -> bool {
    let t = &program.tasks[task];
    let Some(how) = stdlib_tasks::find(&t.kind).and_then(|k| k.person_velocity) else { return false };
    let reads = |bound: &Bound| readings::numbers(program, bound).iter().any(|n| speeds.contains(n));
    t.params.iter().any(|(name, bound)| (how.uses_rate)(name, &t.params) && reads(bound))
}

/// Smallest distance (m) that a task keeps; `None` if it has none that is known.
fn kept(c: &Checked, task: usize) -> Option<f64> {
    let min = c.places.tasks[task].operands.get("min").filter(|min| min.dimension == LENGTH)?;
    let low = Ranges::new(c.context, &min.nodes, &std::collections::BTreeMap::new()).at(*min.nodes.first()?).low;
    let signals = || readings::of_nodes(c, &min.nodes);
    // A distance that grows with an uncertainty is at least its constant part.
    match low.is_finite() {
        true => Some(low),
        false if signals().is_empty() => None,
        false => constant_part(c, *min.nodes.first()?),
    }
}

/// Constant summand of a sum.
fn constant_part(c: &Checked, node: usize) -> Option<f64> {
    use runtime::program::Op;
    let graph = c.context.graph;
    match graph.ops()[node] {
        Op::Const(x) => Some(x),
        Op::Add(a, b) => graph.constant(a).or_else(|| graph.constant(b)),
        _ => None,
    }
}

/// Filters of wrenches that a condition or a target reads.
fn wrenches(c: &Checked, out: &mut Vec<Diagnostic>) {
    let conditions = readings::of_conditions(c);
    for (i, s) in c.program.interface.signals.iter().enumerate() {
        let Some(cutoff) = s.conditioning.low_pass.filter(|_| s.kind == "wrench") else { continue };
        let constant = 1.0 / (TAU * cutoff);
        if constant <= SLOW {
            continue;
        }
        let declared = readings::signal(c.expanded, &s.name).and_then(|d| d.settings.get("low_pass"));
        let Some(written) = declared else { continue };
        let follows = |task: &usize| {
            let t = &c.program.tasks[*task];
            let target = stdlib_tasks::find(&t.kind).is_some_and(|k| k.row_kind == RowKind::Equality);
            target && t.params.values().any(|b| readings::signals(c.program, b).contains(&i))
        };
        let user = match in_stacks(c.program).into_iter().find(follows) {
            Some(task) => format!("`{}` yields to it", c.program.tasks[task].name),
            None if (s.at + 1..=s.at + s.len).any(|n| conditions.contains(&n)) => {
                "a condition waits for it".to_string()
            }
            None => continue,
        };
        out.push(
            Diagnostic::warning(
                "HQ0543",
                readings::entry(written),
                format!("the force of `{}` lags by {}, and {user}", s.name, shown(rounded(constant), TIME)),
            )
            .here(format!("a time constant of {}", shown(rounded(constant), TIME)))
            .note("a contact is noticed about this time after it happened, and until then the motion goes on")
            .help(Help::with(
                "write for instance {}; a filter of a sensor of forces is fast, and the noise that it leaves is below the threshold",
                [Snippet::entry("low_pass", "20 Hz")],
            )),
        );
    }
}

/// Two digits of a number.
fn rounded(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}
