//! 3D replay: links as primitives with their poses over time, walls, control points and keep-out volumes.

use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Model, Shape, VisualGeometry};
use std::collections::BTreeSet;

use runtime::Program;
use runtime::record::series::SeriesRecorder;
use serde_json::{Value as Json, json};
use stdlib_tasks::bound::{Bound, Geometry};

use super::obstacles::obstacles;
use super::people::people;

/// Drawn links: all, in model order.
pub fn drawn_links(program: &Program) -> Vec<LinkId> {
    (0..program.robot.model.links.len()).map(|i| LinkId(i as u32)).collect()
}

pub(super) fn round(x: f64) -> f64 {
    (x * 1e5).round() / 1e5
}

pub(super) fn xyz(v: &Vector3<f64>) -> [f64; 3] {
    [round(v.x), round(v.y), round(v.z)]
}

pub(super) fn wxyz(p: &Isometry3<f64>) -> [f64; 4] {
    let r = p.rotation;
    [round(r.w), round(r.i), round(r.j), round(r.k)]
}

/// Data of the scene; `truth` is the program whose obstacles are where they truly were.
pub fn scene(program: &Program, truth: Option<&Program>, series: &SeriesRecorder) -> Json {
    let model = &program.robot.model;
    let links: Vec<Json> = series.links.iter().map(|&l| link(model, l)).collect();
    let data: Vec<f64> = series.poses.iter().flatten().map(|&x| round(x)).collect();
    json!({
        "up": "z",
        "links": links,
        "poses": { "stride": 7, "frames": series.times.len(), "times": series.times, "data": data },
        "planes": planes(program),
        "points": points(program).iter().map(|g| json!({ "name": g.name, "link": g.link.0, "xyz": xyz(&g.origin.translation.vector) })).collect::<Vec<_>>(),
        "keep_out": keep_out(program),
        "obstacles": obstacles(program, truth, series),
        "people": people(program, series),
        "targets": [],
        "traces": traces(program),
    })
}

fn link(model: &Model, id: LinkId) -> Json {
    let link = model.link_ref(id);
    let mut visuals: Vec<Json> = link
        .visual
        .iter()
        .filter_map(|v| {
            let mut shape = match &v.geometry {
                VisualGeometry::Box { size } => json!({ "type": "box", "size": size }),
                VisualGeometry::Cylinder { radius, length } => {
                    json!({ "type": "cylinder", "radius": radius, "length": length })
                }
                VisualGeometry::Capsule { radius, length } => {
                    json!({ "type": "capsule", "radius": radius, "length": length })
                }
                VisualGeometry::Sphere { radius } => json!({ "type": "sphere", "radius": radius }),
                VisualGeometry::Mesh { .. } => return None,
            };
            shape["xyz"] = json!(xyz(&v.origin.translation.vector));
            shape["wxyz"] = json!(wxyz(&v.origin));
            shape["color"] = json!(v.color);
            Some(shape)
        })
        .collect();
    if visuals.is_empty() {
        // A link whose visuals are meshes is drawn by its collision shapes.
        visuals = link.collision.iter().map(|c| placed(&c.shape, &c.origin)).collect();
    }
    json!({ "name": link.name, "visuals": visuals })
}

pub(super) fn placed(shape: &Shape, origin: &Isometry3<f64>) -> Json {
    let mut out = match *shape {
        Shape::Sphere { radius } => json!({ "type": "sphere", "radius": radius }),
        Shape::Capsule { radius, half_length } => {
            json!({ "type": "capsule", "radius": radius, "length": 2.0 * half_length })
        }
        Shape::Box { half } => json!({ "type": "box", "size": half.map(|h| 2.0 * h) }),
        Shape::Cylinder { radius, half_length } => {
            json!({ "type": "cylinder", "radius": radius, "length": 2.0 * half_length })
        }
        Shape::Hull(ref hull) => {
            let vertices: Vec<f64> = hull.corners().iter().flat_map(xyz).collect();
            let faces: Vec<u32> = hull.triangles().iter().flatten().copied().collect();
            json!({ "type": "mesh", "vertices": vertices, "faces": faces })
        }
    };
    out["xyz"] = json!(xyz(&origin.translation.vector));
    out["wxyz"] = json!(wxyz(origin));
    out["color"] = json!(null);
    out
}

/// Tasks of one type in the run's stacks, without duplicates.
fn tasks<'p>(program: &'p Program, kind: &'static str) -> impl Iterator<Item = &'p runtime::program::TaskProgram> {
    let stacks = program.run_stacks();
    let members = stacks.iter().flat_map(|&s| &program.stacks[s].levels).flat_map(|l| &l.members).map(|m| m.task);
    let tasks: BTreeSet<usize> = members.collect();
    tasks.into_iter().map(|t| &program.tasks[t]).filter(move |t| t.kind == kind)
}

fn numbers(program: &Program, bound: Option<&Bound>) -> Vec<f64> {
    match bound {
        Some(Bound::Value(s)) => program.values.initial.get(s.at..s.at + s.len).unwrap_or_default().to_vec(),
        _ => Vec::new(),
    }
}

fn planes(program: &Program) -> Vec<Json> {
    tasks(program, "virtual_wall")
        .filter(|t| !t.params.contains_key("on"))
        .filter_map(|t| {
            let p = numbers(program, t.params.get("through"));
            if p.len() != 9 {
                return None;
            }
            let at = |i: usize| Vector3::new(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
            let normal = (at(1) - at(0)).cross(&(at(2) - at(0))).try_normalize(1e-12)?;
            // The part of the plane near the robot is shown.
            let stands = program.robot.stands_at();
            let point = stands - normal * normal.dot(&(stands - at(0)));
            let distance = numbers(program, t.params.get("d_min")).first().copied().unwrap_or(0.0);
            Some(json!({ "name": t.name, "point": xyz(&point), "normal": xyz(&normal), "size": 2.0, "distance": distance }))
        })
        .collect()
}

fn geometries(bound: Option<&Bound>) -> &[Geometry] {
    match bound {
        Some(Bound::Geometries(list)) => list,
        _ => &[],
    }
}

fn is_point(g: &Geometry) -> bool {
    matches!(g.shape, Shape::Sphere { radius } if radius == 0.0)
}

/// Points in limits, without duplicates.
fn points(program: &Program) -> Vec<Geometry> {
    let walls = tasks(program, "virtual_wall").flat_map(|t| geometries(t.params.get("points")));
    let sides = tasks(program, "self_collision").flat_map(|t| geometries(t.params.get("between")));
    let mut out: Vec<Geometry> = Vec::new();
    for g in walls.chain(sides).filter(|g| is_point(g)) {
        if !out.contains(g) {
            out.push(g.clone());
        }
    }
    out
}

/// Far side of each collision task, expanded by its distance. Sides with more than two parts, and bodies without a
/// radius, are left out.
fn keep_out(program: &Program) -> Vec<Json> {
    let mut out = Vec::new();
    for t in tasks(program, "self_collision") {
        let parts = geometries(t.params.get("and"));
        let d = numbers(program, t.params.get("d_min")).first().copied().unwrap_or(0.0);
        if parts.len() > 2 {
            continue;
        }
        for g in parts {
            let (half, radius) = match g.shape {
                Shape::Sphere { radius } => (0.0, radius),
                Shape::Capsule { radius, half_length } => (half_length, radius),
                Shape::Box { .. } | Shape::Cylinder { .. } | Shape::Hull(_) => continue,
            };
            let end = |z: f64| xyz(&(g.origin * Point3::new(0.0, 0.0, z)).coords);
            out.push(
                json!({ "name": g.name, "link": g.link.0, "from": end(-half), "to": end(half), "radius": radius + d }),
            );
        }
    }
    out
}

/// Paths of the arms' tips, or of the last link if no arm is declared.
fn traces(program: &Program) -> Vec<Json> {
    let model = &program.robot.model;
    if program.robot.arms.is_empty() {
        let last = model.links.len().saturating_sub(1);
        return vec![json!({ "name": model.links[last].name, "link": last, "xyz": [0.0, 0.0, 0.0] })];
    }
    let one = |a: &stdlib_tasks::bound::Arm| json!({ "name": model.link_ref(a.tip).name, "link": a.tip.0, "xyz": [0.0, 0.0, 0.0] });
    program.robot.arms.iter().map(one).collect()
}
