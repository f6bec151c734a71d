//! Compares the table of keys with the behaviour of the compiler: units, ranges, defaults, required keys.

use crate::common;

use common::{compile_text, examples};
use dsl::Syntax;
use hierarq_compiler::sections::{self, BlockSchema, InSyntax, Key, Place, ValueType};
use hierarq_compiler::units;
use mission::kinds::layers::blocks as layers;
use mission::kinds::schedule::blocks as schedule;
use stdlib_tasks::params::Presence;

const ROBOT: &str = "urdf \"robots/arm7.urdf\"  rate 100 Hz  home { joint_4 1 rad }";
const STACK: &str = "task still = hold(link_7)\nstack s { level a { still } }\n";

/// A spec in which a section has these additional entries.
fn spec(section: &BlockSchema, entries: &str) -> Option<String> {
    let robot = |inner: &str| format!("hierarq 1\nrobot r {{ {inner} }}\n{STACK}");
    let level = |inner: &str| {
        format!("hierarq 1\nrobot r {{ {ROBOT} }}\ntask still = hold(link_7)\nstack s {{ level a {inner} }}\n")
    };
    let run = |inner: &str| format!("{}run {{ {inner} }}\n", robot(ROBOT));
    let is = |other: &BlockSchema| std::ptr::eq(section, other);
    // A mission with robot `m`, person `h` and worker `w`, each with these entries before its required ones.
    let mission = |own: &str, [m, h, w]: [&str; 3]| {
        format!(
            "hierarq 1\nmission x : schedule {{ {own}\n robot m {{ {m}  depot [0, 0] m  speed [0.5, 2] m/s  serve 1 s }}  \
             human h {{ {h}  place [3, 4] m  duration 10 s }}  worker w {{ {w}  place [4, 3] m  duration 10 s }} }}\n"
        )
    };
    let block = |name: &str| format!("{name} {{ {entries} }}");
    // A mission of layers with robot `r`, person `h`, object `o` and task `t`, in the same way.
    let layers = |own: &str, [r, h, o, t]: [&str; 4]| {
        format!(
            "hierarq 1\nmission x : layers {{ {own}\n robot r {{ {r}  place [0, 0, 0] m  speed [0.5, 2] m/s  skills {{ go 1 s }} }}  \
             human h {{ {h}  place [1, 0, 0] m  speed 1 m/s  skills {{ go 1 s }} }}  object o {{ {o}  place [1, 1, 0] m }}  \
             layer l {{ task t = go {{ {t}  to [1, 0, 0] m }} }} }}\n"
        )
    };
    Some(if is(&sections::ROBOT) {
        robot(&[ROBOT, entries].join("  "))
    } else if is(&sections::POINT) {
        robot(&format!("{ROBOT}  points {{ p {{ link link_7  {entries} }} }}"))
    } else if is(&sections::LEVEL) {
        level(&format!("{entries} {{ still }}"))
    } else if is(&sections::MEMBER) {
        level(&format!("{{ still {entries} }}"))
    } else if is(&sections::RUN) {
        run(entries)
    } else if is(&sections::SIMULATOR) {
        run(&format!("simulator {{ {entries} }}"))
    } else if is(&schedule::SCHEDULE) {
        mission(entries, [""; 3])
    } else if is(&schedule::SCHEDULE_WEIGHTS) {
        mission(&block("weights"), [""; 3])
    } else if is(&schedule::ADAPTATION) {
        mission(&block("adaptation"), [""; 3])
    } else if is(&schedule::SCHEDULE_ROBOT) {
        mission("", [entries, "", ""])
    } else if is(&mission::declare::common::ENERGY) {
        mission("", [&block("energy"), "", ""])
    } else if is(&schedule::SCHEDULE_HUMAN) {
        mission("", ["", entries, ""])
    } else if is(&schedule::SCHEDULE_WORKER) {
        mission("", ["", "", entries])
    } else if is(&layers::LAYERS) {
        layers(entries, [""; 4])
    } else if is(&layers::LAYERS_WEIGHTS) {
        layers(&block("weights"), [""; 4])
    } else if is(&layers::LAYERS_ROBOT) {
        layers("", [entries, "", "", ""])
    } else if is(&layers::LAYERS_HUMAN) {
        layers("", ["", entries, "", ""])
    } else if is(&layers::OBJECT) {
        layers("", ["", "", entries, ""])
    } else if is(&layers::LAYERS_TASK) {
        layers("", ["", "", "", entries])
    } else if is(&schedule::APPROACH) {
        mission("", ["", &format!("approaches {{ m {{ {entries} }} }}"), ""])
    } else {
        return None;
    })
}

fn codes(text: &str) -> Vec<&'static str> {
    let report = compile_text(text, Syntax::Native, &examples(), &[]).report;
    report.diagnostics.iter().map(|d| d.code).collect()
}

/// Keys of `*.hq` blocks that are tested, with their sections.
fn asked() -> Vec<(&'static BlockSchema, &'static Key)> {
    let all = sections::ALL.iter().filter(|s| spec(s, "").is_some());
    all.flat_map(|s| s.written(Syntax::Native).map(move |k| (*s, k))).collect()
}

#[test]
fn numbers_have_the_units_and_ranges_of_the_table() {
    let mut tried = 0;
    for (section, key) in asked() {
        let (ValueType::Number(q) | ValueType::Count(q)) = &key.value else { continue };
        if key.name == "rate" {
            continue;
        }
        tried += 1;
        let with = |value: String| codes(&spec(section, &format!("{} {value}", key.name)).expect("asked"));
        let other = if q.dimension == stdlib_tasks::dimension::MASS { "3 s" } else { "3 kg" };
        assert!(with(other.to_string()).contains(&"HQ0301"), "{} takes {other}", key.name);
        let unit = units::written(q.dimension);
        let refused = |x: f64| with(format!("{x} {unit}")).contains(&"HQ0308");
        let inside = (q.min + 1.0).min(q.max);
        assert!(!refused(inside), "{}: {inside} {unit}", key.name);
        assert!(refused(q.min - 1.0), "{} has no bound of {}", key.name, q.min);
        assert_eq!(refused(q.min), !q.min_included, "{} at {}", key.name, q.min);
    }
    assert!(tried >= 6, "only {tried} numbers were tried");
}

#[test]
fn the_rate_has_its_range() {
    for (rate, good) in [("0.1 Hz", true), ("100 kHz", true), ("0.09 Hz", false), ("101 kHz", false)] {
        let text = format!("hierarq 1\nrobot r {{ urdf \"robots/arm7.urdf\"  rate {rate} }}\n{STACK}");
        assert_eq!(!codes(&text).contains(&"HQ0308"), good, "{rate}");
    }
}

#[test]
fn what_stands_in_for_a_key_is_what_the_table_says() {
    let compiled = |text: &str| {
        let compiled = compile_text(text, Syntax::Native, &examples(), &[]);
        assert!(compiled.is_good(), "{text}");
        serde_json::to_value((compiled.program, compiled.missions)).expect("data")
    };
    let mut tried = 0;
    for (section, key) in asked() {
        let Presence::Default(text) = key.presence else { continue };
        // A flag such as `hard` has no value.
        if matches!(key.value, ValueType::Flag) {
            continue;
        }
        tried += 1;
        let without = compiled(&spec(section, "").expect("asked"));
        let with = compiled(&spec(section, &format!("{} {text}", key.name)).expect("asked"));
        assert_eq!(without, with, "{}: `{}`", section.name, key.name);
    }
    assert!(tried >= 8, "only {tried} defaults were tried");
}

#[test]
fn what_the_table_requires_must_be_there() {
    let whole = [
        (&sections::ROBOT, "urdf \"robots/arm7.urdf\"|rate 100 Hz", ("", "")),
        (&sections::ARM, "tip link_7|elbow link_4", ("arms { a { ", " } }")),
        (&sections::POINT, "link link_7|offset [0, 0, 1] m", ("points { a { ", " } }")),
        (&sections::SEGMENT, "link link_7|from [0, 0, 0] m|to [0, 0, 1] m", ("segments { a { ", " } }")),
        (&sections::LIMIT, "lower -1 rad|upper 1 rad", ("limits { joint_1 { ", " } }")),
    ];
    for (section, entries, (before, behind)) in whole {
        let entries: Vec<&str> = entries.split('|').collect();
        for left_out in &entries {
            let name = left_out.split(' ').next().expect("a key");
            let rest: Vec<&str> = entries.iter().copied().filter(|e| e != left_out).collect();
            let inner = format!("{before}{}{behind}", rest.join("  "));
            let robot = if before.is_empty() { inner } else { format!("{ROBOT}  {inner}") };
            let found = codes(&format!("hierarq 1\nrobot r {{ {robot} }}\n{STACK}"));
            let key = section.key(name, Syntax::Native).expect("a key of the section");
            assert_eq!(key.presence == Presence::Required, found.contains(&"HQ0206"), "{}: `{name}`", section.name);
        }
    }
}

#[test]
fn words_are_those_that_the_compiler_takes() {
    for (section, key) in asked() {
        let ValueType::Choice(words) = &key.value else { continue };
        for (word, good) in words.iter().map(|w| (*w, true)).chain([("qqqqqq", false)]) {
            let found = codes(&spec(section, &format!("{} {word}", key.name)).expect("asked"));
            let refused = found.iter().any(|c| matches!(*c, "HQ0201" | "HQ0304"));
            assert_eq!(!refused, good, "{}: `{} {word}`: {found:?}", section.name, key.name);
        }
    }
    let backends: Vec<&str> = solver::Backend::ALL.iter().map(|b| b.name()).collect();
    let key = sections::RUN.key("solver", Syntax::Native).expect("a key of a run");
    assert!(matches!(&key.value, ValueType::Choice(words) if **words == *backends), "{backends:?}");
}

/// Every entry of the table can be written, unless it names another thing, and every other word is rejected.
#[test]
fn the_compiler_refuses_what_the_table_does_not_have() {
    for section in sections::ALL.iter() {
        let Some(text) = spec(section, "qqqqqq 1").filter(|_| !std::ptr::eq(*section, &sections::MEMBER)) else {
            continue;
        };
        let report = compile_text(&text, Syntax::Native, &examples(), &[]).report;
        let d = report.diagnostics.iter().find(|d| d.code == "HQ0205").unwrap_or_else(|| panic!("{}", section.name));
        let help = d.help.as_deref().unwrap_or("");
        for key in section.keys {
            let offered = help.contains(&format!("`{}`", key.name));
            assert_eq!(offered, key.place == Place::Entry, "{}: `{}` in {help}", section.name, key.name);
        }
    }
}

/// The readers know the words that begin members, and the settings of a task, before a kind is known.
#[test]
fn words_of_missions_are_those_of_the_readers() {
    let mut open: Vec<&BlockSchema> = mission::kinds::KINDS.iter().map(|kind| kind.schema).collect();
    while let Some(schema) = open.pop() {
        for role in schema.roles() {
            assert!(dsl::vocabulary::ROLES.contains(&role.name), "{}: `{}`", schema.name, role.name);
            if role.name == "task" {
                let entries: Vec<&str> = role.schema.entries().collect();
                assert_eq!(entries, dsl::vocabulary::TASK_SETTINGS, "{}", role.schema.name);
            }
            open.push(role.schema);
        }
    }
}
