//! Outputs of commands only replace files of their own kind, completely or not at all.

use super::{arm, call, contents, folder, names, utf8};

const UNTIDY: &str = "hierarq 1\nparam   a=1 m\n";
const TIDY: &str = "hierarq 1\n\nparam a = 1 m\n";

#[test]
fn fmt_touches_no_other_file() {
    let dir = folder("fmt");
    let spec = dir.join("a.hq");
    std::fs::write(&spec, UNTIDY).expect("writable");
    std::fs::write(dir.join("a.hq.tmp"), "mine").expect("writable");
    assert_eq!(call(&["fmt", utf8(&spec)]).0, Some(0));
    assert_eq!((contents(&spec).as_str(), contents(&dir.join("a.hq.tmp")).as_str()), (TIDY, "mine"));
    assert_eq!(names(&dir), ["a.hq", "a.hq.tmp"]);
}

#[cfg(unix)]
#[test]
fn fmt_follows_the_link_that_it_was_given_and_no_other() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let dir = folder("fmt_links");
    let (spec, link, other) = (dir.join("a.hq"), dir.join("link.hq"), dir.join("other"));
    std::fs::write(&spec, UNTIDY).expect("writable");
    std::fs::write(&other, "mine").expect("writable");
    symlink(&spec, &link).expect("a link");
    symlink(&other, dir.join("a.hq.tmp")).expect("a link");
    std::fs::set_permissions(&spec, std::fs::Permissions::from_mode(0o640)).expect("changed");
    assert_eq!(call(&["fmt", utf8(&link)]).0, Some(0));
    assert_eq!((contents(&spec).as_str(), contents(&other).as_str()), (TIDY, "mine"));
    assert!(link.is_symlink() && !spec.is_symlink() && dir.join("a.hq.tmp").is_symlink());
    assert_eq!(spec.metadata().expect("there").permissions().mode() & 0o777, 0o640);

    std::fs::write(&spec, UNTIDY).expect("writable");
    std::fs::set_permissions(&spec, std::fs::Permissions::from_mode(0o440)).expect("changed");
    let (code, _, err) = call(&["fmt", utf8(&spec)]);
    assert_eq!((code, err.contains("protected against writing")), (Some(2), true), "{err}");
    assert_eq!(contents(&spec), UNTIDY);
    assert_eq!(names(&dir), ["a.hq", "a.hq.tmp", "link.hq", "other"]);
}

/// Calls that write a file, and the name of the kind of file.
fn writers<'a>(spec: &'a str, mission: &'a str, ticks: &'a str) -> Vec<(Vec<&'a str>, &'static str)> {
    vec![
        (vec!["graph", "editors/words.hq", "--format", "svg", "--out"], "a picture"),
        (vec!["graph", "editors/words.hq", "--out"], "a picture"),
        (vec!["plan", mission, "--gantt"], "a picture"),
        (vec!["plan", mission, "--map"], "a picture"),
        (vec!["test", "examples/bystander.hq", "--scenario", "a recorded walk", "--junit"], "a file of test results"),
        (vec!["solve", ticks, "--answers"], "a file of answers"),
        (vec!["run", spec, "--duration", "20ms", "--out", "", "--problems"], "a file of the problems of a run"),
    ]
}

const MISSION: &str = "hierarq 1
mission field : schedule {
  robot m1 { depot [0, 0] m  speed 0.5 m/s  proximity_speed 0.5 m/s  serve 5 s  deposit 1 s }
  human anna { place [0, 5] m  operations 1  duration 60 s  wait_distance 1 m }
}
";

#[test]
fn what_is_there_is_replaced_by_its_like_and_by_nothing_else() {
    let dir = folder("kinds");
    let spec = arm(&dir, "first", "1 s");
    let mission = dir.join("field.hq");
    std::fs::write(&mission, MISSION).expect("writable");
    let out = dir.join("out");
    let ticks = "examples/ticks/small.jsonl";
    for (n, (mut args, kind)) in writers(utf8(&spec), utf8(&mission), ticks).into_iter().enumerate() {
        if let Some(empty) = args.iter().position(|a| a.is_empty()) {
            args[empty] = utf8(&out);
        }
        let target = dir.join(format!("target{n}"));
        let call = || call(&[&args[..], &[utf8(&target)]].concat());
        // A missing file, an earlier output and an empty file are replaced.
        for _ in 0..2 {
            let (code, _, err) = call();
            assert_eq!(code, Some(0), "{args:?}: {err}");
        }
        let written = contents(&target);
        assert!(!written.is_empty());
        std::fs::write(&target, "").expect("writable");
        assert_eq!(call().0, Some(0), "{args:?}");
        for foreign in ["mine", "hierarq 1\n", "{\"id\": \"a\", \"n\": 1, \"levels\": []}\n", "time,chest.x\n0,1\n"] {
            std::fs::write(&target, foreign).expect("writable");
            let (code, out, err) = call();
            assert_eq!((code, err.contains(&format!("is not {kind}"))), (Some(2), true), "{args:?}: {err}");
            assert_eq!((contents(&target).as_str(), out.as_str()), (foreign, ""), "{args:?}");
        }
        std::fs::remove_file(&target).expect("removed");
        std::fs::create_dir(&target).expect("a folder");
        let (code, _, err) = call();
        assert_eq!((code, err.contains("it is a folder")), (Some(2), true), "{args:?}: {err}");
    }
    assert!(names(&dir).iter().all(|name| !name.contains("tmp")), "{:?}", names(&dir));
}

#[cfg(unix)]
#[test]
fn what_is_read_is_not_overwritten_whatever_it_is_called() {
    use std::os::unix::fs::symlink;
    let dir = folder("sources");
    let spec = arm(&dir, "first", "1 s");
    let mission = dir.join("field.hq");
    std::fs::write(&mission, MISSION).expect("writable");
    let ticks = dir.join("ticks.jsonl");
    std::fs::copy("examples/ticks/small.jsonl", &ticks).expect("copied");
    let machine = dir.join("machine.hq");
    let text =
        contents(&spec).replace("run { ", "machine m {\n  initial go\n  state go { stack s }\n}\n\nrun { machine m  ");
    std::fs::write(&machine, text).expect("writable");
    let calls = [
        (&machine, vec!["graph", utf8(&machine), "--out"]),
        (&mission, vec!["plan", utf8(&mission), "--gantt"]),
        (&mission, vec!["plan", utf8(&mission), "--map"]),
        (&ticks, vec!["solve", utf8(&ticks), "--answers"]),
        (&spec, vec!["run", utf8(&spec), "--problems"]),
    ];
    for (source, args) in calls {
        let before = contents(source);
        let (link, hard) = (dir.join("link"), dir.join("hard"));
        let round = dir.join("..").join(dir.file_name().expect("a name")).join(source.file_name().expect("a name"));
        symlink(source, &link).expect("a link");
        std::fs::hard_link(source, &hard).expect("a link");
        for name in [source, &link, &hard, &round] {
            let (code, out, err) = call(&[&args[..], &[utf8(name)]].concat());
            let said = err.contains("would overwrite what it is made from");
            assert_eq!((code, said, out.as_str()), (Some(2), true, ""), "{args:?} {}: {err}", name.display());
        }
        assert_eq!(contents(source), before, "{args:?}");
        std::fs::remove_file(&link).expect("removed");
        std::fs::remove_file(&hard).expect("removed");
    }
    // Also not the robot, which the spec names.
    let urdf = dir.join("two.urdf");
    let (code, _, err) = call(&["run", utf8(&spec), "--problems", utf8(&urdf)]);
    assert_eq!((code, err.contains("would overwrite what it is made from")), (Some(2), true), "{err}");
}

#[cfg(unix)]
#[test]
fn links_to_other_files_are_not_followed() {
    let dir = folder("links");
    let (other, link) = (dir.join("other.svg"), dir.join("link.svg"));
    // Even if the target is of our kind: the target of a link belongs to someone else.
    let picture = call(&["graph", "editors/words.hq", "--format", "svg"]).1;
    std::fs::write(&other, &picture).expect("writable");
    std::os::unix::fs::symlink(&other, &link).expect("a link");
    let (code, _, err) = call(&["graph", "editors/words.hq", "--out", utf8(&link)]);
    assert_eq!((code, err.contains("is a link to")), (Some(2), true), "{err}");
    assert_eq!(contents(&other), picture);
    // A dangling link does not create its target.
    std::fs::remove_file(&other).expect("removed");
    assert_eq!(call(&["graph", "editors/words.hq", "--out", utf8(&link)]).0, Some(2));
    assert_eq!(names(&dir), ["link.svg"]);
    // Hard links: the other name keeps its content.
    std::fs::remove_file(&link).expect("removed");
    std::fs::write(&other, &picture).expect("writable");
    std::fs::hard_link(&other, &link).expect("a link");
    assert_eq!(call(&["graph", "editors/words.hq", "--out", utf8(&link)]).0, Some(0));
    assert!(contents(&other) == picture && contents(&link) != picture);
}

#[test]
fn two_pictures_do_not_go_into_one_file() {
    let dir = folder("two_pictures");
    let mission = dir.join("field.hq");
    std::fs::write(&mission, MISSION).expect("writable");
    let picture = dir.join("p.svg");
    let (code, _, err) = call(&["plan", utf8(&mission), "--gantt", utf8(&picture), "--map", utf8(&picture)]);
    assert_eq!((code, err.contains("name the same file")), (Some(2), true), "{err}");
    assert!(!picture.exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_told() {
    let compiled: &[&str] = &["compile", "examples/hello.hq", "--format", "json"];
    for args in [
        compiled,
        &["fmt", "examples/hello.hq", "--to", "yaml"],
        &["plan", "examples/vineyard.hq", "--set", "boxes=1", "--json"],
        &["check", "examples/hello.hq"],
        &["schema"],
        &["tasks"],
        &["man"],
        &["completions", "bash"],
        &["explain", "HQ0101"],
        &["--help"],
        &["run", "--help"],
        &["--version"],
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
        let out = super::command(args).stdout(full).output().expect("the binary runs");
        let err = super::cli::text(&out.stderr);
        assert_eq!(
            (out.status.code(), err.contains("cannot write to standard output")),
            (Some(2), true),
            "{args:?}: {err}"
        );
    }
}

/// The size of files is limited to a few kilobytes, as on an almost full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_leaves_what_was_there() {
    let dir = folder("filling");
    let spec = arm(&dir, "first", "20 s");
    let long = dir.join("long.hq");
    let text: String = "hierarq 1\n".to_string() + &(0..2000).map(|n| format!("param  a{n}=1 m\n")).collect::<String>();
    std::fs::write(&long, &text).expect("writable");
    let out = dir.join("out");
    let (chart, problems) = (dir.join("c.svg"), dir.join("p.jsonl"));
    let picture = call(&["graph", "editors/words.hq"]).1;
    std::fs::write(&chart, &picture).expect("writable");
    for args in [
        vec!["fmt", utf8(&long)],
        vec!["graph", "editors/words.hq", "--format", "svg", "--out", utf8(&chart)],
        vec!["run", utf8(&spec), "--out", utf8(&out)],
        vec!["run", utf8(&spec), "--duration", "1s", "--out", utf8(&out), "--problems", utf8(&problems)],
    ] {
        let mut limited = std::process::Command::new("sh");
        limited
            .args(["-c", "trap '' XFSZ; ulimit -f 8; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_hierarq")])
            .args(&args);
        limited.env("NO_COLOR", "1").current_dir(env!("CARGO_MANIFEST_DIR"));
        let (code, _, err) = super::ended(limited);
        assert_eq!((code, err.contains("cannot write")), (Some(2), true), "{args:?}: {err}");
    }
    assert_eq!((contents(&long), contents(&chart)), (text, picture));
    assert_eq!(names(&out), Vec::<String>::new(), "no verdict, and no half of a log");
    assert_eq!(names(&dir), ["c.svg", "long.hq", "out", "two.hq", "two.urdf"]);
}

#[cfg(unix)]
#[test]
fn what_a_spec_quotes_paints_nothing() {
    let dir = folder("colours");
    let spec = dir.join("a.hq");
    for text in [
        "hierarq 1\nparam a = 1 m \u{1b}[8mhidden\u{1b}[0m\n",
        "hierarq 1\n// \u{1b}[31mred\nstack s { level \"\u{1b}[8mx\" { nothing } }\n",
        "hierarq 1\nimport \"\u{1b}[8m.hq\" { x }\n",
    ] {
        std::fs::write(&spec, text).expect("writable");
        for colours in ["0", "1"] {
            let mut check = super::command(&["check", utf8(&spec)]);
            if colours == "1" {
                check.env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1");
            }
            let (code, out, err) = super::ended(check);
            assert_eq!(code, Some(1), "{err}");
            let all = out + &err;
            assert!(!all.contains("\u{1b}[8m") && !all.contains("\u{1b}[31mred") && !all.contains('\u{1a}'), "{all:?}");
            assert!(all.contains('\u{fffd}'), "{all:?}");
        }
    }
}
