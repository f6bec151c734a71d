//! Trees of expressions, units, blocks and YAML forms, compared with trees written by hand.

use crate::common;

use common::good;
use hierarq_dsl::tree::*;
use hierarq_dsl::{SourceId, Syntax, parse, print};

/// A value with every operation in parentheses.
fn shape(value: &Value) -> String {
    let all = |items: &[Value]| items.iter().map(shape).collect::<Vec<_>>().join(" ");
    match &value.kind {
        ValueKind::Number(n) => n.text.clone(),
        ValueKind::Name(n) => n.clone(),
        ValueKind::Text(t) => format!("{t:?}"),
        ValueKind::Unit(of, unit) => {
            let unit: Vec<String> = unit.factors.iter().map(|(s, p)| format!("{s}{p}")).collect();
            format!("<{} {}>", shape(of), unit.join(" "))
        }
        ValueKind::Call(name, args) => format!("{}:({})", name.value, all(args)),
        ValueKind::Field(of, name) => format!("{}.{}", shape(of), name.value),
        ValueKind::List(items) => format!("[{}]", all(items)),
        ValueKind::In(of, frame) => format!("(in {} {})", shape(of), frame.value),
        ValueKind::Named(name, of) => format!("({}={})", name.value, shape(of)),
        ValueKind::Negate(of) => format!("(neg {})", shape(of)),
        ValueKind::Not(of) => format!("(not {})", shape(of)),
        ValueKind::Binary(op, a, b) => format!("({:?} {} {})", op.value, shape(a), shape(b)),
        ValueKind::Block(block) => {
            let entries: Vec<String> =
                block.entries.iter().map(|e| format!("{}={}", e.key.value, shape(&e.value))).collect();
            format!("{{{}}}", entries.join(" "))
        }
        ValueKind::Missing => "missing".to_owned(),
    }
}

fn run_body(text: &str, syntax: Syntax) -> String {
    let spec = good(text, syntax);
    match &spec.items[0].kind {
        ItemKind::Run(run) => shape(&Value { kind: ValueKind::Block(run.body.clone()), span: run.body.span }),
        other => panic!("{other:?} is no run"),
    }
}

/// Reads an entry `v` in a block of each syntax; what else the block holds is shown too.
fn check(text: &str, expected: &str) {
    assert_eq!(
        run_body(&format!("hierarq 1\nrun {{ v {text} }}"), Syntax::Native),
        format!("{{v={expected}}}"),
        "{text}"
    );
    if !text.contains(['\n', '"']) && !expected.contains('=') {
        let yaml = format!("hierarq: 1\nrun: {{ v: '{text}' }}");
        assert_eq!(run_body(&yaml, Syntax::Yaml), format!("{{v={expected}}}"), "{text}");
    }
}

#[test]
fn conditions() {
    check("f(a < b)", "f:((Less a b))");
    check("a + b < c*d", "(Less (Add a b) (Mul c d))");
    check("f(a < b and c >= d or not e)", "f:((Or (And (Less a b) (GreaterEqual c d)) (not e)))");
    check("(not a < b and c)", "(And (not (Less a b)) c)");
    check("(not not a or (b or c) and d)", "(Or (not (not a)) (And (Or b c) d))");
    check("[not a, -b <= c]", "[(not a) (LessEqual (neg b) c)]");
    check("f(not, and, or)", "f:(not and or)");
    check("(a > b)*c", "(Mul (Greater a b) c)");
    // Outside brackets a word is the next key.
    check("a and b", "a and=b");
    check("a  or 3", "a or=3");
}

#[test]
fn min_is_a_unit_and_a_key() {
    check("5 min", "<5 min1>");
    check("5 min  a 3", "<5 min1> a=3");
    check("5 N min", "<5 N1 min1>");
    check("5 N*min a 3", "<5 N1 min1> a=3");
    check("0.5 m  min 0.3 m", "<0.5 m1> min=<0.3 m1>");
    check("5 /s min -x", "<5 s-1> min=(neg x)");
    check("1  min -1", "1 min=(neg 1)");
    check("[1, 2] m min [3, 4] m", "<[1 2] m1> min=<[3 4] m1>");
    check("f(a)  min low", "f:(a) min=low");
    check("(5) min", "<5 min1>");
    check("(5) min, a 3", "<5 min1> a=3");
    check("((5) min and a)", "(And <5 min1> a)");
    check("(5) min*m", "<5 min1 m1>");
    check("3 min - 2 s", "(Sub <3 min1> <2 s1>)");
}

#[test]
fn arguments_with_a_name_keep_it() {
    let same = |a: &str, b: &str| {
        let (a, b) = (format!("hierarq 1\n{a}\n"), format!("hierarq 1\n{b}\n"));
        let x = good(&a, Syntax::Native);
        assert_eq!(print(&x, Syntax::Native).trim_end(), b.trim_end().replacen("hierarq 1\n", "hierarq 1\n\n", 1));
        // YAML says it too.
        assert_eq!(good(&print(&x, Syntax::Yaml), Syntax::Yaml), x);
    };
    same("task t = keep(a - b,min:0.3 m,gain:5 /s)", "task t = keep(a - b, min: 0.3 m, gain: 5 /s)");
    same("task t = keep(value: x, max: (a or b))", "task t = keep(value: x, max: (a or b))");
    same("task t = keep(x, min: 1){max 2}", "task t = keep(x, min: 1) { max 2 }");
    same("task t = keep(x,\n  min : [0, 1],\n)", "task t = keep(x, min: [0, 1])");
    same(
        "stack s { level l { keep(x,min:1) weight 2 other } }",
        "stack s {\n  level l { keep(x, min: 1) weight 2  other }\n}",
    );
}

#[test]
fn operators() {
    check("-a^2", "(neg (Pow a 2))");
    check("a^b^c", "(Pow a (Pow b c))");
    check("a^-b*c", "(Mul (Pow a (neg b)) c)");
    check("-a*b", "(Mul (neg a) b)");
    check("a - b - c", "(Sub (Sub a b) c)");
    check("a/b*c", "(Mul (Div a b) c)");
    check("1 - -2", "(Sub 1 (neg 2))");
    check("a + b*c^2", "(Add a (Mul b (Pow c 2)))");
    check("1 -2", "(Sub 1 2)");
}

#[test]
fn units() {
    check("5 /s", "<5 s-1>");
    check("5/s", "<5 s-1>");
    check("5 / s", "(Div 5 s)");
    check("5/(2 s)", "(Div 5 <2 s1>)");
    check("1/4 s", "(Div 1 <4 s1>)");
    check("0.5 m/s^2", "<0.5 m1 s-2>");
    check("253 N s/m", "<253 N1 s1 m-1>");
    check("3 kg m^2", "<3 kg1 m2>");
    check("3 kg*m^2", "<3 kg1 m2>");
    check("3 kg * m", "(Mul <3 kg1> m)");
    check("[0, 0, 1] m", "<[0 0 1] m1>");
    check("(a + b) rad/s", "<(Add a b) rad1 s-1>");
    check("2*sin(x) m", "(Mul 2 <sin:(x) m1>)");
    check("-5 m", "(neg <5 m1>)");
    check("0.2m", "<0.2 m1>");
    check("2ms", "<2 ms1>");
    check("1e-3 m", "<1e-3 m1>");
    check("[0.1, 0.2] m * (1 - t)", "(Mul <[0.1 0.2] m1> (Sub 1 t))");
    // A word that only begins like a unit, and a unit on the next line, are the next key.
    check("0.2  max 3", "0.2 max=3");
    check("0.2\n m 3", "0.2 m=3");
    check("0.2, m 3", "0.2 m=3");
    check("left  m 3", "left m=3");
}

#[test]
fn lines_and_brackets() {
    check("a\n  + b\n  * c", "(Add a (Mul b c))");
    check("a // half\n + b", "(Add a b)");
    check("f(x, [1, 2],)", "f:(x [1 2])");
    check("a  b [1]", "a b=[1]");
    check("frame(tool).position.x", "frame:(tool).position.x");
    check("trapezoid { to [1] m }", "{trapezoid={to=<[1] m1>}}");
    check("{ trapezoid { to [1] m } }", "{trapezoid={to=<[1] m1>}}");
    check("[{ a x }, pair { b y }]", "[{a=x} {pair={b=y}}]");
    check(r#""a \"b\" \\ \n \u{e9} //""#, r#""a \"b\" \\ \n é //""#);
}

#[test]
fn yaml_forms() {
    let check = |yaml: &str, expected: &str| {
        let text = format!("hierarq: 1\nrun:\n{yaml}");
        assert_eq!(run_body(&text, Syntax::Yaml), expected, "{yaml}");
    };
    check("  title: 3.10\n  urdf: 'a # b'\n", "{title=\"3.10\" urdf=\"a # b\"}");
    check("  package_path: [a/b, \"c d\"]\n", "{package_path=[\"a/b\" \"c d\"]}");
    check(
        "  x: \"arm_*\"\n  y: \"*_arm\"\n  z: arm_?\n  w: a*b\n",
        "{x=\"arm_*\" y=\"*_arm\" z=\"arm_?\" w=(Mul a b)}",
    );
    check("  x: '\"some text\"'\n", "{x=\"some text\"}");
    check("  x: yes\n  y: on\n  z: true\n  w: 'null'\n", "{x=yes y=on z=true w=null}");
    check("  x: >-\n    a\n    + b\n", "{x=(Add a b)}");
    check("  a: &a { x: 1, y: 2 }\n  b: { <<: *a, y: 3 }\n  c: *a\n", "{a={x=1 y=2} b={x=1 y=3} c={x=1 y=2}}");
    check("  x:\n    - 1 m\n    - [a, b]\n    - c: d\n", "{x=[<1 m1> [a b] {c=d}]}");
}

#[test]
fn spans_in_yaml_are_exact() {
    let text = "hierarq: 1\nrun:\n  a: ünknown\n  é: 1\n  b: 1 +  left.tip\n  c: \"2*right\"\n  d: \"\\u0032*right\"\n";
    let (spec, _) = parse(SourceId(0), text, Syntax::Yaml);
    let ItemKind::Run(run) = &spec.items[0].kind else { panic!("no run") };
    let right = |key: &str| match &run.body.get(key).unwrap().value.kind {
        ValueKind::Binary(_, _, right) => &text[right.span.range()],
        other => panic!("{other:?}"),
    };
    assert_eq!(right("b"), "left.tip");
    assert_eq!(right("c"), "right");
    assert_eq!(right("d"), "\"\\u0032*right\"");
}

/// A limit `min` behind any value, on one line: it is printed with a comma only where it would be taken for minutes, and
/// read as it was.
#[test]
fn limits_behind_values() {
    let values =
        ["5", "-5", "0.3 m", "(5) min", "(1 + 2)", "(a or b)", "f(a)", "f(a).x", "[1, 2]", "[1, 2] m", "5 /s", "a"];
    let more = ["a*5", "a - b", "not a", "2*f(a)", "(5) min*m", "3 in a", "\"a\""];
    let limits = ["5", "0.3 m", "-5", "-x", "x", "f(x)", "x.y", "[1, 2] m", "(1 + 2) m", "\"t\"", "{ a 1 }", "x and y"];
    let mut commas = 0;
    for value in values.iter().chain(&more) {
        for limit in limits {
            let text = format!("hierarq 1\ntask t = keep {{ max {value}, min {limit}, gain 3 /s }}\n");
            let Some(spec) = Some(parse(SourceId(0), &text, Syntax::Native)).filter(|p| p.1.is_empty()).map(|p| p.0)
            else {
                continue;
            };
            let printed = print(&spec, Syntax::Native);
            assert_eq!(good(&printed, Syntax::Native), spec, "{printed}");
            if printed.contains(", min") {
                commas += 1;
                let without = printed.replace(", min", "  min");
                let (read, mistakes) = parse(SourceId(0), &without, Syntax::Native);
                assert!(read != spec || !mistakes.is_empty(), "a comma for nothing: {printed}");
            }
        }
    }
    assert!((1..60).contains(&commas), "{commas} commas");
}
