//! Centre of mass: compared with Pinocchio, and with a calculation by hand for a URDF of a few links.

use crate::common;

use common::compile_text;
use common::state::{ARM7, Bench, CANOPIES, program};
use dsl::Syntax;

type Triple = [f64; 3];

/// Results of Pinocchio 4.1.0 for the URDF with a free-flyer root at the origin, and joint `k` (from 1) of its order at
/// `0.1 k (-1)^k`: `pin.centerOfMass(model, data, q)`, and `pin.jacobianCenterOfMass(model, data, q)` times the joint
/// velocities `0.01 (k + 6)`.
const PINOCCHIO: &[(&str, &[&str], Triple, Triple)] = &[
    (
        ARM7,
        &["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6", "joint_7"],
        [0.07484602653826708, -0.018581571231083917, 0.47593546325652375],
        [0.026232662490338027, 0.0033350331101905844, -0.011474683942023856],
    ),
    (
        CANOPIES,
        &[
            "torso_yaw",
            "torso_lift",
            "arm_left_1",
            "arm_left_2",
            "arm_left_3",
            "arm_left_4",
            "arm_left_5",
            "arm_left_6",
            "arm_left_7",
            "arm_right_1",
            "arm_right_2",
            "arm_right_3",
            "arm_right_4",
            "arm_right_5",
            "arm_right_6",
            "arm_right_7",
            "head_pan",
            "head_tilt",
        ],
        [-0.0458503139874152, -0.01250495835507693, 0.4748440854708592],
        [0.0007991872805692471, 0.00023947947026899024, 0.011810763274473994],
    ),
];

#[test]
fn pinocchio_says_the_same() {
    for (robot, joints, position, rate) in PINOCCHIO {
        let program = program(robot, &["track(com) { target [0, 0, 0] m  gain 0 /s }".to_string()]);
        let bench = Bench { program: &program, inputs: vec![] };
        let model = bench.model();
        let (mut q, mut v) = (model.neutral(), vec![0.0; model.nv()]);
        for (i, name) in joints.iter().enumerate() {
            let k = (i + 1) as f64;
            let dof = model.dof(name).expect("a joint");
            q[model.dofs[dof].q_index.expect("a position")] = 0.1 * k * if i % 2 == 0 { -1.0 } else { 1.0 };
            v[dof] = 0.01 * (k + 6.0);
        }
        let mut task = bench.task(0);
        let rows = bench.rows(&mut *task, &q, 0.0).expect("rows");
        let com = bench.value(&*task, &q, 0.0, 3);
        for c in 0..3 {
            assert!((com[c] - position[c]).abs() < 1e-12, "{com:?} is {position:?}");
            let found: f64 = (0..model.nv()).map(|dof| rows.j[(c, dof)] * v[dof]).sum();
            assert!((found - rate[c]).abs() < 1e-12, "{found} is {}", rate[c]);
        }
    }
}

/// A fixed foot of 3 kg, a bar of 1 kg that rotates about z, and a link without mass at its end.
const BAR: &str = r#"<robot name="r">
  <link name="foot"> <inertial> <origin xyz="0 0 1"/> <mass value="3"/> </inertial> </link>
  <link name="bar"> <inertial> <origin xyz="2 0 0" rpy="1 2 3"/> <mass value="1"/> </inertial> </link>
  <link name="end"/>
  <joint name="turn" type="revolute">
    <parent link="foot"/> <child link="bar"/> <origin xyz="0 0 0.4"/> <axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/>
  </joint>
  <joint name="tip" type="fixed"> <parent link="bar"/> <child link="end"/> <origin xyz="9 9 9"/> </joint>
</robot>
"#;

/// Program of a robot with a URDF in a folder of this test.
fn of_urdf(name: &str, urdf: &str, tasks: &[&str]) -> runtime::program::Program {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("r.urdf"), urdf).expect("a file");
    let lines: String = tasks.iter().enumerate().map(|(i, t)| format!("task t{i} = {t}\n")).collect();
    let names: Vec<String> = (0..tasks.len()).map(|i| format!("t{i}")).collect();
    let names = names.join("  ");
    let text = format!(
        "hierarq 1\nrobot r {{ urdf \"r.urdf\"  rate 100 Hz }}\n{lines}stack s {{ level all {{ {names} }} }}\n"
    );
    let compiled = compile_text(&text, Syntax::Native, &folder, &[]);
    compiled.program.unwrap_or_else(|| panic!("{:?}", compiled.report.diagnostics))
}

#[test]
fn a_bar_by_hand() {
    let program = of_urdf("bar", BAR, &["track(com) { target [0, 0, 0] m  gain 0 /s }"]);
    let bench = Bench { program: &program, inputs: vec![] };
    let angle = std::f64::consts::FRAC_PI_2;
    let mut task = bench.task(0);
    let com = bench.value(&*task, &[angle], 0.0, 3);
    // (3 [0, 0, 1] + 1 [0, 2, 0.4]) / 4
    for (x, y) in com.iter().zip([0.0, 0.5, 0.85]) {
        assert!((x - y).abs() < 1e-15, "{com:?}");
    }
    let rows = bench.rows(&mut *task, &[angle], 0.0).expect("rows");
    for (c, y) in [-0.5, 0.0, 0.0].into_iter().enumerate() {
        assert!((rows.j[(c, 0)] - y).abs() < 1e-15, "{}", rows.j);
    }
}

#[test]
fn huge_masses_have_a_centre() {
    let heavy = BAR.replace("value=\"3\"", "value=\"1.5e308\"").replace("value=\"1\"", "value=\"1.5e308\"");
    let program = of_urdf("heavy", &heavy, &["track(com) { target [0, 0, 0] m  gain 0 /s }"]);
    let bench = Bench { program: &program, inputs: vec![] };
    let com = bench.value(&*bench.task(0), &[0.0], 0.0, 3);
    assert_eq!(com, [1.0, 0.0, 0.7]);
}

#[test]
fn what_has_no_mass_that_moves_is_a_constant() {
    // Only the foot has a mass, so the centre is constant and permitted in the parameter of any task.
    let still = BAR.replace("<mass value=\"1\"/>", "<mass value=\"0\"/>");
    let program = of_urdf("still", &still, &["frame_position(end) { position com }"]);
    assert_eq!(program.values.initial[..3], [0.0, 0.0, 1.0]);
    assert!(program.values.tape.outputs.is_empty());
}

#[test]
fn a_program_without_masses_is_refused() {
    let mut program = of_urdf("masses", BAR, &["track(com) { target [0, 0, 0] m }"]);
    assert!(program.check().is_ok());
    for link in &mut program.robot.model.links {
        link.mass = 0.0;
    }
    let refused = program.check().expect_err("there is no centre of mass");
    assert!(refused.message.contains("mass"), "{refused}");
    // In models stored before `center_of_mass` existed, it defaults to the link's origin.
    let text = serde_json::to_string(&program.robot.model).expect("JSON");
    let start = text.find("\"center_of_mass\"").expect("a centre");
    let end = start + text[start..].find(']').expect("its end") + 1;
    let older = format!("{}{}", text[..start].trim_end_matches(','), &text[end..]);
    let model: robot::Model = serde_json::from_str(&older).expect("a model");
    assert_eq!(model.links[0].center_of_mass, nalgebra::Vector3::zeros());
}
