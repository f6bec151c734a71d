//! Expressions: values, units, precedence, and rates compared with central differences in time.

use std::f64::consts::PI;

use dsl::tree::{ItemKind, Value};
use dsl::{Diagnostic, Span, Spanned, Syntax};
use hierarq_compiler::expr::{Axes, FUNCTIONS, Frame, Graph, Kind, Lowering, Meaning, RobotStateTerm, Scope, Typed};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use runtime::program::{Output, Tape, Times};

/// Scope without names, in which `initial(position)` and `initial(orientation)` are the inputs 0..3 and 3..7.
struct Initial;

impl Scope for Initial {
    fn name(&mut self, _: &str) -> Meaning {
        Meaning::Unknown
    }

    fn names(&self) -> Vec<String> {
        Vec::new()
    }

    fn presence(&mut self, _: &str) -> Option<usize> {
        None
    }

    fn initial(&mut self, graph: &mut Graph, argument: &Value, span: Span, _: &mut Vec<Diagnostic>) -> Option<Typed> {
        let turn = matches!(&argument.kind, dsl::tree::ValueKind::Name(n) if n == "orientation");
        let (kind, inputs) = if turn { (Kind::Rotation, 3..7) } else { (Kind::Vector, 0..3) };
        let dimension = stdlib_tasks::dimension::Dimension { m: i8::from(!turn), ..stdlib_tasks::dimension::NONE };
        let nodes = inputs.map(|k| graph.push(runtime::program::Op::Input(k))).collect();
        Some(Typed { kind, dimension, nodes, bare: false, axes: Axes::default(), span })
    }

    fn frame(&mut self, _: &Spanned<String>, _: &mut Vec<Diagnostic>) -> Option<Frame> {
        None
    }

    fn now(&mut self, _: &mut Graph, _: &RobotStateTerm, _: Span, _: &mut Vec<Diagnostic>) -> Option<Typed> {
        None
    }
}

/// An expression, compiled for evaluation.
struct Expression {
    tape: Tape,
    unit: String,
    constant: Option<Vec<f64>>,
}

fn expression(text: &str) -> Expression {
    let whole = format!("hierarq 1\nparam x = {text}\n");
    let (spec, mut diagnostics) = dsl::parse(dsl::SourceId(0), &whole, Syntax::Native);
    let value = spec.items.into_iter().find_map(|i| match i.kind {
        ItemKind::Param(p) => Some(p.value),
        _ => None,
    });
    let mut graph = Graph::default();
    let typed = Lowering { graph: &mut graph, scope: &mut Initial, diagnostics: &mut diagnostics }
        .value(&value.expect("a value"))
        .ok();
    let errors: Vec<&Diagnostic> = diagnostics.iter().filter(|d| d.severity == dsl::Severity::Error).collect();
    let typed = typed.unwrap_or_else(|| panic!("{text}: {errors:?}"));
    assert!(errors.is_empty(), "{text}: {errors:?}");
    let constant = typed.nodes.iter().map(|&n| graph.constant(n)).collect();
    let pairs: Vec<(usize, usize)> = typed.nodes.iter().map(|&n| (n, graph.rate(n))).collect();
    let roots: Vec<usize> = pairs.iter().flat_map(|p| [p.0, p.1]).collect();
    let (ops, index) = graph.extract(&roots);
    let outputs =
        pairs.iter().enumerate().map(|(at, p)| Output { at, value: index[&p.0], rate: index[&p.1] }).collect();
    Expression {
        tape: Tape { ops, outputs, inputs: 7, ..Tape::default() },
        unit: typed.dimension.to_string(),
        constant,
    }
}

/// Values of `initial(position)` and `initial(orientation)`: a rotation of 0.7 rad about (1, 2, 2)/3.
fn start() -> (Vector3<f64>, UnitQuaternion<f64>) {
    let axis = nalgebra::Unit::new_normalize(Vector3::new(1.0, 2.0, 2.0));
    (Vector3::new(0.3, -0.2, 0.9), UnitQuaternion::from_axis_angle(&axis, 0.7))
}

impl Expression {
    /// Values and rates at time `t`.
    fn at(&self, t: f64) -> (Vec<f64>, Vec<f64>) {
        let (p, r) = start();
        let inputs = [p.x, p.y, p.z, r.w, r.i, r.j, r.k];
        let mut registers = vec![0.0; self.tape.ops.len()];
        let (mut values, mut rates) = (vec![0.0; self.tape.outputs.len()], vec![0.0; self.tape.outputs.len()]);
        self.tape.evaluate(Times { t, time: t + 2.0 }, &inputs, &[], &mut registers, &mut values, &mut rates);
        (values, rates)
    }

    /// Compares rates with central differences.
    fn check_rate(&self, t: f64, text: &str) {
        let h = 1e-5;
        let (after, before, rates) = (self.at(t + h).0, self.at(t - h).0, self.at(t).1);
        for ((a, b), rate) in after.iter().zip(&before).zip(rates) {
            let expected = (a - b) / (2.0 * h);
            assert!((rate - expected).abs() <= 1e-6 * (1.0 + expected.abs()), "{text} at {t}: {rate}, not {expected}");
        }
    }
}

fn value(text: &str) -> f64 {
    expression(text).at(0.0).0[0]
}

/// Moving expressions for every function and operator; each is smooth between 0.2 and 1.2 s.
const MOVING: &[&str] = &[
    "sin(2*t/(1 s))",
    "cos(0.5 rad/s * time)",
    "tan(0.3*t/(1 s))",
    "exp(-t/(3 s))",
    "log(1 + t/(1 s))",
    "sqrt(2 + t/(1 s))",
    "sqrt((1 m^2)*(2 + t/(1 s)))",
    "abs(t - 5 s)",
    "abs(t + 5 s)",
    "min(t, 7 s)",
    "min(9 s, 2*t)",
    "max(t, -1 s, time)",
    "clamp(t, 0 s, 9 s)",
    "clamp(t, 4 s, 9 s)",
    "lerp(1 m, 3 m, t/(2 s))",
    "lerp([1, 0, 0] m, [0, 2, 5] m, smoothstep(t/(2 s)))",
    "smoothstep(t/(1.5 s))",
    "norm([t, 2*t, 1 s])",
    "dot([t, 1 s, 2 s], [1, t/(1 s), 3])",
    "cross([t, 1 s, 2 s], [1, t/(1 s), 3])",
    "angle_between([t, 1 s, 2 s], [1, t/(1 s), 3])",
    "rpy(t*0.2 rad/s, 0.1 rad, -t*0.3 rad/s)",
    "axis_angle([1, 2, t/(1 s)], 0.4 rad/s * t)",
    "quaternion(1, t/(1 s), 0.5, -0.25)",
    "normalize([t, 1 s, -0.3 s])",
    "asin(0.5*t/(1 s))",
    "acos(0.5*t/(1 s))",
    "atan2(t, 1 s - 2*t)",
    "if(t < 0.7 s, t, t^2/(1 s))",
    "if((t > 0.5 s and not (t >= 0.9 s) or t <= 0.3 s), 2*t, -t)",
    "inverse(rpy(0.5 rad/s * t, 0.2 rad, 0))",
    "slerp(rpy(0, 0, 0.5 rad/s * t), rpy(0.3 rad, 0.4 rad/s * t, 1 rad), 0.2 + 0.5*t/(1 s))",
    "if(t < 0.5 s, rpy(0, 0, 1 rad/s * t), rpy(1 rad/s * t, 0, 0))",
    "pose([t, 1 s, -2*t]*1 m/s, rpy(t*0.2 rad/s, 0.1 rad, -t*0.3 rad/s))",
    "pose([0.1, 0, 0] m, rpy(0, 0, 0.5 rad/s * t))*pose([0, 0.2, t/(1 s)] m, rpy(0.3 rad/s * t, 0, 0))",
    "inverse(pose([0.1, 0, t/(1 s)] m, rpy(0, 0, 0.5 rad/s * t)))",
    "lerp(pose([0.1, 0, t/(1 s)] m, rpy(0, 0, 0.5 rad/s * t)), pose([1, 2, 3] m, rpy(1 rad, 0, 0)), 0.2 + 0.5*t/(1 s))",
    "(pose([0.1, 0, 0] m, rpy(0, 0, 0.5 rad/s * t))*[1, 2, 3] m).x",
    "t + 2*time",
    "3 s - t",
    "t*t",
    "(1 s)/(1 + t/(1 s))",
    "t/(2 s)/(1 + time/(1 s))",
    "-t",
    "t^2",
    "t^-3",
    "(1 + t/(1 s))^5",
    "[t, -t, t^2/(1 s)]",
    "[1, 2, 3] m * t/(1 s)",
    "initial(position) + [0.1, 0.2, 0.05] m * (1 - cos(pi*t/(4 s)))",
    "initial(orientation)*rpy(0, 0.2 rad/s * t, 0)",
    "rpy(0, 0, 0.5 rad/s * t)*[1, 2, 3] m",
];

#[test]
fn every_function_moves_in_some_expression() {
    for f in FUNCTIONS {
        let call = format!("{}(", f.name);
        assert!(MOVING.iter().any(|m| m.contains(&call)), "`{}` is not tried", f.name);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rates_are_derivatives(t in 0.2..1.2_f64) {
        for text in MOVING {
            expression(text).check_rate(t, text);
        }
    }

    /// Constant folding agrees with evaluation: an expression with a number in place of `t`, and with `t` at that time.
    #[test]
    fn folding_evaluates(x in 0.2..1.2_f64) {
        for text in MOVING.iter().filter(|m| !m.contains("initial") && !m.contains("time")) {
            let words: Vec<String> = text.split_inclusive(|c: char| !c.is_alphanumeric() && c != '_').map(|w| {
                let word = w.trim_end_matches(|c: char| !c.is_alphanumeric() && c != '_');
                if word == "t" { w.replacen('t', &format!("({x:?} s)"), 1) } else { w.to_string() }
            }).collect();
            let folded = expression(&words.concat());
            let constant = folded.constant.clone().expect("constant");
            let moving = expression(text);
            prop_assert_eq!(&moving.unit, &folded.unit, "{}", text);
            for (a, b) in constant.iter().zip(moving.at(x).0) {
                prop_assert!((a - b).abs() <= 1e-12 * (1.0 + a.abs()), "{}: {} and {}", text, a, b);
            }
        }
    }
}

#[test]
fn precedence() {
    for (text, is) in [
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("12/2*3", 18.0),
        ("12/(2*3)", 2.0),
        ("12/2/3", 2.0),
        ("2 - 3 - 4", -5.0),
        ("2 - (3 - 4)", 3.0),
        ("2 + 3*4", 14.0),
        ("-3*-2", 6.0),
        ("2*-3^2", -18.0),
        ("2^-1", 0.5),
        ("--3", 3.0),
        ("if(1 + 1 < 3, 1, 2)", 1.0),
        ("if((1 < 2 or 1 < 2 and 2 < 1), 1, 2)", 1.0),
        ("if(((1 < 2 or 1 < 2) and 2 < 1), 1, 2)", 2.0),
        ("if((not 1 < 2 or true), 1, 2)", 1.0),
        ("if(not (1 < 2 or true), 1, 2)", 2.0),
        ("if((true and not false), 1, 2)", 1.0),
        ("if(2 <= 2, 1, 2) + if(2 < 2, 10, 20) + if(2 >= 2, 100, 200) + if(2 > 2, 1000, 2000)", 2121.0),
        ("if(true, if(false, 1, 2), 3)", 2.0),
        ("atan2(1, -1)/(1 rad)", 0.75 * PI),
        ("atan2(0 m, 0 m)/(1 rad)", 0.0),
        ("asin(1)/(1 rad)", PI / 2.0),
        ("acos(-1)/(1 rad)", PI),
        ("norm(normalize([3, 4, 12] m))", 1.0),
    ] {
        assert_eq!(value(text), is, "{text}");
    }
}

#[test]
fn units_become_si() {
    for (text, is, unit) in [
        ("1 km", 1000.0, "m"),
        ("25 mm", 0.025, "m"),
        ("3 cm + 1 m", 1.03, "m"),
        ("180 deg", PI, "rad"),
        ("0.5 turn", PI, "rad"),
        ("30 rpm", PI, "rad/s"),
        ("2 min", 120.0, "s"),
        ("1 kHz", 1000.0, "1/s"),
        ("5 /s", 5.0, "1/s"),
        ("36 km/h", 10.0, "m/s"),
        ("2 kN", 2000.0, "N"),
        ("3 Nm", 3.0, "N m"),
        ("(6 m)/(2 s)", 3.0, "m/s"),
        ("(6 m)/(2 m)", 3.0, "1"),
        ("(3 m)^2", 9.0, "m^2"),
        ("sqrt(9 m^2)", 3.0, "m"),
        ("norm([3, 4, 0] cm)", 0.05, "m"),
        ("0 + 2 m", 2.0, "m"),
    ] {
        let e = expression(text);
        assert!((e.at(0.0).0[0] - is).abs() < 1e-12 * is.abs().max(1.0), "{text}: {}", e.at(0.0).0[0]);
        assert_eq!(e.unit, unit, "{text}");
    }
}

/// Quaternions of the language compared with rotations of nalgebra.
#[test]
fn orientations() {
    let q = |text: &str| {
        let v = expression(text).at(0.8).0;
        UnitQuaternion::new_unchecked(Quaternion::new(v[0], v[1], v[2], v[3]))
    };
    let (_, initial) = start();
    for (text, is) in [
        ("rpy(0.3 rad, -0.8 rad, 1.9 rad)", Rotation3::from_euler_angles(0.3, -0.8, 1.9).into()),
        ("axis_angle([0, 0, 2], 90 deg)", UnitQuaternion::from_euler_angles(0.0, 0.0, PI / 2.0)),
        ("quaternion(2, 0, 0, 2)", UnitQuaternion::from_euler_angles(0.0, 0.0, PI / 2.0)),
        ("initial(orientation)*rpy(0, 0, 1 rad)", initial * UnitQuaternion::from_euler_angles(0.0, 0.0, 1.0)),
        ("inverse(rpy(0, 0, 1 rad))", UnitQuaternion::from_euler_angles(0.0, 0.0, -1.0)),
        ("slerp(rpy(0, 0, 0), rpy(0, 0, 1 rad), 0.25)", UnitQuaternion::from_euler_angles(0.0, 0.0, 0.25)),
        ("slerp(rpy(0, 0, -2 rad), rpy(0, 0, 2 rad), 0.5)", UnitQuaternion::from_euler_angles(0.0, 0.0, PI)),
        (
            "slerp(initial(orientation), rpy(0.3 rad, -0.8 rad, 1.9 rad), 0.3)",
            initial.slerp(&Rotation3::from_euler_angles(0.3, -0.8, 1.9).into(), 0.3),
        ),
        ("rpy(0, 1 rad, 0)*initial(orientation)", UnitQuaternion::from_euler_angles(0.0, 1.0, 0.0) * initial),
    ] {
        assert!(q(text).angle_to(&is) < 1e-7, "{text}: {} and {is}", q(text));
        assert!((q(text).norm() - 1.0).abs() < 1e-12);
    }
    let turned = expression("rpy(0.3 rad, -0.8 rad, 1.9 rad)*[1, 2, 3] m").at(0.0).0;
    let expected = Rotation3::from_euler_angles(0.3, -0.8, 1.9) * Vector3::new(1.0, 2.0, 3.0);
    assert!((Vector3::from_column_slice(&turned) - expected).norm() < 1e-12);
}

/// Targets of the thesis's experiments as written in the examples, compared with the printed formulae (thesis (3.44) to
/// (3.53); the first component of (3.47) is printed `cos(1 - ..)`, and the examples correct it).
#[test]
fn targets_of_the_experiments() {
    let specs = ["uncooperative_motion.hq", "cooperative_motion.hq"].map(|name| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
        std::fs::read_to_string(path).expect("an example")
    });
    // The expression before a comment that names its equation, without the prefixes of the task's own values.
    let written = |equation: &str| {
        let line = specs.iter().flat_map(|s| s.lines()).find(|l| l.contains(&format!("  // ({equation})")));
        let line = line.unwrap_or_else(|| panic!("({equation}) is in no example")).trim();
        let (code, _) = line.split_once("  //").expect("a comment");
        let (_, value) = code.split_once(' ').expect("a key and a value");
        ["left.", "right.", "absolute.", "relative."].iter().fold(value.to_string(), |v, p| v.replace(p, ""))
    };
    let (p, r) = start();
    for k in 0..40 {
        let t = 0.21 * f64::from(k);
        let (slow, fast) = (1.0 - (PI * t / 4.0).cos(), 1.0 - (PI / 2.0 * t).cos());
        for (equation, is) in [
            ("3.44", Vector3::new(0.1, 0.2, 0.05) * slow),
            ("3.47", Vector3::new(0.1, 0.4, -0.05) * slow),
            ("3.50", Vector3::new(0.05, 0.1, 0.0) * fast),
            ("3.51", Vector3::new(0.1, 0.0, 0.1) * fast),
        ] {
            let v = expression(&written(equation)).at(t).0;
            assert!((Vector3::from_column_slice(&v) - (p + is)).norm() < 1e-12, "({equation}) at {t}");
        }
        for (equation, is) in [
            ("3.45", Rotation3::from_euler_angles(0.0, -PI / 8.0 * slow, 0.0)),
            ("3.48", Rotation3::from_euler_angles(0.0, 0.0, -PI / 8.0 * slow)),
            ("3.52", Rotation3::from_euler_angles(0.0, 0.0, -PI / 8.0 * fast)),
        ] {
            let v = expression(&written(equation)).at(t).0;
            let is = r.to_rotation_matrix() * is;
            let q = UnitQuaternion::new_normalize(Quaternion::new(v[0], v[1], v[2], v[3])).to_rotation_matrix();
            assert!((q.matrix() - is.matrix()).norm() < 1e-12, "({equation}) at {t}");
        }
    }
}
