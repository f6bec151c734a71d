//! `hierarq robot SPEC`

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use compiler::{RobotFacts, robot_facts};
use hierarq::project;
use runtime::text::number;
use serde_json::{Value, json};

use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// A spec with a robot.
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Print the facts, or the diagnostics, as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, a.json);
    }
    let Some(program) = &compiled.program else {
        return Err(format!("{} has no robot of its own: it declares missions alone", a.spec.display()));
    };
    let facts = robot_facts(program, compiled.srdf.as_ref());
    if a.json {
        output::data(&format!("{:#}\n", data(&facts)));
        return Ok(Outcome::Good);
    }
    output::show(&compiled.report);
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = write!(out, "robot {}  urdf {}", program.robot.name, program.robot.urdf);
    if compiled.srdf.is_none() {
        out.push_str("  (no srdf)");
    }
    out.push('\n');
    let _ = text(&facts, &mut out);
    output::data(&out);
    Ok(Outcome::Good)
}

fn text(facts: &RobotFacts, out: &mut String) -> std::fmt::Result {
    if !facts.groups.is_empty() {
        writeln!(out, "\ngroups")?;
    }
    for group in &facts.groups {
        let tip = group.tip.as_ref().map(|tip| format!("  (arm, tip {tip})")).unwrap_or_default();
        writeln!(out, "  {}: {}{tip}", group.name, words(&group.joints))?;
        writeln!(out, "    links {}", words(&group.links))?;
    }
    if !facts.postures.is_empty() {
        writeln!(out, "\npostures")?;
    }
    for posture in &facts.postures {
        let at: Vec<String> = posture.positions.iter().map(|(joint, x)| format!("{joint} {}", number(*x))).collect();
        writeln!(out, "  {} of {}: {}", posture.name, posture.group, words(&at))?;
    }
    for [tool, link] in &facts.end_effectors {
        writeln!(out, "\nend effector {tool} on {link}")?;
    }
    if !facts.passive.is_empty() {
        writeln!(out, "\npassive joints, held still: {}", words(&facts.passive))?;
    }
    if !facts.disabled.is_empty() {
        writeln!(out, "\npairs of links that the SRDF disables, without neighbours")?;
    }
    for pair in &facts.disabled {
        let [a, b] = &pair.links;
        let reason = if pair.reason.is_empty() { "without a reason" } else { &pair.reason };
        let touches = if pair.at_home <= 0.0 { ", touches at home" } else { "" };
        writeln!(out, "  {a} to {b}: {reason}{touches}")?;
    }
    if !facts.touching.is_empty() {
        writeln!(out, "\npairs of links that touch at home and at every sampled posture")?;
    }
    for [a, b] in &facts.touching {
        writeln!(out, "  {a} to {b}")?;
    }
    writeln!(
        out,
        "\n`self_collision {{ between all }}` keeps {} pairs of links apart, with {} rows",
        facts.open, facts.rows
    )
}

fn words(all: &[String]) -> String {
    if all.is_empty() { "none".to_string() } else { all.join(", ") }
}

fn data(facts: &RobotFacts) -> Value {
    let groups = facts
        .groups
        .iter()
        .map(|g| json!({ "name": g.name, "joints": g.joints, "links": g.links, "tip": g.tip }))
        .collect::<Vec<_>>();
    let postures = facts
        .postures
        .iter()
        .map(|p| json!({ "name": p.name, "group": p.group, "positions": p.positions }))
        .collect::<Vec<_>>();
    let disabled = facts
        .disabled
        .iter()
        .map(|p| json!({ "links": p.links, "reason": p.reason, "distance_at_home": p.at_home }))
        .collect::<Vec<_>>();
    json!({
        "groups": groups,
        "postures": postures,
        "end_effectors": facts.end_effectors,
        "passive_joints": facts.passive,
        "disabled_pairs": disabled,
        "always_touching_pairs": facts.touching,
        "open_pairs": facts.open,
        "rows": facts.rows,
    })
}
