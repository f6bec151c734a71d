//! `hierarq init`: the proposed project passes `check` and runs, and no file is lost.

use std::path::Path;

use hierarq::init::{Refusal, Request, propose};
use hierarq::project::{Settings, compile};
use proptest::prelude::*;
use robot::{Base, Model, Options};
use runtime::Simulation;

use super::{folder, hierarq, text, utf8};

/// Checks that the project of `init` with these arguments passes `check --strict` and runs for a second without a
/// fault.
fn works(name: &str, spec: &str, args: &[&str]) -> String {
    let dir = folder(name);
    let project = dir.join("cell");
    let mut all = vec!["init", utf8(&project)];
    all.extend(args);
    let init = hierarq(&all);
    assert_eq!(init.status.code(), Some(0), "{}", text(&init.stderr));
    let spec = project.join(spec);
    let said = text(&init.stdout);
    assert!(said.contains(&format!("wrote {}", spec.display())), "{said}");
    assert!(said.contains(&format!("hierarq run {}", spec.display())), "{said}");
    let check = hierarq(&["check", "--strict", utf8(&spec)]);
    assert_eq!(check.status.code(), Some(0), "{}", text(&check.stderr));
    assert_eq!(hierarq(&["fmt", "--check", utf8(&spec)]).status.code(), Some(0), "it is formatted");
    let out = dir.join("out");
    let run = hierarq(&["run", utf8(&spec), "--duration", "1", "--json", "--out", utf8(&out)]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(summary["faults"], serde_json::json!([]));
    assert!(summary["tasks"]["reach"]["max_error"].as_f64() < Some(2e-3), "the tip follows: {}", summary["tasks"]);
    std::fs::read_to_string(&spec).expect("written")
}

#[test]
fn init_without_a_robot_brings_one() {
    let spec = works("init_example", "arm7.hq", &[]);
    assert!(spec.contains("arms { arm { shoulder link_2  elbow link_4  wrist link_6  tip tool } }"), "{spec}");
    let yaml = works("init_yaml", "arm7.yaml", &["--yaml"]);
    assert!(yaml.starts_with("# A first spec"), "{yaml}");
    let declared = ["`lag`", "`dead_time`", "`tracking_gain`"];
    assert!(declared.iter().all(|key| spec.contains(key) && yaml.contains(key)), "what a real robot needs: {spec}");
}

#[test]
fn init_takes_groups_home_and_pairs_from_an_srdf() {
    let files = ["--urdf", "examples/robots/arm7.urdf"];
    let spec = works("init_srdf", "arm7.hq", &files);
    for line in
        ["srdf \"robots/arm7.srdf\"", "home ready", "// its groups: arm, wrist, hand", "self_collision { between all"]
    {
        assert!(spec.contains(line), "{line}:\n{spec}");
    }
    let yaml = works("init_srdf_yaml", "arm7.yaml", &[&files[..], &["--yaml"]].concat());
    assert!(yaml.contains("home: ready"), "{yaml}");
    // One that is named must be sound.
    let dir = folder("init_srdf_broken");
    let broken = dir.join("broken.srdf");
    std::fs::write(&broken, "<robot name=\"arm7\"><passive_joint name=\"elbow\"/></robot>").expect("writable");
    let project = dir.join("cell");
    let out = hierarq(&[&["init", utf8(&project)], &files[..], &["--srdf", utf8(&broken)]].concat());
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stdout));
    assert!(text(&out.stderr).contains("HQ0408"), "{}", text(&out.stderr));
}

/// A program `xacro` that says how it was called and prints the example arm, or fails as the real one does.
#[cfg(unix)]
fn false_xacro(dir: &Path) -> std::ffi::OsString {
    use std::os::unix::fs::PermissionsExt;
    let bin = dir.join("bin");
    std::fs::create_dir_all(&bin).expect("writable");
    let arm = Path::new("examples/robots/arm7.urdf").canonicalize().expect("the arm");
    let script = format!(
        "#!/bin/sh\necho \"$@\" >> {0}/calls\ncase \"$*\" in\n *srdf*) echo '<robot name=\"arm7\"/>';;\n *size:=*) cat {1};;\n \
         *) echo 'Undefined substitution argument size' >&2; exit 2;;\nesac\n",
        dir.display(),
        arm.display()
    );
    let program = bin.join("xacro");
    std::fs::write(&program, script).expect("writable");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).expect("set");
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths(std::iter::once(bin).chain(std::env::split_paths(&paths))).expect("paths")
}

#[cfg(unix)]
#[test]
fn init_expands_xacro_by_the_program_of_that_name() {
    let dir = folder("init_xacro");
    let path = false_xacro(&dir);
    let robot = dir.join("arm.urdf.xacro");
    std::fs::write(&robot, "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"/>").expect("writable");
    std::fs::write(dir.join("arm.srdf.xacro"), "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"/>")
        .expect("writable");
    let init = |project: &str, path: &std::ffi::OsStr, arguments: &[&str]| {
        let project = dir.join(project);
        let all = [&["init", utf8(&project), "--urdf", utf8(&robot)], arguments].concat();
        let program = std::process::Command::new(env!("CARGO_BIN_EXE_hierarq")).args(all).env("PATH", path).output();
        program.expect("it runs")
    };
    let out = init("cell", &path, &["--xacro-arg", "size:=2", "--xacro-arg", "side=left"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let calls = std::fs::read_to_string(dir.join("calls")).expect("it was called");
    assert!(calls.lines().next().is_some_and(|call| call.ends_with("arm.urdf.xacro size:=2 side:=left")), "{calls}");
    assert!(calls.lines().nth(1).is_some_and(|call| call.contains("arm.srdf.xacro")), "{calls}");
    let written = std::fs::read_to_string(dir.join("cell/robots/arm.urdf")).expect("the expanded robot");
    assert_eq!(written, std::fs::read_to_string("examples/robots/arm7.urdf").expect("the arm"));
    let spec = std::fs::read_to_string(dir.join("cell/arm7.hq")).expect("the spec");
    assert!(spec.contains("urdf \"robots/arm.urdf\"") && spec.contains("srdf \"robots/arm.srdf\""), "{spec}");
    let check = hierarq(&["check", "--strict", utf8(&dir.join("cell/arm7.hq"))]);
    assert_eq!(check.status.code(), Some(0), "{}", text(&check.stderr));
    // The missing argument is named, and nothing is written.
    let out = init("none", &path, &[]);
    assert_eq!(out.status.code(), Some(2), "{}", text(&out.stdout));
    let said = text(&out.stderr);
    assert!(
        said.contains("Undefined substitution argument size") && said.contains("--xacro-arg NAME:=VALUE"),
        "{said}"
    );
    let out = init("none", std::ffi::OsStr::new(""), &[]);
    let said = text(&out.stderr);
    assert!(said.contains("needs the program `xacro`, which is not installed: install it"), "{said}");
    assert!(!dir.join("none").exists());
}

#[test]
fn init_says_what_to_do_with_a_file_in_place_of_the_folder() {
    let out = hierarq(&["init", "examples/robots/arm7.srdf"]);
    let said = text(&out.stderr);
    assert!(
        said.contains("is a file, and `init` writes a folder: hierarq init DIR --urdf ROBOT.urdf --srdf"),
        "{said}"
    );
}

#[test]
fn init_finds_both_arms_of_the_vineyard_robot() {
    let spec = works("init_canopies", "canopies.hq", &["--urdf", "examples/robots/canopies.urdf"]);
    // The same as in the handwritten examples.
    let written = std::fs::read_to_string("examples/common/canopies.hq").expect("readable");
    for side in ["left", "right"] {
        for (word, link) in [
            ("shoulder", format!("arm_{side}_2_link")),
            ("elbow", format!("arm_{side}_4_link")),
            ("wrist", format!("arm_{side}_6_link")),
            ("tip", format!("{side}_tool")),
        ] {
            let line = format!("{word} {link}");
            assert!(spec.contains(&line) && written.contains(&line), "{line}:\n{spec}");
        }
    }
    let wheeled =
        works("init_canopies_base", "canopies.hq", &["--urdf", "examples/robots/canopies.urdf", "--base", "unicycle"]);
    assert!(wheeled.contains("base unicycle") && wheeled.contains("lock [base]"), "{wheeled}");
}

#[test]
fn init_overwrites_nothing() {
    let dir = folder("init_twice");
    let spec = dir.join("arm7.hq");
    std::fs::write(&spec, "mine").expect("writable");
    let init = hierarq(&["init", utf8(&dir)]);
    assert_eq!(init.status.code(), Some(2));
    assert!(text(&init.stderr).contains("arm7.hq exists already; nothing was written"), "{}", text(&init.stderr));
    assert_eq!(std::fs::read_to_string(&spec).expect("readable"), "mine");
    assert!(!dir.join("robots").exists());
}

/// Returns a URDF with chains of joints (name, base link, number); `link` is added to every link.
fn urdf(chains: &[(&str, &str, usize)], link: &str) -> String {
    let mut out = String::from("<robot name=\"made-up 3\"><link name=\"root\"/>");
    for (name, on, joints) in chains {
        let mut parent = (*on).to_string();
        for k in 1..=*joints {
            let axis = if k % 2 == 0 { "0 1 0" } else { "1 0 1" };
            out += &format!(
                "<link name=\"{name}-link{k}\">{link}</link><joint name=\"{name}-{k}\" type=\"revolute\">\
                 <parent link=\"{parent}\"/><child link=\"{name}-link{k}\"/><origin xyz=\"0 0.05 0.15\"/>\
                 <axis xyz=\"{axis}\"/><limit lower=\"-2\" upper=\"2.5\" velocity=\"2\" effort=\"9\"/></joint>"
            );
            parent = format!("{name}-link{k}");
        }
    }
    out + "</robot>"
}

#[test]
fn init_quotes_names_and_refers_to_a_urdf_with_meshes() {
    let dir = folder("init_meshes");
    let package = dir.join("share/parts");
    std::fs::create_dir_all(package.join("urdf")).expect("writable");
    let mesh = "<collision><geometry><mesh filename=\"package://parts/ball.obj\"/></geometry></collision>";
    std::fs::write(package.join("ball.obj"), "v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.02\n").expect("writable");
    let file = package.join("urdf/arm.urdf");
    std::fs::write(&file, urdf(&[("L-arm", "root", 6), ("R-arm", "root", 6), ("neck", "root", 2)], mesh))
        .expect("writable");
    let project = dir.join("cell");
    let init = hierarq(&["init", utf8(&project), "--urdf", utf8(&file)]);
    assert_eq!(init.status.code(), Some(0), "{}", text(&init.stderr));
    let spec = project.join("made_up_3.hq");
    let written = std::fs::read_to_string(&spec).expect("written");
    assert!(written.contains("urdf \"../share/parts/urdf/arm.urdf\""), "{written}");
    assert!(written.contains("package_path \"../share\""), "{written}");
    assert!(written.contains("left [\"L-arm-1\"") && written.contains("tip \"R-arm-link6\""), "{written}");
    assert!(!project.join("robots").exists());
    let check = hierarq(&["check", "--strict", utf8(&spec)]);
    assert_eq!(check.status.code(), Some(0), "{}", text(&check.stderr));
}

#[test]
fn init_takes_a_robot_without_arms_and_refuses_what_is_none() {
    let dir = folder("init_small");
    let file = dir.join("small.urdf");
    std::fs::write(&file, urdf(&[("one", "root", 3), ("two", "root", 2)], "")).expect("writable");
    let init = hierarq(&["init", utf8(&dir.join("a")), "--urdf", utf8(&file)]);
    assert_eq!(init.status.code(), Some(0), "{}", text(&init.stderr));
    let spec = dir.join("a/made_up_3.hq");
    assert!(std::fs::read_to_string(&spec).expect("written").contains("frame_position(\"one-link3\")"));
    assert_eq!(hierarq(&["check", "--strict", utf8(&spec)]).status.code(), Some(0));

    std::fs::write(&file, urdf(&[("one", "root", 6)], "").replace("\"one-link3\"/>", "\"nowhere\"/>"))
        .expect("writable");
    let init = hierarq(&["init", utf8(&dir.join("b")), "--urdf", utf8(&file)]);
    assert_eq!(init.status.code(), Some(1));
    assert!(text(&init.stderr).contains("there is no link `nowhere`"), "{}", text(&init.stderr));
    assert!(!dir.join("b").exists(), "nothing was written");
}

/// Returns the proposed spec for a URDF.
fn proposed(name: &str, urdf: &str) -> String {
    let dir = folder(name);
    let file = dir.join("robot.urdf");
    std::fs::write(&file, urdf).expect("writable");
    let request = Request { folder: dir.join("cell"), urdf: Some(file), ..Request::default() };
    let project = propose(&request).unwrap_or_else(|e| panic!("{e:?}"));
    project.files.last().expect("a spec").1.clone()
}

#[test]
fn a_trunk_is_no_arm_and_neither_is_a_finger() {
    let arms = [("trunk", "root", 5), ("L-arm", "trunk-link5", 7), ("R-arm", "trunk-link5", 7)];
    let fingers = [("L-index", "L-arm-link7", 5), ("L-thumb", "L-arm-link7", 5)];
    let spec = proposed("init_trunk", &urdf(&[arms.as_slice(), fingers.as_slice()].concat(), ""));
    let (_, rest) = spec.split_once("arms {").expect("arms");
    let (arms, _) = rest.split_once("home {").expect("home");
    assert!(arms.contains("left {") && arms.contains("right {"), "{spec}");
    assert_eq!(arms.matches("tip ").count(), 2, "{spec}");
}

#[test]
fn wheels_are_locked_under_a_base_that_drives() {
    let wheel = |side: &str| {
        format!(
            "<link name=\"{side}\"/><joint name=\"{side}_wheel_joint\" type=\"continuous\"><parent link=\"root\"/>\
             <child link=\"{side}\"/><axis xyz=\"0 1 0\"/><limit velocity=\"9\" effort=\"9\"/></joint>"
        )
    };
    let wheels = wheel("left") + &wheel("right") + "</robot>";
    let spec = proposed("init_wheels", &urdf(&[("arm", "root", 6)], "").replace("</robot>", &wheels));
    assert!(spec.contains("base unicycle"), "{spec}");
    assert!(spec.contains("lock [left_wheel_joint, right_wheel_joint]"), "{spec}");
}

/// A joint of a generated robot: parent link, type, axis, limits, position.
type Made = (prop::sample::Index, u8, [i8; 3], (f64, f64), [f64; 3]);

fn made_up(joints: &[Made]) -> String {
    let mut out = String::from("<robot name=\"made\"><link name=\"l0\"/>");
    for (k, (on, kind, axis, (lower, span), at)) in joints.iter().enumerate() {
        let kind = ["revolute", "revolute", "revolute", "continuous", "prismatic", "fixed"][usize::from(*kind) % 6];
        let axis = if *axis == [0, 0, 0] { [0, 0, 1] } else { *axis };
        // Mostly chains: the parent of a link is usually the previous one.
        let on = if on.index(4) > 0 { k } else { on.index(k + 1) };
        out += &format!(
            "<link name=\"l{n}\"/><joint name=\"j{n}\" type=\"{kind}\"><parent link=\"l{on}\"/><child link=\"l{n}\"/>\
             <origin xyz=\"{} {} {}\"/><axis xyz=\"{} {} {}\"/>\
             <limit lower=\"{lower}\" upper=\"{}\" velocity=\"1.5\" effort=\"1\"/></joint>",
            at[0],
            at[1],
            at[2],
            axis[0],
            axis[1],
            axis[2],
            lower + span,
            n = k + 1,
        );
    }
    out + "</robot>"
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any tree with a movable joint gets a spec that compiles, starts inside the limits of the URDF, and runs.
    #[test]
    fn any_robot_gets_a_spec_that_runs(
        joints in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_u8..6, prop::array::uniform3(-1_i8..=1), (-2.0..1.0, 0.1..3.0),
             prop::array::uniform3(-0.3..0.3)),
            1..16,
        ),
        base in prop::sample::select(vec![Base::Fixed, Base::Planar, Base::Unicycle, Base::Floating]),
    ) {
        let urdf = made_up(&joints);
        let dir = folder("init_any");
        let file = dir.join("made.urdf");
        std::fs::write(&file, &urdf).expect("writable");
        let request = Request { folder: dir.join("cell"), urdf: Some(file), base: Some(base), ..Request::default() };
        let (model, _) = Model::from_urdf(&urdf, &Options { base, ..Options::default() }).expect("a robot");
        let project = match propose(&request) {
            Ok(project) => project,
            Err(Refusal::Wrong(_)) if model.nv() == 0 => return Ok(()),
            Err(e) => return Err(TestCaseError::fail(format!("{e:?}\n{urdf}"))),
        };
        for (path, text) in &project.files {
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new(""))).expect("writable");
            std::fs::write(path, text).expect("writable");
        }
        let (path, text) = project.files.last().expect("a spec");
        let compiled = compile(path, &Settings::default());
        let program = match compiled.program {
            Some(program) => program,
            None => return Err(TestCaseError::fail(format!("{}\n{text}", compiled.report.render(compiler::Style::Plain, 100)))),
        };
        for dof in &model.dofs {
            if let Some(i) = dof.q_index {
                let q = program.robot.home[i];
                prop_assert!(dof.lower <= q && q <= dof.upper, "{} starts at {q}\n{text}", dof.name);
            }
        }
        let mut short = program.clone();
        short.run.duration = 0.2;
        let mut simulation = Simulation::new(&short).expect("a compiled program can be executed");
        let mut seen = Seen::default();
        simulation.run(&mut seen, &mut || 0.0, &mut |_| true).expect("memory does not fail");
        prop_assert!(seen.ticks > 0 && !seen.fault, "{text}");
    }
}

#[derive(Default)]
struct Seen {
    ticks: usize,
    fault: bool,
}

impl runtime::Recorder for Seen {
    fn tick(&mut self, t: &runtime::Tick) -> std::io::Result<()> {
        self.ticks += 1;
        self.fault |= t.fault.is_some();
        Ok(())
    }
}
