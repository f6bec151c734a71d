//! `hierarq robot SPEC`

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use compiler::{MeshFacts, RobotFacts, ShapeFacts, mesh_facts, robot_facts};
use hierarq::project;
use robot::ShapeKind;
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
    let meshes = mesh_facts(&compiled.meshes);
    if a.json {
        output::data(&format!("{:#}\n", data(&facts, &meshes)));
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
    let _ = mesh_text(&meshes, &mut out);
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

/// Meshes, with a line for each kind of shapes that can stand for them.
fn mesh_text(meshes: &[MeshFacts], out: &mut String) -> std::fmt::Result {
    if !meshes.is_empty() {
        writeln!(out, "\nmeshes, and how far shapes exceed them")?;
    }
    for mesh in meshes {
        let open = if mesh.volume.is_none() { " (open)" } else { "" };
        writeln!(out, "  {}: {}{open}", mesh.link, mesh.file)?;
        match &mesh.shapes {
            Err(why) => writeln!(out, "    not known: {why}")?,
            Ok(shapes) => {
                for shape in shapes {
                    let by = volume_share(mesh, shape).map(|x| format!(", {:+.1} % of the volume", 100.0 * x));
                    let is_used = if shape.kind == mesh.kind { "  (used)" } else { "" };
                    // Rounded up, as it is a bound.
                    let distance = (1e4 * shape.excess.distance).ceil() / 10.0;
                    writeln!(out, "    {}: up to {distance:.1} mm{}{is_used}", named(shape), by.unwrap_or_default())?;
                }
            }
        }
    }
    Ok(())
}

/// Volume of shapes beyond that of their mesh, relative to it; `None` for an open or flat one.
fn volume_share(mesh: &MeshFacts, shape: &ShapeFacts) -> Option<f64> {
    mesh.volume.filter(|volume| *volume > 0.0).map(|volume| shape.excess.volume / volume - 1.0)
}

fn named(shape: &ShapeFacts) -> String {
    match (shape.kind, shape.count) {
        (ShapeKind::Capsules, _) => "capsule".to_string(),
        (ShapeKind::Hulls, _) => "hull".to_string(),
        (ShapeKind::Pieces, 1) => "1 piece".to_string(),
        (ShapeKind::Pieces, n) => format!("{n} pieces"),
    }
}

fn words(all: &[String]) -> String {
    if all.is_empty() { "none".to_string() } else { all.join(", ") }
}

fn mesh_data(mesh: &MeshFacts) -> Value {
    let kind = |kind: ShapeKind| match kind {
        ShapeKind::Capsules => "capsules",
        ShapeKind::Hulls => "hulls",
        ShapeKind::Pieces => "pieces",
    };
    let shape = |s: &ShapeFacts| {
        json!({
            "kind": kind(s.kind),
            "count": s.count,
            "excess_m": s.excess.distance,
            "volume_m3": s.excess.volume,
        })
    };
    let shapes = mesh.shapes.as_ref().map(|all| all.iter().map(shape).collect::<Vec<_>>());
    json!({
        "link": mesh.link,
        "file": mesh.file,
        "used": kind(mesh.kind),
        "volume_m3": mesh.volume,
        "shapes": shapes.as_ref().ok(),
        "error": shapes.as_ref().err(),
    })
}

fn data(facts: &RobotFacts, meshes: &[MeshFacts]) -> Value {
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
        "meshes": meshes.iter().map(mesh_data).collect::<Vec<_>>(),
    })
}
