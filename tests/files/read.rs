//! Endless inputs are not read: devices, pipes, and files without a size limit.

#![cfg(unix)]

use std::io::Write;
use std::process::{Command, Stdio};

use super::{arm, call, contents, folder, utf8};

fn pipe(path: &std::path::Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("there is a `mkfifo`").success());
}

#[test]
fn pipes_and_devices_are_refused() {
    let dir = folder("endless");
    let spec = arm(&dir, "first", "50 ms");
    let text = contents(&spec);
    let zero = |name: &str| {
        let path = dir.join(name);
        std::os::unix::fs::symlink("/dev/zero", &path).expect("a link");
        path
    };
    for (n, make) in [true, false].into_iter().enumerate() {
        let odd = |name: &str| {
            let path = dir.join(format!("{n}{name}"));
            if make {
                pipe(&path);
                return path;
            }
            zero(&format!("{n}{name}"))
        };
        let (import, csv, urdf, layers) = (odd("i.hq"), odd("w.csv"), odd("r.urdf"), odd("l.json"));
        let (program, own, replay) = (odd("p.json"), odd("own.hq"), odd("t.jsonl"));
        let name = |path: &std::path::Path| path.file_name().expect("a name").to_string_lossy().into_owned();
        let written = |what: &str, text: String| {
            let path = dir.join(format!("{n}{what}.hq"));
            std::fs::write(&path, text).expect("writable");
            path
        };
        let importing = written("importing", format!("hierarq 1\nimport \"{}\" {{ x }}\n", name(&import)));
        let robot = written("robot", text.replace("two.urdf", &name(&urdf)));
        let playing = written(
            "playing",
            text.clone()
                + "\nhuman anna {\n  points [chest]\n  timeout 0.1 s\n  max_speed 4 m/s\n  lost hold\n  growth 0.5 m/s\n}\n"
                + &format!("scenario s {{ duration 50 ms  humans {{ anna {{ file \"{}\" }} }} }}\n", name(&csv)),
        );
        let letters = contents(std::path::Path::new("examples/letters.hq"));
        let layered = written("layered", letters.replace("layers/${job}.json", &name(&layers)));
        let out = dir.join(format!("{n}out"));
        for args in [
            vec!["check", utf8(&own)],
            vec!["fmt", utf8(&own)],
            vec!["check", utf8(&importing)],
            vec!["check", utf8(&robot)],
            vec!["check", utf8(&playing)],
            vec!["check", utf8(&layered)],
            vec!["run", utf8(&program)],
            vec!["compile", utf8(&program)],
            vec!["plan", utf8(&program)],
            vec!["bench", utf8(&program)],
            vec!["init", utf8(&out), "--urdf", utf8(&urdf)],
            vec!["context", "examples/letters.hq", "letter_h", "--replay", utf8(&replay)],
        ] {
            let (code, _, err) = call(&args);
            assert!(code == Some(1) || code == Some(2), "{args:?}: {err}");
            assert!(err.contains("it is a device or a pipe, and no file"), "{args:?}: {err}");
        }
        assert!(!out.exists());
    }
    // A pipe of problems ends when its writer closes it; a device may never end.
    let (code, _, err) = call(&["solve", utf8(&zero("zero.jsonl"))]);
    assert_eq!((code, err.contains("it is a device or a pipe")), (Some(1), true), "{err}");
    // Pipes in a folder are not opened.
    let (code, _, err) = call(&["test", utf8(&dir)]);
    assert!(code.is_some_and(|code| code > 0), "{err}");
}

#[test]
fn journals_and_results_are_no_pipes() {
    let dir = folder("odd_outputs");
    let spec = arm(&dir, "first", "50 ms");
    std::fs::write(&spec, contents(&spec) + "\nscenario s { seed 1 }\n").expect("writable");
    let out = dir.join("m.parquet");
    pipe(&dir.join("m.parquet.journal"));
    let (code, _, err) = call(&["sweep", utf8(&spec), "--runs", "2", "--out", utf8(&out)]);
    assert_eq!((code, err.contains("it is a device or a pipe")), (Some(2), true), "{err}");
    let folder = dir.join("out");
    std::fs::create_dir(&folder).expect("writable");
    std::os::unix::fs::symlink("/dev/null", folder.join("log.csv")).expect("a link");
    let (code, _, err) = call(&["run", utf8(&spec), "--out", utf8(&folder)]);
    assert_eq!((code, err.contains("it is a device or a pipe")), (Some(2), true), "{err}");
    assert!(folder.join("log.csv").is_symlink());
    // A picture may be written to a device: nothing is replaced there.
    assert_eq!(call(&["graph", "editors/words.hq", "--out", "/dev/null"]).0, Some(0));
}

#[test]
fn an_editor_that_announces_too_much_is_told() {
    for length in ["18446744073709551615", "100000000000", "99999999999999999999999"] {
        let mut child = super::command(&["lsp"])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary runs");
        let mut input = child.stdin.take().expect("piped");
        write!(input, "Content-Length: {length}\r\n\r\n{{}}").expect("written");
        let out = child.wait_with_output().expect("it ends");
        let err = super::cli::text(&out.stderr);
        assert_eq!((out.status.code(), err.contains(length)), (Some(2), true), "{err}");
        assert!(!err.contains("panicked"), "{err}");
        drop(input);
    }
}
