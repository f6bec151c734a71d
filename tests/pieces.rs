//! Convex pieces of links and obstacles: the cache beside a spec changes no byte of a result, and bad meshes are reported.

use crate::common::cli::{folder, hierarq, text};

use std::fmt::Write;
use std::path::{Path, PathBuf};

use compiler::{Compiled, Input, compile};
use dsl::Syntax;

/// A ring of 1,152 triangles as OBJ, in units of `scale` m.
fn ring(scale: f64) -> String {
    let (around, section) = (36, 16);
    let mut out = String::new();
    for k in 0..around * section {
        let [u, v] = [(k / section, around), (k % section, section)]
            .map(|(i, n)| std::f64::consts::TAU * f64::from(i) / f64::from(n));
        let r = (0.1 + 0.03 * v.cos()) / scale;
        let _ = writeln!(out, "v {} {} {}", r * u.cos(), r * u.sin(), 0.03 / scale * v.sin());
    }
    let at = |i: i32, j: i32| i % around * section + j % section + 1;
    for (i, j) in (0..around * section).map(|k| (k / section, k % section)) {
        let _ = writeln!(out, "f {} {} {} {}", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
    out
}

const URDF: &str = "<robot name='gantry'><link name='bridge'/><link name='hook'><collision><geometry>
<mesh filename='ring.obj' scale='0.001 0.001 0.001'/></geometry></collision></link>
<joint name='along' type='prismatic'><parent link='bridge'/><child link='hook'/><axis xyz='1 0 0'/>
<limit lower='-1' upper='1' velocity='0.5' effort='1'/></joint></robot>";

const SPEC: &str = "hierarq 1
robot gantry { urdf \"gantry.urdf\"  rate 100 Hz  pieces [hook]  pieces_within 8 mm }
obstacle ring { mesh \"ring.obj\"  scale 0.001  shape pieces  pieces_within 8 mm  position [0.5, 0, 0] m }
task limits = joint_position_limits
task speeds = joint_velocity_limits
task accelerations = joint_acceleration_limits
task clear = keep_clear(hook) { of ring  d_min 1 cm }
task still = joint_velocity { velocity 0 m/s }
stack s {
  level limits hard { limits  speeds }
  level room hard { clear }
  level gentle { accelerations }
  level motion { still }
}
";

fn project(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::write(folder.join("gantry.urdf"), URDF).expect("writable");
    std::fs::write(folder.join("ring.obj"), ring(0.001)).expect("writable");
    folder
}

fn compiled(folder: &Path, text: &str) -> Compiled {
    compile(&Input { name: "spec.hq", text, syntax: Syntax::Native, folder, set: &[], package_paths: &[] })
}

/// The program as bytes, and the codes of the diagnostics.
fn result(folder: &Path) -> (String, Vec<&'static str>) {
    let compiled = compiled(folder, SPEC);
    let codes = compiled.report.diagnostics.iter().map(|d| d.code).collect();
    let program = compiled.program.unwrap_or_else(|| panic!("{:?}", compiled.report.diagnostics));
    (serde_json::to_string(&program).expect("a program"), codes)
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let found = std::fs::read_dir(folder.join(robot::PIECES_FOLDER)).expect("a folder");
    let mut found: Vec<PathBuf> = found.map(|e| e.expect("an entry").path()).collect();
    found.sort();
    found
}

#[test]
fn a_result_does_not_depend_on_the_cache() {
    let folder = project("pieces_cache");
    let _ = std::fs::remove_dir_all(folder.join(robot::PIECES_FOLDER));
    let (first, codes) = result(&folder);
    assert!(codes.is_empty(), "{codes:?}");
    // Link and obstacle have the same mesh, scale and tolerance.
    let [entry] = entries(&folder).try_into().expect("one entry");
    let written = std::fs::read(&entry).expect("readable");
    assert_eq!(result(&folder), (first.clone(), vec![]));

    // The entry is read: other pieces in it are other shapes. Nobody writes such a thing by accident, since it is hashed.
    for damaged in [&b"somebody else's"[..], &written[..written.len() / 2], b""] {
        std::fs::write(&entry, damaged).expect("writable");
        assert_eq!(result(&folder), (first.clone(), vec!["HQ0585"]));
        assert_eq!(std::fs::read(&entry).expect("readable"), written);
        assert_eq!(result(&folder), (first.clone(), vec![]));
    }

    // Another mesh or tolerance is another entry.
    let wider = SPEC.replacen("pieces_within 8 mm", "pieces_within 20 mm", 1);
    assert!(compiled(&folder, &wider).program.is_some());
    assert_eq!(entries(&folder).len(), 2);

    // A folder that cannot be written: a file is in its place.
    std::fs::remove_dir_all(folder.join(robot::PIECES_FOLDER)).expect("removable");
    std::fs::write(folder.join(robot::PIECES_FOLDER), "in the way").expect("writable");
    assert_eq!(result(&folder), (first, vec![]));
    std::fs::remove_file(folder.join(robot::PIECES_FOLDER)).expect("removable");
}

#[test]
fn bad_meshes_are_reported() {
    let folder = project("pieces_bad");
    let whole = ring(0.001);
    // Without its last faces the ring is open: its surface alone would be cut, into too many pieces.
    let open: String = whole.lines().take(36 * 16 + 500).map(|line| format!("{line}\n")).collect();
    let nan = whole.replacen("v 1", "v nan ", 1);
    for (mesh, within, expected) in [
        (open.as_str(), "8 mm", vec!["HQ0584", "HQ0584"]),
        (whole.as_str(), "0.2 mm", vec!["HQ0584", "HQ0584"]),
        (&nan, "8 mm", vec!["HQ0403", "HQ0581"]),
        ("v 0 0 0\nv 1 0 0\n", "8 mm", vec!["HQ0403", "HQ0581"]),
        ("", "8 mm", vec!["HQ0403", "HQ0581"]),
    ] {
        std::fs::write(folder.join("ring.obj"), mesh).expect("writable");
        let compiled = compiled(&folder, &SPEC.replace("8 mm", within));
        let codes: Vec<&str> = compiled.report.diagnostics.iter().map(|d| d.code).collect();
        assert!(expected.iter().all(|code| codes.contains(code)), "{codes:?} lack {expected:?}");
        assert_eq!(codes.is_empty(), expected.is_empty(), "{codes:?}");
    }
    // Metres in place of millimetres: 260 m across.
    std::fs::write(folder.join("ring.obj"), &whole).expect("writable");
    let urdf = URDF.replace("0.001 0.001 0.001", "1 1 1");
    std::fs::write(folder.join("gantry.urdf"), urdf).expect("writable");
    let compiled = compiled(&folder, SPEC);
    assert!(compiled.report.diagnostics.iter().any(|d| d.code == "HQ0403" && d.message.contains("millimetres")));
}

#[test]
fn a_link_has_one_kind_of_shapes() {
    let folder = project("pieces_kinds");
    let of = |keys: &str| {
        let compiled = compiled(&folder, &SPEC.replace("pieces [hook]", keys));
        let codes: Vec<&str> = compiled.report.diagnostics.iter().map(|d| d.code).collect();
        let link = |p: &runtime::Program| p.robot.model.links[1].collision.clone();
        (codes, compiled.program.as_ref().map(link))
    };
    let count = |keys: &str| of(keys).1.expect("good").len();
    assert!(count("pieces all") > 5);
    assert_eq!((count("pieces all  hulls [hook]"), count("pieces all  capsules [hook]")), (1, 1));
    assert!(count("hulls all  pieces [hook]") > 5);
    assert!(matches!(of("").1.expect("good")[0].shape, robot::Shape::Capsule { .. }));
    assert!(matches!(of("hulls all").1.expect("good")[0].shape, robot::Shape::Hull(_)));
    assert!(of("hulls [hook]  pieces [hook]").0.contains(&"HQ0207"));
    assert!(of("hulls all  pieces all").0.contains(&"HQ0207"));
    assert!(of("pieces [hock]").0.contains(&"HQ0201"));
}

#[test]
fn robot_prints_how_far_shapes_exceed_meshes() {
    let out = hierarq(&["robot", "examples/hook.hq"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let shown = text(&out.stdout);
    let meshes = shown.split("\nmeshes").nth(1).expect("a table");
    insta::assert_snapshot!(meshes.replace(env!("CARGO_MANIFEST_DIR"), ""));
    let out = hierarq(&["robot", "--json", "examples/hook.hq"]);
    let data: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!(
        (&data["meshes"][0]["used"], data["meshes"][0]["shapes"][2]["count"].as_u64()),
        (&"pieces".into(), Some(4))
    );
}
