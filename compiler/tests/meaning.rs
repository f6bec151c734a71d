//! The corpus of meaning: well-formed specs with one mistake each that no grammar sees, and specs that look alike and are
//! right.
//!
//! The specs are in `meaning/*.txt`, one file per class. They were written from what happens to users of controllers, without
//! the checks of the compiler in view, so that a share of them stays silent. The snapshots have the verdict of each, so that a
//! new check shows as a difference; the figures are in `docs/src/internals/meaning.md`.

mod judge;
mod page;
mod read;

use judge::{Outcome, Verdict};
use read::Sample;

/// The classes: name of the file, title in the book, text.
const CLASSES: &[(&str, &str, &str)] = &[
    ("magnitudes", "magnitudes and units", include_str!("meaning/magnitudes.txt")),
    ("limits", "limits that are not there", include_str!("meaning/limits.txt")),
    ("guards", "guards that guard nothing", include_str!("meaning/guards.txt")),
    ("levels", "level, hardness, priority", include_str!("meaning/levels.txt")),
    ("reach", "reach", include_str!("meaning/reach.txt")),
    ("feasibility", "feasibility", include_str!("meaning/feasibility.txt")),
    ("freedom", "freedom", include_str!("meaning/freedom.txt")),
    ("machines", "machines", include_str!("meaning/machines.txt")),
    ("expectations", "expectations and scenarios", include_str!("meaning/expectations.txt")),
    ("frames", "frames and signs", include_str!("meaning/frames.txt")),
    ("sensors", "sensors, people, admittance", include_str!("meaning/sensors.txt")),
    ("missions", "missions", include_str!("meaning/missions.txt")),
];

/// All samples of a class.
fn samples(name: &str) -> Vec<Sample> {
    let (.., text) = CLASSES.iter().find(|c| c.0 == name).expect("a class");
    read::samples(name, text)
}

/// Compares the verdicts of a class with the accepted ones.
fn check(name: &str) {
    let outcomes = judge::all(&samples(name));
    for o in &outcomes {
        println!("{}", o.story);
    }
    let out: String = outcomes.iter().map(Outcome::line).collect();
    insta::assert_snapshot!(format!("meaning_{name}"), out);
}

macro_rules! classes {
    ($($name:ident)*) => { $(#[test] fn $name() { check(stringify!($name)); })* };
}

classes!(magnitudes limits guards levels reach feasibility freedom machines expectations frames sensors missions);

/// A spec with a mistake of form would be found for the wrong reason. A name may be the mistake itself.
#[test]
fn the_specs_are_well_formed() {
    let mut wrong = Vec::new();
    for (name, ..) in CLASSES {
        for o in judge::all(&samples(name)) {
            let names = |f: &judge::Found| f.code.starts_with("HQ02") && !f.marked;
            let form = o.found.iter().filter(|f| f.code.starts_with("HQ01") || names(f));
            wrong.extend(form.map(|f| format!("{name}: {}: {} {}", o.name, f.code, f.message)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Names are unique, so that a verdict belongs to one spec, and everything is said of each.
#[test]
fn the_specs_are_described() {
    let mut seen = std::collections::BTreeSet::new();
    for (name, ..) in CLASSES {
        for s in samples(name) {
            let provable = s.good || ["yes", "partly", "no"].iter().any(|w| s.provable.starts_with(w));
            assert!(provable, "{name}: {}: `provable` is yes, partly or no", s.name);
            assert!(!s.source.is_empty() && !s.mistake.is_empty(), "{name}: {} lacks a line", s.name);
            assert!(seen.insert(s.name.clone()), "`{}` occurs twice", s.name);
        }
    }
}

#[test]
fn the_figures_are_those_of_the_book() {
    let classes: Vec<_> = CLASSES.iter().map(|c| (c.1, judge::all(&samples(c.0)))).collect();
    let all = || classes.iter().flat_map(|c| &c.1);
    assert!(all().all(|o| o.verdict != Verdict::Panicked), "a spec makes the compiler panic");
    page::published(&page::figures(&classes));
}

/// The judge is only meaningful if it tells a marked line from another one.
#[test]
fn the_judge_tells_right_from_wrong() {
    let verdict = |task: &str, marked: &str| {
        let text = format!("==== a name\nmistake: m\n\ntask a = {task}\n\nstack s {{ level l hard {{ a }} }}\n");
        let text = text.replacen(marked, &format!("«{marked}»"), 1);
        judge::all(&read::samples("judge", &text)).remove(0).verdict
    };
    let fast = "frame_position(tool) { position initial(position)  gain 500 /s }";
    assert_eq!(verdict(fast, "500 /s"), Verdict::Exact);
    assert_eq!(verdict(fast, "stack s"), Verdict::Elsewhere);
}
