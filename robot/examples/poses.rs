//! Link poses of a URDF as JSON, for a comparison with another program:
//! `poses URDF [--base NAME] [--package-path DIR] [--random N] [--seed S] [NAME=POSITION ..]`.
//!
//! With `NAME=POSITION` the joints stand there and all others at the neutral configuration; with
//! `--random N` there are N random configurations inside the limits. Each configuration lists the
//! position of every joint that is not fixed (followers and locked ones too), the pose of the
//! base, and for every link its position \[m\] and its rotation matrix by rows, in the world.
#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use hierarq_robot::{Base, Data, Drive, JointId, LinkId, Model, Options, UrdfMessage};
use serde::Serialize;

/// The order from the command line.
struct Order {
    urdf: PathBuf,
    base: Base,
    package_paths: Vec<PathBuf>,
    random: usize,
    seed: u64,
    positions: Vec<(String, f64)>,
}

#[derive(Serialize)]
struct Report<'m> {
    name: &'m str,
    base: Base,
    links: usize,
    joints: usize,
    /// Names of the degrees of freedom, in the order of `v`.
    dofs: Vec<&'m str>,
    mimics: Vec<&'m str>,
    /// Joints whose limits leave one position.
    immovable: Vec<&'m str>,
    shapes: usize,
    visuals: usize,
    /// Number of warnings of each kind.
    warnings: BTreeMap<&'static str, usize>,
    configurations: Vec<Configuration<'m>>,
}

#[derive(Serialize)]
struct Configuration<'m> {
    q: Vec<f64>,
    joints: BTreeMap<&'m str, f64>,
    links: BTreeMap<&'m str, Pose>,
}

#[derive(Serialize)]
struct Pose {
    p: [f64; 3],
    #[serde(rename = "R")]
    rotation: [[f64; 3]; 3],
}

fn main() -> ExitCode {
    match order(std::env::args().skip(1)).and_then(|order| report(&order)) {
        Ok(json) => {
            println!("{json}");
            ExitCode::SUCCESS
        }
        Err(text) => {
            eprintln!("{text}");
            ExitCode::FAILURE
        }
    }
}

fn order(mut words: impl Iterator<Item = String>) -> Result<Order, String> {
    let mut order = Order {
        urdf: PathBuf::new(),
        base: Base::Fixed,
        package_paths: Vec::new(),
        random: 0,
        seed: 1,
        positions: Vec::new(),
    };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("`{word}` needs a value"));
        match word.as_str() {
            "--base" => {
                order.base = match value()?.as_str() {
                    "fixed" => Base::Fixed,
                    "planar" => Base::Planar,
                    "unicycle" => Base::Unicycle,
                    "floating" => Base::Floating,
                    other => return Err(format!("there is no base `{other}`")),
                }
            }
            "--package-path" => order.package_paths.push(value()?.into()),
            "--random" => order.random = value()?.parse().map_err(|_| "`--random` needs a count")?,
            "--seed" => order.seed = value()?.parse().map_err(|_| "`--seed` needs a number")?,
            _ => match word.split_once('=') {
                Some((name, x)) => {
                    let x = x.parse().map_err(|_| format!("`{x}` is no number"))?;
                    order.positions.push((name.to_owned(), x));
                }
                None => order.urdf = word.into(),
            },
        }
    }
    Ok(order)
}

fn report(order: &Order) -> Result<String, String> {
    let text = std::fs::read_to_string(&order.urdf).map_err(|e| format!("{}: {e}", order.urdf.display()))?;
    let options = Options {
        base: order.base,
        urdf_dir: order.urdf.parent().map(Path::to_path_buf),
        package_paths: order.package_paths.clone(),
        read_meshes: !order.package_paths.is_empty(),
        ..Options::default()
    };
    let (model, warnings) = Model::from_urdf(&text, &options).map_err(|errors| listed(&text, &errors))?;
    let named = |wanted: fn(&Drive) -> bool| {
        model.joints.iter().filter(|j| wanted(&j.drive)).map(|j| j.name.as_str()).collect::<Vec<_>>()
    };
    let mut counts = BTreeMap::new();
    for warning in &warnings {
        *counts.entry(warning.code.as_str()).or_insert(0) += 1;
    }
    let report = Report {
        name: &model.name,
        base: model.root_base(),
        links: model.links.len(),
        joints: model.joints.len(),
        dofs: model.dofs.iter().map(|d| d.name.as_str()).collect(),
        mimics: named(|d| matches!(d, Drive::Mimic { .. })),
        immovable: named(|d| matches!(d, Drive::Locked(_))),
        shapes: model.links.iter().map(|l| l.collision.len()).sum(),
        visuals: model.links.iter().map(|l| l.visual.len()).sum(),
        warnings: counts,
        configurations: wanted(order, &model)?.into_iter().map(|q| pose(&model, q)).collect(),
    };
    serde_json::to_string(&report).map_err(|e| e.to_string())
}

fn listed(text: &str, errors: &[UrdfMessage]) -> String {
    let line = |m: &UrdfMessage| format!("{}:{}: {m}", m.line_column(text).0, m.code);
    errors.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The configurations that were asked for; the neutral one with the given positions comes first
/// unless only random ones were wanted.
fn wanted(order: &Order, model: &Model) -> Result<Vec<Vec<f64>>, String> {
    let mut all = Vec::new();
    if order.random == 0 || !order.positions.is_empty() {
        let mut q = model.neutral();
        for (name, x) in &order.positions {
            let found = model.dof(name).and_then(|d| model.dofs[d].q_index);
            q[found.ok_or(format!("no joint `{name}` to set"))?] = *x;
        }
        all.push(q);
    }
    // xorshift64*: Vigna, An experimental exploration of Marsaglia's xorshift generators (2016).
    let mut state = order.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut rng = || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    };
    all.extend((0..order.random).map(|_| model.random_configuration(&mut rng)));
    Ok(all)
}

fn pose(model: &Model, q: Vec<f64>) -> Configuration<'_> {
    let mut data = Data::new(model);
    model.forward(&q, &mut data);
    let moving = (0..model.joints.len() as u32).map(JointId).filter(|j| model.joint_ref(*j).drive != Drive::Fixed);
    let joints = moving.map(|j| (model.joint_ref(j).name.as_str(), model.joint_position(j, &q))).collect();
    let links = (0..model.links.len() as u32).map(LinkId).map(|l| {
        let R_WL = data.rotation(l);
        let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| R_WL[(i, j)]));
        (model.link_ref(l).name.as_str(), Pose { p: (*data.position(l)).into(), rotation })
    });
    Configuration { joints, links: links.collect(), q }
}
