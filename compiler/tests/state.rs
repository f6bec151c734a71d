//! Expressions of the robot's current state: their rows compared with central differences in the configuration and in
//! time, and with tasks of the library; and points without a derivative.

use crate::common;

use common::state::{ARM7, Bench, CANOPIES, difference, program, rng};
use hierarq_compiler::expr::FUNCTIONS;
use proptest::prelude::*;
use stdlib_tasks::task::TaskFault;

const H: f64 = 1e-6;

/// Every function and every leaf, with the number of components; `@` names frames and joints of each robot.
const VALUES: &[(usize, &str)] = &[
    (3, "frame(@A).position"),
    (4, "frame(@A).orientation"),
    (3, "point(@A, [0.1, -0.2, 0.3] m)"),
    (1, "joint(@J)"),
    (1, "distance(finger, base_point)"),
    (1, "distance(finger, [lower, upper])"),
    (1, "distance(lower, upper)"),
    (1, "distance(finger, plane([0.1, 0, -0.2] m, [0.2, -0.3, 2]))"),
    (1, "distance([lower, upper, wrist], plane([0, 0, 0.1] m, [0.3, 1, 0.1]))"),
    (1, "distance(plane([0.1, 0.2, 0.3] m in @B, [1, 2, -0.5]), finger)"),
    (1, "distance([elbow, upper], plane([0.1, 0, 0] m, [0, 0.6, 0.8] in @B))"),
    (3, "com"),
    (1, "manipulability(@A)"),
    (1, "manipulability(@A, linear)"),
    (1, "manipulability(@A, angular)"),
    (1, "angle_between(frame(@A).orientation*[0, 0, 1], point(@B, [0.1, 0.2, 0.3] m) - frame(@A).position)"),
    (3, "com in @A"),
    (1, "norm(com - frame(@B).position) + 2*dot(com, [0, 0.6, 0.8])"),
    (3, "frame(@A).position - frame(@B).position"),
    (3, "frame(@A).orientation*[1, 2, 3] m + frame(@B).position*2"),
    (4, "inverse(frame(@B).orientation)*frame(@A).orientation"),
    (4, "frame(@A).orientation*rpy(0.1 rad, joint(@J), 0.5 rad/s * t)"),
    (4, "axis_angle(frame(@A).position, joint(@K))"),
    (4, "axis_angle(frame(@A).position + [0, 0, 5] m, 0.7 rad)"),
    (4, "quaternion(1, joint(@J)/(1 rad), 0.5, sin(joint(@K)))"),
    (4, "slerp(frame(@A).orientation, frame(@B).orientation, 0.3)"),
    (4, "slerp(rpy(0, 0, 0.4 rad/s * t), frame(@B).orientation, 0.5 + 0.2*sin(joint(@J)))"),
    (7, "frame(@A).pose"),
    (7, "frame(@A).pose in @B"),
    (7, "inverse(frame(@B).pose)*frame(@A).pose"),
    (7, "frame(@A).pose*pose([0.1, 0.2, 0.5 m * sin(joint(@J))/(1 m)] m, rpy(0.3 rad, joint(@K), 0.5 rad/s * t))"),
    (7, "lerp(frame(@A).pose, frame(@B).pose, 0.3 + 0.1*sin(joint(@J)))"),
    (7, "if(joint(@J) < 0.2 rad, frame(@A).pose, frame(@B).pose)"),
    (3, "frame(@B).pose*(([0.1, 0.2, 0.3] m * sin(joint(@J))) in @B)"),
    (4, "(inverse(frame(@B).pose)*frame(@A).pose).orientation"),
    (1, "norm(frame(@A).position - [0.1, 0.2, 0.3] m)"),
    (1, "dot(frame(@A).position, frame(@B).orientation*[0, 1, 0])"),
    (3, "cross(frame(@A).position, [0, 1, 0] m) + cross(frame(@B).position, frame(@A).position)"),
    (3, "normalize(frame(@A).position - frame(@B).position)"),
    (1, "atan2(dot(frame(@A).position, [0, 1, 0]), dot(frame(@A).position, [1, 0, 0]))"),
    (1, "asin(0.9*sin(joint(@J)))"),
    (1, "acos(0.9*cos(joint(@J) + joint(@K)))"),
    (1, "sin(joint(@J))*cos(joint(@K)) + tan(0.3*joint(@J))"),
    (1, "exp(0.3*sin(joint(@J)))/log(3 + cos(joint(@K)))"),
    (1, "sqrt(2 + sin(joint(@J)))*abs(joint(@K) - 0.2 rad)"),
    (1, "min(joint(@J), joint(@K), 0.3 rad) + max(0.1 rad, joint(@J)) + clamp(joint(@K), -1 rad, 1 rad)"),
    (1, "if((joint(@J) < 0.2 rad and joint(@K) >= -1 rad), 2*joint(@J), joint(@J)^2/(1 rad))"),
    (1, "if((not (joint(@J) <= 0.2 rad) or joint(@K) > 1 rad), sin(joint(@J)), -joint(@K))"),
    (3, "lerp(frame(@A).position, frame(@B).position, 0.3 + 0.1*sin(2*pi*t/(3 s)))"),
    (1, "smoothstep(0.5 + 0.2*sin(joint(@J)))"),
    (1, "norm(frame(@A).position - [0.1 + 0.05*sin(2 rad/s * t), 0, 0.9 + 0.1*t/(1 s)] m)*(1 + time/(2 s))"),
    (3, "[joint(@J), 0.5 rad, joint(@J)*(joint(@K)/(1 rad))^3]"),
    (1, "1/(3 + joint(@J)/(1 rad)) - (2 + sin(joint(@K)))^-2"),
];

/// `track` of a value with a constant target and zero gain: `lower = -d/dt value`.
fn pulled(len: usize, value: &str) -> String {
    let target = match len {
        1 => "0",
        3 => "[0, 0, 0]",
        7 => "pose([0, 0, 0] m, rpy(0, 0, 0))",
        _ => "rpy(0, 0, 0)",
    };
    format!("track({value}) {{ target {target}  gain 0 /s }}")
}

fn close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 2e-7 * (1.0 + scale.max(b.abs()))
}

#[test]
fn every_function_and_leaf_is_tried() {
    let tried = |name: &str| VALUES.iter().any(|(_, v)| v.contains(&format!("{name}(")));
    for name in
        FUNCTIONS.iter().map(|f| f.name).chain(["frame", "point", "joint", "distance", "plane", "manipulability"])
    {
        assert!(tried(name), "`{name}` is not tried");
    }
    assert!(VALUES.iter().any(|(_, v)| *v == "com"));
}

#[test]
fn rows_are_derivatives() {
    let tasks: Vec<String> = VALUES.iter().map(|(len, v)| pulled(*len, v)).collect();
    for robot in [ARM7, CANOPIES] {
        let program = program(robot, &tasks);
        let bench = Bench { program: &program, inputs: vec![] };
        let model = bench.model();
        let mut rng = rng(7);
        let mut compared = 0;
        for _ in 0..6 {
            let (q, t) = (model.random_configuration(&mut rng), 0.2 + rng());
            for (i, (len, value)) in VALUES.iter().enumerate() {
                let mut task = bench.task(i);
                let rows = bench.rows(&mut *task, &q, t).unwrap_or_else(|e| panic!("{value}: {e:?}"));
                let at = |q: &[f64], t: f64| bench.value(&*task, q, t, *len);
                let still = difference(&at(&q, t + H), &at(&q, t - H), H);
                for (r, x) in still.iter().enumerate() {
                    assert!(close(-rows.lower[r], *x, 0.0), "{value}: rate {} is {x}", -rows.lower[r]);
                    assert_eq!(rows.lower[r], rows.upper[r]);
                }
                let scale = rows.j.amax();
                for dof in 0..model.nv() {
                    let moved = |h: f64| {
                        let (mut q, mut v) = (q.clone(), vec![0.0; model.nv()]);
                        v[dof] = h;
                        model.integrate(&mut q, &v, 1.0);
                        at(&q, t)
                    };
                    for (r, x) in difference(&moved(H), &moved(-H), H).iter().enumerate() {
                        assert!(close(rows.j[(r, dof)], *x, scale), "{value}, {dof}: {} is {x}", rows.j[(r, dof)]);
                        compared += usize::from(x.abs() > 1e-3);
                    }
                }
            }
        }
        assert!(compared > 1000, "{compared} derivatives are not zero");
    }
}

/// Tasks of the library, and equal tasks written as expressions.
const SAME: &[(&str, &str)] = &[
    (
        "frame_position(@A) { position [0.3 + 0.1*sin(1 rad/s * t), 0.1, 0.9] m  gain 3 /s }",
        "track(frame(@A).position) { target [0.3 + 0.1*sin(1 rad/s * t), 0.1, 0.9] m  gain 3 /s }",
    ),
    (
        "frame_orientation(@A) { orientation rpy(0, 0.3 rad/s * t, 0.2 rad)  gain 2 /s }",
        "track(frame(@A).orientation) { target rpy(0, 0.3 rad/s * t, 0.2 rad)  gain 2 /s }",
    ),
    (
        "frame_pose(@A) { position [0.3 + 0.1*sin(1 rad/s * t), 0.1, 0.9] m  orientation rpy(0, 0.3 rad/s * t, 0.2 rad) }",
        "track(frame(@A).pose, target: pose([0.3 + 0.1*sin(1 rad/s * t), 0.1, 0.9] m, rpy(0, 0.3 rad/s * t, 0.2 rad)))",
    ),
    (
        "virtual_wall(finger) { through [[0, 0, -3], [1, 0, -3], [0, 1, -3]] m  d_min 0.1 m + 0.01 m/s * t  gain 5 /s }",
        "keep(dot(point(@A, [0.02, 0, 0.05] m), [0, 0, 1]) + 3 m) { min 0.1 m + 0.01 m/s * t  gain 5 /s }",
    ),
    (
        "virtual_wall(finger) { through [[0, 0, -3], [1, 0, -3], [0, 1, -3]] m  on @B  gain 5 /s }",
        "keep(dot(point(@A, [0.02, 0, 0.05] m) - frame(@B).position, frame(@B).orientation*[0, 0, 1])) { min -3 m  gain 5 /s }",
    ),
    (
        "virtual_wall(upper) { through [[0, 0, -3], [1, 0, -3], [0, 1, -3.5]] m  d_min 0.1 m  gain 5 /s }",
        "keep(distance(upper, plane([0, 0, -3] m, [0, 0.5, 1]))) { min 0.1 m  gain 5 /s }",
    ),
    (
        "virtual_wall(finger) { through [[0, 0, -3], [1, 0, -3], [0, 1, -3]] m  on @B  gain 5 /s }",
        "keep(distance(finger, plane([4, 4, -3] m in @B, [0, 0, 1]))) { min 0 m  gain 5 /s }",
    ),
    (
        "self_collision { between finger  and base_point  d_min 0.01 m  gain 4 /s }",
        "keep(norm(point(@A, [0.02, 0, 0.05] m) - POINT)) { min 0.01 m  gain 4 /s }",
    ),
    (
        "self_collision { between finger  and upper  d_min 0.001 m  gain 4 /s }",
        "keep(distance(finger, upper)) { min 0.001 m  gain 4 /s }",
    ),
    (
        "joint_position { target { @J 0.2 rad * sin(1 rad/s * t) }  gain 2 /s }",
        "track(joint(@J)) { target 0.2 rad * sin(1 rad/s * t)  gain 2 /s }",
    ),
    (
        "joint_position_limits { joints @J  lower { @J -1.5 rad }  upper { @J 1.2 rad }  gain 6 /s }",
        "keep(joint(@J)) { min -1.5 rad  max 1.2 rad  gain 6 /s }",
    ),
];

#[test]
fn rows_are_those_of_the_library() {
    for robot in [ARM7, CANOPIES] {
        let base = if robot == ARM7 { "frame(link_1).position" } else { "frame(torso_link).position" };
        let tasks: Vec<String> = SAME.iter().flat_map(|(a, b)| [(*a).to_string(), b.replace("POINT", base)]).collect();
        let program = program(robot, &tasks);
        let bench = Bench { program: &program, inputs: vec![] };
        let mut rng = rng(8);
        for _ in 0..20 {
            let (q, t) = (bench.model().random_configuration(&mut rng), 2.0 * rng());
            for (i, (library, own)) in SAME.iter().enumerate() {
                let a = bench.rows(&mut *bench.task(2 * i), &q, t).expect("rows");
                let b = bench.rows(&mut *bench.task(2 * i + 1), &q, t).expect("rows");
                assert!((&a.j - &b.j).amax() < 1e-12, "{library} and {own}: {} and {}", a.j, b.j);
                let pairs = [(&a.lower, &b.lower), (&a.upper, &b.upper), (&a.margins, &b.margins)];
                for (x, y) in pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b)) {
                    assert!(x == y || (x - y).abs() < 1e-12, "{library} and {own}: {x} and {y}");
                }
            }
        }
    }
}

/// Parts of poses, and equal expressions without poses.
const PARTS: &[(&str, &str, &str)] = &[
    ("frame(@A).pose", "frame(@A).position", "frame(@A).orientation"),
    ("frame(@A).pose in @B", "frame(@A).position in @B", "frame(@A).orientation in @B"),
    (
        "lerp(frame(@A).pose, pose([0.1, 0, 0.5] m, rpy(0, 1 rad, 0)), 0.3)",
        "lerp(frame(@A).position, [0.1, 0, 0.5] m, 0.3)",
        "slerp(frame(@A).orientation, rpy(0, 1 rad, 0), 0.3)",
    ),
];

#[test]
fn poses_have_the_rows_of_their_parts() {
    let targets = ["[0.3 + 0.1*sin(1 rad/s * t), 0.1, 0.9] m", "rpy(0, 0.3 rad/s * t, 0.2 rad)"];
    let track = |value: &str, target: &str| format!("track({value}) {{ target {target}  gain 3 /s }}");
    let tasks: Vec<String> = (PARTS.iter())
        .flat_map(|(pose, p, q)| {
            let both = format!("pose({}, {})", targets[0], targets[1]);
            [track(pose, &both), track(p, targets[0]), track(q, targets[1])]
        })
        .collect();
    for robot in [ARM7, CANOPIES] {
        let program = program(robot, &tasks);
        let bench = Bench { program: &program, inputs: vec![] };
        let mut rng = rng(8);
        for _ in 0..20 {
            let (q, t) = (bench.model().random_configuration(&mut rng), 2.0 * rng());
            for (i, (text, ..)) in PARTS.iter().enumerate() {
                let pose = bench.rows(&mut *bench.task(3 * i), &q, t).expect("rows");
                assert_eq!(pose.lower, pose.upper);
                for (part, first) in [(1, 0), (2, 3)] {
                    let own = bench.rows(&mut *bench.task(3 * i + part), &q, t).expect("rows");
                    assert!((pose.j.rows(first, 3) - &own.j).amax() < 1e-12, "{text}: {} and {}", pose.j, own.j);
                    for (x, y) in pose.lower[first..].iter().zip(&own.lower) {
                        assert!((x - y).abs() < 1e-12, "{text}: {x} and {y}");
                    }
                }
                let dimensions: Vec<String> =
                    bench.task(3 * i).rows().iter().map(|r| format!("{} {}", r.name, r.dimension)).collect();
                assert_eq!(dimensions, ["x m", "y m", "z m", "rx rad", "ry rad", "rz rad"]);
            }
        }
    }
}

/// Functions without a derivative at `joint(@J) = 0.4 rad`, and the derivative in their row.
const AWKWARD: &[(&str, f64)] = &[
    ("norm([z, 0, 0])", 0.0),
    ("sqrt(z*z)", 0.0),
    ("abs(z)", 1.0),
    ("min(z, -z)", 1.0),
    ("max(z, -z)", 1.0),
    ("max(-z, z)", -1.0),
    ("clamp(z, 0, 1)", 1.0),
    ("clamp(z, -1, 0)", 1.0),
    ("atan2(z, z)", 0.0),
    ("asin(1 + z)", 0.0),
    ("acos(1 + z)", 0.0),
    ("asin(-1 + z)", 0.0),
    ("dot(normalize([z, 0, 0]), [1, 0, 0])", 0.0),
    ("if(z < 0, 5*z, 2*z)", 2.0),
    ("if(z <= 0, 5*z, 2*z)", 5.0),
    ("if((z > 0 or z >= 0), 5*z, 2*z)", 5.0),
    ("if((z > 0 and z >= 0), 5*z, 2*z)", 2.0),
    ("smoothstep(z)", 0.0),
];

#[test]
fn awkward_points_have_the_derivative_that_the_book_says() {
    let z = |v: &str| {
        v.replace('z', "(joint(joint_2)/(1 rad) - 0.4)").replace("normali(joint(joint_2)/(1 rad) - 0.4)e", "normalize")
    };
    let tasks: Vec<String> = AWKWARD.iter().map(|(v, _)| pulled(1, &z(v))).collect();
    let program = program(ARM7, &tasks);
    let bench = Bench { program: &program, inputs: vec![] };
    let mut q = bench.model().neutral();
    q[1] = 0.4;
    for (i, (value, slope)) in AWKWARD.iter().enumerate() {
        let rows = bench.rows(&mut *bench.task(i), &q, 0.0).expect("rows");
        assert_eq!(rows.j[(0, 1)], *slope, "{value}");
    }
}

#[test]
fn half_turns_and_no_turns_are_interpolated() {
    let tasks: Vec<String> = ["0 deg", "180 deg", "179.9999 deg", "0.00001 deg"]
        .iter()
        .map(|a| {
            pulled(4, &format!("slerp(rpy(0, 0, joint(joint_2)), rpy(0, 0, {a})*rpy(0, 0, joint(joint_2)), 0.25)"))
        })
        .collect();
    let program = program(ARM7, &tasks);
    let bench = Bench { program: &program, inputs: vec![] };
    let q = bench.model().neutral();
    for (i, task) in tasks.iter().enumerate() {
        let rows = bench.rows(&mut *bench.task(i), &q, 0.0).expect("rows");
        assert!((rows.j[(2, 1)] - 1.0).abs() < 1e-6, "{}: {}", task, rows.j);
        assert!(rows.j[(0, 1)].abs() < 1e-6 && rows.j[(1, 1)].abs() < 1e-6);
    }
}

#[test]
fn what_is_not_finite_is_a_fault() {
    let z = "(joint(joint_2)/(1 rad) - 0.4)";
    let values =
        ["1/Z", "log(Z)", "sqrt(Z - 1)", "asin(2.5 - Z)", "if(log(Z - 1) < 0, 1, 2)*joint(joint_1)", "exp(1/abs(Z))"];
    // Home has a different second joint, so that all expressions compile.
    let robot = ARM7.replace("0.1, 0.4, 0.2", "0.1, 1.9, 0.2");
    let tasks: Vec<String> = values.iter().map(|v| pulled(1, &v.replace('Z', z))).collect();
    let program = program(&robot, &tasks);
    let bench = Bench { program: &program, inputs: vec![] };
    let mut q = bench.model().neutral();
    q[1] = 0.4;
    for (i, task) in tasks.iter().enumerate() {
        assert_eq!(bench.rows(&mut *bench.task(i), &q, 0.0).err(), Some(TaskFault::NotFinite { row: 0 }), "{}", task);
    }
}

#[test]
fn gains_and_limits_of_the_state_are_watched() {
    let tasks = [
        "track(joint(joint_1)) { target 0  gain 150 /s * sin(joint(joint_2)) }",
        "keep(joint(joint_1)) { min joint(joint_2)  max 0.5 rad }",
        "keep(joint(joint_1)) { min -0.1 rad/s * t  max 1 rad - 1 rad/s * t }",
    ]
    .map(String::from);
    let robot = ARM7.replace("0.1, 0.4, 0.2", "0.1, 0.05, 0.2");
    let program = program(&robot, &tasks);
    let bench = Bench { program: &program, inputs: vec![] };
    let mut q = bench.model().neutral();
    for (angle, good) in [(0.0, true), (0.5, true), (0.8, false), (-0.1, false)] {
        q[1] = angle;
        let rows = bench.rows(&mut *bench.task(0), &q, 0.0);
        assert_eq!(rows.err(), (!good).then_some(TaskFault::Gain { row: 0 }), "{angle}");
    }
    // A bound that depends on the state has a row of its own, and cannot cross the other bound.
    q[1] = 0.8;
    let rows = bench.rows(&mut *bench.task(1), &q, 0.0).expect("rows");
    assert_eq!((rows.j[(0, 0)], rows.j[(0, 1)], rows.j[(1, 0)], rows.j[(1, 1)]), (1.0, -1.0, 1.0, 0.0));
    assert_eq!((rows.margins[0], rows.margins[1]), (-0.8, 0.5));
    assert!(bench.rows(&mut *bench.task(2), &q, 0.5).is_ok());
    assert_eq!(bench.rows(&mut *bench.task(2), &q, 3.0).err(), Some(TaskFault::Crossed { row: 0 }));
}

/// Random smooth expressions of two joints, a frame and the time.
fn number() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("(joint(@J)/(1 rad))".to_string()),
        Just("(joint(@K)/(1 rad))".to_string()),
        Just("(t/(1 s))".to_string()),
        Just("dot(frame(@A).orientation*[1, 0, 0], [0, 0.6, 0.8])".to_string()),
        Just("(norm(frame(@A).position - frame(@B).position)/(1 m))".to_string()),
        (-2.0..2.0f64).prop_map(|x| if x < 0.0 { format!("({x:.3})") } else { format!("{x:.3}") }),
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
        (inner.clone(), inner, 0..10usize).prop_map(|(a, b, op)| match op {
            0 => format!("({a} + {b})"),
            1 => format!("({a} - {b})"),
            2 | 3 => format!("{a}*{b}"),
            4 => format!("{a}/(2.5 + sin({b}))"),
            5 => format!("sin({a} + {b})"),
            6 => format!("atan2({a}, 1.5 + cos({b}))/(1 rad)"),
            7 => format!("sqrt(1 + ({a})^2)*cos({b})"),
            8 => format!("dot(normalize([{a}, 1, {b}]), [0.3, -0.5, 0.8])"),
            _ => format!("exp(-({a})^2)"),
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rows_of_anything_are_derivatives(value in number(), seed in 0..1000u64) {
        let value = format!("{value} + joint(@J)*0.1/(1 rad)");
        let program = program(ARM7, &[pulled(1, &value)]);
        let bench = Bench { program: &program, inputs: vec![] };
        let mut rng = rng(seed);
        let (q, t) = (bench.model().random_configuration(&mut rng), rng());
        let mut task = bench.task(0);
        let rows = bench.rows(&mut *task, &q, t).expect("rows");
        let at = |q: &[f64], t: f64| bench.value(&*task, q, t, 1);
        // Nested products grow, and with them the error of the differences.
        let size = 1.0 + at(&q, t)[0].abs() + rows.j.amax() + rows.lower[0].abs();
        let good = |a: f64, b: f64| (a - b).abs() <= 1e-5 * size;
        let still = difference(&at(&q, t + H), &at(&q, t - H), H)[0];
        prop_assert!(good(-rows.lower[0], still), "{}: {} is {}", value, -rows.lower[0], still);
        for dof in 0..bench.model().nv() {
            let moved = |h: f64| {
                let mut q = q.clone();
                q[dof] += h;
                at(&q, t)
            };
            let x = difference(&moved(H), &moved(-H), H)[0];
            prop_assert!(good(rows.j[(0, dof)], x), "{}, {}: {} is {}", value, dof, rows.j[(0, dof)], x);
        }
    }
}
