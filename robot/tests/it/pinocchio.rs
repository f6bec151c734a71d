//! Poses and Jacobians that Pinocchio computed (`tests/data/oracle_*.json`): the same to 1e-9.

use std::collections::BTreeMap;
use std::path::Path;

use hierarq_robot::{Base, Data, Model, Options};
use nalgebra::DMatrix;
use serde::Deserialize;

#[derive(Deserialize)]
struct Oracle {
    /// Relative to the root of the workspace.
    urdf: String,
    base: Base,
    /// Names of the columns of the Jacobians, the base's first.
    velocities: Vec<String>,
    configurations: Vec<Configuration>,
}

#[derive(Deserialize)]
struct Configuration {
    /// The base's numbers, then one per joint.
    q: Vec<f64>,
    /// Names of the entries of `q`.
    joints: Vec<String>,
    links: BTreeMap<String, Frame>,
}

#[derive(Deserialize)]
struct Frame {
    p: [f64; 3],
    #[serde(rename = "R")]
    rotation: [[f64; 3]; 3],
    /// 6 × nv, linear first, LOCAL_WORLD_ALIGNED.
    #[serde(rename = "J")]
    jacobian: Vec<Vec<f64>>,
}

/// The oracle's column for each of our degrees of freedom, by name; the base's by place, of which
/// a unicycle has the first and the last of the plane.
fn columns(oracle: &Oracle, model: &Model) -> Vec<usize> {
    let of_base: &[usize] = match model.root_base() {
        Base::Fixed => &[],
        Base::Planar => &[0, 1, 2],
        Base::Unicycle => &[0, 2],
        Base::Floating => &[0, 1, 2, 3, 4, 5],
    };
    let by_name = |name: &String| oracle.velocities.iter().position(|v| v == name);
    let joints = model.dofs.iter().skip(of_base.len());
    let joints = joints.map(|d| by_name(&d.name).unwrap_or_else(|| panic!("no column {}", d.name)));
    of_base.iter().copied().chain(joints).collect()
}

fn compare(oracle: &Oracle, base: Base, urdf: &str, file: &str) {
    let options = Options { base, ..Options::default() };
    let (model, _) = Model::from_urdf(urdf, &options).unwrap_or_else(|m| panic!("{file}: {m:#?}"));
    assert!(!oracle.configurations.is_empty(), "{file} has no configuration");
    let columns = columns(oracle, &model);
    let mut data = Data::new(&model);
    let mut J = DMatrix::zeros(6, model.nv());
    for configuration in &oracle.configurations {
        let nq = model.root_base().nq();
        assert_eq!(configuration.q.len(), configuration.joints.len());
        assert_eq!(configuration.q.len(), model.nq(), "{file}: another number of joints");
        let mut q = model.neutral();
        q[..nq].copy_from_slice(&configuration.q[..nq]);
        for (name, x) in configuration.joints.iter().zip(&configuration.q).skip(nq) {
            let dof = model.dof(name).unwrap_or_else(|| panic!("{file}: no joint `{name}`"));
            q[model.dofs[dof].q_index.unwrap()] = *x;
        }
        model.forward(&q, &mut data);
        assert!(!configuration.links.is_empty());
        for (name, frame) in &configuration.links {
            let link = model.link(name).unwrap_or_else(|| panic!("{file}: no link `{name}`"));
            let (p, R) = (*data.position(link), *data.rotation(link));
            data.jacobian(&model, link, &p, &mut J);
            for i in 0..3 {
                assert!((p[i] - frame.p[i]).abs() < 1e-9, "{file}: position of {name}");
                for j in 0..3 {
                    assert!((R[(i, j)] - frame.rotation[i][j]).abs() < 1e-9, "{file}: {name}");
                }
            }
            for (i, expected) in frame.jacobian.iter().enumerate() {
                for (dof, &column) in columns.iter().enumerate() {
                    let gap = (J[(i, dof)] - expected[column]).abs();
                    assert!(gap < 1e-9, "{file}: J of {name} at {i}, {dof} is {gap} off");
                }
            }
        }
    }
}

#[test]
fn pinocchio_computes_the_same() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = 0;
    for entry in std::fs::read_dir(here.join("tests/data")).unwrap() {
        let path = entry.unwrap().path();
        let file = path.file_name().and_then(|n| n.to_str()).unwrap_or("").to_owned();
        if !(file.starts_with("oracle_") && file.ends_with(".json")) {
            continue;
        }
        let oracle: Oracle =
            serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap_or_else(|e| panic!("{file}: {e}"));
        let urdf = std::fs::read_to_string(here.join("..").join(&oracle.urdf))
            .unwrap_or_else(|e| panic!("{file}: {}: {e}", oracle.urdf));
        compare(&oracle, oracle.base, &urdf, &file);
        if oracle.base == Base::Planar {
            compare(&oracle, Base::Unicycle, &urdf, &file);
        }
        files += 1;
    }
    assert!(files >= 4, "only {files} files of reference kinematics");
}
