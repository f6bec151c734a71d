//! Findings of the compiler about random machines, against all that the machines can do: an interpreter of the execution of machines,
//! written from its description in the book, tries all values of the signals at every tick.

mod all_runs;
mod random_machines;

use std::collections::{BTreeMap, BTreeSet};

use crate::common;

use all_runs::brute;
use common::{compile_text, examples};
use dsl::Syntax;
use random_machines::{Condition, Machine, Random};

/// Codes of the diagnostics of a text.
fn codes(text: &str) -> BTreeSet<&'static str> {
    let compiled = compile_text(text, Syntax::Native, &examples(), &[]);
    compiled.report.diagnostics.iter().map(|d| d.code).collect()
}

/// Names in backticks of the messages of a code.
fn told(text: &str) -> BTreeMap<&'static str, Vec<Vec<String>>> {
    let compiled = compile_text(text, Syntax::Native, &examples(), &[]);
    assert_eq!(compiled.report.errors(), 0, "{text}\n{}", common::annotated(&compiled));
    let mut out: BTreeMap<&'static str, Vec<Vec<String>>> = BTreeMap::new();
    for d in &compiled.report.diagnostics {
        let names = d.message.split('`').skip(1).step_by(2).map(str::to_string).collect();
        out.entry(d.code).or_default().push(names);
    }
    out
}

/// The machines of the test.
fn machines() -> impl Iterator<Item = Machine> {
    let mut r = Random(20_260_101);
    (0..400).map(move |_| Machine::random(&mut r))
}

#[test]
fn findings_are_those_of_all_runs() {
    let (mut never, mut stuck, mut flipping, mut compared) = (0, 0, 0, 0);
    let (mut held, mut violated, mut open) = (0, 0, 0);
    let mut r = Random(7);
    for m in machines() {
        let text = m.spec("");
        let last = m.states.len() - 1;
        let both = Box::new([Condition::random(&mut r, 0), Condition::random(&mut r, 0)]);
        let property = (1 + r.below(last), Condition::And(both));
        let Some(b) = brute(&m, &property) else { continue };
        compared += 1;
        let told = told(&text);
        let named =
            |code: &str, s: usize| told.get(code).is_some_and(|all| all.iter().any(|names| names.contains(&m.name(s))));
        // A number that is counted is unknown from some value on, and how long a state around others has been active is
        // not followed, so that less is claimed.
        let exact = !m.counts() && m.states.iter().skip(1).all(|s| s.initial.is_none());
        let mut explained = String::new();
        for s in (1..last).filter(|&s| m.states[s].initial.is_none()) {
            let entered = b.leaves.contains(&s);
            // A message about a state covers those inside it.
            let unreachable = m.path(s).iter().any(|&p| named("HQ0704", p));
            // It may follow from what is said of another state or transition.
            let others = ["HQ0704", "HQ0705", "HQ0706", "HQ0719"].iter().any(|c| told.contains_key(c));
            if (unreachable && entered) || (exact && !(unreachable || entered || others)) {
                explained.push_str(&format!("{}: entered {entered}, HQ0704 {unreachable}\n", m.name(s)));
            }
            let stays = entered && !b.left.contains(&s);
            let without = named("HQ0719", s) || named("HQ0705", s);
            if (without && !stays) || (exact && stays && !without) {
                explained.push_str(&format!("{}: stays {stays}, HQ0705 or HQ0719 {without}\n", m.name(s)));
            }
            never += usize::from(unreachable);
            stuck += usize::from(named("HQ0719", s));
        }
        let flips = told.contains_key("HQ0720");
        if (flips && b.flips.is_empty()) || (exact && !flips && !b.flips.is_empty()) {
            explained.push_str(&format!("flips {:?}, HQ0720 {:?}\n", b.flips, told.get("HQ0720")));
        }
        flipping += usize::from(flips);
        let check = format!("\n  check never (in({}) and {})", m.name(property.0), property.1.text());
        let verdicts = codes(&m.spec(&check));
        match (verdicts.contains("HQ0721"), verdicts.contains("HQ0722")) {
            (true, _) => violated += 1,
            (false, true) => open += 1,
            (false, false) => held += 1,
        }
        let wrong = verdicts.contains("HQ0721") && !b.violated;
        if wrong || (b.violated && !verdicts.contains("HQ0721") && !verdicts.contains("HQ0722")) {
            explained.push_str(&format!("{check}: violated {}, {verdicts:?}\n", b.violated));
        }
        assert!(explained.is_empty(), "{text}\n{explained}");
    }
    assert!(held > 30 && violated > 30 && open < 100, "{held} {violated} {open}");
    assert!(compared > 200 && never > 30 && stuck > 3 && flipping > 30, "{compared} {never} {stuck} {flipping}");
}

/// A machine of 50 states around a ring, each with conditions on several signals with thresholds of its own.
fn large() -> String {
    let mut out = String::from("hierarq 1\nrobot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz }\n");
    (0..5).for_each(|k| out.push_str(&format!("signal d{k} : length\n")));
    out.push_str("signal p : point\nvariable n : number = 0\nstack still { level all { joint_velocity_limits } }\n");
    out.push_str("machine m { initial s0  stack still  on fault(any) -> end  when norm(p) > 9 m -> end\n");
    for s in 0..50 {
        let (next, other) = ((s + 1) % 50, (s * 7 + 3) % 50);
        let at = |k: usize| 0.01 * (1 + (s * 13 + k * 29) % 50) as f64;
        out.push_str(&format!(
            "  state s{s} {{ enter set(n, {s})  when d{} < {} m and norm(p) > {} m -> s{next}  \
             when d{} > {} m or d{} < {} m for 1 s -> s{other}  when n > {s} -> end  when p.x - d0 > {} m -> s{next}  \
             after 9 s -> s{next} }}\n",
            s % 5,
            at(0),
            at(1),
            (s + 1) % 5,
            at(2),
            (s + 2) % 5,
            at(3),
            at(4),
        ));
    }
    out.push_str("  final state end\n}\n");
    out
}

#[test]
fn fifty_states_with_fifty_thresholds_take_less_than_a_second() {
    let text = large();
    let begin = std::time::Instant::now();
    let told = told(&text);
    let time = begin.elapsed();
    // Each state has set the number that its condition compares.
    assert_eq!(told.get("HQ0704"), None, "{told:?}");
    assert!(time.as_secs_f64() < 1.0, "{time:?}");
}
