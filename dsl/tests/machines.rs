//! Signals, machines and scenarios: the two syntaxes side by side, what the printer makes of them, and how formulas are
//! taken apart, written out by hand.

use crate::common;

use common::{good, trees};
use hierarq_dsl::tree::*;
use hierarq_dsl::{SourceId, Span, Spanned, Syntax, parse, print};
use proptest::prelude::*;

const HQ: &str = include_str!("common/machines.hq");
const YAML: &str = include_str!("common/machines.yaml");

#[test]
fn the_syntaxes_are_equal() {
    assert_eq!(good(HQ, Syntax::Native), good(YAML, Syntax::Yaml));
}

#[test]
fn the_formatted_texts_stay_as_they_are() {
    assert_eq!(print(&good(HQ, Syntax::Native), Syntax::Native), HQ);
    assert_eq!(print(&good(YAML, Syntax::Yaml), Syntax::Yaml), YAML);
}

#[test]
fn translations_keep_comments() {
    for (text, from, to) in [(HQ, Syntax::Native, Syntax::Yaml), (YAML, Syntax::Yaml, Syntax::Native)] {
        let there = print(&good(text, from), to);
        for comment in ["seen by the cameras", "whatever happens", "the long way", "asks the operator", "of the hands"]
        {
            assert!(there.contains(comment), "`{comment}` was lost:\n{there}");
        }
    }
}

/// A comment behind an item of a list stays with it, in its syntax and in the other.
#[test]
fn comments_of_items_stay_with_them() {
    let hq = "hierarq 1

scenario day {
  happens [
    { at 10 s  late h1  by 5 s },  // the box jams
    { at 100 s  lost r },
    { at 150 s  lost m },  // flat battery
    { at 200 s  back r },  // charged
  ]
}
";
    let yaml = "hierarq: 1

scenarios:
  day:
    happens:
      - { at: 10 s, late: h1, by: 5 s }  # the box jams
      - { at: 100 s, lost: r }
      - { at: 150 s, lost: m }  # flat battery
      - { at: 200 s, back: r }  # charged
";
    let (one, other) = (good(hq, Syntax::Native), good(yaml, Syntax::Yaml));
    assert_eq!(print(&one, Syntax::Native), hq);
    assert_eq!(print(&other, Syntax::Yaml), yaml);
    assert_eq!(print(&one, Syntax::Yaml), yaml);
    assert_eq!(print(&other, Syntax::Native), hq);
    // Items of several lines end with theirs.
    let tall = "hierarq 1

scenario day {
  happens [
    {
      at 10 s  // or later
      late h1
      by 5 s
    },  // the box jams
    { at 100 s  lost r },
  ]
}
";
    let read = good(tall, Syntax::Native);
    assert_eq!(print(&read, Syntax::Native), tall);
    let there = print(&read, Syntax::Yaml);
    let (jams, next) = (there.find("# the box jams"), there.find("100 s"));
    assert!(jams.is_some() && jams < next, "{there}");
    assert_eq!(print(&good(&there, Syntax::Yaml), Syntax::Yaml), there);
}

/// A formula with every operation in parentheses.
fn shape(f: &Formula) -> String {
    use FormulaKind as F;
    let window = |w: &Window| {
        let end = |v: &Option<Value>| v.as_ref().map_or(String::new(), number);
        if w.is_open() { String::new() } else { format!("[{}..{}]", end(&w.from), end(&w.to)) }
    };
    match &f.kind {
        F::Always(w, a) => format!("(always{} {})", window(w), shape(a)),
        F::Eventually(w, a) => format!("(eventually{} {})", window(w), shape(a)),
        F::Never(w, a) => format!("(never{} {})", window(w), shape(a)),
        F::Until(a, w, b) => format!("(until{} {} {})", window(w), shape(a), shape(b)),
        F::After(a, b) => format!("(after {} {})", shape(a), shape(b)),
        F::Not(a) => format!("(not {})", shape(a)),
        F::And(a, b) => format!("(and {} {})", shape(a), shape(b)),
        F::Or(a, b) => format!("(or {} {})", shape(a), shape(b)),
        F::Implies(a, b) => format!("(implies {} {})", shape(a), shape(b)),
        F::Value(v) => number(v),
        F::Missing => "missing".to_owned(),
    }
}

fn number(v: &Value) -> String {
    match &v.kind {
        ValueKind::Number(n) => n.text.clone(),
        ValueKind::Unit(of, _) => number(of),
        ValueKind::Name(n) => n.clone(),
        ValueKind::Call(n, args) => format!("{}({})", n.value, args.iter().map(number).collect::<Vec<_>>().join(" ")),
        ValueKind::Binary(op, a, b) => format!("{}{}{}", number(a), op.value.text(), number(b)),
        other => format!("{other:?}"),
    }
}

fn expects(text: &str, syntax: Syntax) -> Vec<Expect> {
    good(text, syntax)
        .items
        .into_iter()
        .filter_map(|item| match item.kind {
            ItemKind::Scenario(s) => Some(s.expects),
            _ => None,
        })
        .flatten()
        .collect()
}

/// A formula in both syntaxes; printing it gives the same formula.
fn check(text: &str, expected: &str) {
    let hq = format!("hierarq 1\nscenario s {{ expect {text} }}\n");
    let yaml = format!("hierarq: 1\nscenarios: {{ s: {{ expect: ['{text}'] }} }}\n");
    let all = expects(&hq, Syntax::Native);
    assert_eq!(shape(&all[0].formula), expected, "{text}");
    assert_eq!(expects(&yaml, Syntax::Yaml), all, "{text}");
}

#[test]
fn formulas() {
    check("always a and b or c", "(always (or (and a b) c))");
    check("(always a) and b", "(and (always a) b)");
    check("always (a) and b", "(always (and a b))");
    check("always(a) and b", "(always (and a b))");
    check("(a and always(b))", "(and a (always b))");
    check("a and always b or c", "(and a (always (or b c)))");
    check("always a until b", "(until (always a) b)");
    check("a until within 3 s b and c", "(until[..3] a (and b c))");
    check("a until from 1 s to 2 s : b until c", "(until[1..2] a (until b c))");
    check("a implies b implies c until d", "(implies a (implies b (until c d)))");
    check("not a and b", "(and (not a) b)");
    check("not always a and b", "(not (always (and a b)))");
    check("not (a or b)", "(not (or a b))");
    check("(not a < 3)", "(not a<3)");
    check("within 25 s in(grasp)", "(eventually[..25] in(grasp))");
    check("within 25 s : always a", "(always[..25] a)");
    check("eventually within 25 s : always a", "(eventually[..25] (always a))");
    check("from 2 s to 5 s : always a < 5 mm", "(always[2..5] a<5)");
    check("always from 2 s a", "(always[2..] a)");
    check("never to 2 s : a", "(never[..2] a)");
    check("after in(ask) : within 25 s : in(grasp)", "(after in(ask) (eventually[..25] in(grasp)))");
    check("after a and b : c implies d", "(implies (after (and a b) c) d)");
    check("after after a : b : c", "(after (after a b) c)");
    check("after always : a : b", "(after (always a) b)");
    check("in(look) until within 20 s : (in(ask) or in(pre))", "(until[..20] in(look) (or in(ask) in(pre)))");
    check("(a + b) < c", "a+b<c");
    check("((a))", "a");
}

#[test]
fn actions_without_parentheses_are_those_with() {
    let read =
        |text: &str| match &good(&format!("hierarq 1\nmachine m {{ enter {text} }}\n"), Syntax::Native).items[0].kind {
            ItemKind::Machine(m) => m.body.actions[0].clone(),
            other => panic!("{other:?}"),
        };
    for (bare, called) in [
        ("say \"a\"", "say(\"a\")"),
        ("gripper close right", "gripper(close, right)"),
        ("wait 3 s", "wait(3 s)"),
        ("wait fast 3 min", "wait(fast, 3 min)"),
        ("home", "home()"),
    ] {
        assert_eq!(read(bare), read(called), "{bare}");
        assert_eq!(good(&format!("hierarq: 1\nmachines: {{ m: {{ enter: '{bare}' }} }}"), Syntax::Yaml).items.len(), 1);
    }
}

#[test]
fn states_on_one_line() {
    let text = "hierarq 1\nmachine m { initial a  state a { stack s do f(x) on b -> c on d -> e blend 1 s after 3 min -> a.b } final state c { stack t } final state e }\n";
    let ItemKind::Machine(m) = &good(text, Syntax::Native).items[0].kind else { panic!("no machine") };
    let a = &m.body.states[0];
    let to: Vec<&str> = a.body.transitions.iter().map(|t| t.target.as_str()).collect();
    assert_eq!((m.body.states.len(), to), (3, vec!["c", "e", "a.b"]));
    assert_eq!(a.body.transitions[1].settings.entries.len(), 1);
}

/// A slip in one state leaves the others as they are.
#[test]
fn other_states_survive_a_slip() {
    let slips = [
        "state x { on found pre }",
        "state x\n    on found -> pre\n  }",
        "state x { on found -> }",
        "state x { on -> a }",
        "state x! { stack b }",
        "state x { stack b( }",
        "state x { do }",
        "state x { enter say(\"a\"  on b -> c }",
        "state { stack b }",
        "final x { stack b }",
        "state x { blend 3 mtr }",
        "state x { on a -> b blend 3 mtr }",
        "state x { when a < -> b }",
        "state x { 5 $ }",
        "stat x { on a -> b }",
    ];
    for slip in slips {
        let text = format!(
            "hierarq 1\nmachine m {{\n  state a {{ stack s }}\n  {slip}\n  state z {{ on q -> a }}\n}}\nparam p = 1\n"
        );
        let (spec, diags) = parse(SourceId(0), &text, Syntax::Native);
        assert!((1..=2).contains(&diags.len()), "{}\n{text}", common::render(&text, &diags));
        let ItemKind::Machine(m) = &spec.items[0].kind else { panic!("no machine in {text}") };
        let names: Vec<&str> = m.body.states.iter().map(|s| s.name.as_str()).filter(|n| *n != "x").collect();
        assert_eq!(names, ["a", "z"], "{text}");
        assert_eq!(m.body.states.last().map(|s| s.body.transitions.len()), Some(1), "{text}");
        assert_eq!(spec.items.len(), 2, "{text}");
    }
}

#[test]
fn states_nest_sixteen_deep() {
    let nested = |n: usize| {
        let hq = format!("hierarq 1\nmachine m {{ {}{} }}\n", "state a { x 1 ".repeat(n), "}".repeat(n));
        let yaml =
            format!("hierarq: 1\nmachines: {{ m: {}{{ x: 1 }}{} }}\n", "{ states: { a: ".repeat(n), " } }".repeat(n));
        [(hq, Syntax::Native), (yaml, Syntax::Yaml)]
    };
    for (text, syntax) in nested(16) {
        good(&text, syntax);
    }
    for (text, syntax) in nested(17) {
        let codes: Vec<_> = parse(SourceId(0), &text, syntax).1.iter().map(|d| d.code).collect();
        assert_eq!(codes, ["HQ0191"], "{text}");
    }
}

#[test]
fn long_formulas_are_refused() {
    for chain in
        ["not ", "always ", "after ", "a and ", "a implies ", "a until ", "within 3 s ", "always within 3 s : "]
    {
        let text = format!("hierarq 1\nscenario s {{ expect {}a }}\n", chain.repeat(50_000));
        let codes: Vec<_> = parse(SourceId(0), &text, Syntax::Native).1.iter().map(|d| d.code).collect();
        assert_eq!(codes, ["HQ0195"], "{chain}");
    }
    let text = format!("hierarq 1\nscenario s {{ expect {}a }}\n", "always ( ".repeat(1000));
    assert_eq!(parse(SourceId(0), &text, Syntax::Native).1[0].code, "HQ0191");
    let text = format!("hierarq 1\nscenario s {{ expect {}a{} }}\n", "always ( ".repeat(60), " )".repeat(60));
    let thread = std::thread::Builder::new().stack_size(1 << 20);
    let read = thread.spawn(move || parse(SourceId(0), &text, Syntax::Native).1.len()).unwrap().join().unwrap();
    assert_eq!(read, 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn formulas_keep_their_meaning(formula in trees::scenarios::formula()) {
        let expect = Expect { label: None, formula, span: Span::default(), comments: Default::default() };
        let name = Spanned::new("s".to_owned(), Span::default());
        let scenario = Scenario { name, body: Default::default(), expects: vec![expect] };
        let item = Item { kind: ItemKind::Scenario(scenario), span: Span::default(), comments: Default::default() };
        let spec = Spec { version: Some(Spanned::new(1, Span::default())), items: vec![item], ..Spec::default() };
        for syntax in [Syntax::Native, Syntax::Yaml] {
            let text = print(&spec, syntax);
            let read = good(&text, syntax);
            prop_assert_eq!(&read, &spec, "{}", text);
            prop_assert_eq!(print(&read, syntax), text);
        }
    }
}
