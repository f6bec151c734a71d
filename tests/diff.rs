//! `hierarq diff`: what differs in behaviour, and nothing else.

use std::path::{Path, PathBuf};

use hierarq::diff::{Difference, Differences, Form, render};
use hierarq::project::{Settings, compile, load};
use runtime::program::CompiledFile;

use crate::common::cli::hierarq;
use crate::common::{EXAMPLES, MISSIONS};

fn example(name: &str) -> PathBuf {
    Path::new("examples").join(name)
}

/// Compares an example with a version of it in which texts are replaced.
fn changed(name: &str, replaced: &[(&str, &str)]) -> Differences {
    let mut text = std::fs::read_to_string(example(name)).expect("an example");
    for (old, new) in replaced {
        assert!(text.contains(old), "{old}");
        text = text.replacen(old, new, 1);
    }
    let before = compile(&example(name), &Settings::default());
    let input = compiler::Input {
        name,
        text: &text,
        syntax: dsl::Syntax::Native,
        folder: Path::new("examples"),
        set: &[],
        package_paths: &[],
    };
    let after = compiler::compile(&input);
    assert!(after.is_good(), "{}", after.report.to_json());
    Differences::new(&before, &after, [false; 2])
}

fn lines(of: &Differences) -> Vec<String> {
    let line = |d: &Difference| {
        let [old, new] = [&d.before, &d.after].map(|text| text.as_deref().unwrap_or("-"));
        format!("{} | {} | {old} | {new}", d.subject, d.attribute)
    };
    of.behaviour.iter().map(line).collect()
}

/// Both syntaxes say the same, and a compiled program what its spec says.
#[test]
fn the_same_behaviour_has_no_difference() {
    for name in EXAMPLES.iter().chain(MISSIONS) {
        let [native, yaml] =
            ["hq", "yaml"].map(|end| compile(&example(&format!("{name}.{end}")), &Settings::default()));
        let found = Differences::new(&native, &yaml, [false; 2]);
        assert_eq!(lines(&found), Vec::<String>::new(), "{name}");
        assert_eq!((found.gained, found.lost), (vec![], vec![]), "{name}");
        let json = CompiledFile::to_json(name, native.program.as_ref(), &native.missions).expect("data");
        let CompiledFile { program, missions } = CompiledFile::read(&json).expect("a program");
        let read = compiler::Compiled { program, missions, ..Default::default() };
        let found = Differences::new(&native, &read, [false, true]);
        assert_eq!(lines(&found), Vec::<String>::new(), "{name}");
        assert!(found.is_empty() && found.findings_unknown, "{name}");
    }
}

/// Comments, order of declarations of tasks and spelling of units are no behaviour.
#[test]
fn another_text_may_be_the_same_behaviour() {
    let found = changed("hello.hq", &[("hierarq 1", "// A comment.\nhierarq 1")]);
    assert!(found.is_empty(), "{:?}", lines(&found));
}

#[test]
fn differences_are_told_by_their_subject() {
    let found = changed("bystander.hq", &[("level limits hard", "level limits")]);
    assert_eq!(
        lines(&found),
        ["level limits of stack alone | is | hard | soft", "level limits of stack beside | is | hard | soft"]
    );
    assert!(!found.gained.is_empty(), "a soft level of limits is warned of");
    let text = render(&found, ["a.hq", "b.hq"], Form::Plain);
    assert!(text.contains("level limits of stack alone\n  is: hard -> soft"), "{text}");
    let text = render(&found, ["a.hq", "b.hq"], Form::Markdown);
    assert!(text.contains("#### level limits of stack alone\n\n- `is`: `hard` -> `soft`"), "{text}");
}

/// Each planted change of behaviour is found, with its subject, and nothing besides.
#[test]
fn planted_changes_are_found_alone() {
    let one = |name: &str, old: &str, new: &str| lines(&changed(name, &[(old, new)]));
    let away = |point: &str| format!("task away_{point} | gain | 5 | 4");
    let three = ["chest", "left_wrist", "right_wrist"].map(away);
    assert_eq!(one("bystander.hq", "gain 5 /s", "gain 4 /s"), three);
    // A param is written out in each task that uses it.
    let clear = one("bystander.hq", "param clear = 0.4 m", "param clear = 0.5 m");
    assert!(clear.iter().any(|line| line.starts_with("task away_chest | min |")), "{clear:?}");
    assert!(clear.iter().any(|line| line.contains("expect always norm(frame(tool).position")), "{clear:?}");
    let reordered = one("panel.hq", "after [light]", "");
    assert!(
        !reordered.is_empty() && reordered.iter().all(|line| line.starts_with("mission together |")),
        "{reordered:?}"
    );
    let rate = one("supermarket.hq", "if(away.x < 0 m, 1, 0.5)", "if(away.x < 0 m, 1, 0.4)");
    assert!(rate.iter().all(|line| line.starts_with("mission market |")) && rate.len() == 2, "{rate:?}");
    let after = one("harvesting.hq", "after 8 s -> view", "after 9 s -> view");
    assert!(after.len() >= 2 && after.iter().all(|line| line.starts_with("state ")), "{after:?}");
}

/// Each difference from A to B is one from B to A.
#[test]
fn differences_are_symmetric() {
    let specs: Vec<_> = ["hello.hq", "bystander.hq", "nearness.hq", "picker.hq", "panel.hq", "vineyard_day.hq"]
        .map(|name| load(&example(name), &Settings::default()))
        .into_iter()
        .collect();
    for a in &specs {
        for b in &specs {
            let [there, back] = [Differences::new(a, b, [false; 2]), Differences::new(b, a, [false; 2])];
            let key = |d: &Difference, turned: bool| {
                let [old, new] = if turned { [&d.after, &d.before] } else { [&d.before, &d.after] };
                (d.subject.clone(), d.attribute.clone(), old.clone(), new.clone())
            };
            let mut one: Vec<_> = there.behaviour.iter().map(|d| key(d, false)).collect();
            let mut other: Vec<_> = back.behaviour.iter().map(|d| key(d, true)).collect();
            one.sort();
            other.sort();
            assert_eq!(one, other);
            assert_eq!((there.gained, there.lost), (back.lost, back.gained));
        }
    }
}

#[test]
fn the_command_says_by_its_exit_code_if_something_differs() {
    let same = hierarq(&["diff", "examples/hello.hq", "examples/hello.yaml"]);
    assert_eq!(same.status.code(), Some(0), "{}", String::from_utf8_lossy(&same.stderr));
    assert_eq!(String::from_utf8_lossy(&same.stdout).trim(), "no difference in behaviour");
    let other = hierarq(&["diff", "examples/hello.hq", "examples/bystander.hq", "--json"]);
    assert_eq!(other.status.code(), Some(1));
    let data: serde_json::Value = serde_json::from_slice(&other.stdout).expect("JSON");
    assert!(data["behaviour"].as_array().is_some_and(|all| !all.is_empty()));
    let wrong = hierarq(&["diff", "examples/hello.hq", "examples/no_such.hq"]);
    assert_eq!(wrong.status.code(), Some(2));
}
