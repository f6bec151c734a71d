//! Values reported as unreachable are unreachable: intervals compared with the numbers inside them, ranges with values
//! at random configurations, jumps with both sides of a changing comparison.

use crate::common;

use common::state::{ARM7, Bench, CANOPIES, program, rng, words};
use common::{compile_text, examples};
use dsl::Syntax;
use hierarq_compiler::expr::Interval;
use proptest::prelude::*;
use runtime::program::Op;

/// Values of each kind that has bounds, with their number of components; `@` names frames and joints.
const VALUES: &[(usize, &str)] = &[
    (3, "frame(@A).position"),
    (3, "point(@A, [0.1, -0.2, 0.3] m)"),
    (1, "frame(@A).position.z"),
    (1, "2*joint(@J) - joint(@K)"),
    (1, "distance(finger, base_point)"),
    (1, "distance(lower, upper)"),
    (1, "distance(finger, plane([0.1, 0, -0.2] m, [0.2, -0.3, 2]))"),
    (3, "com"),
    (3, "com in @A"),
    (3, "frame(@A).position - frame(@B).position"),
    (3, "(frame(@A).position + 3*frame(@B).position)/4"),
    (3, "frame(@A).position in @B"),
    (1, "norm(frame(@A).position - frame(@B).position)"),
    (1, "norm(frame(@A).position - [0.1, 0.2, 0.3] m)"),
    (3, "frame(@A).orientation*[1, 2, 3] m + frame(@B).position*2"),
    (3, "frame(@A).orientation*[0, 0, 1]"),
    (3, "inverse(frame(@B).orientation)*frame(@A).orientation*[0, 0.6, 0.8]"),
    (3, "slerp(frame(@A).orientation, frame(@B).orientation, 0.3)*[1, 0, 0]"),
    (1, "dot(frame(@A).orientation*[0, 0, 1], frame(@B).orientation*[0, 1, 0])"),
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
    (3, "lerp(frame(@A).position, frame(@B).position, 0.3 + 0.1*sin(2*pi*t/(3 s)))"),
    (1, "smoothstep(0.5 + 0.2*sin(joint(@J)))"),
    (1, "norm(frame(@A).position - [0.1 + 0.05*sin(2 rad/s * t), 0, 0.9 + 0.1*t/(1 s)] m)*(1 + time/(2 s))"),
    (1, "1/(3 + joint(@J)/(1 rad)) - (2 + sin(joint(@K)))^-2"),
];

/// Codes and messages of a spec's diagnostics.
fn codes(text: &str) -> Vec<(&'static str, String)> {
    let compiled = compile_text(text, Syntax::Native, &examples(), &[]);
    compiled.report.diagnostics.iter().map(|d| (d.code, format!("{} {}", d.message, d.primary.text))).collect()
}

/// A spec for one robot with these tasks.
fn spec(robot: &str, tasks: &[String]) -> String {
    let tasks: Vec<String> = tasks.iter().map(|t| words(t, robot)).collect();
    format!("hierarq 1\n{robot}stack s {{ level all {{\n{}\n}} }}\nrun {{ duration 1 s }}\n", tasks.join("\n"))
}

#[test]
fn what_the_robot_reaches_is_never_out_of_reach() {
    let tasks: Vec<String> = VALUES
        .iter()
        .map(|(len, v)| format!("track({v}) {{ target {}  gain 0 /s }}", if *len == 1 { "0" } else { "[0, 0, 0]" }))
        .collect();
    for robot in [ARM7, CANOPIES] {
        let program = program(robot, &tasks);
        let bench = Bench { program: &program, inputs: vec![] };
        let mut rng = rng(11);
        for k in 0..20 {
            let q = bench.model().random_configuration(&mut rng);
            let t = f64::from(k % 3);
            let reached = VALUES.iter().enumerate().map(|(i, (len, value))| {
                let numbers = bench.value(&*bench.task(i), &q, t, *len);
                let text: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
                let target = if *len == 1 { text[0].clone() } else { format!("[{}]", text.join(", ")) };
                format!("track({value}) {{ target {target} }}")
            });
            let found = codes(&spec(robot, &reached.collect::<Vec<_>>()));
            let wrong: Vec<_> = found.iter().filter(|(code, _)| *code == "HQ0520").collect();
            assert!(wrong.is_empty(), "{wrong:#?}");
        }
    }
}

/// Bounds of targets and limits are tight: factor 1 is the bound itself.
#[test]
fn bounds_are_as_tight_as_they_can_be() {
    // The finger of the single arm reaches as far as the lengths of its links.
    let cases: &[(&str, f64)] = &[
        ("track(dot(frame(@A).orientation*[0, 0.6, 0.8], frame(@B).orientation*[1, 0, 0])) { target @ }", 1.0),
        ("track(sin(joint(@J)) + 2) { target @ }", 3.0),
        ("track(norm(frame(@A).orientation*[2, 0, 0] + [0, 0, 1])) { target @ }", 3.0),
        ("track(norm([0, 0, 1] - 2*normalize(frame(@A).position))) { target @ }", 3.0),
        ("keep(5*dot(frame(@A).orientation*[0, 0, 1], [0, 0, 1])) { min @ }", 5.0),
        ("keep(-abs(joint(@J))) { min @ rad }", 0.0),
    ];
    for (task, bound) in cases {
        let said = |x: f64| {
            let found =
                codes(&spec(ARM7, &[task.replace('@', "#").replace("# ", &format!("{x:?} ")).replace('#', "@")]));
            found.iter().any(|(code, _)| *code == "HQ0520")
        };
        assert!(said(bound + 1e-3), "{task} beyond {bound}");
        assert!(!said(bound - 1e-3), "{task} within {bound}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// `if(t < k, a + b t, c + d t)` jumps if the two lines differ at k, and only if the time k is reached.
    #[test]
    fn lines_that_meet_do_not_jump(a in -2..3_i32, b in -2..3_i32, c in -2..3_i32, d in -2..3_i32, k in -1..3_i32) {
        let target = format!("if(t < {k} s, ({a} + {b}*t/(1 s)) deg, ({c} + {d}*t/(1 s)) deg)");
        let found = codes(&spec(ARM7, &[format!("track(joint(@J)) {{ target {target} }}")]));
        let jumps = k > 0 && a + b * k != c + d * k;
        prop_assert_eq!(found.iter().any(|(code, _)| *code == "HQ0521"), jumps, "{}: {:?}", target, found);
    }
}

/// Discontinuous expressions, and continuous ones that look similar.
#[test]
fn jumps() {
    let cases = [
        ("track(joint(@J)) { target if(joint(@K) > 20 deg, 1 deg, 2 deg) }", true),
        ("track(if(joint(@K) > 20 deg, 1, 2)*joint(@J)) { target 2 deg }", false),
        ("track(if(joint(@K) > 0 deg, 1, -1)*joint(@K)) { target 2 deg }", false),
        ("track(if(joint(@K) > 0 deg, joint(@K), -joint(@K))) { target 2 deg }", false),
        ("track(if(joint(@K) > 0 deg, joint(@K) + 1 deg, -joint(@K))) { target 2 deg }", true),
        ("track(joint(@J)) { target if((t > 1 s and t < 2 s), 1 deg, 2 deg) }", true),
        ("track(joint(@J)) { target if(t < -1 s, 1 deg, 2 deg) }", false),
        ("track(joint(@J)) { target lerp(1 deg, 2 deg, smoothstep(t/(1 s))) }", false),
        ("track(joint(@J)) { target clamp(t*1 deg/(1 s), 0 deg, 3 deg) }", false),
        ("keep(joint(@J)) { min if(t > 1 s, -50 deg, -60 deg) }", true),
        ("keep(joint(@J)) { min if(t > 1 s, -50 deg, -50 deg) }", false),
        ("track(frame(@A).orientation) { target if(t > 1 s, rpy(0, 0, 0), rpy(0, 0, 1 rad)) }", true),
        ("keep(joint(@J)) { min -50 deg  gain if(t > 1 s, 1 /s, 2 /s) }", false),
    ];
    for (task, jumps) in cases {
        let found = codes(&spec(ARM7, &[task.to_string()]));
        assert_eq!(found.iter().any(|(code, _)| *code == "HQ0521"), jumps, "{task}: {found:?}");
    }
}

fn interval() -> impl Strategy<Value = Interval> {
    (-4.0..4.0_f64, 0.0..3.0_f64).prop_map(|(low, width)| Interval::new(low, low + width))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Every operation maps numbers of its operands' intervals into its own interval.
    #[test]
    fn numbers_lie_in_their_interval(
        a in interval(), b in interval(), c in interval(), shares in prop::array::uniform3(0.0..=1.0_f64), n in -4..5_i32,
    ) {
        let operands = [a, b, c];
        let numbers: Vec<f64> = operands.iter().zip(shares).map(|(i, s)| i.low + s * (i.high - i.low)).collect();
        let all = [
            Op::Add(0, 1), Op::Sub(0, 1), Op::Sub(0, 0), Op::Mul(0, 1), Op::Mul(0, 0), Op::Div(0, 1), Op::Neg(0),
            Op::Sin(0), Op::Cos(0), Op::Asin(0), Op::Acos(0), Op::Atan2(0, 1), Op::Exp(0), Op::Log(0), Op::Sqrt(0),
            Op::Abs(0), Op::Powi(0, n), Op::Min(0, 1), Op::Max(0, 1), Op::Less(0, 1), Op::LessEqual(0, 1),
            Op::Select(0, 1, 2),
        ];
        for op in all {
            let range = Interval::of(op, |i| operands[i], |_| Interval::ALL);
            let value = op.value(|i| numbers[i], |_| f64::NAN);
            prop_assert!(value.is_nan() || (range.low <= value && value <= range.high), "{:?}: {} in {:?}", op, value, range);
        }
    }
}
