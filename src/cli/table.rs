//! Tables at the end of a run.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use hierarq::report::roughness;
use runtime::expect::Verdict;
use runtime::quantity::quantity;
use runtime::record::expectations::ExpectationRecord;
use runtime::record::summary::{LevelSummary, MANY_FAULTS, MARGIN_TOLERANCE, Summary, TaskSummary};
use runtime::record::verify::{DIFFERENT, UNPROVEN, Verification};

/// Formats a margin; values within the tolerance are shown as zero.
pub(super) fn margin(x: f64, unit: &str) -> String {
    quantity(if x.abs() < MARGIN_TOLERANCE { 0.0 } else { x }, unit)
}

/// Returns a share of the ticks in words.
fn of_the_time(x: f64) -> String {
    if x >= 0.9995 { "all the time".to_string() } else { format!("{} of the time", share(x)) }
}

fn share(x: f64) -> String {
    if x == 0.0 {
        "never".to_string()
    } else if x < 0.0005 {
        "< 0.1 %".to_string()
    } else if x >= 0.9995 {
        "always".to_string()
    } else {
        format!("{:.1} %", 100.0 * x)
    }
}

fn new_table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY).set_header(header.to_vec());
    table
}

/// Creates a table no wider than the terminal.
pub(super) fn wide_table(header: &[&str]) -> Table {
    let mut table = new_table(header);
    let width = u16::try_from(super::output::width()).unwrap_or(100);
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
    table
}

/// Returns the table of tasks, in the order of their levels.
pub fn tasks(summary: &Summary, order: &[String]) -> String {
    let mut table = new_table(&["level", "task", "closest / largest error", "at", "at the end", "active"]);
    for name in order {
        let Some(t) = summary.tasks.get(name) else { continue };
        for (i, row) in rows(t).into_iter().enumerate() {
            let (level, task) = if i == 0 { (t.level.clone(), name.clone()) } else { (String::new(), String::new()) };
            table.add_row([level, task, row.0, row.1, row.2, row.3]);
        }
    }
    for i in 2..6 {
        if let Some(c) = table.column_mut(i) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{table}\n")
}

fn rows(t: &TaskSummary) -> Vec<(String, String, String, String)> {
    let at = |s: f64| format!("{s:.2} s");
    let note = if t.undefined_ticks > 0 { format!("undefined on {} ticks", t.undefined_ticks) } else { String::new() };
    if let Some(m) = t.min_margin {
        let unit = t.min_margin_unit.as_deref().unwrap_or(&t.unit);
        let row = t.min_margin_row.as_deref().map(|r| format!("  {r}")).unwrap_or_default();
        // Rows of several units have no common final value.
        let last = t.final_margin.filter(|_| unit == t.unit).map(|x| margin(x, unit)).unwrap_or_default();
        return vec![(
            format!("{}{row}", margin(m, unit)),
            at(t.at_s),
            last,
            t.active_share.map(share).unwrap_or_default(),
        )];
    }
    if t.errors.is_empty() {
        let value = |x: Option<f64>| x.map(|x| quantity(x, &t.unit)).unwrap_or_default();
        return vec![(value(t.max_error), at(t.at_s), value(t.final_error), note)];
    }
    (t.errors.iter().enumerate())
        .map(|(i, (part, e))| {
            let note = if i == 0 { note.clone() } else { String::new() };
            (format!("{}  {part}", quantity(e.max, &e.unit)), at(e.at_s), quantity(e.last, &e.unit), note)
        })
        .collect()
}

/// Returns the states of a machine in a few lines, with the number of times each was entered; only the end of a long
/// list.
pub fn states(summary: &Summary) -> String {
    const SHOWN: usize = 24;
    const COUNTED: usize = 12;
    let hidden = summary.states.len().saturating_sub(SHOWN);
    let mut lines = String::new();
    if hidden > 0 {
        lines += &format!("{hidden} earlier states, in summary.json\n");
    }
    for s in &summary.states[hidden..] {
        let again = if s.entries > 1 { format!("  entered {} times", s.entries) } else { String::new() };
        lines += &format!("{:>9.2} s  {}{again}\n", s.from_s, s.state);
    }
    let mut all: Vec<(&String, u64)> = summary.entries.iter().map(|(state, n)| (state, *n)).collect();
    all.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let counts: Vec<String> = all.iter().take(COUNTED).map(|(state, n)| format!("{state} {n}")).collect();
    let more = if all.len() > COUNTED { format!(", {} others", all.len() - COUNTED) } else { String::new() };
    if !counts.is_empty() {
        lines += &format!("entries: {}{more}\n", counts.join(", "));
    }
    lines
}

/// Returns the faults that the machine handled.
pub fn answered(summary: &Summary) -> String {
    let mut all = summary.faults.iter().filter(|f| f.answered);
    let shown = all.by_ref().take(MANY_FAULTS);
    let text: String =
        shown.map(|f| format!("fault at {:.2} s, handled by the machine: {}\n", f.time, f.text)).collect();
    match all.count() {
        0 => text,
        more => format!("{text}and {more} more, in summary.json\n"),
    }
}

/// Returns the table of levels, in descending order of priority.
pub fn levels(summary: &Summary) -> String {
    let mut table = new_table(&["level", "rows", "at a bound", "could not be met in full", "freedom left, at least"]);
    for LevelSummary { stack, name, hard, rows, saturated_share, relaxed_share, min_freedom, .. } in &summary.levels {
        let name = stack.as_ref().map_or_else(|| name.clone(), |s| format!("{s}: {name}"));
        let name = if *hard { format!("{name} (hard)") } else { name };
        table.add_row([
            name,
            rows.to_string(),
            share(*saturated_share),
            share(*relaxed_share),
            min_freedom.to_string(),
        ]);
    }
    for i in 1..5 {
        if let Some(c) = table.column_mut(i) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{table}\n")
}

/// Returns the table of joints that jumped or reversed; empty if none did.
pub fn joints(summary: &Summary) -> String {
    const SHOWN: usize = 12;
    let rough = roughness::rough(&summary.joints);
    if rough.is_empty() {
        return String::new();
    }
    let mut table =
        new_table(&["joint", "largest acceleration", "at", "reversals", "first at", "velocity jumps", "first at"]);
    let at = |s: Option<f64>| s.map(|s| format!("{s:.2} s")).unwrap_or_default();
    for (name, j) in rough.iter().take(SHOWN) {
        table.add_row([
            name.to_string(),
            quantity(j.max_acceleration, &j.unit),
            at(Some(j.at_s)),
            j.reversals.to_string(),
            at(j.first_reversal_s),
            j.jumps.to_string(),
            at(j.first_jump_s),
        ]);
    }
    for i in 1..7 {
        if let Some(c) = table.column_mut(i) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    let more = match rough.len().saturating_sub(SHOWN) {
        0 => String::new(),
        n => format!("and {n} more, in summary.json\n"),
    };
    format!("{table}\n{more}")
}

/// Returns advice on joints that jumped or reversed.
pub fn rough(summary: &Summary) -> String {
    roughness::advice(&summary.joints).map(|advice| format!("warning: {advice}\n")).unwrap_or_default()
}

/// Returns the limits that restricted levels, with the level, for the largest shares of the time.
pub fn held_back(summary: &Summary) -> String {
    const SHOWN: usize = 6;
    let mut lines = String::new();
    for h in summary.held_back.iter().take(SHOWN) {
        lines += &format!("`{}` was limited by `{}`, {}: {}\n", h.level, h.by_task, h.by_row, of_the_time(h.share));
    }
    let more = summary.held_back.len().saturating_sub(SHOWN);
    if more > 0 {
        lines += &format!("and {more} more, in summary.json\n");
    }
    lines
}

/// Returns the result of the verification with the second solver, as one line.
pub fn verification(v: &Verification) -> String {
    let failed = if v.failed == 0 { String::new() } else { format!("; {} without a solution", v.failed) };
    format!(
        "solved again by {}: {} ticks{failed}, largest difference {:.1e} at {:.2} s{}; optimality of the run's own solutions: {}\n",
        v.backend,
        v.ticks,
        v.max_difference,
        v.at_s,
        if v.different > 0 {
            format!(
                " ({} ticks differ by more than {DIFFERENT:.0e}, with residuals of {} of up to {:.1e})",
                v.different, v.backend, v.other_certificate
            )
        } else {
            String::new()
        },
        if v.max_certificate > UNPROVEN {
            format!("NOT PROVEN, residual {:.1e}", v.max_certificate)
        } else {
            format!("proven, residual at most {:.1e}", v.max_certificate)
        }
    )
}

/// Returns advice on violated limits.
pub fn hints(summary: &Summary) -> String {
    summary.hints.iter().map(|h| format!("hint: {h}\n")).collect()
}

/// Returns the cells of an expectation: verdict, margin, instant.
pub fn expectation(e: &ExpectationRecord) -> [String; 3] {
    let verdict = match e.verdict {
        Verdict::Holds => "holds",
        Verdict::Fails => "FAILS",
        Verdict::Undecided => "UNDECIDED",
    };
    let unit = e.unit.as_deref().unwrap_or_default();
    let size = e.margin.map_or_else(|| "-".to_string(), |m| margin(m, unit));
    let at = e.worst_s.map_or_else(|| "-".to_string(), |s| format!("{s:.2} s"));
    [verdict.to_string(), size, at]
}

/// Returns the title of an expectation; if it did not hold, with the instant from which an expression was undefined, or that
/// the run was too short.
pub fn expected(e: &ExpectationRecord) -> String {
    match e.undefined_s.filter(|_| e.verdict != Verdict::Holds) {
        Some(s) => format!("{} (an operand has no value at {s:.2} s and counts as false)", e.title()),
        None if e.verdict == Verdict::Undecided => format!("{} (the run ends before it is decided)", e.title()),
        None if e.untested => format!("{} (never put to the test: its condition was never true)", e.title()),
        None => e.title().to_string(),
    }
}

/// Returns the table of the expectations of a run; empty without any. `good` is true if all results are as expected.
pub fn expectations(all: &[ExpectationRecord], good: bool) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut table = wide_table(&["expectation", "verdict", "margin", "at"]);
    for e in all {
        let [verdict, margin, at] = expectation(e);
        table.add_row([expected(e), verdict, margin, at]);
    }
    format!("{table}\n{}\n", if good { "as expected" } else { "NOT as expected" })
}
