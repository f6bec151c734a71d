//! Figures of `hierarq check --deep`: what the sampled postures showed.

use std::io::IsTerminal;

use compiler::{Contacts, Freedom, Sampled, SampledStack};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use super::table::wide_table;

/// Bar of the postures that have been examined, if somebody can see it.
pub fn bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    let style =
        ProgressStyle::with_template("  {bar:40.cyan/black} {percent:>3} %  {pos} of {len} postures, {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

/// Returns the figures for people.
pub fn text(sampled: &Sampled, postures: usize) -> String {
    let mut table =
        wide_table(&["stack", "inside all hard limits", "a hard level cannot be met", "freedom of the levels"]);
    for s in &sampled.stacks {
        if s.needs_signals {
            table.add_row([s.name.as_str(), "not sampled: needs signals", "", ""]);
            continue;
        }
        let freedom: Vec<String> = s.freedom.iter().map(freedom).collect();
        table.add_row([
            s.name.clone(),
            format!("{} of {postures}", s.inside),
            s.infeasible.to_string(),
            freedom.join(", "),
        ]);
    }
    let touching = match sampled.contacts.as_ref().map(|c| c.unguarded) {
        None => "The links have no collision shapes.".to_string(),
        Some(0) => "No links touch that no limit keeps apart.".to_string(),
        Some(1) => "1 pair of links touches at some postures, and no limit keeps it apart.".to_string(),
        Some(n) => format!("{n} pairs of links touch at some postures, and no limit keeps them apart."),
    };
    let contacts = sampled.contacts.as_ref().map(contacts).unwrap_or_default();
    format!("{postures} postures, seed {}:\n{table}\n{touching}\n{contacts}", sampled.seed)
}

/// Pairs that touch, and are left out of the warning.
fn contacts(of: &Contacts) -> String {
    let mut out = match of.disabled {
        0 => String::new(),
        1 => "1 pair that touches at some postures is disabled in the SRDF.\n".to_string(),
        n => format!("{n} pairs that touch at some postures are disabled in the SRDF.\n"),
    };
    if !of.always.is_empty() {
        let pairs: Vec<String> = of.always.iter().map(|[a, b]| format!("{a} to {b}")).collect();
        let touch = if pairs.len() == 1 { "touches" } else { "touch" };
        out += &format!("By how the shapes are drawn, {touch} at home or nearly everywhere: {}.\n", pairs.join(", "));
    }
    out
}

/// Freedom of a level: one number, or least, median and most.
fn freedom(of: &Freedom) -> String {
    match (of.quantile(0.0), of.quantile(0.5), of.quantile(1.0)) {
        (Some(least), Some(_), Some(most)) if least == most => format!("{} {most}", of.level),
        (Some(least), Some(median), Some(most)) => format!("{} {least} to {most} (median {median})", of.level),
        _ => format!("{} -", of.level),
    }
}

/// Returns the figures as data.
pub fn data(sampled: &Sampled, postures: usize) -> Value {
    let stack = |s: &SampledStack| {
        let freedom = |f: &Freedom| json!({ "level": f.level, "postures_by_freedom": f.counts });
        json!({
            "stack": s.name,
            "needs_signals": s.needs_signals,
            "inside": s.inside,
            "infeasible": s.infeasible,
            "freedom": s.freedom.iter().map(freedom).collect::<Vec<_>>(),
        })
    };
    json!({
        "postures": postures,
        "seed": sampled.seed,
        "stacks": sampled.stacks.iter().map(stack).collect::<Vec<_>>(),
        "unguarded_pairs": sampled.contacts.as_ref().map(|c| c.unguarded),
        "disabled_pairs": sampled.contacts.as_ref().map(|c| c.disabled),
        "always_touching_pairs": sampled.contacts.as_ref().map(|c| c.always.as_slice()),
    })
}
